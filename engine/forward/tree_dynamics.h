#pragma once

#include <memory>
#include <vector>

#include "engine/base/thread_team.h"
#include "engine/forward/rigid_scene.h"

namespace lithe {

/// Rigid bodies in a tree of lower pairs: articulated-body recursion (Featherstone, Rigid Body Dynamics Algorithms,
/// 2008, ch. 7), in world axes, from the leaves to the roots and back; cost linear in the bodies. What a joint leaves
/// free is solved for at the joint's point, so that neither multipliers nor relative coordinates are ever formed; the
/// state stays the absolute one. Several threads, if available, work on branches and islands separately; their
/// contributions are added in one order, so that the bits are the same for any number of threads.
///   F = I a + b of the subtree at that point,  Sᵀ F = 0 for the free motions S,  a = a_parent + S y + c
class TreeDynamics final : public ForwardKernel {
 public:
  /// Null if the joints close a loop.
  static std::unique_ptr<TreeDynamics> make(const RigidScene& scene);

  ForwardMethod method() const override { return ForwardMethod::tree; }
  void accelerations(const double* q, const double* v, const double* load, double* v_dot) override;
  /// Places each body on its parent, from the roots on: rotated by the small angle between the axes, then moved.
  bool project(double* q, double* v, double tolerance) override;

 private:
  enum class Kind { root, spherical, revolute, other };
  struct Link {
    Kind kind;
    int q, v;
    int parent = -1;  // index of a link before this one, -1: ground
    int other = -1;   // place in others_, of a joint of another kind
    int handed = -1;  // place in handed_, of a link whose parent is worked on apart from it
    double mass;
    Matrix3 inertia;
    Vector3 r, r_parent;        // of the joint's markers, in the axes of their bodies
    Matrix3 axes, axes_parent;  // of the markers, likewise
    JointFreedom freedom;
  };
  /// F = [M H; Hᵀ J] (a, ω̇) + (b, t), about some point; M and J symmetric.
  struct Articulated {
    Matrix3 M, H, J;
    Vector3 b, t;
  };
  /// Of a link at the present state, in world axes.
  struct Motion {
    Matrix3 A;
    Vector3 w;
    Articulated subtree;          // of the links beyond this one, about its centre of mass
    Vector3 r, r_parent;          // from both centres of mass to the joint's point
    Vector3 swing, swing_parent;  // ω × (ω × r) of both
    Matrix3 gain;                 // spherical: ω̇ = -gain a - rest
    Vector3 rest;  // revolute: ω̇ = ω̇_parent + turn_bias - axis (pull · a + twist · ω̇_parent + rest[0])
    Vector3 axis, turn_bias, pull, twist;
    Vector3 a, alpha;
  };
  struct Other {  // free motions of a joint of another kind, at its point: y = -gainᵀ (a, ω̇) - rest
    int count = 0;
    Vector6 motion[3], bias;
    Vector6 gain[3];
    double rest[3];
  };

  explicit TreeDynamics(const RigidScene& scene);
  void divide();
  void place(int i, const double* q, const double* v);
  static void clear(Articulated& a);
  static Articulated shifted_out(const Articulated& own, const Vector3& r, const Vector3& swing);
  static void add_shifted_in(Articulated& parent, const Articulated& at_joint, const Vector3& r, const Vector3& swing);
  void eliminate(int i, const double* q, const double* v, const double* load);
  void eliminate_spherical(Motion& m, Articulated& at_joint) const;
  void eliminate_revolute(const Link& link, Motion& m, const Motion& parent, Articulated& at_joint) const;
  void eliminate_other(const Link& link, const Motion& m, const Motion& parent, const double* v, Articulated& at_joint);
  void find(int i, double* v_dot);

  Vector3 gravity_;
  std::vector<Link> links_;      // parents first, each subtree in a row
  std::vector<Motion> motions_;  // of ground, then of the links
  std::vector<Other> others_;
  struct Branch {
    int first, last;  // links: one or more whole subtrees
  };
  std::vector<Branch> branches_;
  std::vector<int> trunk_;           // the links of no branch
  std::vector<Articulated> handed_;  // what branches add to links of the trunk
  std::vector<int> handed_to_;       // those links
  ThreadTeam threads_;
  double ground_[3] = {0, 0, 0};  // its place and velocity
};

}  // namespace lithe
