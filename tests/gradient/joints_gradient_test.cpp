#include "bodies/rigid_body.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/bushing.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/orientation_joint.h"
#include "joints/parallel_axes_joint.h"
#include "joints/planar_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/screw_joint.h"
#include "joints/spherical_joint.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

/// A body held to the ground by a bushing, and another hung from it by the joint, under a force; the joint's place and
/// tilt are parameters too.
template <class Joint, class... Parameters>
ParametricScene hung(const char* name, Parameters... parameters) {
  return {.name = name,
          .duration = 0.2,
          .draw =
              [=](SystemGraph& graph, const SweepPoint& p) {
                auto& first = graph.add<RigidBody>(
                    "first", {.mass = 2, .inertia = {0.05, 0.06, 0.07}, .angular_velocity = {0.4, -0.3, 0.5}});
                const Matrix3 tilt = rotation_about({1, 2, 0.5}, p["tilt"]);
                const Vector3 place(0.3, p["place"], 0.1);
                auto& second = graph.add<RigidBody>("second", {.mass = p["mass"],
                                                               .inertia = {0.02, 0.03, 0.025},
                                                               .position = place + tilt.col(0) * 0.2,
                                                               .orientation = tilt,
                                                               .velocity = {0.1, 0.2, -0.1}});
                graph.add<Bushing>("bushing", {graph.ground().marker(), first.marker()},
                                   {.stiffness = Bushing::diagonal({p["stiffness"], 900, 800}, {60, 50, 40}),
                                    .damping = Bushing::diagonal({5, 5, 5}, {0.5, 0.5, 0.5})});
                auto& joint =
                    graph.add<Joint>("joint", {first.marker(place, tilt), second.marker({-0.2, 0, 0})}, parameters...);
                graph.add<PointForce>("push", {second.marker({0.1, 0.05, 0})},
                                      {.force = {3, p["force"], 1}, .torque = {0.2, 0.1, -0.3}});
                return std::vector<Sensor>{position(second.marker({0.2, 0, 0}), "end"), multipliers(joint, "lambda"),
                                           kinetic_energy("kinetic")};
              },
          .integrator = exact_alpha(5e-3)};
}

const std::vector<DesignParameter> kHung{
    {"tilt", 0.3}, {"place", 0.15}, {"mass", 0.9}, {"stiffness", 1000}, {"force", -4}};
const std::vector<Quantity> kEnd{value_at("end_z", 0.2), value_at("lambda_1", 0.11), integral("kinetic")};

TEST(JointGradients, Revolute) { expect_gradient(hung<RevoluteJoint>("revolute"), kEnd, kHung); }
TEST(JointGradients, Spherical) { expect_gradient(hung<SphericalJoint>("spherical"), kEnd, kHung); }
TEST(JointGradients, Fixed) { expect_gradient(hung<FixedJoint>("fixed"), kEnd, kHung); }
TEST(JointGradients, Prismatic) { expect_gradient(hung<PrismaticJoint>("prismatic"), kEnd, kHung); }
TEST(JointGradients, Cylindrical) { expect_gradient(hung<CylindricalJoint>("cylindrical"), kEnd, kHung); }
TEST(JointGradients, Planar) { expect_gradient(hung<PlanarJoint>("planar"), kEnd, kHung); }
TEST(JointGradients, Screw) {
  expect_gradient(hung<ScrewJoint>("screw", ScrewJoint::Parameters{.lead = 0.05}), kEnd, kHung);
}
TEST(JointGradients, PointOnLine) { expect_gradient(hung<PointOnLineJoint>("point on line"), kEnd, kHung); }
TEST(JointGradients, PointOnPlane) { expect_gradient(hung<PointOnPlaneJoint>("point on plane"), kEnd, kHung); }
TEST(JointGradients, Orientation) { expect_gradient(hung<OrientationJoint>("orientation"), kEnd, kHung); }
TEST(JointGradients, ParallelAxes) { expect_gradient(hung<ParallelAxesJoint>("parallel axes"), kEnd, kHung); }

TEST(JointGradients, Distance) {
  ParametricScene scene = hung<SphericalJoint>("distance");
  scene.draw = [](SystemGraph& graph, const SweepPoint& p) {
    auto& ball = graph.add<RigidBody>("ball", {.mass = p["mass"],
                                               .inertia = {0.02, 0.03, 0.025},
                                               .position = {p["place"], 0.3, 0.4},
                                               .velocity = {0.3, 0.1, 0}});
    auto& rod = graph.add<DistanceJoint>("rod", {graph.ground().marker(), ball.marker({0.02, 0, 0.05})});
    graph.add<SpringDamper>("spring", {graph.ground().marker({0.5, -0.5, p["tilt"]}), ball.marker()},
                            {.stiffness = p["stiffness"], .natural_length = 0.6, .preload = p["force"]});
    return std::vector<Sensor>{position(ball.marker({0.2, 0, 0}), "end"), multipliers(rod, "lambda"),
                               kinetic_energy("kinetic")};
  };
  expect_gradient(scene, kEnd, {{"tilt", 0.3}, {"place", 0.15}, {"mass", 0.9}, {"stiffness", 100}, {"force", -4}});
}

}  // namespace
}  // namespace lithe::test
