#pragma once

#include <cmath>

namespace lithe::lab {

/// Fixed steps, all of h, or h and h/2 in turn.
enum class Steps { constant, alternating };

/// The next step: the last one is stretched or cut to end at t_stop, by less than a part in 1e9 or as it must.
inline double next_step(Steps pattern, double h, long taken, double left) {
  const double wished = pattern == Steps::alternating && taken % 2 == 1 ? h / 2 : h;
  return wished > left * (1 - 1e-9) ? left : wished;
}

}  // namespace lithe::lab
