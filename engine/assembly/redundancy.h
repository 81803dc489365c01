#pragma once

#include <string>
#include <vector>

#include "engine/assembly/evaluator.h"
#include "engine/factor/block_structure.h"
#include "engine/model/layout.h"
#include "engine/model/system_graph.h"

/// What assemble() asks to find rows that repeat others. `values`: the blocks of [M Gᵀ; G ·] at the state in question.
namespace lithe {

/// Whether bodies and constraints make a tree: then rows of one joint never depend on those of another, however small a
/// pivot of a long chain becomes. Bodies without a frame count as loops: they may lack what a joint asks of them.
bool is_tree(const SystemGraph& graph, const Layout& layout);

/// Rows that depend on others, a line a mechanism (bodies that constraints connect).
std::string dependent_rows_text(const SystemGraph& graph, const Layout& layout, const std::vector<int>& dependent);

/// z with Gᵀ z = 0 and z = -1 in a row that is left out: the rows that it repeats. [M Gᵀ; G 0] is factorised.
VectorX null_vector(const Evaluator& evaluator, int row);

/// g M⁻¹ gᵀ of each row, bodies' couplings of frame and elastic coordinates left out: the scale on which its pivot is
/// judged.
VectorX row_compliances(const BlockStructure& blocks, const std::vector<double>& values);

/// Rows of constraints that depend on other rows of their own joint: those whose pivot falls below `tolerance` times
/// their compliance. Sorted.
std::vector<int> dependent_within_joints(const BlockStructure& blocks, const std::vector<double>& values,
                                         double tolerance);

}  // namespace lithe
