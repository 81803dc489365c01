#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/output/table.h"

namespace lithe::test {

/// Columns of a table, by number, that are added up to one of ADAMS's.
using AddedColumns = std::vector<int>;

/// A run of 5 s, a row every 0.01 s, beside all result files of ADAMS of that name (tests/data/adams): for position,
/// velocity, acceleration, quaternion, angular velocity and acceleration, force and torque the table's columns. Within
/// how far ADAMS is from an independent Newton-Euler run (tests/data/adams/README.md), and the next step of its second
/// digit; each bound is small enough to see a wrong sign.
void expect_adams_results(const std::string& name, const Table& table,
                          const std::array<std::vector<AddedColumns>, 8>& columns);

}  // namespace lithe::test
