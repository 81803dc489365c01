#include "engine/assembly/find_rigid_scene.h"

#include <algorithm>
#include <map>

#include "engine/assembly/system.h"
#include "engine/forward/planar_dynamics.h"
#include "engine/forward/tree_dynamics.h"
#include "engine/model/planar_body.h"
#include "engine/model/rigid_frame_body.h"

namespace lithe {
namespace {

/// Pose of a marker in the axes of its body, which is told by its kinematics anywhere.
RigidScene::Side side(const Marker& marker, int body, const double* q) {
  static const double none = 0;
  const auto cache = marker.body->make_cache();
  const BodyState state{body < 0 ? &none : q, &none, cache.get()};
  marker.body->evaluate(state, Level::position);
  MarkerKinematics k;
  marker.body->marker_kinematics(state, marker.index, Level::position, k);
  if (body < 0) return {-1, k.p, k.R};
  if (const auto* planar = dynamic_cast<const PlanarBody*>(marker.body)) return {body, k.p - planar->center(q), k.R};
  return {body, k.r, k.A->transpose() * k.R};
}

bool has_planar_bodies(const RigidScene& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const auto& b) { return b.in_plane; });
}

}  // namespace

std::optional<RigidScene> find_rigid_scene(const System& system) {
  const SystemGraph& graph = system.graph();
  RigidScene scene{{}, {}, graph.gravity(), system.initial_state().q, 1};
  if (graph.constraints().empty() || !system.velocity_rows().empty()) return std::nullopt;
  for (const auto& f : graph.forces())
    if (f.force->reaction_of()) return std::nullopt;
  scene.bodies.reserve(system.layout().bodies().size());
  scene.joints.reserve(graph.constraints().size());
  std::map<const Body*, int> index{{graph.bodies().front().body, -1}};
  for (const auto& slice : system.layout().bodies()) {
    if (const auto* planar = dynamic_cast<const PlanarBody*>(slice.body)) {
      const PlanarBody::Plane& body = planar->plane();
      int normal = 0;
      if (body.axes.col(2).maxCoeff(&normal) != 1) return std::nullopt;
      index[slice.body] = static_cast<int>(scene.bodies.size());
      scene.bodies.push_back({slice.q, slice.v, body.mass, body.inertia * Matrix3::Identity(), true, normal});
      continue;
    }
    const auto* inertia = rigid_inertia_of(*slice.body);
    if (!inertia || !slice.frame || slice.linear > 0) return std::nullopt;
    index[slice.body] = static_cast<int>(scene.bodies.size());
    scene.bodies.push_back({slice.q, slice.v, inertia->mass, inertia->inertia});
  }
  const auto side_of = [&](const Marker& m) {
    const int body = index.at(m.body);
    return side(m, body, body < 0 ? nullptr : scene.q.data() + scene.bodies[body].q);
  };
  for (const auto& c : graph.constraints()) {
    const auto freedom = c.constraint->freedom();
    if (!freedom || c.markers.size() != 2 || c.markers[0].body == c.markers[1].body) return std::nullopt;
    scene.joints.push_back({side_of(c.markers[0]), side_of(c.markers[1]), *freedom});
  }
  return scene;
}

std::unique_ptr<ForwardKernel> make_forward_kernel(const RigidScene& scene) {
  if (auto kernel = PlanarDynamics::make(scene)) return kernel;
  return has_planar_bodies(scene) ? nullptr : TreeDynamics::make(scene);
}

/// A tree's kernel is not made for it: it may take more memory than all else, and implicit methods do not ask for it.
ForwardMethod find_forward_method(const System& system) {
  const auto scene = find_rigid_scene(system);
  if (!scene) return ForwardMethod::constraints;
  if (PlanarDynamics::make(*scene)) return ForwardMethod::planar;
  return !has_planar_bodies(*scene) && TreeDynamics::serves(*scene) ? ForwardMethod::tree : ForwardMethod::constraints;
}

}  // namespace lithe
