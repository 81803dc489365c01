#include "engine/watches.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lithe {

double time_round_off(double time) { return 8 * std::numeric_limits<double>::epsilon() * std::abs(time); }

void Watches::begin(double time, bool all) {
  for (Watch& watch : watches_) {
    if (!all && watch.begun) continue;
    watch.origin = time;
    watch.told = 0;
    watch.begun = true;
  }
}

double Watches::next_stop(double time, double end) const {
  double stop = end;
  for (const Watch& watch : watches_) {
    const double next = watch.next_time();
    if (watch.schedule.interval > 0 && next > time + watch.slack(time) && next < end - watch.slack(end))
      stop = std::min(stop, next);
  }
  return stop;
}

double Watches::Watch::next_time() const { return origin + static_cast<double>(told) * schedule.interval; }

/// Schedules meet, and meet the end, where times differ by round-off alone: 3 · 0.1 and 0.3.
double Watches::Watch::slack(double time) const { return 1e-9 * schedule.interval + time_round_off(time); }

bool Watches::Watch::is_due(double time) const {
  if (told > 0 && told_time == time) return false;
  return schedule.interval == 0 || next_time() <= time + slack(time);
}

}  // namespace lithe
