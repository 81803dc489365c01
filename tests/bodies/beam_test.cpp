#include "bodies/beam/beam.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "bodies/beam/beam_element.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/assembly/evaluated.h"
#include "engine/run/simulation.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "tests/support/body_checks.h"
#include "tests/support/joint_checks.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

namespace lithe::test::beam_test {
namespace {

const Material kSteel{2.1e11, 0.3, 7850};

BeamAxis along_x(double length) { return BeamAxis::straight({0, 0, 0}, {length, 0, 0}, {0, 1, 0}); }

/// Every strain tied to every other.
BeamSection coupled_section() {
  RandomNumbers random(7);
  BeamSection s = BeamSection::diagonal({40, 30, 20, 3, 5, 4}, 2, {0.3, 0.2, 0.15});
  Matrix6 B;
  for (int i = 0; i < 6; ++i) B.col(i) = random.vector(6, 0.3);
  const Vector6 root = s.stiffness.diagonal().cwiseSqrt();
  s.stiffness += root.asDiagonal() * (B * B.transpose()) * root.asDiagonal();
  return s.damped(0.02);
}

// ---- sections ----

TEST(BeamSection, ShapesHaveTheirConstants) {
  const double G = kSteel.young / 2.6;
  EXPECT_NEAR(BeamSection::rectangle(1, 1, kSteel).stiffness(3, 3) / G, 0.140577014955, 1e-12);
  const BeamSection r = BeamSection::rectangle(0.06, 0.04, kSteel);
  EXPECT_NEAR(r.stiffness(4, 4), kSteel.young * 0.06 * 0.04 * 0.04 * 0.04 / 12, 1e-9 * r.stiffness(4, 4));
  EXPECT_NEAR(r.stiffness(5, 5), kSteel.young * 0.04 * 0.06 * 0.06 * 0.06 / 12, 1e-9 * r.stiffness(5, 5));
  EXPECT_NEAR(r.mass(0, 0), 7850 * 0.06 * 0.04, 1e-12);
  const double area = M_PI * 1e-4;
  const BeamSection c = BeamSection::circle(0.01, kSteel);
  EXPECT_NEAR(c.stiffness(1, 1), 6 * 1.3 / (7 + 6 * 0.3) * G * area, 1e-9 * c.stiffness(1, 1));  // Cowper's table
  EXPECT_NEAR(c.stiffness(3, 3), G * M_PI / 2 * 1e-8, 1e-9 * c.stiffness(3, 3));
  // A tube of hardly any bore is the circle; a thin one has Cowper's 2 (1 + ν) / (4 + 3 ν).
  EXPECT_LT((BeamSection::tube(1e-8, 0.01, kSteel).stiffness - c.stiffness).norm(), 1e-9 * c.stiffness.norm());
  const BeamSection thin = BeamSection::tube(0.9999, 1, kSteel);
  EXPECT_NEAR(thin.stiffness(1, 1) / thin.stiffness(0, 0) * 2.6, 2 * 1.3 / (4 + 0.9), 1e-6);
  // An I whose web is as wide as its flanges is a rectangle, but for torsion and shear.
  const BeamSection I = BeamSection::i_beam({.height = 0.2, .width = 0.1, .web = 0.1, .flange = 0.02}, kSteel);
  const BeamSection full = BeamSection::rectangle(0.1, 0.2, kSteel);
  for (const int k : {0, 4, 5}) EXPECT_NEAR(I.stiffness(k, k), full.stiffness(k, k), 1e-9 * full.stiffness(k, k));
  EXPECT_LT((I.mass - full.mass).norm(), 1e-9 * full.mass.norm());
}

TEST(BeamSection, MovesAndTurns) {
  const BeamSection s = BeamSection::rectangle(0.06, 0.04, kSteel), m = s.moved(0.1, -0.2);
  EXPECT_LT((m.mass_center() - Vector3(0, 0.1, -0.2)).norm(), 1e-15);
  m.check("moved");
  EXPECT_NEAR(m.stiffness(0, 5), -0.1 * s.stiffness(0, 0), 1e-6 * s.stiffness(0, 0));  // axial: Γ1 + K2 r3 - K3 r2
  EXPECT_NEAR(m.stiffness(0, 4), -0.2 * s.stiffness(0, 0), 1e-6 * s.stiffness(0, 0));
  EXPECT_LT((m.moved(-0.1, 0.2).stiffness - s.stiffness).norm(), 1e-9 * s.stiffness.norm());
  const BeamSection t = s.turned(M_PI / 2);
  EXPECT_NEAR(t.stiffness(4, 4), s.stiffness(5, 5), 1e-9 * s.stiffness(5, 5));
}

TEST(BeamSection, RefusesWhatIsNone) {
  const auto message = [](auto&& spoil) {
    BeamSection s = BeamSection::rectangle(0.06, 0.04, kSteel);
    spoil(s);
    return message_of<SceneError>([&] { s.check("section 3"); });
  };
  EXPECT_NE(message([](auto& s) { s.stiffness(4, 4) = -1; }).find("section 3 in bending about 2"), std::string::npos);
  EXPECT_NE(message([](auto& s) { s.stiffness(0, 1) = s.stiffness(1, 0) = 2e9; }).find("positive definite"),
            std::string::npos);
  EXPECT_NE(message([](auto& s) { s.stiffness(0, 1) = 1e8; }).find("symmetric"), std::string::npos);
  EXPECT_NE(message([](auto& s) { s.mass(0, 0) = 0; }).find("mass per length of section 3"), std::string::npos);
  EXPECT_NE(message([](auto& s) { s.mass(1, 1) *= 2; }).find("not that of a section"), std::string::npos);
  EXPECT_NE(message([](auto& s) { s.mass(4, 4) = -1; }).find("rotary inertia"), std::string::npos);
  EXPECT_NE(message([](auto& s) { s.damping[2] = -1; }).find("shear along 3"), std::string::npos);
  EXPECT_NE(message_of<SceneError>([] { BeamSection::tube(2, 1, kSteel); }).find("inner radius"), std::string::npos);
}

Vector6 read(Snapshot& now, const Sensor& sensor) {
  Vector6 values;
  sensor.evaluate(now, {values.data(), 6});
  return values;
}

// ---- element ----

/// Wrenches are the derivatives of the energy, the tangent those of the wrenches.
TEST(BeamElement, PullsByWhatItsEnergyLoses) {
  const FramePose start{{0.3, -0.2, 0.5}, rotation_exp(Vector3(0.4, -0.7, 0.9))};
  for (const double curvature : {0.0, 0.4, 1.4}) {
    SCOPED_TRACE(curvature);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const BeamAxis axis = BeamAxis::curved(start, Vector3(0.5, -0.3, 0.8).normalized() * curvature, 1);
    std::vector<Marker> ends;
    for (const double arc : {0.0, 1.0}) {
      const FramePose pose = axis.pose(arc);
      auto& body =
          graph.add<RigidBody>("end " + std::to_string(ends.size()),
                               {.mass = 1, .inertia = {1, 1, 1}, .position = pose.position, .orientation = pose.axes});
      ends.push_back(body.marker());
    }
    check_force(graph, graph.add<BeamElement>("element", {ends[0], ends[1]}, {.section = coupled_section()}));
  }
}

/// A rigid motion of all nodes changes no strain.
TEST(Beam, IsObjective) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  const BeamAxis axis = BeamAxis::curved({}, {0.5, -0.3, 0.8}, 2);
  auto& beam = graph.add<Beam>("beam", {.axis = axis, .sections = {{0, coupled_section()}}, .elements = 5});
  const System system = assemble(graph);
  RandomNumbers random(3);
  State bent = system.initial_state(), moved = bent;
  const Layout& layout = system.layout();
  layout.retract(system.initial_state().q, random.vector(layout.v_count(), 0.1), bent.q);
  moved.q = bent.q;
  const Matrix3 turn = rotation_exp({1.1, -2, 0.7});
  for (const auto& body : layout.bodies()) {
    if (!body.frame) continue;
    const Vector3 p = bent.q.segment<3>(body.q);
    const Vector4 e = bent.q.segment<4>(body.q + 3);
    moved.q.segment<3>(body.q) = turn * p + Vector3(5, -3, 8);
    moved.q.segment<4>(body.q + 3) = quaternion_product(quaternion_of(turn), e).normalized();
  }
  Snapshot before(system, bent), after(system, moved);
  for (int i = 0; i < beam.element_count(); ++i) {
    const Vector6 strain = read(before, beam.strain(i));
    EXPECT_GT(strain.norm(), 0.01);
    expect_below("strains after a rigid motion", (read(after, beam.strain(i)) - strain).norm(), 1e-12);
  }
}

// ---- beam ----

/// M, weight, power, virtual work, markers at nodes and between them: tests/support/body_checks.h.
TEST(Beam, OwesWhatEveryBodyOwes) {
  BeamSection section = coupled_section().damped(0);
  section.mass = BeamSection::diagonal(section.stiffness.diagonal(), 2, {0.3, 0.2, 0.15}).moved(0.1, -0.2).mass;
  for (const auto& [time, mass] : {std::pair(0.0, Beam::Mass::consistent),
                                   {0.0, Beam::Mass::lumped},
                                   {0.02, Beam::Mass::consistent},
                                   {0.02, Beam::Mass::lumped}}) {
    SystemGraph graph{{.gravity = {1, 2, -9.81}}};
    const BeamAxis axis = BeamAxis::curved({{1, 2, 3}, rotation_exp({0.3, 0.2, -0.5})}, {0.4, 0.1, 0.6}, 3);
    auto& beam =
        graph.add<Beam>("beam", {.axis = axis, .sections = {{0, section.damped(time)}}, .elements = 2, .mass = mass});
    const Matrix3 turned = rotation_about({1, 1, 0}, 0.5);
    const std::vector<Marker> markers = {beam.marker(0), beam.marker(1.5, {0.1, 0.2, 0.3}, turned), beam.marker(0.4),
                                         beam.marker(2.9, {-0.1, 0.4, 0.2}, turned)};
    check_body(graph, beam, markers, {.mass = 6, .dissipation = time});
  }
}

/// In a rigid motion a straight beam of one section has the kinetic energy of the body that it is; a curved and tapered
/// one too with lumped mass, and with consistent mass an error that falls by four.
TEST(Beam, HasTheInertiaOfTheWhole) {
  using Mass = Beam::Mass;
  const auto energy = [](const BeamAxis& axis, const std::vector<Beam::Station>& sections, int elements, Mass mass) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    graph.add<Beam>("beam", {.axis = axis,
                             .sections = sections,
                             .elements = elements,
                             .mass = mass,
                             .velocity = {1, -2, 0.5},
                             .angular_velocity = {0.7, 1.1, -0.4}});
    const System system = assemble(graph);
    Snapshot now(system, system.initial_state());
    return total_energy().value(now);
  };
  const BeamSection root = BeamSection::rectangle(0.3, 0.1, kSteel).moved(0.05, 0.02);
  // ∫ ½ μ |v + ω × (s e1 + c)|² ds + ½ L ωᵀ J ω about the mass centre line
  const double L = 3, mass = root.mass_per_length();
  const Vector3 v(1, -2, 0.5), w(0.7, 1.1, -0.4), c = root.mass_center();
  const Matrix3 J = root.mass.bottomRightCorner<3, 3>() + mass * skew(c) * skew(c);
  const Vector3 at_start = v + w.cross(c), along = w.cross(Vector3::UnitX());
  const double exact =
      0.5 * mass * (L * at_start.squaredNorm() + L * L * at_start.dot(along) + L * L * L / 3 * along.squaredNorm()) +
      0.5 * L * w.dot(J * w);
  for (const Mass kind : {Mass::lumped, Mass::consistent})
    expect_below("rigid motion, straight", std::abs(energy(along_x(L), {{0, root}}, 3, kind) / exact - 1), 1e-13);
  const BeamSection tip = BeamSection::rectangle(0.1, 0.05, kSteel);
  const BeamAxis axis = BeamAxis::curved({{1, 2, 3}, rotation_exp({0.3, 0.2, -0.5})}, {0.4, 0.1, 0.6}, L);
  double found[3];
  for (const int k : {0, 1, 2}) found[k] = energy(axis, {{0, root}, {L, tip}}, 8 << k, Mass::consistent);
  EXPECT_NEAR((found[0] - found[1]) / (found[1] - found[2]), 4, 0.05);
  const double lumped[] = {energy(axis, {{0, root}, {L, tip}}, 4, Mass::lumped),
                           energy(axis, {{0, root}, {L, tip}}, 64, Mass::lumped)};
  expect_below("rigid motion, curved, lumped", std::abs(lumped[0] / lumped[1] - 1), 1e-10);
  EXPECT_NEAR(lumped[1], (4 * found[2] - found[1]) / 3, 1e-5 * lumped[1]);
}

TEST(Beam, HasMarkersAnywhere) {
  SystemGraph graph;
  auto& beam = graph.add<Beam>("beam", {.axis = along_x(2),
                                        .sections = {{0, BeamSection::circle(0.1, kSteel)}},
                                        .elements = 10,
                                        .stations = {0.5, 1.23},
                                        .velocity = {0, 0, 1},
                                        .angular_velocity = {0, 0, 2}});
  EXPECT_EQ(beam.element_count(), beam.node_count() - 1);
  const System system = assemble(graph);
  Snapshot now(system, system.initial_state());
  EXPECT_NEAR(beam.arc(beam.element_at(1.23)), 1.23, 1e-15);
  for (const double arc : {0.0, 0.5, 0.77, 1.23, 1.999, 2.0}) {
    EXPECT_LT((now.marker(beam.marker(arc)).p - Vector3(arc, 0, 0)).norm(), 1e-14);
    EXPECT_LT((now.marker(beam.marker(arc, {0, 0.2, 0.1})).p - Vector3(arc, 0.2, 0.1)).norm(), 1e-14);
    EXPECT_LT((now.marker(beam.marker(arc)).v - Vector3(0, 2 * arc, 1)).norm(), 1e-14);
  }
  EXPECT_NEAR(beam.length(), 2, 1e-14);
  EXPECT_NE(message_of<SceneError>([&] { beam.marker(2.1); }).find("no section at 2.1"), std::string::npos);
  EXPECT_NE(message_of<SceneError>([&] { beam.axes(-1); }).find("no node -1"), std::string::npos);
  EXPECT_NE(message_of<SceneError>([&] { beam.strain(beam.element_count()); }).find("element_at"), std::string::npos);
}

/// Pages show it as thick as its section is, and where it is.
TEST(Beam, IsDrawnAsThickAsItsSections) {
  SystemGraph graph;
  const BeamSection section = BeamSection::rectangle(0.04, 0.01, kSteel).moved(0.02, -0.03);
  const auto& beam = graph.add<Beam>("beam", {.axis = along_x(1), .sections = {{0, section}}, .elements = 4});
  const System system = assemble(graph);
  const DrawnMesh mesh = beam.drawn_mesh(false);
  Matrix3X points = mesh.points;
  points.setZero();
  Evaluator equations(system);
  State state = system.initial_state();
  for (int i = 0; i < beam.node_count(); ++i) state.q[7 * i + 1] += 5;
  equations.evaluate(0, state.q, state.v, Level::velocity);
  beam.drawn_points(body_state(equations, beam), mesh, points);
  EXPECT_LT((points - mesh.points - Vector3(0, 5, 0).replicate(1, points.cols())).cwiseAbs().maxCoeff(), 1e-14);
  const auto rims = mesh.points.rightCols(mesh.points.cols() - beam.node_count());
  EXPECT_LT((rims.rowwise().minCoeff() - Vector3(0, 0, -0.035)).norm(), 1e-12);
  EXPECT_LT((rims.rowwise().maxCoeff() - Vector3(1, 0.04, -0.025)).norm(), 1e-12);
  // A closed surface: each edge of a triangle is another's, the other way round.
  std::set<std::pair<int, int>> open;
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      if (!open.erase({t[(k + 1) % 3], t[k]})) open.insert({t[k], t[(k + 1) % 3]});
  EXPECT_TRUE(open.empty());
}

TEST(Beam, RefusesWhatCannotBeDrawn) {
  const BeamSection section = BeamSection::circle(0.1, kSteel);
  const auto message = [&](Beam::Parameters p) {
    return message_of<SceneError>([&] {
      SystemGraph graph;
      graph.add<Beam>("beam", p);
      assemble(graph);
    });
  };
  EXPECT_NE(message({.axis = along_x(1)}).find("no section"), std::string::npos);
  EXPECT_NE(message({.sections = {{0, section}}}).find("length"), std::string::npos);
  EXPECT_NE(message({.axis = along_x(1), .sections = {{0.5, section}, {0.2, section}}}).find("section 1"),
            std::string::npos);
  EXPECT_NE(message({.axis = along_x(1), .sections = {{0, section}}, .elements = 0}).find("elements"),
            std::string::npos);
  EXPECT_NE(message({.axis = along_x(1), .sections = {{0, section}}, .stations = {1.5}}).find("beyond"),
            std::string::npos);
  EXPECT_NE(message({.axis = BeamAxis::curved({}, {0, 0, 3}, 2), .sections = {{0, section}}, .elements = 2})
                .find("more elements"),
            std::string::npos);
}

/// Its own weight bends it as it should, while deflections are small: lumped mass gives the moments in the elements'
/// middles, consistent mass their means along the elements.
TEST(Beam, CarriesItsWeight) {
  for (const auto mass : {Beam::Mass::lumped, Beam::Mass::consistent}) {
    SystemGraph graph;
    const BeamSection section = BeamSection::rectangle(0.1, 0.1, kSteel);
    auto& beam = graph.add<Beam>("beam", {.axis = along_x(2), .sections = {{0, section}}, .elements = 4, .mass = mass});
    graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0, 0}, beam.axes(0)), beam.marker(0)});
    const System system = assemble(graph);
    Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
    const double w = section.mass_per_length() * 9.81;
    for (int i = 0; i < 4; ++i) {
      const double rest = 2 - (i + 0.5) * 0.5;
      const Vector6 n = read(now, beam.resultants(i));
      const double more = mass == Beam::Mass::lumped ? 0 : 0.5 * 0.5 / 12;
      EXPECT_NEAR(n[4], 0.5 * w * (rest * rest + more), 1e-4 * w);  // about axis 2 = y, downwards
      EXPECT_NEAR(n[2], -w * rest, 1e-4 * w);
    }
  }
}

// ---- motion ----

/// A free rod thrown by a force and moments in space: the path of tests/data/beams, and no energy lost afterwards.
TEST(Beam, FliesAsTheReferenceSays) {
  const BeamSection section = BeamSection::diagonal({1e4, 1e4, 1e4, 500, 500, 500}, 1, {20, 10, 10});
  double errors[3];
  for (int k = 0; k < 3; ++k) {  // 8 and 16 elements, and 8 with consistent mass
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& rod = graph.add<Beam>("rod", {.axis = BeamAxis::straight({6, 0, 0}, {0, 0, 8}, {0, 1, 0}),
                                        .sections = {{0, section}},
                                        .elements = k == 1 ? 16 : 8,
                                        .mass = k == 2 ? Beam::Mass::consistent : Beam::Mass::lumped});
    graph.add<UserForce>("throw", {rod.marker(0)}, {[](double t, const MarkerView&) {
                           const double M = t < 2.5 ? 80 * t : t < 5 ? 200 * (2 - t / 2.5) : 0;
                           return Wrench{{M / 10, 0, 0}, {0, M, M / 2}};
                         }});
    const System system = assemble(graph);
    State state = system.initial_state();
    const Method method = runge_kutta8(1e-9);
    Simulation simulation(system, *method);
    std::ifstream table(LITHE_TEST_DATA "/beams/D04_flying_rod_3d.csv");
    std::string line;
    std::getline(table, line);
    errors[k] = 0;
    double energy = 0, drift = 0;
    while (std::getline(table, line)) {
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream numbers(line);
      double t;
      Vector3 free_end, middle, loaded_end;
      numbers >> t;
      for (Vector3* p : {&free_end, &middle, &loaded_end}) numbers >> (*p)[0] >> (*p)[1] >> (*p)[2];
      simulation.run(state, t);
      Snapshot now(system, state);
      errors[k] =
          std::max({errors[k], (now.marker(rod.marker(10)).p - free_end).norm(),
                    (now.marker(rod.marker(5)).p - middle).norm(), (now.marker(rod.marker(0)).p - loaded_end).norm()});
      const double total = total_energy().value(now);
      if (t == 5) energy = total;
      if (t > 5) drift = std::max(drift, std::abs(total / energy - 1));
    }
    expect_below("flying rod, energy", drift, 1e-8);
  }
  expect_below("flying rod, 8 elements, m", errors[0], 0.4);
  expect_below("flying rod, 16 elements, m", errors[1], 0.1);
  expect_below("flying rod, 8 elements with consistent mass, m", errors[2], 0.15);
}

}  // namespace
}  // namespace lithe::test::beam_test
