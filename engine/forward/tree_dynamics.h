#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/base/lanes.h"
#include "engine/base/thread_team.h"
#include "engine/forward/ball_tree.h"
#include "engine/forward/rigid_scene.h"

namespace lithe {

/// Rigid bodies in a tree of lower pairs: articulated-body recursion (Featherstone, Rigid Body Dynamics Algorithms,
/// 2008, ch. 7), in world axes, from the leaves to the roots and back; cost linear in the bodies. Neither multipliers
/// nor relative coordinates are ever formed; the state stays the absolute one. Several threads, if available, work on
/// branches and islands separately; their contributions are added in one order, so that the bits are the same for any
/// number of threads.
///   F = I a + p of a subtree,  Sᵀ F = 0 for the free motions S of its joint,  a = a_parent + S y + c
/// A few links in a row share the point that I, p and a refer to, the centre of mass of the first: there is nothing to
/// shift between them, and their arms stay short beside their own size. Where all joints are balls, BallTree does it.
class TreeDynamics final : public ForwardKernel {
 public:
  /// Whether it can: the joints close no loop, and none both slides and turns about every axis.
  static bool serves(const RigidScene& scene);
  /// Null if it cannot.
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
    int parent = -1;     // index of a link before this one, -1: ground
    int first_free = 0;  // place in free_ of its joint's free motions
    int handed = -1;     // place in handed_, of a link whose parent is worked on apart from it
    int depth = 0;       // links before it
    double mass;
    Matrix3 inertia;
    Vector3 r, r_parent;        // of the joint's markers, in the axes of their bodies
    Matrix3 axes, axes_parent;  // of the markers, likewise
    JointFreedom freedom;
    bool leads() const { return depth % kTogether == 0; }  // its centre of mass is the point that links refer to
    bool slides() const { return freedom.x || freedom.y || freedom.z; }
  };
  static constexpr int kTogether = 4;
  using Spatial = lanes::Spatial;
  struct Articulated {
    Spatial column[6];  // of I
    Spatial p;
    void clear();
    void add(const Articulated& other);
    Spatial times(const Spatial& s) const;
    /// I -= u gᵀ, p -= u rest.
    void subtract(const Spatial& u, const Spatial& g, double rest);
  };
  /// Of a link at the present state, in world axes.
  struct Motion {
    Articulated subtree;  // of the links beyond this one
    Spatial a;            // (acceleration of the body's point at the reference, ω̇)
    Spatial c;            // what a differs by from the parent's besides free motions
    lanes::Columns A;
    Lanes w;
    Lanes x;      // its centre of mass from the reference
    Lanes shift;  // of one that leads: its reference from the parent's
  };
  struct FreeMotion {
    Spatial S, gain;  // y = -gain · a - rest
    double rest;
  };

  explicit TreeDynamics(const RigidScene& scene);
  void divide();
  void place(int i, const double* q, const double* v);
  void add_own(const Link& link, Motion& m, const double* v, const double* load) const;
  int find_free_motions(const Link& link, Motion& m, const Motion& parent, const double* q, const double* v);
  static void shift(Articulated& subtree, const Lanes& d, const Lanes& w_parent);
  void eliminate(int i, const double* q, const double* v, const double* load);
  void find(int i, double* v_dot);

  Lanes gravity_;
  std::vector<Link> links_;      // parents first, each subtree in a row
  std::vector<Motion> motions_;  // of ground, then of the links
  std::vector<FreeMotion> free_;
  std::vector<BallTree::Range> branches_;  // of links: one or more whole subtrees
  std::vector<int> trunk_;                 // the links of no branch
  std::vector<Articulated> handed_;        // what branches add to links of the trunk
  std::vector<int> handed_to_;             // those links
  std::optional<BallTree> balls_;
  ThreadTeam threads_;
  double ground_[3] = {0, 0, 0};  // its place and velocity
};

}  // namespace lithe
