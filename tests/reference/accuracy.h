#pragma once

#include <functional>
#include <limits>

#include "tests/reference/benchmark.h"

namespace lithe::test {

constexpr double kAny = std::numeric_limits<double>::infinity();  // a bound that nothing breaks

/// The true error of the default integrator against the tolerance asked: `error(method)` over `size`, the largest value
/// of the watched quantity, is at most ten times the tolerance. With LITHE_ACCURACY=FILE.csv from 1e-3 to 1e-10, a line
/// each (tools/accuracy.sh makes docs/accuracy.md of them); else at 1e-6 alone. `factor`: the ten, where the motion
/// itself amplifies errors; docs/accuracy.md says why. `tightest`: below it runs stop.
inline void expect_accuracy(const std::string& id, const std::string& watched, double size,
                            const std::function<double(Method)>& error, double factor = 10, double tightest = 1e-10) {
  const char* path = std::getenv("LITHE_ACCURACY");
  std::vector<double> tolerances{1e-6};
  if (path) tolerances = {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};
  for (double tolerance : tolerances) {
    if (tolerance < tightest) break;
    const double relative = error(automatic(tolerance)) / size;
    if (path) {
      std::FILE* file = std::fopen(path, "a");
      ASSERT_TRUE(file) << path;
      std::fprintf(file, "%s,%s,%.0e,%.6e\n", id.c_str(), watched.c_str(), tolerance, relative);
      std::fclose(file);
    } else {
      expect_below(id + ", default at 1e-6, " + watched, relative, factor * tolerance);
    }
  }
}

}  // namespace lithe::test
