#pragma once

#include <span>
#include <vector>

#include "engine/base/math.h"
#include "engine/base/thread_team.h"

namespace lithe {

/// Accelerations of a tree of rigid bodies whose joints are all balls. A ball hands on a force and no torque: what
/// hangs on it is, to the link before it, a mass M_e of three by three at the ball's centre and a force f there. With
/// M, H, J the inertia of a link and of what hangs on it, about its own ball, whose acceleration is a:
///   F = M a + H ω̇ + force,   0 = Hᵀ a + J ω̇ + torque
///   F = M_e a + f,   M_e = M - H J⁻¹ Hᵀ,   f = force - H J⁻¹ torque
/// It is TreeDynamics for this case, in a third of the operations. What depends on no other link is found for four
/// links at once.
class BallTree {
 public:
  struct Link {
    int q, v;    // first coordinate and velocity
    int parent;  // index of a link before this one, -1: ground or none
    bool held;   // by a ball; otherwise a body that moves freely
    double mass;
    Matrix3 inertia;      // body axes, about the centre of mass
    Vector3 r, r_parent;  // the ball's centre from the centre of mass, in the axes of the link and of its parent
  };
  struct Range {
    int first, last;
  };
  /// `branches`: whole subtrees, which threads may share; `trunk`: the links of no branch; both in the links' order.
  BallTree(const std::vector<Link>& links, std::span<const Range> branches, std::span<const int> trunk,
           const Vector3& gravity);
  void accelerations(const double* q, const double* v, const double* load, double* v_dot, ThreadTeam& threads);

 private:
  /// Four links side by side: constants, then what follows from their state, in world axes.
  struct alignas(32) Four {
    double mass[4], inertia[6][4], r[3][4];  // inertia about the ball: xx, xy, xz, yy, yz, zz
    double arm[3][4] = {};                   // the first ball beyond, from the ball; body axes
    double A[9][4], w[3][4];                 // A row by row
    double x[3][4], swing[3][4];             // centre of mass from the ball, and ω × (ω × x)
    double d[3][4], d_swing[3][4];           // likewise of the first ball beyond
    double J[6][4], force[3][4], torque[3][4];
    double a[3][4], alpha[3][4];  // of the ball's centre, and ω̇
  };
  struct Symmetric {
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    Vector3 operator*(const Vector3& a) const;
  };
  struct Node {
    int q = 0, v = 0, child = -1, sibling = -1;  // the latter: first of its children, the next of its parent's
    bool hangs = false, held = false;            // on another node; by a ball
    Vector3 arm, d, swing;                       // of its ball from its parent's as in Four, of all but the first child
    Symmetric M;                                 // M_e
    Vector3 f, a;
    double yx, zx, zy;  // below L's diagonal, J = L D Lᵀ
    Vector3 gain[3];    // Lᵀ ω̇ = -(gain · a + rest)
    Vector3 rest;
  };

  int append(const std::vector<Link>& links, std::span<const int> chosen, std::vector<int>& node_of);
  void place(int four, const double* q, const double* v, const double* loads);
  void eliminate(int i);
  void find(int i);
  void write(int four, int count, double* v_dot) const;
  void inwards(const Range& range, const double* q, const double* v, const double* load);
  void outwards(const Range& range, double* v_dot);

  const Vector3 gravity_;
  std::vector<Four> fours_;
  std::vector<Node> nodes_;  // node i is number i % 4 of fours_[i / 4]; each range starts at a multiple of four
  std::vector<Range> branches_;
  Range trunk_;
};

}  // namespace lithe
