#pragma once

#include "engine/base/math.h"

namespace lithe {

/// Entries of the lower triangle of a sparse symmetric linear block, sorted by column, diagonal first.
struct LinearPattern {
  Eigen::VectorXi rows, columns;
};

}  // namespace lithe
