#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/output/table.h"

namespace lithe {

/// Parameters of a sweep are a Table: a column a parameter, a row a point. Written by hand, read by read_csv(), or made
/// by grid() or latin_hypercube().

/// A parameter and the values that it takes.
struct SweepAxis {
  std::string name;
  std::vector<double> values;
};
/// A parameter and its bounds.
struct SweepRange {
  std::string name;
  double lower = 0, upper = 1;
};

/// All combinations (full factorial), the last parameter changing fastest. Throws SceneError: no axis, an axis without
/// name or values, a name twice.
Table grid(const std::vector<SweepAxis>& axes);

/// `count` points at random, spread evenly: of the `count` equal parts of each range, every one holds exactly one point
/// (McKay, Beckman, Conover, Technometrics 21, 1979). The same seed gives the same points, on any machine. Another
/// distribution comes of a range from 0 to 1 and the inverse of its distribution function, in the scene. Throws
/// SceneError: no range, fewer than one point, bounds that do not rise, a name twice.
Table latin_hypercube(const std::vector<SweepRange>& ranges, int count, std::uint64_t seed);

/// `count` values from `first` to `last`, both met exactly. Throws SceneError for fewer than two.
std::vector<double> evenly_spaced(double first, double last, int count);

}  // namespace lithe
