#include "tests/reference/accuracy.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

namespace lithe::test {

void expect_accuracy(const std::string& id, const std::string& watched, double size,
                     const std::function<double(Method)>& error, double factor, double tightest) {
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
