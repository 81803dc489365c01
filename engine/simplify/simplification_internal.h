#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/assembly/evaluated.h"
#include "engine/factor/graph_topology.h"
#include "engine/model/rigid_frame_body.h"
#include "engine/simplify/simplification.h"

namespace lithe {

/// Makes the smaller scene, in the order of its functions.
class Simplifier {
 public:
  Simplifier(SystemGraph& whole, const SimplificationOptions& options, Simplification& made);
  void run();

 private:
  static constexpr int kGround = -1;
  struct Item {  // a body of the smaller scene
    std::vector<int> bodies;
    bool rigid = false;
    RigidInertia inertia{};
    FramePose start, drawn;  // of its frame
    int plane = -1;          // index into planes_; -1: none
    Body* body = nullptr;
  };
  using Tie = SystemGraph::ConstraintEntry;
  struct LowerPair {  // between rigid items, or one and ground
    int a, b;
    JointFreedom freedom;
    Matrix3 axes;  // of its first marker
  };

  /// The first of the body's.
  const Layout::BodySlice& slice(int body) const { return system_.layout().bodies()[slices_[body]]; }
  const State& initial() const { return system_.initial_state(); }
  int body_of(const Marker& m) const { return m.body == &whole_.ground() ? kGround : number_.at(m.body); }
  /// The item a marker moves with.
  int item_of(const Marker& m) const {
    const int body = body_of(m);
    return body == kGround ? kGround : item_[body];
  }
  FramePose frame(int body, const VectorX& q) const {
    return {q.segment<3>(slice(body).q), rotation_matrix(q.segment<4>(slice(body).q + 3))};
  }
  FramePose pose(const Marker& m);
  std::string name(const Item& item) const;
  void say(const std::string& line);

  // Bodies welded to each other and to ground: simplification_welds.cpp.
  void find_welds();
  bool may_go(const Tie& joint);
  int find_refused();
  bool is_within(const std::vector<Marker>& markers) const;
  void make_items();
  void compose(Item& item) const;
  void report_welds();

  // Bodies that joints hold in planes: simplification_planes.cpp.
  void find_planes();
  std::vector<LowerPair> lower_pairs(Topology& all, bool& tree);
  std::vector<Vector3> normals(const std::vector<LowerPair>& joints) const;
  std::vector<char> held_in_plane(const std::vector<LowerPair>& joints, const Vector3& normal) const;
  void keep_forward_method();
  std::vector<int> rows_that_act(const Tie& joint);

  // The smaller graph.
  bool stands_in(int item) const {
    return item != kGround && (items_[item].bodies.size() > 1 || items_[item].plane >= 0);
  }
  void draw_bodies();
  Marker moved(const Marker& m);
  std::vector<Marker> moved(const std::vector<Marker>& markers);
  void draw_connectors();
  void draw_constraint(int number, std::vector<std::string>& idle);
  void draw_force(const SystemGraph::ForceEntry& force);
  void draw_contact(const SystemGraph::ContactEntry& contact);
  bool is_on_ground(const std::vector<Marker>& markers) const;
  void keep_angles(int first, int count);
  void note_slices();

  SystemGraph& whole_;
  const SimplificationOptions& options_;
  Simplification& made_;
  const System& system_;
  Evaluator start_, drawn_;  // at the consistent start, and as drawn
  VectorX drawn_q_;
  std::map<const Body*, int> number_;
  std::vector<const SystemGraph::BodyEntry*> entries_;  // of bodies
  std::map<const Constraint*, std::string> consumers_;  // force elements, by the joint whose reaction they want
  std::vector<int> slices_;                             // of bodies, indices into the layout's
  std::vector<char> rigid_, held_;                      // of bodies; of groups
  std::vector<int> group_, size_;                       // of bodies; of groups
  std::vector<const Tie*> welded_;
  std::vector<int> item_;  // of bodies
  std::vector<Item> items_;
  std::vector<Matrix3> planes_;
  std::map<std::pair<const Body*, int>, Marker> markers_;
  int left_out_ = 0;                                     // rows
  int angle_ = 0;                                        // of the whole's, the next one
  std::vector<std::pair<const Tie*, int>> only_counts_;  // joints without a row left, and their first angle
};

/// "'a', 'b' and 'c'"
std::string quoted(const std::vector<std::string>& names);

}  // namespace lithe
