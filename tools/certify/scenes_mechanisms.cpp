// Linkages in the x-z plane, driven at the crank; hinges turn about y.
#include <cmath>

#include "bodies/shapes.h"
#include "engine/assembly/batch_of.h"
#include "joints/coordinate_drive.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tools/certify/scenes.h"

namespace lithe::certify {
namespace {

const Matrix3 kAboutY = axes_along(Vector3::UnitY());

/// A straight rigid link between two places, and the hinge at its first.
RigidBody& crank(SystemGraph& graph, const std::string& name, const Vector3& from, const Vector3& to) {
  const Vector3 along = to - from;
  const MassProperties shape = box({along.norm(), 0.02, 0.02}, 7800);
  return graph.add<RigidBody>(name, {.mass = shape.mass,
                                     .inertia = shape.inertia,
                                     .position = 0.5 * (from + to),
                                     .orientation = rotation_about({0, 1, 0}, -std::atan2(along.z(), along.x()))});
}

/// An elastic rod between two places: hinged to a holder at half height of its root, its other end free.
struct Rod {
  SolidModel solid;
  std::vector<int> edge;
  ElasticPart part;
};
Rod rod_between(SystemGraph& graph, ElasticParts& parts, const std::string& name, const Places& holder,
                const Vector3& from, const Vector3& to, double thickness, const Material& material, double damping) {
  const Vector3 along = to - from;
  const double w = thickness;
  const SolidModel solid = bar({along.norm(), w, w}, {12, 1, 2}, material);
  const std::vector<int> edge =
      nodes_where(*solid, [w](const Vector3& p) { return p.x() < 1e-9 && std::abs(p.z() - w / 2) < 1e-9; });
  const Matrix3 turned = rotation_about({0, 1, 0}, -std::atan2(along.z(), along.x()));
  ElasticPart part = parts.add(graph, name,
                               {.solid = solid,
                                .frame = HingeFrame{edge},
                                .eigenmodes = 10,
                                .loaded = {solid->node_set("x1")},
                                .stiffness_damping = damping,
                                .position = from - turned * Vector3(0, w / 2, w / 2),
                                .orientation = turned});
  hold(graph, name + "_pin", holder, part, edge);
  return {solid, edge, part};
}

std::vector<Sensor> slider_crank(SystemGraph& graph, ElasticParts& parts, double speed, double run_up_time,
                                 const Material& material, double damping) {
  const Vector3 pin(0.15, 0, 0), end(0.45, 0, 0);
  auto& arm = crank(graph, "crank", {0, 0, 0}, pin);
  auto& shaft =
      graph.add<RevoluteJoint>("shaft", {graph.ground().marker({}, kAboutY), on(arm)(Vector3::Zero(), kAboutY)});
  graph.add<CoordinateDrive>("motor", {shaft.angle()}, {.motion = run_up(speed, run_up_time)});
  Rod rod = rod_between(graph, parts, "rod", on(arm), pin, end, 0.01, material, damping);
  auto& slider = graph.add<RigidBody>("slider", {.mass = 0.1, .inertia = {1e-5, 1e-5, 1e-5}, .position = end});
  graph.add<SphericalJoint>("wrist", {rod.part.average("x1"), slider.marker()});
  const Matrix3 along_x = axes_along(Vector3::UnitX());
  graph.add<PrismaticJoint>("guide", {graph.ground().marker({}, along_x), slider.marker({}, along_x)});
  const Marker middle = rod.part.node(node_at(*rod.solid, {0.15, 0.005, 0.005}));
  return {position(slider.marker(), "slider"),
          deflection_between(middle, arm.marker({0.075, 0, 0}), slider.marker(), "bend")};
}

std::vector<Sensor> four_bar(SystemGraph& graph, ElasticParts& parts) {
  // Crank along x; the place where coupler and rocker meet, by their lengths.
  const double coupler = 0.45, rocker = 0.3, base = 0.5, arm = 0.12, gap = base - arm;
  const double x = (coupler * coupler - rocker * rocker + gap * gap) / (2 * gap);
  const Vector3 pin(arm, 0, 0), knee(arm + x, 0, std::sqrt(coupler * coupler - x * x)), post(base, 0, 0);
  auto& driver = crank(graph, "crank", {0, 0, 0}, pin);
  auto& shaft =
      graph.add<RevoluteJoint>("shaft", {graph.ground().marker({}, kAboutY), on(driver)(Vector3::Zero(), kAboutY)});
  auto& motor = graph.add<CoordinateDrive>("motor", {shaft.angle()}, {.motion = run_up(30, 0.15)});
  Rod rod = rod_between(graph, parts, "coupler", on(driver), pin, knee, 0.012, {2e9, 0.35, 1150}, 5e-5);
  auto& swing = crank(graph, "rocker", post, knee);
  graph.add<RevoluteJoint>("post", {graph.ground().marker(post, kAboutY), on(swing)(post, kAboutY)});
  graph.add<SphericalJoint>("knee", {rod.part.average("x1"), on(swing)(knee, Matrix3::Identity())});
  return {position(rod.part.node(node_at(*rod.solid, {coupler / 2, 0.006, 0.006})), "coupler"),
          multipliers(motor, "drive")};
}

}  // namespace

void add_mechanisms(std::vector<Scene>& scenes) {
  scenes.push_back({.name = "slider_crank_moderate",
                    .shows = "rod of steel at 60 rad/s: the slider is rigid motion, the bend is nearly static",
                    .duration = 0.4,
                    .samples = 100,
                    .draw = [](SystemGraph& graph, ElasticParts& parts) {
                      return slider_crank(graph, parts, 60, 0.1, {2.1e11, 0.3, 7800}, 1e-5);
                    }});
  scenes.push_back({.name = "slider_crank_fast",
                    .shows = "rod of plastic at 150 rad/s: several modes, and the thrust of the slider stiffens",
                    .duration = 0.2,
                    .samples = 100,
                    .draw = [](SystemGraph& graph, ElasticParts& parts) {
                      return slider_crank(graph, parts, 150, 0.06, {1e10, 0.35, 1400}, 1e-5);
                    }});
  scenes.push_back({.name = "four_bar",
                    .shows = "soft coupler; its middle, and the moment of the drive",
                    .duration = 1,
                    .samples = 100,
                    .gravity = {0, 0, 0},
                    .draw = four_bar});
}

}  // namespace lithe::certify
