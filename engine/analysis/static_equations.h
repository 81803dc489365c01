#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "engine/assembly/evaluator.h"

namespace lithe {

/// The balance of a system at rest and its Newton matrix, for the searches of equilibria:
///   F(q, λ) = Gᵀ λ - f(q, 0, t),   g(q, t);   [K + σM  Gᵀ; G  0] (d, Δλ),   K = ∂F/∂q
/// d turns and moves the pose evaluated last: q ⊕ d. Solved by KLU with pivoting, since K may be indefinite. Redundant
/// rows are left out: their g and λ are zero.
class StaticEquations {
 public:
  explicit StaticEquations(Evaluator& equations);
  ~StaticEquations();

  /// Fills force and gap at a pose.
  void evaluate(double time, ConstVectorRef q, ConstVectorRef lambda);
  VectorX force;  // F, N, N m, or of the unit of a modal coordinate
  VectorX gap;    // g

  /// The matrix at the pose evaluated last, and what round-off leaves of F there. False: singular, or not finite.
  bool factorize(double shift, ConstVectorRef lambda);
  /// (d, l) <- matrix⁻¹ (d, l). False: not finite.
  bool solve(VectorX& d, VectorX& l) const;
  /// The same with what the bodies' tangents leave out (the stiffness that loads have through deformed markers): GMRES
  /// (Saad & Schultz 1986) on the differenced equations, preconditioned by the factor. The factor is that of the pose
  /// evaluated last, with these multipliers; `length`: a motion over which the equations are smooth.
  bool solve_exactly(VectorX& d, VectorX& l, ConstVectorRef lambda, double length);
  /// K d by differences of fourth order over `length`, multipliers held; the pose evaluated last stays. `coarse`: dᵀ K
  /// d of second order.
  VectorX stiffness_times(const VectorX& d, ConstVectorRef lambda, double length, double* coarse = nullptr);
  /// Whether K + σM, as factorised last, is positive for all motions that the rows allow. False: it may not be.
  bool surely_convex() const;
  /// How many motions the rows allow.
  int freedoms() const;
  /// M d at the pose evaluated last with these multipliers; force must still be that pose's.
  VectorX mass_times(ConstVectorRef d, ConstVectorRef lambda) const;
  /// Of each entry of force: how much it changes where coordinates and multipliers change by their last bits.
  const VectorX& round_off() const { return round_off_; }

  void leave_out_redundant(VectorX& lambda) const;
  double largest_gap() const { return gap.size() > 0 ? gap.lpNorm<Eigen::Infinity>() : 0; }

 private:
  void collect();
  void product(const VectorX& x, ConstVectorRef lambda, double length, VectorX& out);
  void find_round_off(ConstVectorRef q, ConstVectorRef lambda);

  Evaluator& equations_;
  const int velocities_, rows_;
  std::vector<char> redundant_;
  double time_ = 0, shift_ = 0;
  VectorX q_, still_, round_off_, magnitudes_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::SparseMatrix<double> sparse_;
  class Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace lithe
