#include <gtest/gtest.h>

#include <cmath>

#include "bodies/beam/beam.h"
#include "bodies/cable/cable.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "engine/run/simulation.h"
#include "joints/aerodynamics/airfoil_load.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/support/joint_checks.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"
#include "tests/support/pairs.h"

/// Steady strip theory against closed forms and a blade-element integral written apart.
namespace lithe::test::airfoil_test {
namespace {

constexpr double kDensity = 1.2;
const AirfoilLaw kStalling = [](double a) {
  return AirfoilCoefficients{1.1 * std::sin(2 * a) + 0.2, 0.02 + 1.5 * std::sin(a) * std::sin(a), -0.05 - 0.1 * a};
};

WindField uniform(const Vector3& velocity) {
  return [velocity](const Vector3&, double) { return velocity; };
}

/// What the strips do in all, world axes, about the world's origin.
Vector6 total(Snapshot& now, const std::vector<AirfoilStrip*>& strips) {
  Vector6 sum = Vector6::Zero(), load;
  for (const AirfoilStrip* strip : strips) {
    applied_force(*strip, 0).evaluate(now, {load.data(), 6});
    sum.head<3>() += load.head<3>();
    sum.tail<3>() += load.tail<3>() + now.marker(strip->markers()[0]).p.cross(Vector3(load.head<3>()));
  }
  return sum;
}

/// A wing along x, its leading edge at +y, flies along y with a climb; or stands in the wind that it would feel.
TEST(AirfoilStrip, HasTheLiftDragAndMomentOfATranslatingWing) {
  const double c = 0.4, b = 1.7, twist = 0.07, ahead = 0.06, V = 20, climb = -3;
  for (const bool flies : {true, false}) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const Vector3 velocity(2, V, climb);
    auto& body = graph.add<RigidBody>("wing", {.velocity = flies ? velocity : Vector3(0, 0, 0)});
    auto& strip = graph.add<AirfoilStrip>("strip", {body.marker()},
                                          {.width = b,
                                           .chord = c,
                                           .twist = twist,
                                           .ahead = ahead,
                                           .airfoil = kStalling,
                                           .wind = flies ? WindField{} : uniform(-velocity),
                                           .density = kDensity});
    const System system = assemble(graph);
    Snapshot now(system, system.initial_state());
    const double path = std::atan2(climb, V), alpha = twist - path;  // sinks: from below
    EXPECT_NEAR(angle_of_attack(strip).value(now), alpha, 1e-14);
    const auto [c_l, c_d, c_m] = kStalling(alpha);
    const double q = 0.5 * kDensity * (V * V + climb * climb), lift = q * b * c * c_l, drag = q * b * c * c_d;
    Vector6 wanted;
    wanted << 0, -drag * std::cos(path) - lift * std::sin(path), lift * std::cos(path) - drag * std::sin(path), 0, 0, 0;
    const Vector3 centre(0, ahead * std::cos(twist), ahead * std::sin(twist));
    wanted.tail<3>() = centre.cross(Vector3(wanted.head<3>())) + Vector3(q * b * c * c * c_m, 0, 0);
    EXPECT_LT((total(now, {&strip}) - wanted).norm(), 1e-12 * wanted.norm()) << total(now, {&strip}).transpose();
    EXPECT_EQ(strip.drawn_shapes(0).size(), 1u);
  }
}

TEST(AirfoilStrip, HasItsTangentOnAllBodies) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const std::vector<Marker> markers = pair.draw(graph, {0.3, 0.5, -0.4});
    const WindField gust = [](const Vector3& p, double t) {
      return Vector3(1 + 0.2 * p[2], -9 + std::sin(t), 2 + p[0] - 0.3 * p[1]);
    };
    auto& strip = graph.add<AirfoilStrip>("strip", {markers[1]},
                                          {.width = 0.3,
                                           .chord = 0.2,
                                           .twist = 0.1,
                                           .ahead = 0.05,
                                           .airfoil = kStalling,
                                           .wind = gust,
                                           .density = kDensity});
    check_force(graph, strip, {.conservative = false});
  }
}

TEST(AirfoilStrip, WhoseWindIsNoNumberIsNamed) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("wing", {});
  graph.add<AirfoilStrip>("gusty", {body.marker()},
                          {.width = 1, .chord = 1, .airfoil = kStalling, .wind = [](const Vector3&, double t) {
                             return Vector3(0, t > 0.1 ? std::nan("") : -5, 0);
                           }});
  const System system = assemble(graph);
  State state = system.initial_state();
  const Method method = index3(0.01);
  expect_says(message_of<SimulationError>([&] { Simulation(system, *method).run(state, 1); }), {"'gusty'"});
}

/// m v_dot = -½ ρ V c b c_l' v: the damping of a plunging wing; its power is what the wing loses.
TEST(AirfoilStrip, DampsAPlungingWing) {
  const double V = 30, c = 0.5, b = 2, m = 3, slope = 5.5, v0 = 0.01;
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& body = graph.add<RigidBody>("wing", {.mass = m, .velocity = {0, 0, v0}});
  graph.add<PrismaticJoint>("guide", {graph.ground().marker(), body.marker()});
  auto& strip = graph.add<AirfoilStrip>(
      "strip", {body.marker()},
      {.width = b, .chord = c, .airfoil = linear_airfoil(slope), .wind = uniform({0, -V, 0}), .density = kDensity});
  const System system = assemble(graph);
  State state = system.initial_state();
  {
    Snapshot now(system, state);
    const double wanted = -0.5 * kDensity * V * c * b * slope * v0 * v0;
    EXPECT_NEAR(power(strip).value(now) / wanted, 1, 1e-6);
    EXPECT_NEAR(m * v0 * state.v_dot[2] / wanted, 1, 1e-6);
  }
  const Method method = runge_kutta8(1e-12);
  Simulation(system, *method).run(state, 0.05);
  const double rate = 0.5 * kDensity * V * c * b * slope / m;
  EXPECT_LT(std::exp(-rate * 0.05), 0.3);
  EXPECT_NEAR(state.v[2] / (v0 * std::exp(-rate * 0.05)), 1, 1e-6);
}

/// A section that pitches about its aerodynamic centre meets the flow as if it were turned by θ̇ c / 2V more.
TEST(AirfoilStrip, FeelsThePitchRateAtThreeQuartersOfItsChord) {
  const double V = 25, c = 0.6, b = 1.5, slope = 2 * M_PI, rate = 0.01;
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& body = graph.add<RigidBody>("wing", {.angular_velocity = {rate, 0, 0}});
  auto& strip = graph.add<AirfoilStrip>(
      "strip", {body.marker()},
      {.width = b, .chord = c, .airfoil = linear_airfoil(slope), .wind = uniform({0, -V, 0}), .density = kDensity});
  const System system = assemble(graph);
  Snapshot now(system, system.initial_state());
  const double wanted = 0.5 * kDensity * V * V * b * c * slope * rate * c / (2 * V);
  EXPECT_NEAR(total(now, {&strip})[2] / wanted, 1, 1e-6);
  const double moment = 0.5 * kDensity * V * V * b * c * c * -M_PI / 8 * rate * c / V;
  EXPECT_NEAR(total(now, {&strip})[3] / moment, 1, 1e-6);
}

/// Plunge h up, pitch θ nose up about an axis, the mass centre s behind it, the aerodynamic centre e before it:
///   [m_1 + m_2, -m_2 s; -m_2 s, I + m_2 s²] (ḧ, θ̈) + diag(k_h, k_θ) (h, θ) = (1, e) L,
///   L = q c b c_l' (θ - (ḣ + (e - c/2) θ̇) / V), and -(π/16) ρ V c³ b θ̇ on θ: growth and frequencies below and above
///   flutter.
TEST(AirfoilStrip, LetsASectionFlutterAsItsEquationsSay) {
  const double m1 = 1, m2 = 4, inertia = 0.12, s = 0.08, e = 0.1, c = 0.8, b = 1, slope = 6, k_h = 2000, k_theta = 300;
  int unstable = 0;
  for (const double V : {5.0, 12.0, 20.0, 26.0}) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const Matrix3 along_span = rotation_about({0, 1, 0}, M_PI / 2);
    auto& carrier = graph.add<RigidBody>("carrier", {.mass = m1});
    auto& wing = graph.add<RigidBody>("wing", {.mass = m2, .inertia = {inertia, 1, 1}, .position = {0, -s, 0}});
    auto& guide = graph.add<PrismaticJoint>("guide", {graph.ground().marker(), carrier.marker()});
    auto& hinge =
        graph.add<RevoluteJoint>("hinge", {carrier.marker({}, along_span), wing.marker({0, s, 0}, along_span)});
    graph.add<CoordinateSpring>("plunge", {guide.displacement()}, {.stiffness = k_h});
    graph.add<CoordinateSpring>("pitch", {hinge.angle()}, {.stiffness = k_theta});
    graph.add<AirfoilStrip>("strip", {wing.marker({0, s, 0})},
                            {.width = b,
                             .chord = c,
                             .ahead = e,
                             .airfoil = linear_airfoil(slope),
                             .wind = uniform({0, -V, 0}),
                             .density = kDensity});
    const System system = assemble(graph);
    const Linearization found = linearize(system, system.initial_state());

    const double lift = 0.5 * kDensity * V * V * c * b * slope;
    MatrixX M(2, 2), K(2, 2), D(2, 2), A = MatrixX::Zero(4, 4);
    M << m1 + m2, -m2 * s, -m2 * s, inertia + m2 * s * s;
    K << k_h, -lift, 0, k_theta - e * lift;
    D << lift / V, lift * (e - c / 2) / V, e * lift / V,
        e * lift * (e - c / 2) / V + M_PI / 16 * kDensity * V * c * c * c * b;
    A.topRightCorner(2, 2).setIdentity();
    A.bottomLeftCorner(2, 2) = -solve(M, K);
    A.bottomRightCorner(2, 2) = -solve(M, D);
    const Eigen::VectorXcd wanted = eigenvalues(A);
    for (const Mode& mode : found.modes) {
      double nearest = 1e9;
      for (Eigen::Index i = 0; i < wanted.size(); ++i)
        nearest = std::min(nearest, std::abs(wanted[i] - mode.eigenvalue));
      EXPECT_LT(nearest / std::abs(mode.eigenvalue), 1e-6) << "at " << V << " m/s";
    }
    unstable += found.largest_growth() > 0;
    std::printf("%4.0f m/s: growth %+.4f 1/s\n", V, found.largest_growth());
  }
  EXPECT_GT(unstable, 0);
  EXPECT_LT(unstable, 4);
}

TEST(AirfoilLoad, DampsTheBendingOfABeamByHalfOfWhatItsMassTakes) {
  const double V = 12, c = 0.3, mass = 2, slope = 6;
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& wing = graph.add<Beam>(
      "wing", {.axis = BeamAxis::straight({0, 0, 0}, {4, 0, 0}, {0, 1, 0}),
               .sections = {{0, BeamSection::diagonal({1e8, 1e8, 1e8, 1e6, 500, 1e5}, mass, {2e-5, 1e-5, 1e-5})}},
               .elements = 8});
  graph.add<FixedJoint>("root", {graph.ground().marker({0, 0, 0}, wing.axes(0)), wing.marker(0)});
  add_airfoil_load(
      graph, "air", wing,
      {.stations = {{.chord = c, .airfoil = linear_airfoil(slope)}}, .wind = uniform({0, -V, 0}), .density = kDensity});
  const System system = assemble(graph);
  const Linearization found = linearize(system, system.initial_state(), {.mode_count = 6});
  // ζ ω = c_a / 2μ of each mode, but for the mass, which is lumped: of second order in the elements.
  const double wanted = -0.5 * kDensity * V * c * slope / (2 * mass);
  std::printf("flap: %.6f 1/s at %.3f Hz, closed form %.6f\n", found.modes[0].growth(), found.modes[0].frequency(),
              wanted);
  EXPECT_NEAR(found.modes[0].growth() / wanted, 1, 2e-3);
}

/// Thrust and torque of a twisted, tapered blade that turns, against the blade-element integral.
TEST(AirfoilLoad, OfARotorIsTheBladeElementIntegral) {
  const double spin = 6, wind = 8, hub = 1, tip = 10;
  const AirfoilLaw thick = linear_airfoil(5, -0.05, 0.03), thin = kStalling;
  const auto inflow = [](double r) { return 0.4 - 0.035 * r; };  // pitch, rad
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& blade = graph.add<Beam>("blade", {.axis = BeamAxis::straight({hub, 0, 0}, {tip, 0, 0}, {0, 1, 0}),
                                          .sections = {{0, BeamSection::circle(0.1, {7e10, 0.3, 2700})}},
                                          .elements = 18,
                                          .velocity = {0, hub * spin, 0},
                                          .angular_velocity = {0, 0, spin}});
  const auto strips =
      add_airfoil_load(graph, "air", blade,
                       {.stations = {{.arc = 0, .chord = 1.2, .twist = inflow(hub), .airfoil = thick},
                                     {.arc = tip - hub, .chord = 0.3, .twist = inflow(tip), .airfoil = thin}},
                        .wind = uniform({0, 0, wind}),
                        .density = kDensity});
  EXPECT_EQ(strips.size(), 36u);
  EXPECT_EQ(strips[7]->name(), "air.7");
  const System system = assemble(graph);
  Snapshot now(system, system.initial_state());
  const Vector6 found = total(now, strips);

  double thrust = 0, torque = 0;
  constexpr int kParts = 2000;
  for (int i = 0; i <= kParts; ++i) {  // Simpson
    const double share = static_cast<double>(i) / kParts, r = hub + (tip - hub) * share;
    const double weight = (tip - hub) / kParts / 3 * (i == 0 || i == kParts ? 1 : i % 2 == 1 ? 4 : 2);
    const double phi = std::atan2(wind, spin * r), W2 = wind * wind + spin * spin * r * r;
    const double angle = inflow(r) + phi, chord = 1.2 - 0.9 * share;
    const double c_l = (1 - share) * thick(angle).lift + share * thin(angle).lift;
    const double c_d = (1 - share) * thick(angle).drag + share * thin(angle).drag;
    const double q = 0.5 * kDensity * W2 * chord;
    thrust += weight * q * (c_l * std::cos(phi) + c_d * std::sin(phi));
    torque += weight * r * q * (c_l * std::sin(phi) - c_d * std::cos(phi));
  }
  expect_below("thrust", std::abs(found[2] / thrust - 1), 1e-6);
  expect_below("torque", std::abs(found[5] / torque - 1), 1e-6);
}

/// A wing that twists alone, its aerodynamic centre e before its axis: λ² = q c e c_l' / GJ.
struct TwistingWing {
  static constexpr double kLength = 2, kTorsion = 100, kChord = 0.5, kAhead = 0.1, kSlope = 6, kSpeed = 10;
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  Beam& wing;
  Marker tip;
  TwistingWing(int elements, double q, double twist)
      : wing(graph.add<Beam>(
            "wing", {.axis = BeamAxis::straight({0, 0, 0}, {kLength, 0, 0}, {0, 1, 0}),
                     .sections = {{0, BeamSection::diagonal({1e10, 1e10, 1e10, kTorsion, 1e9, 1e9}, 1, {1, 0.5, 0.5})}},
                     .elements = elements})),
        tip(wing.marker(kLength)) {
    graph.add<FixedJoint>("root", {graph.ground().marker({0, 0, 0}, wing.axes(0)), wing.marker(0)});
    add_airfoil_load(
        graph, "air", wing,
        {.stations = {{.chord = kChord, .twist = twist, .ahead = kAhead, .airfoil = linear_airfoil(kSlope)}},
         .wind = uniform({0, -kSpeed, 0}),
         .density = 2 * q / (kSpeed * kSpeed)});
  }
  /// (π / 2l)² GJ / (c e c_l'): divergence.
  static double divergence() { return std::pow(M_PI / (2 * kLength), 2) * kTorsion / (kChord * kAhead * kSlope); }
};

TEST(AirfoilLoad, TwistsAWingAndDivergesAsTheClosedFormsSay) {
  const double q_D = TwistingWing::divergence(), twist = 1e-5;
  double twisted[2], diverging[2];
  for (int k = 0; k < 2; ++k) {
    TwistingWing scene(8 << k, 0.5 * q_D, twist);
    const System system = assemble(scene.graph);
    Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
    const Matrix3 R = now.marker(scene.tip).R;
    twisted[k] = std::atan2(R(2, 1), R(1, 1));
    const auto stiffness = [&](double q) {
      TwistingWing at(8 << k, q, 0);
      const System still = assemble(at.graph);
      return linearize(still, still.initial_state()).lowest_stiffness();
    };
    double last = 0.8 * q_D, q = 0.95 * q_D, at_last = stiffness(last);
    for (int i = 0; i < 3; ++i) {
      const double here = stiffness(q);
      last = std::exchange(q, q - here * (q - last) / (here - at_last));
      at_last = here;
    }
    diverging[k] = q;
  }
  const double wanted = twist * (1 / std::cos(M_PI / 2 * std::sqrt(0.5)) - 1);
  expect_below("twist, 16 elements", std::abs(twisted[1] / wanted - 1), 5e-3);
  expect_below("twist, extrapolated", std::abs((4 * twisted[1] - twisted[0]) / 3 / wanted - 1), 2e-4);
  expect_below("divergence, 16 elements", std::abs(diverging[1] / q_D - 1), 2e-3);
  expect_below("divergence, extrapolated", std::abs((4 * diverging[1] - diverging[0]) / 3 / q_D - 1), 2e-5);
}

TEST(Airfoil, TableIsMetAtItsPointsAndHeldBeyond) {
  const std::vector<double> angles{-0.3, -0.1, 0.05, 0.2, 0.4}, lift{-0.8, -0.4, 0.4, 1.2, 0.9},
      drag{0.1, 0.02, 0.01, 0.02, 0.2}, moment{0, -0.02, -0.03, -0.03, -0.1};
  const AirfoilLaw law = airfoil_table(angles, lift, drag, moment);
  for (std::size_t i = 0; i < angles.size(); ++i) {
    EXPECT_NEAR(law(angles[i]).lift, lift[i], 1e-14);
    EXPECT_NEAR(law(angles[i]).drag, drag[i], 1e-14);
    EXPECT_NEAR(law(angles[i]).moment, moment[i], 1e-14);
  }
  EXPECT_EQ(law(2).lift, law(0.4).lift);
  EXPECT_EQ(law(-3).drag, law(-0.3).drag);
  EXPECT_NEAR(airfoil_table({-1, 1}, {-6, 6})(0.25).lift, linear_airfoil(6)(0.25).lift, 1e-14);
  expect_says(message_of<SceneError>([&] { airfoil_table({0, 1}, {0}); }), {"lift of an airfoil"});
  expect_says(message_of<SceneError>([&] { airfoil_table({0, 0}, {0, 1}); }), {"does not come after"});
  expect_says(message_of<SceneError>([&] { airfoil_table({}, {}); }), {"two points"});
  expect_says(message_of<SceneError>([&] { linear_airfoil(std::nan("")); }), {"lift slope"});
}

TEST(AirfoilLoad, RefusesWhatCannotBe) {
  const AirfoilLaw law = linear_airfoil();
  const auto refused = [&](const AirfoilLoad& load) {
    SystemGraph graph;
    auto& wing = graph.add<Beam>("wing", {.axis = BeamAxis::straight({0, 0, 0}, {2, 0, 0}),
                                          .sections = {{0, BeamSection::circle(0.1, {7e10, 0.3, 2700})}}});
    const std::string text = message_of<SceneError>([&] { add_airfoil_load(graph, "air", wing, load); });
    EXPECT_NE(text.find("airfoil_test.cpp:"), std::string::npos) << text;
    return text;
  };
  expect_says(refused({}), {"'air'", "no station"});
  expect_says(refused({.stations = {{.chord = 0, .airfoil = law}}}), {"the chord of station 0"});
  expect_says(refused({.stations = {{.chord = 1}}}), {"station 0 has no airfoil"});
  expect_says(refused({.stations = {{.arc = 1, .chord = 1, .airfoil = law}, {.arc = 1, .chord = 1, .airfoil = law}}}),
              {"station 1 does not lie behind"});
  expect_says(refused({.from = 1, .to = 3, .stations = {{.chord = 1, .airfoil = law}}}), {"leaves its body", "2.0"});
  expect_says(refused({.stations = {{.chord = 1, .twist = std::nan(""), .airfoil = law}}}), {"the twist of station 0"});
  expect_says(refused({.stations = {{.chord = 1, .airfoil = law}}, .density = 0}), {"density"});

  SystemGraph graph;
  auto& rope = graph.add<Cable>("rope", {.to = {2, 0, 0}, .mass_per_length = 1, .axial_stiffness = 1});
  expect_says(message_of<SceneError>(
                  [&] { add_airfoil_load(graph, "air", rope, {.stations = {{.chord = 1, .airfoil = law}}}); }),
              {"sections of 'rope' do not turn", "LineLoad"});
  auto& body = graph.add<RigidBody>("body", {});
  expect_says(
      message_of<SceneError>([&] { graph.add<AirfoilStrip>("a", {body.marker()}, {.chord = 1, .airfoil = law}); }),
      {"width"});
  expect_says(message_of<SceneError>([&] { graph.add<AirfoilStrip>("b", {body.marker()}, {.width = 1, .chord = 1}); }),
              {"no airfoil"});
}

}  // namespace
}  // namespace lithe::test::airfoil_test
