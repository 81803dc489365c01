#include "engine/observe/observer_schedules.h"

#include <cxxabi.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <typeinfo>

#include "engine/archive/archive.h"
#include "engine/base/number_text.h"

namespace lithe {

double time_round_off(double time) { return 8 * std::numeric_limits<double>::epsilon() * std::abs(time); }

void ObserverSchedules::begin(double time, bool all) {
  for (Watch& watch : watches_) {
    if (!all && watch.begun) continue;
    watch.origin = time;
    watch.told = 0;
    watch.begun = true;
  }
}

double ObserverSchedules::next_stop(double time, double end) const {
  double stop = end;
  for (const Watch& watch : watches_) {
    const double next = watch.next_time();
    if (watch.schedule.interval > 0 && next > time + watch.slack(time) && next < end - watch.slack(end))
      stop = std::min(stop, next);
  }
  return stop;
}

void ObserverSchedules::rethrow_of(const Observer& observer, double time) {
  try {
    throw;
  } catch (...) {  // NOLINT: an error, which is told below
  }
  const char* mangled = typeid(observer).name();
  const std::unique_ptr<char, void (*)(void*)> type(abi::__cxa_demangle(mangled, nullptr, nullptr, nullptr), std::free);
  rethrow_as_error(std::string("the observer ") + (type ? type.get() : mangled), time_text(time),
                   "see what it does there; the state is kept, and so is what others observed");
}

double ObserverSchedules::Watch::next_time() const { return origin + static_cast<double>(told) * schedule.interval; }

void ObserverSchedules::history(Archive& archive) {
  int count = static_cast<int>(watches_.size());
  archive("count", count);
  if (count < 0 || static_cast<std::size_t>(count) > watches_.size())
    throw SceneError("the checkpoint was written with " + std::to_string(count) + " observers, there are " +
                         std::to_string(watches_.size()) + " now",
                     archive.source(), "observe() the same ones, in the same order, before resume()");
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
    archive.group(std::to_string(i), [&] {
      Watch& watch = watches_[i];
      archive.same("interval", watch.schedule.interval);
      archive("origin", watch.origin);
      archive("told", watch.told);
      archive("told_time", watch.told_time);
      archive("begun", watch.begun);
      watch.observer->history(archive);
    });
}

/// Schedules meet, and meet the end, where times differ by round-off alone: 3 · 0.1 and 0.3.
double ObserverSchedules::Watch::slack(double time) const { return 1e-9 * schedule.interval + time_round_off(time); }

bool ObserverSchedules::Watch::is_due(double time) const {
  if (told > 0 && told_time == time) return false;
  return schedule.interval == 0 || next_time() <= time + slack(time);
}

}  // namespace lithe
