#pragma once

#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/observe/observer.h"
#include "engine/observe/stop_run.h"

namespace lithe {

class Archive;

/// Largest round-off error of a time near this one, s.
double time_round_off(double time);

/// Observers and their schedules, for the loop over time. `look()` returns the snapshot for the observers; it is called
/// only if an observer is due.
class ObserverSchedules {
 public:
  void add(Observer& observer, Schedule schedule) { watches_.push_back({&observer, schedule}); }
  /// Schedules begin at `time`: of observers that are new, or of all.
  void begin(double time, bool all);
  /// The next time after `time` at which an observer is due; `end` if there is none before it.
  double next_stop(double time, double end) const;
  /// The position of each schedule, and its observer's history. Loading: observers are matched by their order and
  /// schedules; SceneError for others. Observers beyond the saved ones are new.
  void history(Archive& archive);

  /// Who asks for the end of the run (StopRun), the last of them; empty: nobody.
  template <class Look>
  [[nodiscard]] std::string tell_due(double time, Look&& look) {
    std::string stopped_by;
    for (Watch& watch : watches_)
      if (watch.is_due(time)) {
        const std::string by = tell(watch, time, look);  // if it throws, a continued run calls it again
        ++watch.told;
        if (!by.empty()) stopped_by = by;
      }
    return stopped_by;
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
  /// Who asks for the end of the run; empty: nobody.
  template <class Look>
  static std::string tell(Watch& watch, double time, Look&& look) {
    Snapshot& snapshot = look();
    std::string stopped_by;
    try {
      watch.observer->observe(snapshot);
    } catch (const StopRun& stop) {
      stopped_by = stop.who();
    } catch (...) {
      rethrow_of(*watch.observer, time);
    }
    watch.told_time = time;
    return stopped_by;
  }

  std::vector<Watch> watches_;
};

}  // namespace lithe
