#pragma once

#include <vector>

#include "engine/factor/block_factor.h"
#include "engine/factor/block_structure.h"

namespace lithe {

class Evaluator;

/// The multipliers of least norm |λ| among all with the same Gᵀ λ: the part of λ in the range of G. Linear cost,
/// however many rows are redundant, and no row is singled out.
///
/// With A = G Gᵀ, (1 - δ (A + δ)⁻¹) λ keeps that part but for a share δ/σ² and takes the rest away; what it took of the
/// force comes back by steps λ += (A + δ)⁻¹ G (F - Gᵀ λ), which stay in the range (proximal point iteration;
/// Rockafellar 1976). (A + δ)⁻¹ is the block factor of [1 Gᵀ; G -δ], which has a pivot for every row at every pose.
class LeastNorm {
 public:
  explicit LeastNorm(const BlockStructure& structure);

  /// `values`: the blocks of G at the pose, in the structure's places.
  void apply(const std::vector<double>& values, VectorRef lambda);
  /// The same of a copy, which is kept: asked again for the same λ, it is not computed again, until forget().
  const VectorX& of(const std::vector<double>& values, ConstVectorRef lambda);
  /// The blocks have changed.
  void forget() { loaded_ = known_ = false; }

 private:
  static BlockStructure with_compliance(const BlockStructure& structure);
  void load(const std::vector<double>& values);
  void filter(VectorRef lambda);

  BlockStructure structure_;
  BlockFactor factor_;
  std::vector<double> values_;
  VectorX force_, x_;
  VectorX asked_, copy_;  // of()
  bool loaded_ = false, known_ = false;
};

/// Once: the multipliers of least norm with the same Gᵀ λ at the state evaluated last. Does nothing without redundant
/// rows.
void minimize_norm(const Evaluator& evaluator, VectorRef lambda);

}  // namespace lithe
