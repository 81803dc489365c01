#pragma once

#include <functional>
#include <span>
#include <string>

#include "engine/output/csv.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test {

/// Reference table of a benchmark (shared/reference/benchmarks): "R06_chain_spherical/reference_N4.csv".
Table reference(const std::string& file);

/// Runs `scene` to each row's time up to `end` and calls compare(row): the columns after the time.
void follow(Scene& scene, Integrator& integrator, const Table& table, double end,
            const std::function<void(std::span<const double>)>& compare);

}  // namespace lithe::test
