#pragma once

#include <functional>
#include <span>
#include <vector>

#include "engine/base/math.h"
#include "engine/factor/block_structure.h"

/// Products with the blocks of G, and all blocks in turn. `values`: the array that a BlockStructure describes.
namespace lithe {

/// Adds Gᵀ (lambda, tension) to `force`: `lambda` has one number for each of `constraint_rows` rows, `tension` one for
/// each compliant row. Null: those rows are left out.
void add_row_forces(const BlockStructure& blocks, const std::vector<double>& values, int constraint_rows,
                    const double* lambda, const double* tension, double* force);

/// The same of some Jacobians, by their index.
void add_row_forces(const BlockStructure& blocks, const std::vector<double>& values, std::span<const int> jacobians,
                    int constraint_rows, const double* lambda, const double* tension, double* force);

/// Adds G v of the constraint rows to `rates`.
void add_rates(const BlockStructure& blocks, const std::vector<double>& values, const double* v, VectorRef rates);

/// Every block of [S Gᵀ; G -C]: row, column (rows of G follow the velocities) and its values. Those of -C come last.
void visit_blocks(const BlockStructure& blocks, const std::vector<double>& values,
                  const std::function<void(int row, int column, ConstMatrixRef block)>& visit);

}  // namespace lithe
