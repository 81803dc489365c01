#include <gtest/gtest.h>

#include "bodies/beam/beam_surface.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/base/rotations.h"
#include "engine/observe/contact_sensors.h"
#include "engine/observe/recorder.h"
#include "engine/observe/snapshot.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "tests/support/methods.h"

/// Beams touch with the outline of their sections.
namespace lithe::test::beam_contact_test {
namespace {

constexpr double kWide = 0.04, kThick = 0.02, kLength = 1;
const Material kPlastic{2e9, 0.3, 1200}, kSteel{2.1e11, 0.3, 7850};
const SectionShape kBar = SectionShape::rectangle(kWide, kThick);

/// Axis 2 horizontal: on its wide face; or vertical: on edge.
Beam& add_bar(SystemGraph& graph, const std::string& name, double height, bool on_edge, const Material& material,
              int elements = 10, double damping = 0) {
  return graph.add<Beam>(name, {.axis = BeamAxis::straight({0, 0, height}, {kLength, 0, height},
                                                           on_edge ? Vector3(0, 0, 1) : Vector3(0, 1, 0)),
                                .sections = {{0, kBar.section(material).damped(damping)}},
                                .elements = elements});
}

Collider skin_of(Beam& beam, const SectionShape& shape, int rings = 1) {
  const SurfaceMesh skin = surface(beam, shape, rings);
  return {skin.frame, shape::surface(skin.nodes, skin.points, skin.triangles, skin.reach)};
}

double value(const Sensor& sensor, Snapshot& now) {
  double out = 0;
  sensor.evaluate(now, {&out, 1});
  return out;
}

struct Momentum {
  Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();  // about the world's origin
  void add(const Vector3& x, const Vector3& p, const Vector3& l) { linear += p, angular += l + x.cross(p); }
};

void add_momentum(const Beam& beam, const Layout& layout, const State& state, Momentum& sum) {
  const Layout::BodySlice& slice = layout.slice(beam);
  for (int i = 0; i < beam.node_count(); ++i) {
    const double *q = state.q.data() + slice.q + 7 * i, *v = state.v.data() + slice.v + 6 * i;
    const Matrix3 A = rotation_matrix(Eigen::Map<const Vector4>(q + 3));
    Vector6 twist;
    twist << A.transpose() * Eigen::Map<const Vector3>(v), Eigen::Map<const Vector3>(v + 3);
    const Vector6 momentum = beam.lumped_mass(i) * twist;
    sum.add(Eigen::Map<const Vector3>(q), A * momentum.head<3>(), A * momentum.tail<3>());
  }
}

class EitherFace : public testing::TestWithParam<bool> {};

/// Dropped by a tenth of a millimetre it comes to rest on the face that it lies on, its whole weight on the floor, as
/// fast as its damping lets it. The alpha method goes on trembling at the speed of one step's fall, 0.01 m/s.
TEST_P(EitherFace, RestsOnThePlane) {
  const double half = (GetParam() ? kWide : kThick) / 2;
  for (const bool alpha : {false, true}) {
    SystemGraph graph;
    Beam& beam = add_bar(graph, "bar", half + 1e-4, GetParam(), kPlastic, 10, 1e-3);
    auto& floor = graph.add<Contact>("floor", {{graph.ground().marker(), shape::half_space()}, skin_of(beam, kBar)},
                                     {.friction = {.coefficient = 0.3}});
    const System system = assemble(graph);
    State state = system.initial_state();
    Snapshot start(system, state);
    EXPECT_NEAR(value(gap(floor, 0, 1, 0.01), start), 1e-4, 1e-15);
    MoreauJean moreau_jean{{.step = 1e-3}};
    NonsmoothGeneralizedAlpha generalized_alpha{{.step = 1e-3}};
    Integrator& integrator = alpha ? static_cast<Integrator&>(generalized_alpha) : moreau_jean;
    Simulation simulation{system, integrator};
    simulation.run(state, alpha ? 0.3 : 1);
    Snapshot now(system, state);
    double deepest = 0, fastest = 0;
    for (int i = 0; i < beam.node_count(); ++i) {
      deepest = std::max(deepest, std::abs(state.q[7 * i + 2] - half));
      fastest = std::max(fastest, state.v.segment<3>(6 * i).norm());
    }
    expect_below("gap of a bar at rest, m", deepest, alpha ? 2e-5 : 1e-9);
    expect_below("speed of a bar at rest, m/s", fastest, alpha ? 4e-2 : 1e-7);
    if (alpha) continue;
    double force[6];
    contact_force(floor, 1).evaluate(now, force);
    EXPECT_NEAR(force[2] / (beam.mass() * 9.81), 1, 1e-5);
  }
}

/// With a compliant law at rest: the depth is the load of a corner over its stiffness.
TEST_P(EitherFace, SinksIntoASoftPlane) {
  const double half = (GetParam() ? kWide : kThick) / 2, stiffness = 1e6;
  SystemGraph graph;
  Beam& beam = add_bar(graph, "bar", half - 1e-7, GetParam(), kSteel);
  auto& floor = graph.add<Contact>("floor", {{graph.ground().marker(), shape::half_space()}, skin_of(beam, kBar)},
                                   {.law = Compliance{.stiffness = stiffness, .exponent = 1}});
  const System system = assemble(graph);
  Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
  double force[6];
  contact_force(floor, 1).evaluate(now, force);
  EXPECT_NEAR(force[2] / (beam.mass() * 9.81), 1, 1e-9);
  // Its weight goes to two corners of each node: the depths' mean is that of a rigid bar on 22 springs.
  double mean = 0;
  for (int i = 0; i < beam.node_count(); ++i) {
    const Matrix3 axes = rotation_matrix(Eigen::Map<const Vector4>(now.state().q.data() + 7 * i + 3));
    const double below = half * axes.row(2).tail<2>().cwiseAbs().maxCoeff();  // of the turned section
    mean += (below - now.state().q[7 * i + 2]) / beam.node_count();
  }
  EXPECT_NEAR(mean * stiffness * 2 * beam.node_count() / (beam.mass() * 9.81), 1, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Bars, EitherFace, testing::Bool());

/// Distance of a point from a box.
double to_box(const Vector3& half, const Vector3& x) {
  const Vector3 beyond = x.cwiseAbs() - half;
  return beyond.maxCoeff() < 0 ? beyond.maxCoeff() : beyond.cwiseMax(0).norm();
}

/// Balls around a straight bar, over faces, edges and corners, and in it: the distance is that of a box.
TEST(BeamContact, FacesEdgesAndCornersAreThoseOfTheSection) {
  constexpr double kRadius = 0.015;
  const Vector3 half(kLength / 2, kWide / 2, kThick / 2);
  for (const Vector3& place :
       {Vector3(0.513, 0.004, 0.03), Vector3(0.37, -0.05, 0.003), Vector3(0.71, 0.03, 0.025), Vector3(1.02, 0.03, 0.02),
        Vector3(-0.01, 0, 0), Vector3(0.447, 0.002, 0.019), Vector3(0.5, 0, 0.012), Vector3(0.333, -0.029, -0.001)}) {
    SystemGraph graph;
    Beam& beam = add_bar(graph, "bar", 0, false, kPlastic);
    auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .inertia = {1, 1, 1}, .position = place});
    auto& touch =
        graph.add<Contact>("touch", {{ball.marker(), shape::sphere(kRadius)}, skin_of(beam, kBar)}, {.law = Sensing{}});
    const System system = assemble(graph);
    Snapshot now(system, system.initial_state());
    EXPECT_NEAR(value(gap(touch, 0, 1, 0.1), now), to_box(half, place - Vector3(kLength / 2, 0, 0)) - kRadius, 1e-12)
        << place.transpose();
  }
}

/// Between the flanges of an I a ball meets the web; in a tube's wall and at an ellipse, the outer rim.
TEST(BeamContact, OutlinesOfShapes) {
  const auto gap_at = [](const SectionShape& shape, const Vector3& place, double radius) {
    SystemGraph graph;
    Beam& beam = graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                                          .sections = {{0, shape.section(kSteel)}},
                                          .elements = 4});
    auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .inertia = {1, 1, 1}, .position = place});
    auto& touch =
        graph.add<Contact>("touch", {{ball.marker(), shape::sphere(radius)}, skin_of(beam, shape)}, {.law = Sensing{}});
    const System system = assemble(graph);
    Snapshot now(system, system.initial_state());
    return value(gap(touch, 0, 1, 0.1), now);
  };
  const SectionShape beam = SectionShape::i_beam({.height = 0.2, .width = 0.1, .web = 0.01, .flange = 0.02});
  EXPECT_NEAR(gap_at(beam, {0.4, 0.03, 0}, 0.02), 0.03 - 0.005 - 0.02, 1e-12);
  EXPECT_NEAR(gap_at(beam, {0.4, 0.04, 0.06}, 0.01), 0.08 - 0.06 - 0.01, 1e-12);  // under the upper flange
  EXPECT_NEAR(gap_at(beam, {0.4, 0.02, 0.13}, 0.01), 0.02, 1e-12);
  const SectionShape tube = SectionShape::tube(0.05, 0.06);
  const double facet = 0.06 * (1 - std::cos(M_PI / 32));
  EXPECT_NEAR(gap_at(tube, {0.3, 0.1, 0}, 0.01), 0.03, 1e-12);  // at a corner
  EXPECT_NEAR(gap_at(tube, {0.3, 0.1 * std::cos(M_PI / 32), 0.1 * std::sin(M_PI / 32)}, 0.01), 0.03 + facet, 1e-12);
  EXPECT_NEAR(gap_at(SectionShape::ellipse(0.06, 0.03), {0.3, 0, -0.1}, 0.01), 0.1 - 0.03 - 0.01, 1e-12);
}

/// A cantilever that an end moment bends to a quarter of a circle: its skin is a polygon between circles about the
/// centre, with the sag κ s²/8 of its chords.
TEST(BeamContact, MovesWithTheNodes) {
  constexpr int kElements = 8;
  constexpr double kTurn = M_PI / 2, kCircle = kLength / kTurn, kRadius = 0.1;
  for (const int rings : {1, 3}) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    Beam& beam = add_bar(graph, "bar", 0, false, kPlastic, kElements);
    graph.add<FixedJoint>("clamp", {graph.ground().marker(), beam.marker(0, {}, beam.axes(0).transpose())});
    const double EI = kBar.section(kPlastic).stiffness(4, 4);
    graph.add<PointForce>("moment", {beam.marker(kLength)}, {.torque = Vector3(0, -EI / kCircle, 0)});
    auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .inertia = {1, 1, 1}, .position = Vector3(0, 0, kCircle)});
    graph.add<FixedJoint>("hold", {graph.ground().marker({0, 0, kCircle}), ball.marker()});
    auto& touch = graph.add<Contact>("touch", {{ball.marker(), shape::sphere(kRadius)}, skin_of(beam, kBar, rings)},
                                     {.law = Sensing{}});
    const System system = assemble(graph);
    Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
    const double chord = std::cos(kTurn / (2 * kElements * rings));
    EXPECT_NEAR(value(gap(touch, 0, 1, 1), now), (kCircle - kThick / 2) * chord - kRadius, 1e-9);
  }
}

/// Dropped flat on a floor that gives all speed back: no energy is gained at any step, and what is missing after the
/// bounce shakes in the bar and goes with its damping. How much that is hangs on rounding (0.05 to 72 % of it): nodes
/// meet the floor at once, and which of them meets it again first is decided by the last digits.
TEST(BeamContact, GainsNoEnergyInABounce) {
  constexpr double kDrop = 0.05;
  const double period = 2 * std::sqrt(2 * kDrop / 9.81);
  for (const int elements : {10, 20}) {
    SystemGraph graph;
    Beam& beam = add_bar(graph, "bar", kThick / 2 + kDrop, false, kPlastic, elements, 1e-4);
    graph.add<Contact>("floor", {{graph.ground().marker(), shape::half_space()}, skin_of(beam, kBar)},
                       {.law = RigidSurfaces{.restitution = 1}});
    const System system = assemble(graph);
    State state = system.initial_state();
    Snapshot now(system, state);
    const double start = value(total_energy(), now), all = beam.mass() * 9.81 * kDrop;
    NonsmoothGeneralizedAlpha method{{.step = 1e-3}};
    Simulation simulation{system, method};
    double highest = 0;
    for (int step = 1; step <= 200; ++step) {
      simulation.run(state, step * period / 200);
      now.evaluate(state);
      highest = std::max(highest, (value(total_energy(), now) - start) / all);
    }
    expect_below("energy gained on the way, of that of the drop", highest, 1e-6);
    EXPECT_LT(value(total_energy(), now), start);
  }
}

/// A block hits the edge of a free bar between its nodes, without gravity: momenta of both stay, and energy, part of it
/// in the bar's waves.
TEST(BeamContact, KeepsMomentaAndEnergyInAnImpact) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  Beam& beam = add_bar(graph, "bar", 0, false, kPlastic);
  constexpr double kMass = 0.3, kEdge = 0.03;
  const Vector3 inertia = Vector3::Constant(kMass * kEdge * kEdge / 6);
  auto& block = graph.add<RigidBody>("block", {.mass = kMass,
                                               .inertia = Inertia(inertia[0], inertia[1], inertia[2]),
                                               .position = {0.33, 0.012, 0.04},
                                               .orientation = rotation_exp({0.3, 0.5, 0.2}),
                                               .velocity = {0.2, 0, -2}});
  auto& touch =
      graph.add<Contact>("touch", {{block.marker(), shape::box(Vector3::Constant(kEdge))}, skin_of(beam, kBar)},
                         {.law = Compliance{.stiffness = 1e6}});
  const System system = assemble(graph);
  State state = system.initial_state();
  const auto momenta = [&] {
    Momentum sum;
    add_momentum(beam, system.layout(), state, sum);
    const Layout::BodySlice& slice = system.layout().slice(block);
    const Matrix3 A = rotation_matrix(Vector4(state.q.segment<4>(slice.q + 3)));
    sum.add(state.q.segment<3>(slice.q), kMass * state.v.segment<3>(slice.v),
            A * inertia.cwiseProduct(state.v.segment<3>(slice.v + 3)));
    return sum;
  };
  const Momentum before = momenta();
  const double energy = 0.5 * kMass * 4.04;
  ExplicitRungeKutta integrator{{.tolerance = {.relative = 1e-10, .absolute = 1e-12}}};
  Simulation simulation{system, integrator};
  double deepest = 0;
  for (int i = 1; i <= 40; ++i) {
    simulation.run(state, 5e-4 * i);
    Snapshot now(system, state);
    deepest = std::max(deepest, value(penetration(touch), now));
    const Momentum moved = momenta();
    EXPECT_NEAR((moved.linear - before.linear).norm(), 0, 1e-9);
    EXPECT_NEAR((moved.angular - before.angular).norm(), 0, 1e-9);
    EXPECT_NEAR(value(total_energy(), now) / energy, 1, 1e-6);
  }
  EXPECT_GT(deepest, 1e-5);
  Snapshot now(system, state);
  EXPECT_EQ(value(contact_count(touch), now), 0);
  EXPECT_GT(value(kinetic_energy(beam), now), 0.01 * energy);
}

/// A box slides along a beam that is held at both ends, over all its nodes: nothing stops it at one.
TEST(BeamContact, NothingCatchesAtTheNodes) {
  SystemGraph graph;
  Beam& beam = add_bar(graph, "beam", 0, false, kSteel);
  for (const double arc : {0.0, kLength})
    graph.add<FixedJoint>("clamp " + std::to_string(arc),
                          {graph.ground().marker({arc, 0, 0}, beam.axes(0)), beam.marker(arc)});
  constexpr double kHalf = 0.01;
  auto& box = graph.add<RigidBody>("box", {.mass = 0.1,
                                           .inertia = {1e-5, 1e-5, 1e-5},
                                           .position = {0.2, 0.003, kThick / 2 + kHalf},
                                           .velocity = {1, 0, 0}});
  graph.add<Contact>("touch", {{box.marker(), shape::box(Vector3::Constant(2 * kHalf))}, skin_of(beam, kBar)}, {});
  const System system = assemble(graph);
  State state = system.initial_state();
  MoreauJean integrator{{.step = 5e-4}};
  Simulation simulation{system, integrator};
  simulation.run(state, 0.5);
  const Layout::BodySlice& slice = system.layout().slice(box);
  // The beam sags by some micrometres, and swings a little under the box.
  EXPECT_NEAR(state.v[slice.v], 1, 1e-3);
  EXPECT_NEAR(state.q[slice.q], 0.7, 1e-3);
  EXPECT_NEAR(state.q[slice.q + 2], kThick / 2 + kHalf, 1e-4);
  expect_below("sideways, m", std::abs(state.q[slice.q + 1] - 0.003), 1e-6);
}

/// Two bars crosswise, and a bar on the ridge of a mesh: edges that cross are points.
TEST(BeamContact, EdgesThatCross) {
  constexpr double kDeep = 1e-4;
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  Beam& lower = add_bar(graph, "lower", 0, false, kPlastic);
  Beam& upper = graph.add<Beam>(
      "upper", {.axis = BeamAxis::straight({0.47, -0.53, kThick - kDeep}, {0.47, 0.47, kThick - kDeep}, {1, 0, 0}),
                .sections = {{0, kBar.section(kPlastic)}},
                .elements = 10});
  auto& touch = graph.add<Contact>("touch", {skin_of(lower, kBar), skin_of(upper, kBar)}, {.law = Sensing{}});
  const std::vector<Vector3> ridge{{0, -1, -1}, {0, 1, -1}, {1, -1, 0}, {1, 1, 0}, {2, -1, -1}, {2, 1, -1}};
  auto& roof = graph.add<Contact>("roof",
                                  {{graph.ground().marker({-0.47, 0, -kThick / 2 + kDeep}),
                                    shape::mesh(ridge, {{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}})},
                                   skin_of(lower, kBar)},
                                  {.law = Sensing{}});
  const System system = assemble(graph);
  Snapshot now(system, system.initial_state());
  EXPECT_NEAR(value(gap(touch, 0, 1, 0.1), now), -kDeep, 1e-12);
  EXPECT_EQ(value(contact_count(touch), now), 4);
  EXPECT_NEAR(value(gap(roof, 0, 1, 0.1), now), -kDeep, 1e-12);
  EXPECT_EQ(value(contact_count(roof), now), 2);
}

TEST(BeamContact, RefusesWhatIsNoOutline) {
  SystemGraph graph;
  Beam& beam = add_bar(graph, "bar", 0, false, kPlastic);
  EXPECT_THROW(surface(beam, SectionOutline{{0, 0}, {1, 0}}), SceneError);
  EXPECT_THROW(surface(beam, SectionOutline{{0, 0}, {0, 1}, {1, 0}}), SceneError);          // clockwise
  EXPECT_THROW(surface(beam, SectionOutline{{0, 0}, {1, 0}, {0, 1}, {1, 1}}), SceneError);  // crosses itself
  EXPECT_THROW(surface(beam, SectionOutline{{0, 0}, {std::nan(""), 0}, {0, 1}}), SceneError);
  EXPECT_THROW(surface(beam, kBar, 0), SceneError);
  EXPECT_THROW(SectionShape::circle(0.1).outline(2), SceneError);
  EXPECT_THROW(surface(beam,
                       [](double arc) {
                         SectionOutline outline{{0.1, 0}, {0, 0.1}, {-0.1, 0}};
                         if (arc > 0.5) outline.push_back({0, -0.1});
                         return outline;
                       }),
               SceneError);
}

}  // namespace
}  // namespace lithe::test::beam_contact_test
