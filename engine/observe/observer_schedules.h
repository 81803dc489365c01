#pragma once

#include <vector>

#include "engine/base/error.h"
#include "engine/observe/observer.h"

namespace lithe {

class Archive;

/// What round-off may do to a time near this one, s.
double time_round_off(double time);

/// Observers and when each is to be told: the one diary of whoever moves time. `look()` gives the snapshot to show, and
/// is asked for it only where somebody is told.
class ObserverSchedules {
 public:
  void add(Observer& observer, Schedule schedule) { watches_.push_back({&observer, schedule}); }
  /// Schedules begin at `time`: of observers that are new, or of all.
  void begin(double time, bool all);
  /// The next time after `time` that somebody waits for; `end` if there is none before it.
  double next_stop(double time, double end) const;
  /// Where each schedule is, and what its observer has kept. Loading: observers are told apart by their order and
  /// schedules; SceneError for others. Those beyond what was saved are new.
  void history(Archive& archive);

  template <class Look>
  void tell_due(double time, Look&& look) {
    for (Watch& watch : watches_)
      if (watch.is_due(time)) {
        tell(watch, time, look);  // if it throws, a run that goes on tells it again
        ++watch.told;
      }
  }
  /// Those whose schedule would skip `time` too, after a failure: it shows how that came.
  template <class Look>
  void tell_all(double time, Look&& look) {
    for (Watch& watch : watches_) {
      if (watch.told_time == time) continue;
      try {
        tell(watch, time, look);
      } catch (const Error&) {  // NOLINT: the failure itself matters more
      }
    }
  }

 private:
  struct Watch {
    Observer* observer;
    Schedule schedule;
    double origin = 0;  // t₀ of the schedule
    long told = 0;      // states of the schedule, so far
    double told_time = 0;
    bool begun = false;

    double next_time() const;
    double slack(double time) const;
    bool is_due(double time) const;
  };
  /// What an observer throws, by its type: it has no name.
  [[noreturn]] static void rethrow_of(const Observer& observer, double time);
  template <class Look>
  static void tell(Watch& watch, double time, Look&& look) {
    Snapshot& snapshot = look();
    try {
      watch.observer->observe(snapshot);
    } catch (...) {
      rethrow_of(*watch.observer, time);
    }
    watch.told_time = time;
  }

  std::vector<Watch> watches_;
};

}  // namespace lithe
