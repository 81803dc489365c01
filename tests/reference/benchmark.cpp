#include "tests/reference/benchmark.h"

#include <gtest/gtest.h>

namespace lithe::test {

Table reference(const std::string& file) { return read_csv(std::string(LITHE_TEST_DATA) + "/benchmarks/" + file); }

void follow(Scene& scene, Integrator& integrator, const Table& table, double end,
            const std::function<void(std::span<const double>)>& compare) {
  for (int row = 0; row < table.row_count() && table.at(row, 0) <= end * (1 + 1e-12); ++row) {
    ASSERT_NO_FATAL_FAILURE(scene.run(integrator, table.at(row, 0)));
    compare(std::span<const double>(table.values).subspan(row * table.columns.size() + 1, table.columns.size() - 1));
  }
}

}  // namespace lithe::test
