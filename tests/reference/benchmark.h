#pragma once

#include "engine/output/csv.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test {

/// Reference table of a benchmark (shared/reference/benchmarks): "R06_chain_spherical/reference_N4.csv".
inline Table reference(const std::string& file) {
  return read_csv(std::string(LITHE_TEST_DATA) + "/benchmarks/" + file);
}

/// Runs `scene` to each row's time up to `end` and calls compare(row): the columns after the time.
template <class Compare>
void follow(Scene& scene, Integrator& integrator, const Table& table, double end, Compare&& compare) {
  for (int row = 0; row < table.row_count() && table.at(row, 0) <= end * (1 + 1e-12); ++row) {
    ASSERT_NO_FATAL_FAILURE(scene.run(integrator, table.at(row, 0)));
    compare(std::span<const double>(table.values).subspan(row * table.columns.size() + 1, table.columns.size() - 1));
  }
}

}  // namespace lithe::test
