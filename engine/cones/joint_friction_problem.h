#pragma once

#include <functional>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// Friction impulses p of surfaces in joints, whose normal impulses are the joints' own reactions and grow with p:
///   u = W p + free,   N_i(p) = load_i + Σ_k |constant_k + by_k p|
///   |p_i| <= μ N_i(p), and where u_i ≠ 0: p_i = -μ N_i(p) u_i / |u_i|
/// A surface has one to three directions. μ is by the speeds at the start and the end of the step, |u_i before| and
/// |u_i|; what turns back was at rest between. A law without friction at rest never holds its surface.
struct JointFrictionProblem {
  struct Press {
    Vector3 constant;
    Matrix3X by;  // 3 x rows
  };
  struct Surface {
    int first, count;  // rows
    double load;       // N s, of what does not depend on reactions
    std::vector<Press> presses;
    std::function<double(double before, double after)> friction;  // μ by the speeds, m/s
  };
  std::vector<Surface> surfaces;
  MatrixX W;
  VectorX free, before;

  static constexpr int kMostPresses = 3;  // of a surface
  struct Result {
    bool converged;
    int sweeps;
    double change;  // of an impulse in the last sweep, N s
  };
  /// From the p given; tells which surfaces stick. Surface by surface, each exactly while the others are held, until
  /// none changes by more than round-off. Sticking is taken before sliding wherever both would do: so a joint jams
  /// where its friction would load itself without bound (Painlevé).
  Result solve(VectorX& p, std::vector<char>& sticks) const;
};

}  // namespace lithe
