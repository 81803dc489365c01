#pragma once

#include "engine/cones/cone_problem.h"

namespace lithe {

/// Bullet's solvers of mixed linear complementarity problems, for comparison: w = W r + free, lo <= r <= hi, on the
/// dense operator (Bullet's own signs: A x - b = w, with b = -free).
/// - Friction by a pyramid: |r_1| <= μ r_n, |r_2| <= μ r_n each by itself: up to √2 too much between the axes, and not
///   against the slip. So are rolling moments. The reported residual is that of the cone, so these rarely converge.
/// - dantzig: the limits are taken from the normal impulses without friction. Gave up on stacks with four corners a
///   face, with compliance too.
/// - lemke: cannot move limits; they are taken from the last solution, `iterations` times. Inverts W: where it
///   is singular, with compliance alone. Gives up on impulses beyond 1e5 N s.
/// - projected_gauss_seidel: row by row, `iterations` sweeps.
/// Where Bullet gives up or returns no finite values: r = 0, not converged.
class BulletMlcp final : public ConeSolver {
 public:
  enum class Method { dantzig, lemke, projected_gauss_seidel };
  struct Parameters {
    Method method = Method::dantzig;
    int iterations = 50;
    double compliance = 0;  // added to the diagonal, of its own entries: redundant contacts (Bullet's "global CFM")
  };
  BulletMlcp() = default;
  explicit BulletMlcp(Parameters parameters) : parameters_(parameters) {}

  std::string name() const override;
  ConeResult solve(const ConeProblem& problem, double tolerance, VectorX& r) override;
  std::unique_ptr<ConeSolver> clone() const override { return std::make_unique<BulletMlcp>(parameters_); }

 private:
  Parameters parameters_;
};

}  // namespace lithe
