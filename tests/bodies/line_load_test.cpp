#include "joints/forces/line_load.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <utility>

#include "bodies/beam/beam.h"
#include "bodies/cable/cable.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "engine/model/input.h"
#include "engine/run/simulation.h"
#include "joints/fixed_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/spherical_joint.h"
#include "tests/support/joint_checks.h"
#include "tests/support/methods.h"

/// Loads spread along beams and cables, dead and following, against closed forms and the rod's own differential
/// equations. Stability under followers: follower_stability_test.cpp.
namespace lithe::test::line_load_test {
namespace {

using Axes = LineLoad::Axes;

BeamAxis along_x(double length) { return BeamAxis::straight({0, 0, 0}, {length, 0, 0}, {0, 1, 0}); }
BeamSection rod(double EA, double GA, double EI) {
  return BeamSection::diagonal({EA, GA, GA, EI, EI, EI}, 1, {2e-3, 1e-3, 1e-3});
}
constexpr double kEA = 2500, kGA = 1000;  // of a rod of length 1 and EI = 1

/// Place of the tip and its turn about z, by 20, 40 and 80 elements without the errors of second and fourth order.
Vector3 tip_of_cantilever(const BeamSection& section, const LineLoad& load, double* coarse = nullptr) {
  Vector3 tips[3];
  for (int k = 0; k < 3; ++k) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& beam = graph.add<Beam>("beam", {.axis = along_x(1), .sections = {{0, section}}, .elements = 20 << k});
    graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0, 0}, beam.axes(0)), beam.marker(0)});
    add_line_load(graph, "load", beam, load);
    const Marker end = beam.marker(1);
    const System system = assemble(graph);
    Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
    const MarkerKinematics tip = now.marker(end);
    tips[k] << tip.p.head<2>(), std::atan2(tip.R(1, 0), tip.R(0, 0));
  }
  const Vector3 first = (4 * tips[1] - tips[0]) / 3, second = (4 * tips[2] - tips[1]) / 3,
                best = (16 * second - first) / 15;
  if (coarse) *coarse = (tips[0] - best).norm();
  return best;
}

TEST(LineLoad, BendsACantileverAsTheLinearTheorySays) {
  const double q = 1e-5;
  const Vector3 tip = tip_of_cantilever(rod(kEA, kGA, 1), {.density = {{0, force({0, q, 0})}}});
  expect_below("q L⁴/8EI + q L²/2GA", std::abs(tip[1] / (q / 8 + q / (2 * kGA)) - 1), 1e-9);
  expect_below("q L³/6EI", std::abs(tip[2] / (q / 6) - 1), 1e-9);
  const Vector3 pulled =
      tip_of_cantilever(rod(kEA, kGA, 1), {.from = 0.25, .to = 0.5, .density = {{0, force({1, 0, 0})}}});
  expect_below("pulled along", std::abs((pulled[0] - 1) / (0.25 * 0.375 / kEA) - 1), 1e-9);
}

/// In its plane, a rod of length 1 and EI = 1, from its free end to its clamp: place, angle, force, moment, by
/// Runge-Kutta 4. Free of the engine's mechanics.
Vector3 tip_of_rod(const std::function<Vector3(double)>& density, Axes axes) {
  using State = Eigen::Matrix<double, 6, 1>;  // x, y, θ, n_x, n_y, m
  const auto slope = [&](double s, const State& y) -> State {
    const double c = std::cos(y[2]), d = std::sin(y[2]);
    const double strain = 1 + (c * y[3] + d * y[4]) / kEA, shear = (c * y[4] - d * y[3]) / kGA;
    Vector3 f = density(s);
    if (axes == Axes::section) f.head<2>() = Eigen::Vector2d(c * f[0] - d * f[1], d * f[0] + c * f[1]);
    const double x = strain * c - shear * d, z = strain * d + shear * c;
    State rate;
    rate << x, z, y[5], -f[0], -f[1], -(x * y[4] - z * y[3]) - f[2];
    return rate;
  };
  const auto root = [&](double angle) {
    constexpr int kSteps = 4000;
    State y = State::Zero();
    y[2] = angle;
    for (int i = 0; i < kSteps; ++i) {
      const double h = -1.0 / kSteps, s = 1 + i * h;
      const State a = slope(s, y), b = slope(s + h / 2, y + h / 2 * a), c = slope(s + h / 2, y + h / 2 * b);
      y += h / 6 * (a + 2 * b + 2 * c + slope(s + h, y + h * c));
    }
    return y;
  };
  double last = 1, angle = 1.2;
  for (int i = 0; i < 30 && std::abs(angle - last) > 1e-13; ++i) {
    const double at_last = root(last)[2], here = root(angle)[2];
    last = std::exchange(angle, angle - here * (angle - last) / (here - at_last));
  }
  return {-root(angle)[0], -root(angle)[1], angle};
}

TEST(LineLoad, BendsFarAsTheDifferentialEquationsOfTheRodSay) {
  const struct {
    const char* what;
    std::function<Vector3(double)> density;  // f_x, f_y, m_z
    LineLoad load;
  } cases[] = {
      {"uniform", [](double) { return Vector3(0, 20, 0); }, {.density = {{0, force({0, 20, 0})}}}},
      {"linear, with a moment",
       [](double s) { return Vector3(-5, 20 * (1 - s), 3 * s); },
       {.density = {{0, {{-5, 20, 0}, {0, 0, 0}}}, {1, {{-5, 0, 0}, {0, 0, 3}}}}}},
      {"a function of the arc",
       [](double s) { return Vector3(0, 20 * std::sin(M_PI * s), 0); },
       {.law =
            [](double s, double) {
              return force({0, 20 * std::sin(M_PI * s), 0});
            }}},
  };
  for (auto c : cases)
    for (const Axes axes : {Axes::world, Axes::section}) {
      c.load.axes = axes;
      const std::string what = std::string(c.what) + (axes == Axes::world ? ", dead" : ", following");
      double coarse = 0;
      const Vector3 tip = tip_of_cantilever(rod(kEA, kGA, 1), c.load, &coarse);
      expect_below(what + ", 20 elements", coarse, 3e-3);
      expect_below(what + ", extrapolated", (tip - tip_of_rod(c.density, axes)).norm(), 1e-9);
    }
}

/// What a piece does at its two points.
std::array<std::pair<Wrench, Vector3>, 2> loads(Snapshot& now, const LineLoadPiece& piece, double time = 0) {
  const MarkerKinematics at[] = {now.marker(piece.markers()[0]), now.marker(piece.markers()[1])};
  const MarkerView views[] = {{at[0], 0}, {at[1], 1}};
  ForceRows rows(2);
  piece.evaluate(time, views, rows);
  return {{{rows.load(0), at[0].p}, {rows.load(1), at[1].p}}};
}

/// Force and moment about the origin of all pieces, as they are drawn.
Vector6 resultant(SystemGraph& graph, const std::vector<LineLoadPiece*>& pieces, double time = 0) {
  const System system = assemble(graph);
  Snapshot now(system, system.initial_state());
  Vector6 sum = Vector6::Zero();
  for (const LineLoadPiece* piece : pieces)
    for (const auto& [wrench, place] : loads(now, *piece, time)) {
      sum.head<3>() += wrench.force;
      sum.tail<3>() += wrench.torque + place.cross(wrench.force);
    }
  return sum;
}

TEST(LineLoad, OfLinearDensityHasItsResultant) {
  SystemGraph graph;
  auto& beam = graph.add<Beam>("beam", {.axis = along_x(2), .sections = {{0, rod(1, 1, 1)}}, .elements = 7});
  // From 0.3 to 1.7: a ramp to 4 N/m at 0.9, flat beyond; and 3 N m/m about x.
  const auto pieces = add_line_load(
      graph, "ramp", beam,
      {.from = 0.3, .to = 1.7, .density = {{0.3, {{0, 0, 0}, {3, 0, 0}}}, {0.9, {{0, 0, 4}, {3, 0, 0}}}}});
  Vector6 exact;
  const double ramp = 0.5 * 0.6 * 4, flat = 0.8 * 4;
  exact << 0, 0, ramp + flat, 3 * 1.4, -(ramp * (0.3 + 0.4) + flat * 1.3), 0;
  EXPECT_LT((resultant(graph, pieces) - exact).norm(), 1e-13);
  EXPECT_EQ(pieces.front()->name(), "ramp.0");
}

TEST(LineLoad, FollowsItsLawInTime) {
  SystemGraph graph;
  auto& beam = graph.add<Beam>("beam", {.axis = along_x(2), .sections = {{0, rod(1, 1, 1)}}, .elements = 3});
  const auto pieces = add_line_load(graph, "gust", beam, {.law = [](double s, double t) {
                                      return force({0, s * t, 0});
                                    }});
  EXPECT_TRUE(pieces[0]->depends_on_time());
  EXPECT_LT((resultant(graph, pieces, 3) - (Vector6() << 0, 6, 0, 0, 0, 8).finished()).norm(), 1e-13);
}

TEST(LineLoad, IsTimesItsAmplitude) {
  SystemGraph graph;
  auto& beam = graph.add<Beam>("beam", {.axis = along_x(2), .sections = {{0, rod(1, 1, 1)}}, .elements = 3});
  auto& twice = graph.add<Input>("twice", {.value = 2});
  const auto even = add_line_load(graph, "even", beam, {.density = {{0, force({0, 1, 0})}}, .amplitude = ramp(0, 2)});
  const auto given = add_line_load(graph, "given", beam, {.density = {{0, force({0, 1, 0})}}, .amplitude = twice});
  const auto gust = add_line_load(graph, "gust", beam,
                                  {.law =
                                       [](double s, double t) {
                                         return force({0, s * t, 0});
                                       },
                                   .amplitude = twice});
  EXPECT_TRUE(even[0]->depends_on_time() && given[0]->depends_on_time());
  const auto off = [&](const auto& pieces, double force_y, double moment_z) {
    return (resultant(graph, pieces, 3) - (Vector6() << 0, force_y, 0, 0, 0, moment_z).finished()).norm();
  };
  EXPECT_LT(off(even, 12, 12), 1e-13);  // 6 N/m at t = 3 s over 2 m
  EXPECT_LT(off(given, 4, 4), 1e-13);
  EXPECT_LT(off(gust, 12, 16), 1e-13);
}

/// As the weight of consistent mass, at the same points; of a cable, as its weight.
TEST(LineLoad, OfTheWeightActsAsGravity) {
  for (const bool cable : {false, true}) {
    VectorX rest[2];
    for (const bool loaded : {false, true}) {
      SystemGraph graph{{.gravity = {0, 0, loaded ? 0.0 : -9.81}}};
      const LineLoad weight{.density = {{0, force({0, 0, -9.81 * 2})}}};
      const Marker wall = graph.ground().marker();
      if (cable) {
        auto& line = graph.add<Cable>(
            "cable", {.to = {2, 0, 0}, .length = 2.3, .elements = 9, .mass_per_length = 2, .axial_stiffness = 1e4});
        graph.add<SphericalJoint>("left", {wall, line.start()});
        graph.add<SphericalJoint>("right", {graph.ground().marker({2, 0, 0}), line.end()});
        if (loaded) add_line_load(graph, "weight", line, weight);
      } else {
        auto& line = graph.add<Beam>(
            "beam", {.axis = along_x(2),
                     .sections = {{0, BeamSection::diagonal({500, 300, 300, 9, 9, 9}, 2, {0.2, 0.1, 0.1})}},
                     .elements = 9,
                     .mass = Beam::Mass::consistent});
        graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0, 0}, line.axes(0)), line.marker(0)});
        if (loaded) add_line_load(graph, "weight", line, weight);
      }
      const System system = assemble(graph);
      rest[loaded] = find_equilibrium(system, system.initial_state()).state.q;
    }
    expect_below("load against weight", (rest[0] - rest[1]).norm(), 1e-13);
  }
}

/// Under hydrostatic pressure a ring shrinks, and buckles at 3 EI/R³; where each force keeps its direction, at 4 EI/R³
/// (S. Timoshenko, J. Gere, Theory of Elastic Stability, art. 7.6; A. P. Boresi, J. Appl. Mech. 22 (1955) 95). A
/// quarter, whose ends slide along the axes of symmetry.
TEST(LineLoad, OfPressureBucklesARing) {
  const double EA = 1e6, length = M_PI / 2;
  for (const Axes axes : {Axes::section, Axes::world}) {
    double critical[3];
    for (int k = 0; k < 3; ++k) {
      const auto stiffness = [&](double p) {
        SystemGraph graph{{.gravity = Vector3::Zero()}};
        const BeamAxis arc = BeamAxis::curved({{1, 0, 0}, rotation_about({0, 0, 1}, M_PI / 2)}, {0, 0, 1}, length);
        auto& ring = graph.add<Beam>(
            "ring", {.axis = arc,
                     .sections = {{0, BeamSection::diagonal({EA, EA, EA, 100, 100, 1}, 1, {2e-6, 1e-6, 1e-6})}},
                     .elements = 4 << k});
        const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2), up = rotation_about({1, 0, 0}, -M_PI / 2);
        graph.add<PrismaticJoint>("right",
                                  {graph.ground().marker({1, 0, 0}, along), ring.marker_at_world({1, 0, 0}, along)});
        graph.add<PrismaticJoint>("top", {graph.ground().marker({0, 1, 0}, up), ring.marker_at_world({0, 1, 0}, up)});
        LineLoad pressure{.axes = axes};
        if (axes == Axes::section)
          pressure.density = {{0, force({0, p, 0})}};  // axis 2 points to the centre
        else
          pressure.law = [p](double s, double) { return force({-p * std::cos(s), -p * std::sin(s), 0}); };
        add_line_load(graph, "pressure", ring, pressure);
        const Marker top = ring.marker(length);
        const System system = assemble(graph);
        const State state = find_equilibrium(system, system.initial_state()).state;
        Snapshot now(system, state);
        expect_below("radius of the ring", std::abs(now.marker(top).p[1] - (1 - p / EA)), 1e-10);
        return linearize(system, state).lowest_stiffness();
      };
      double last = 2.5, p = 3.2, at_last = stiffness(last);
      for (int i = 0; i < 3; ++i) {
        const double here = stiffness(p);
        last = std::exchange(p, p - here * (p - last) / (here - at_last));
        at_last = here;
      }
      critical[k] = p;
    }
    const double first = (4 * critical[1] - critical[0]) / 3, second = (4 * critical[2] - critical[1]) / 3;
    const double exact = axes == Axes::section ? 3 : 4;
    expect_below("ring, 16 elements a quarter", std::abs(critical[2] / exact - 1), 0.01);
    expect_below("ring, extrapolated", std::abs((16 * second - first) / 15 / exact - 1), 4e-6);
  }
}

/// One piece on a bent beam that has hardly any stiffness of its own.
TEST(LineLoad, HasItsTangent) {
  for (const Axes axes : {Axes::world, Axes::section})
    for (const bool moment : {false, true}) {
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      BeamSection limp = rod(1, 1, 1);
      limp.stiffness *= 1e-12;
      auto& beam = graph.add<Beam>(
          "beam", {.axis = BeamAxis::curved({}, {0.3, -0.5, 0.8}, 2), .sections = {{0, limp}}, .elements = 3});
      const Wrench wrench{{3, -2, 4}, moment ? Vector3(0.5, 0.7, -0.4) : Vector3::Zero()};
      const auto pieces =
          add_line_load(graph, "load", beam, {.from = 0.8, .to = 1.2, .density = {{0, wrench}}, .axes = axes});
      ASSERT_EQ(pieces.size(), 1u);
      check_force(graph, *pieces[0], {.conservative = axes == Axes::world && !moment, .tolerance = 1e-9});
    }
}

/// Σ F · p of a dead load.
double moment_of_forces(Snapshot& now, const std::vector<LineLoadPiece*>& pieces) {
  double sum = 0;
  for (const LineLoadPiece* piece : pieces)
    for (const auto& [force, place] : loads(now, *piece)) sum += force.force.dot(place);
  return sum;
}

TEST(LineLoad, DoesTheWorkThatABeamGains) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& beam = graph.add<Beam>("beam", {.axis = along_x(1), .sections = {{0, rod(200, 100, 1)}}, .elements = 4});
  graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0, 0}, beam.axes(0)), beam.marker(0)});
  const auto pieces = add_line_load(graph, "load", beam, {.from = 0.1, .density = {{0, force({0, 3, 9})}}});
  const System system = assemble(graph);
  State state = system.initial_state();
  Snapshot now(system, state);
  const double before = moment_of_forces(now, pieces);
  const Method method = runge_kutta8(1e-11);
  Simulation(system, *method).run(state, 0.3);
  now.evaluate(state);
  const double gained = kinetic_energy().value(now) + elastic_energy(beam).value(now);
  EXPECT_GT(gained, 1);
  EXPECT_NEAR(gained, moment_of_forces(now, pieces) - before, 1e-8 * gained);
}

TEST(LineLoad, RefusesWhatCannotBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<LineLoad::Station> uniform{{0, force({0, 0, -1})}};
  const auto refused = [](bool cable, const LineLoad& load) -> std::string {
    SystemGraph graph;
    try {
      if (cable) {
        auto& line = graph.add<Cable>("line", {.to = {2, 0, 0}, .mass_per_length = 1, .axial_stiffness = 1});
        add_line_load(graph, "bad", line, load);
      } else {
        auto& line = graph.add<Beam>("line", {.axis = along_x(2), .sections = {{0, rod(1, 1, 1)}}});
        add_line_load(graph, "bad", line, load);
      }
      assemble(graph);
    } catch (const SceneError& error) {
      EXPECT_EQ(error.where().rfind("line_load_test.cpp:", 0), 0u) << error.what();
      EXPECT_FALSE(error.fix().empty());
      return error.problem();
    }
    return "accepted";
  };
  const auto expect = [&](const std::string& words, const LineLoad& load, bool cable = false) {
    const std::string problem = refused(cable, load);
    EXPECT_NE(problem.find("'bad"), std::string::npos) << problem;
    EXPECT_NE(problem.find(words), std::string::npos) << problem;
  };
  EXPECT_EQ(refused(false, {.density = uniform}), "accepted");
  expect("leaves its body", {.from = 1, .to = 2.1, .density = uniform});
  expect("leaves its body", {.from = -0.1, .density = uniform});
  expect("is empty", {.from = 1, .to = 1, .density = uniform});
  expect("from", {.from = nan, .density = uniform});
  expect("no density", {});
  expect("a density and a law", {.density = uniform, .law = [](double, double) { return force({0, 0, 1}); }});
  expect("the force of station 1", {.density = {{0, force({0, 0, 0})}, {1, force({0, nan, 0})}}});
  expect("the moment of station 0", {.density = {{0, torque({nan, 0, 0})}}});
  expect("station 1 does not lie behind", {.density = {{1, force({0, 0, 0})}, {1, force({0, 1, 0})}}});
  expect("sections of 'line' do not turn", {.density = uniform, .axes = Axes::section}, true);
  expect("puts a moment on 'line'", {.density = {{0, torque({1, 0, 0})}}}, true);
}

}  // namespace
}  // namespace lithe::test::line_load_test
