// A flexible bar held by a joint at one end and holding a rigid body by another at its other end: every type of joint,
// reduced, reduced with rigid faces, and nodal. The rows of a single joint are checked on every pairing of bodies in
// tests/joints.
#include <gtest/gtest.h>

#include <functional>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "integrators/explicit_runge_kutta.h"
#include "joints/constant_velocity_joint.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/orientation_joint.h"
#include "joints/parallel_axes_joint.h"
#include "joints/perpendicular_axes_joint.h"
#include "joints/planar_joint.h"
#include "joints/planar_pin_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/revolute_spherical_joint.h"
#include "joints/screw_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/bodies/bar_model.h"
#include "tests/bodies/fe_models.h"

namespace lithe::test::flexible_joints_test {
namespace {

struct Type {
  std::string name;
  int rank;
  Vector3 gap;  // from A to B as drawn
  std::function<void(SystemGraph&, const std::string&, std::vector<Marker>)> add;
  Matrix3 turn_B = Matrix3::Identity();  // axes of B to those of A
};

template <class T, class... Parameters>
Type type(const std::string& name, int rank, const Vector3& gap, const Parameters&... parameters) {
  return {name, rank, gap, [=](SystemGraph& graph, const std::string& joint, std::vector<Marker> markers) {
            graph.add<T>(joint, std::move(markers), parameters...);
          }};
}

Type turned(Type type) {
  type.turn_B = rotation_about({1, 0, 0}, M_PI / 2);
  return type;
}

const std::vector<Type> kTypes = {
    type<RevoluteJoint>("revolute", 5, {0, 0, 0}),
    type<SphericalJoint>("spherical", 3, {0, 0, 0}),
    type<FixedJoint>("fixed", 6, {0, 0, 0}),
    type<UniversalJoint>("universal", 4, {0, 0, 0}),
    type<ConstantVelocityJoint>("constant velocity", 4, {0, 0, 0}),
    type<CylindricalJoint>("cylindrical", 4, {0, 0, 0.02}),
    type<PrismaticJoint>("prismatic", 5, {0, 0, 0.02}),
    type<PlanarJoint>("planar", 3, {0.02, 0.01, 0}),
    type<PointOnLineJoint>("point on line", 2, {0, 0, 0.02}),
    type<PointOnPlaneJoint>("point on plane", 1, {0.02, 0.01, 0}),
    type<ScrewJoint>("screw", 5, {0, 0, 0}, ScrewJoint::Parameters{.lead = 0.02}),
    type<PlanarPinJoint>("planar pin", 2, {0, 0, 0.02}),
    type<ParallelAxesJoint>("parallel axes", 2, {0.02, 0.01, 0.03}),
    type<OrientationJoint>("orientation", 3, {0.02, 0.01, 0.03}),
    type<RevoluteSphericalJoint>("revolute-spherical", 2, {0.03, 0.04, 0},
                                 RevoluteSphericalJoint::Parameters{.length = 0.05}),
    turned(type<PerpendicularAxesJoint>("perpendicular axes", 1, {0.02, 0.01, 0.03})),
    type<DistanceJoint>("distance", 1, {0.03, 0, 0.04}, DistanceJoint::Parameters{.length = 0.05}),
};

enum class Kind { reduced, rigid_faces, nodal };

class BarBetweenJoints : public testing::TestWithParam<Kind> {};

TEST_P(BarBetweenJoints, OfEveryTypeMovesWithinThemAndKeepsItsEnergy) {
  // Rubber, so that few steps resolve it.
  const FiniteElementModel model =
      bar_model({.size = {0.3, 0.04, 0.03}, .bricks = {4, 1, 1}, .young = 3e6, .density = 1000});
  const auto &start = model.node_set("start"), &end = model.node_set("end");
  const Kind kind = GetParam();
  const auto basis = kind == Kind::nodal ? make_basis(model, ThreeNodeFrame{1, end[0], 2}, kAllNodal)
                     : kind == Kind::reduced
                         ? make_basis(model, MeanAxisFrame{}, 2, {.loaded = {{start}, {end}}})
                         : make_basis(model, MeanAxisFrame{}, 2, {.rigid = {start, end}, .loaded = {{start}, {end}}});
  for (const Type& joint : kTypes) {
    SCOPED_TRACE(joint.name);
    SystemGraph graph{{.gravity = {1, 2, -9.81}}};
    const Matrix3 turn = rotation_about({1, 2, 3}, 0.9);  // of the joints' axes
    auto& bar = graph.add<FlexibleBody>("bar", {.basis = basis});
    auto& bob = graph.add<RigidBody>("bob", {.mass = 0.3, .inertia = {1e-3, 2e-3, 2e-3}, .position = {0.4, 0, 0}});
    const auto face = [&](const std::vector<int>& nodes) {
      return kind == Kind::rigid_faces ? bar.rigid(nodes, turn) : bar.average(nodes, turn);
    };
    const Vector3 shift = turn * joint.gap, tip = Vector3(-0.1, 0, 0) + shift;
    joint.add(graph, "root", {graph.ground().marker(-shift, turn * joint.turn_B.transpose()), face(start)});
    joint.add(graph, "tip", {face(end), bob.marker(tip, turn * joint.turn_B)});
    const System system = assemble(graph);
    EXPECT_EQ(system.rank(), 2 * joint.rank);
    EXPECT_EQ(system.redundant_rows().size(), 0u);

    Evaluator equations(system);
    State state = system.initial_state();
    ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-8, .absolute = 1e-9}});
    integrator.start(equations, state);
    const auto energy = [&] {
      equations.evaluate(state.time, state.q, state.v, Level::velocity);
      return equations.energy();
    };
    const double before = energy().total();
    while (state.time < 0.05) ASSERT_TRUE(integrator.step(equations, state, 0.05).ok());
    const auto after = energy();
    VectorX g(system.layout().row_count());
    equations.constraint(Level::position, g);
    EXPECT_LT(g.cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_GT(after.kinetic + after.elastic, 1e-4);
    EXPECT_NEAR(after.total(), before, 1e-6);
  }
}

std::string name_of(const testing::TestParamInfo<Kind>& test) {
  return test.param == Kind::reduced ? "reduced" : test.param == Kind::nodal ? "nodal" : "rigid_faces";
}
INSTANTIATE_TEST_SUITE_P(Kinds, BarBetweenJoints, testing::Values(Kind::reduced, Kind::rigid_faces, Kind::nodal),
                         name_of);

}  // namespace
}  // namespace lithe::test::flexible_joints_test
