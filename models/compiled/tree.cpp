#include <algorithm>
#include <queue>

#include "engine/model/rigid_frame_body.h"
#include "models/compiled/tree_maker_internal.h"
#include "models/link_graph_internal.h"

namespace lithe {
namespace {

ModelPose about_z(double angle) {
  return {Vector3::Zero(), Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix()};
}
/// Axes whose z is axis k of these.
ModelPose z_along(int k) {
  Matrix3 R = Matrix3::Zero();
  for (int i = 0; i < 3; ++i) R((k + 1 + i) % 3, i) = 1;
  return {Vector3::Zero(), R};
}
ModelPose seen_back(const ModelPose& pose) { return seen_from(pose, {}); }

CompiledTree::Link::Angle angle(double c, double s, double within) {
  const double length = std::hypot(c, s);
  c /= length, s /= length;
  if (std::abs(s) < within) s = 0, c = c > 0 ? 1 : -1;
  if (std::abs(c) < within) c = 0, s = s > 0 ? 1 : -1;
  return {c, s};
}
/// R = Rz(first) Rx(tilt) Rz(last); without tilt all of it in the last.
void find_angles(const Matrix3& R, double within, CompiledTree::Link& link) {
  link.tilt = angle(R(2, 2), std::hypot(R(0, 2), R(1, 2)), within);
  if (link.tilt.s == 0) {
    link.first = {};
    link.last = angle(R(0, 0), link.tilt.c * R(1, 0), within);
  } else {
    link.first = angle(-R(1, 2), R(0, 2), within);
    link.last = angle(R(2, 1), R(2, 0), within);
  }
}

void add_name(std::vector<std::string>& names, const Element& element, std::initializer_list<const char*> parts) {
  for (const char* part : parts) names.push_back(element.name() + part);
}
void add_inertia(const RigidInertia& body, const ModelPose& pose, CompiledTree::Link& link) {
  const Matrix3 arm = skew(pose.position);
  link.mass += body.mass;
  link.moment += body.mass * pose.position;
  link.inertia += pose.rotation * body.inertia * pose.rotation.transpose() - body.mass * arm * arm;
}

}  // namespace

CompiledTree CompiledTreeMaker::make() {
  tree_.gravity = graph_.gravity();
  tree_.inputs.assign(graph_.inputs().begin(), graph_.inputs().end());
  if (!graph_.contacts().empty()) refuse(*graph_.contacts().front().contact, "it is a contact", "leave it out");
  for (std::size_t b = 1; b < graph_.bodies().size(); ++b)
    if (!rigid_inertia_of(*graph_.bodies()[b].body))
      refuse(*graph_.bodies()[b].body, "it is no RigidBody", "draw it rigid, or run the scene by the engine");
  find_tree();
  for (std::size_t i = 0; i < drafts_.size(); ++i) place(static_cast<int>(i));
  for (const auto& entry : graph_.forces()) add_force(entry);
  tree_.q = Eigen::Map<const VectorX>(q_.data(), static_cast<Eigen::Index>(q_.size()));
  tree_.v = Eigen::Map<const VectorX>(v_.data(), static_cast<Eigen::Index>(v_.size()));
  return std::move(tree_);
}

ModelPose CompiledTreeMaker::on_body(const Marker& marker) {
  const MarkerKinematics k = now_.marker(marker);
  if (marker.body == graph_.bodies().front().body) return {k.p, k.R};
  return {k.r, k.A->transpose() * k.R};
}

void CompiledTreeMaker::find_tree() {
  std::map<const Body*, std::vector<const SystemGraph::ConstraintEntry*>> joints_of;
  for (const auto& entry : graph_.constraints()) {
    if (!entry.constraint->freedom() || entry.markers.size() != 2)
      refuse(*entry.constraint, "it is no lower pair that moves freely",
             "hinges, slides, cylindrical, planar, ball and fixed joints can be");
    for (const Marker& marker : entry.markers) {
      joints_of[marker.body].push_back(&entry);
      if (marker.body != graph_.bodies().front().body) scale_ = std::max(scale_, on_body(marker).position.norm());
    }
  }
  std::queue<std::pair<const Body*, const SystemGraph::ConstraintEntry*>> open;  // and by which it was found
  const auto hang = [&](const Body* body) {
    open.emplace(body, nullptr);
    while (!open.empty()) {
      const auto [from, by] = open.front();
      open.pop();
      for (const auto* entry : joints_of[from]) {
        if (entry == by) continue;
        const bool reversed = entry->markers[1].body == from;
        const Marker &inner = entry->markers[reversed ? 1 : 0], &outer = entry->markers[reversed ? 0 : 1];
        if (places_.contains(outer.body))
          refuse(*entry->constraint, "it closes a loop",
                 "open the loop, or run the scene by the engine, which closes it");
        add_joint(*entry, inner, outer, reversed);
        open.emplace(outer.body, entry);
      }
    }
  };
  const Body* ground = graph_.bodies().front().body;
  places_[ground] = {-1, {}};
  hang(ground);
  for (const auto& entry : graph_.bodies()) {
    if (places_.contains(entry.body)) continue;
    add_free(*entry.body);
    hang(entry.body);
  }
}

void CompiledTreeMaker::add_free(const Body& body) {
  places_[&body] = {static_cast<int>(drafts_.size()), {}};
  const BodyState state = now_.body_state(body);
  add_link({.bodies = {{&body, {}}}});
  q_.insert(q_.end(), state.q, state.q + 7);
  v_.insert(v_.end(), state.v, state.v + 6);
  add_name(tree_.position_names, body, {".p_x", ".p_y", ".p_z", ".e_w", ".e_x", ".e_y", ".e_z"});
  add_name(tree_.velocity_names, body, {".v_x", ".v_y", ".v_z", ".omega_x", ".omega_y", ".omega_z"});
}

void CompiledTreeMaker::add_link(const Draft& draft) {
  CompiledTree::Link link{.parent = draft.parent, .motion = draft.motion};
  link.q = static_cast<int>(q_.size()), link.v = static_cast<int>(v_.size());
  tree_.links.push_back(link);
  drafts_.push_back(draft);
}

void CompiledTreeMaker::add_joint(const SystemGraph::ConstraintEntry& entry, const Marker& inner, const Marker& outer,
                                  bool reversed) {
  const OnBody from = places_.at(inner.body);
  const JointFreedom freedom = *entry.constraint->freedom();
  const bool ball = freedom.rotation == JointFreedom::Rotation::any;
  std::vector<int> axes;
  for (int k = 0; k < 3; ++k)
    if (k == 0 ? freedom.x : k == 1 ? freedom.y : freedom.z) axes.push_back(k);
  if (freedom.rotation == JointFreedom::Rotation::about_z) axes.push_back(3);
  if (ball && !axes.empty())
    refuse(*entry.constraint, "it slides and turns about all axes", "draw a slide and a ball with a body between");
  if (reversed) std::reverse(axes.begin(), axes.end());
  joints_.push_back({entry.constraint, entry.markers[0], entry.markers[1], -1, -1, static_cast<int>(q_.size()),
                     static_cast<int>(v_.size()), axes});
  int parent = from.link;
  ModelPose inwards = from.pose * on_body(inner), outwards = seen_back(on_body(outer));
  if (ball) {
    add_link({.parent = parent, .motion = Motion::ball, .inner = inwards});
    parent = static_cast<int>(drafts_.size()) - 1;
    inwards = {};
    measure_ball(*entry.constraint, inner, outer);
  }
  for (const int k : axes) {
    // Backwards, a joint moves by the opposite: its frames are turned upside down.
    ModelPose own = k < 3 ? z_along(k) : ModelPose{};
    if (reversed) own = own * ModelPose{Vector3::Zero(), Vector3(1, -1, -1).asDiagonal()};
    add_link({.parent = parent, .motion = k < 3 ? Motion::slide : Motion::turn, .inner = inwards * own});
    parent = static_cast<int>(drafts_.size()) - 1;
    inwards = seen_back(own);
    measure(*entry.constraint, entry.markers[0], entry.markers[1], k, axes.size() > 1);
  }
  const ModelPose body = inwards * outwards;
  places_[outer.body] = {parent, body};
  if (parent >= 0) drafts_[parent].bodies.emplace_back(outer.body, body);
  joints_.back().link_A = places_.at(entry.markers[0].body).link;
  joints_.back().link_B = places_.at(entry.markers[1].body).link;
}

void CompiledTreeMaker::measure(const Constraint& joint, const Marker& of_A, const Marker& of_B, int k, bool several) {
  const MarkerKinematics A = now_.marker(of_A), B = now_.marker(of_B);
  if (k < 3) {
    const Vector3 apart = B.p - A.p;
    q_.push_back(A.R.col(k).dot(apart));
    v_.push_back(A.R.col(k).dot(B.v - A.v - A.w.cross(apart)));
  } else {
    q_.push_back(std::atan2(A.R.col(1).dot(B.R.col(0)), A.R.col(0).dot(B.R.col(0))));
    v_.push_back(A.R.col(2).dot(B.w - A.w));
  }
  const char* kParts[] = {".x", ".y", ".z", ".angle"};
  for (auto* names : {&tree_.position_names, &tree_.velocity_names})
    names->push_back(joint.name() + (several ? kParts[k] : ""));
}

void CompiledTreeMaker::measure_ball(const Constraint& joint, const Marker& inner, const Marker& outer) {
  const MarkerKinematics A = now_.marker(inner), B = now_.marker(outer);
  const Vector4 e = quaternion_of(A.R.transpose() * B.R);
  const Vector3 w = B.R.transpose() * (B.w - A.w);
  q_.insert(q_.end(), e.data(), e.data() + 4);
  v_.insert(v_.end(), w.data(), w.data() + 3);
  add_name(tree_.position_names, joint, {".e_w", ".e_x", ".e_y", ".e_z"});
  add_name(tree_.velocity_names, joint, {".omega_x", ".omega_y", ".omega_z"});
}

void CompiledTreeMaker::place(int i) {
  Draft& draft = drafts_[i];
  CompiledTree::Link& link = tree_.links[i];
  const ModelPose inner = draft.parent < 0 ? draft.inner : seen_from(drafts_[draft.parent].moved, draft.inner);
  if (draft.motion == Motion::turn || draft.motion == Motion::slide) {
    const auto next = std::find_if(drafts_.begin(), drafts_.end(), [i](const Draft& d) { return d.parent == i; });
    double turn = 0, along = 0;
    if (next != drafts_.end()) {
      const Vector3 z = next->inner.rotation.col(2);
      if (std::hypot(z[0], z[1]) > 1e-14)
        turn = std::atan2(z[0], -z[1]);
      else if (next->inner.position.head<2>().norm() > 1e-14 * scale_)
        turn = std::atan2(next->inner.position[1], next->inner.position[0]);
    }
    if (draft.parent >= 0) {
      int k = 0;
      inner.rotation.col(2).cwiseAbs().maxCoeff(&k);
      along = -inner.position[k] / inner.rotation(k, 2);
    }
    draft.moved = ModelPose{{0, 0, along}, about_z(turn).rotation};
  }
  const ModelPose at = inner * draft.moved;
  for (int k = 0; k < 3; ++k) link.shift[k] = snapped(at.position[k], scale_);
  find_angles(at.rotation, right_angles_within_, link);
  for (const auto& [body, pose] : draft.bodies)
    add_inertia(*rigid_inertia_of(*body), seen_from(draft.moved, pose), link);
  const double size = link.mass * scale_, trace = link.inertia.trace();
  for (int k = 0; k < 3; ++k) {
    link.moment[k] = snapped(link.moment[k], size);
    for (int j = 0; j < 3; ++j) link.inertia(k, j) = snapped(link.inertia(k, j), trace);
  }
}

CompiledTree CompiledTree::of(const System& system, double right_angles_within) {
  return CompiledTreeMaker(system, right_angles_within).make();
}

}  // namespace lithe
