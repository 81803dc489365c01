#pragma once

#include <map>

#include "engine/base/error.h"
#include "engine/model/adjustable.h"
#include "engine/observe/snapshot.h"
#include "models/compiled/tree_internal.h"
#include "models/model_description.h"

namespace lithe {

/// Makes the tree of a compiled scene: bodies and joints (tree.cpp), then forces (tree_forces.cpp) of a system.
class CompiledTreeMaker {
 public:
  CompiledTreeMaker(const System& system, double right_angles_within)
      : graph_(system.graph()),
        now_(system, system.initial_state()),
        right_angles_within_(std::max(right_angles_within, 1e-14)) {}

  CompiledTree make();

 private:
  using Motion = CompiledTree::Motion;
  /// A link as the joints give it; its axes may still turn about z, and its origin move along it.
  struct Draft {
    int parent = -1;
    Motion motion = Motion::free;
    ModelPose inner{};  // of the joint, in the parent's draft
    std::vector<std::pair<const Body*, ModelPose>> bodies{};
    ModelPose moved{};  // of the link in its draft
  };
  struct OnBody {
    int link;
    ModelPose pose;  // of the body in the link's draft
  };
  struct Joint {
    const Constraint* constraint;
    Marker A, B;
    int link_A, link_B;
    int first_q, first_v;
    std::vector<int> axes;  // of its coordinates in order: 0 x, 1 y, 2 z, 3 turn about z
  };

  [[noreturn]] static void refuse(const Element& element, const std::string& what, const std::string& fix) {
    throw SceneError("'" + element.name() + "' cannot be compiled: " + what, "lithe compile", fix);
  }
  /// Without what round-off has left of zeros and ones.
  static double snapped(double x, double scale) { return std::abs(x) < 1e-14 * scale ? 0 : x; }

  ModelPose on_body(const Marker& marker);
  void find_tree();
  void add_free(const Body& body);
  void add_link(const Draft& draft);
  void add_joint(const SystemGraph::ConstraintEntry& entry, const Marker& inner, const Marker& outer, bool reversed);
  /// Coordinate k of a joint and its rate at the start.
  void measure(const Constraint& joint, const Marker& of_A, const Marker& of_B, int k, bool several);
  void measure_ball(const Constraint& joint, const Marker& inner, const Marker& outer);
  /// Turns a link's axes about z, and moves its origin along it, so that fewer numbers remain between it, its parent
  /// and the next link (as Denavit and Hartenberg do); then its place and its inertia.
  void place(int i);

  void add_force(const SystemGraph::ForceEntry& entry);
  CompiledTree::Number number(const Adjustable& x) const;
  /// Which freedom of a joint a coordinate is, up to a sign and a constant.
  CompiledTree::Spring on_joint(const Element& element, const JointCoordinate& coordinate);

  const SystemGraph& graph_;
  Snapshot now_;
  const double right_angles_within_;
  CompiledTree tree_;
  std::vector<Draft> drafts_;
  std::vector<Joint> joints_;
  std::map<const Body*, OnBody> places_;
  std::vector<double> q_, v_;
  double scale_ = 0;  // m
};

}  // namespace lithe
