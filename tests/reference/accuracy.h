#pragma once

#include <functional>
#include <limits>
#include <string>

#include "tests/reference/benchmark.h"

namespace lithe::test {

constexpr double kAny = std::numeric_limits<double>::infinity();  // a bound that nothing breaks

/// The true error of the default integrator against the tolerance asked: `error(method)` over `size`, the largest value
/// of the watched quantity, is at most ten times the tolerance. With LITHE_ACCURACY=FILE.csv from 1e-3 to 1e-10, a line
/// each (tools/accuracy.sh makes docs/accuracy.md of them); else at 1e-6 alone. `factor`: the ten, where the motion
/// itself amplifies errors; docs/accuracy.md says why. `tightest`: below it runs stop.
void expect_accuracy(const std::string& id, const std::string& watched, double size,
                     const std::function<double(Method)>& error, double factor = 10, double tightest = 1e-10);

}  // namespace lithe::test
