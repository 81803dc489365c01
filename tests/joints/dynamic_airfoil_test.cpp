// Unsteady lift and dynamic stall: against the steady strip, thin-airfoil theory and equations integrated apart.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "bodies/beam/beam.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/state_space.h"
#include "engine/run/simulation.h"
#include "joints/aerodynamics/airfoil_load.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/first_order_states.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"
#include "tests/support/pairs.h"

namespace lithe::test::dynamic_airfoil_test {
namespace {

constexpr double kDensity = 1.2, kChord = 0.4, kWidth = 1.5, kSpeed = 20;

/// A section that stalls at some 14 degrees, with camber.
AirfoilLaw stalling() {
  std::vector<double> angles, lift, drag, moment;
  const double zero = -0.03;
  for (int i = -36; i <= 36; ++i) {
    const double a = i * M_PI / 36, f = 1 / (1 + std::exp((std::abs(a) - 0.25) / 0.03));
    angles.push_back(a);
    lift.push_back(std::abs(a) > 1.6 ? 1.1 * std::sin(2 * a)
                                     : f * 6.1 * (a - zero) + (1 - f) * 1.1 * std::sin(2 * (a - zero)));
    drag.push_back(0.01 + (1 - f) * 1.5 * std::sin(a) * std::sin(a));
    moment.push_back(-0.03 - 0.1 * (1 - f) * std::sin(a));
  }
  return airfoil_table(angles, lift, drag, moment);
}

WindField along(double speed) {
  return [speed](const Vector3&, double) { return Vector3(0, -speed, 0); };
}
AirfoilStrip::Parameters strip_of(AirfoilLaw law, double speed = kSpeed) {
  return {.width = kWidth, .chord = kChord, .airfoil = std::move(law), .wind = along(speed), .density = kDensity};
}

DynamicAirfoilStrip& add_strip(SystemGraph& graph, const Marker& at, const DynamicAirfoilStrip::Parameters& p,
                               const VectorX& start = DynamicAirfoilStrip::start()) {
  auto& flow = graph.add<FirstOrderStates>("flow", {.start = start});
  return graph.add<DynamicAirfoilStrip>("strip", {at, flow.point(0), flow.point(1)}, p);
}

Vector6 load(Snapshot& now, const ForceElement& strip) {
  Vector6 out;
  applied_force(strip, 0).evaluate(now, {out.data(), 6});
  return out;
}

TEST(DynamicAirfoil, InSteadyFlowIsASteadyStrip) {
  for (const AirfoilLaw& law : {linear_airfoil(5.9, -0.02, 0.01, -0.03), stalling()})
    for (const double angle : {-2.9, -0.7, -0.26, -0.03, 0.0, 0.08, 0.2, 0.24, 0.27, 0.4, 1.2, 2.5}) {
      SCOPED_TRACE(angle);
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      auto& body = graph.add<RigidBody>("wing", {.orientation = rotation_about({1, 0, 0}, angle)});
      const DynamicAirfoilStrip::Parameters p{.strip = strip_of(law)};
      const auto& steady = graph.add<AirfoilStrip>("steady", {body.marker()}, p.strip);
      const auto& strip = add_strip(graph, body.marker(), p, DynamicAirfoilStrip::settled(p, angle, kSpeed));
      const System system = assemble(graph);
      const State state = system.initial_state();
      Snapshot now(system, state);
      const Vector6 wanted = load(now, steady), found = load(now, strip);
      EXPECT_LT((found - wanted).norm(), 1e-12 * wanted.norm());
      // Its states rest.
      const int first = system.layout().slice(*strip.markers()[1].body).v;
      EXPECT_LT(now.accelerations().segment(first, 12).lpNorm<Eigen::Infinity>(), 1e-10 * kSpeed / kChord);
    }
}

/// From zero lift the flow goes to the steady one.
TEST(DynamicAirfoil, SettlesToTheSteadyStrip) {
  for (const double angle : {0.1, 0.22, 0.5}) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& body = graph.add<RigidBody>("wing", {.orientation = rotation_about({1, 0, 0}, angle)});
    graph.add<FixedJoint>("stand", {graph.ground().marker({0, 0, 0}, rotation_about({1, 0, 0}, angle)), body.marker()});
    const DynamicAirfoilStrip::Parameters p{.strip = strip_of(stalling())};
    const auto& steady = graph.add<AirfoilStrip>("steady", {body.marker()}, p.strip);
    const auto& strip = add_strip(graph, body.marker(), p);
    const System system = assemble(graph);
    State state = system.initial_state();
    const Method method = radau(1e-10);
    Simulation(system, *method).run(state, 6);  // 600 half chords: e^(-0.0455 600)
    Snapshot now(system, state);
    EXPECT_LT((load(now, strip) - load(now, steady)).norm(), 1e-7 * load(now, steady).norm()) << angle;
  }
}

// ---- attached flow ----

/// What the two lags do to the downwash at a reduced frequency k = ω c/2W.
Complex wake(const FlowLags& lags, double k) {
  const Complex s(0, k);
  return 1 - lags.wake_share_1 - lags.wake_share_2 + lags.wake_share_1 * lags.wake_rate_1 / (s + lags.wake_rate_1) +
         lags.wake_share_2 * lags.wake_rate_2 / (s + lags.wake_rate_2);
}
/// Theodorsen's function, by Hankel functions of the second kind.
Complex theodorsen(double k) {
  const Complex H_0(std::cyl_bessel_j(0, k), -std::cyl_neumann(0, k)),
      H_1(std::cyl_bessel_j(1, k), -std::cyl_neumann(1, k));
  return H_1 / (H_1 + Complex(0, 1) * H_0);
}

/// A thin section that may plunge (up, h), or pitch (nose up, θ) about a point e behind the aerodynamic centre; its
/// lift by its motion, both in answer to an effort.
Complex lift_by_motion(bool pitches, double behind, double omega) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& effort = graph.add<Input>("effort");
  auto& body = graph.add<RigidBody>("wing", {.mass = 2, .inertia = {0.1, 1, 1}});
  const Matrix3 span = rotation_about({0, 1, 0}, M_PI / 2);
  JointCoordinate x;
  if (pitches)
    x = graph.add<RevoluteJoint>("pitch", {graph.ground().marker({}, span), body.marker({}, span)}).angle();
  else
    x = graph.add<PrismaticJoint>("plunge", {graph.ground().marker(), body.marker()}).displacement();
  graph.add<CoordinateMotor>("shaker", {x}, {.effort = effort});
  AirfoilStrip::Parameters p = strip_of(linear_airfoil());
  p.ahead = behind;
  auto& strip = add_strip(graph, body.marker(), {.strip = p});
  const System system = assemble(graph);
  const StateSpace linear = linearize(system, system.initial_state(), {&effort},
                                      {applied_force(strip, 0, kWorldAxes, "load"), coordinate(x, "x")});
  const auto H = linear.response(Complex(0, omega));
  return H(2, 0) / H(6, 0);
}

/// L = q c b 2π [C(k) w_3/4 / W + T ω/2]: the circulatory lift of thin-airfoil theory with the wake's lags for C, and
/// the apparent mass's share of turning.
TEST(DynamicAirfoil, AnswersPlungeAndPitchAsItsWakeSays) {
  const double q = 0.5 * kDensity * kSpeed * kSpeed * kChord * kWidth, T = 0.5 * kChord / kSpeed;
  for (const double k : {0.02, 0.1, 0.3, 0.8, 2.0}) {
    const double omega = k / T;
    const Complex s(0, omega), C = wake({}, k);
    const Complex plunge = -q * 2 * M_PI * C * s / kSpeed;
    EXPECT_LT(std::abs(lift_by_motion(false, 0, omega) - plunge), 1e-6 * std::abs(plunge)) << k;
    for (const double behind : {0.0, 0.1}) {
      const Complex at_three_quarters = 1.0 - s * (behind - kChord / 2) / kSpeed;
      const Complex pitch = q * (2 * M_PI * C * at_three_quarters + M_PI * T * s);
      EXPECT_LT(std::abs(lift_by_motion(true, behind, omega) - pitch), 1e-6 * std::abs(pitch)) << k;
    }
  }
}

TEST(DynamicAirfoil, HasTheodorsensLiftAsJonesApproximatesIt) {
  EXPECT_NEAR(theodorsen(0.1).real(), 0.8319, 1e-4);  // Bisplinghoff, Ashley, Halfman, table 5-1
  EXPECT_NEAR(theodorsen(0.1).imag(), -0.1723, 1e-4);
  const double q = 0.5 * kDensity * kSpeed * kSpeed * kChord * kWidth, T = 0.5 * kChord / kSpeed;
  double amplitude = 0, phase = 0;
  for (double k = 0.01; k <= 1; k *= 1.5) {
    const Complex found = lift_by_motion(false, 0, k / T) / (-q * 2 * M_PI * Complex(0, k / T) / kSpeed),
                  ratio = found / theodorsen(k);
    amplitude = std::max(amplitude, std::abs(std::abs(ratio) - 1)), phase = std::max(phase, std::abs(std::arg(ratio)));
  }
  expect_below("amplitude against Theodorsen", amplitude, 0.025);
  expect_below("phase, rad", phase, 0.025);
}

/// A plunging section gives up ½ |ḣ|² Re(L/ḣ) at every frequency.
TEST(DynamicAirfoil, TakesPowerFromAPlunge) {
  const double T = 0.5 * kChord / kSpeed;
  for (double k = 0.01; k < 5; k *= 2) EXPECT_LT((lift_by_motion(false, 0, k / T) / Complex(0, k / T)).real(), 0) << k;
}

// ---- stall ----

const double kMean = 12 * M_PI / 180, kSwing = 8 * M_PI / 180, kReduced = 0.1;

/// A section that is driven in pitch about its aerodynamic centre, through stall.
struct Pitching {
  explicit Pitching(AirfoilLaw law)
      : omega(kReduced * 2 * kSpeed / kChord),
        body(graph.add<RigidBody>(
            "wing", {.orientation = rotation_about({1, 0, 0}, kMean), .angular_velocity = {kSwing * omega, 0, 0}})) {
    const Matrix3 span = rotation_about({0, 1, 0}, M_PI / 2);
    auto& hinge = graph.add<RevoluteJoint>("pitch", {graph.ground().marker({}, span), body.marker({}, span)});
    graph.add<CoordinateDrive>("drive", {hinge.angle()}, {.motion = harmonic(kSwing, omega, 0, kMean)});
    strip = &add_strip(graph, body.marker(), {.strip = strip_of(std::move(law))});
  }
  double angle(double t) const { return kMean + kSwing * std::sin(omega * t); }
  double rate(double t) const { return kSwing * omega * std::cos(omega * t); }

  SystemGraph graph{{.gravity = Vector3::Zero()}};
  double omega;
  RigidBody& body;
  DynamicAirfoilStrip* strip;
};

/// The same section by equations written apart, and steps of a fourth-order method.
struct Apart {
  explicit Apart(const Pitching& pitching) : scene(pitching), law(stalling()) {
    double low = -0.1, high = 0;
    for (int i = 0; i < 100; ++i) (law(0.5 * (low + high)).lift > 0 ? high : low) = 0.5 * (low + high);
    zero = high;
    for (double a = 0.02; a <= 0.35; a += 1e-3)
      slope = std::max({slope, law(zero + a).lift / a, -law(zero - a).lift / a});
  }
  double point(double a) const {
    const double ratio = law(a).lift / (slope * (a - zero));
    return ratio > 0.25 ? std::pow(2 * std::sqrt(ratio) - 1, 2) : 0;
  }
  double effective(double t, const Eigen::Vector4d& y) const {
    const double w = scene.rate(t), th = scene.angle(t);
    return std::atan2(0.5 * (kSpeed * std::sin(th) + 0.5 * kChord * w) + y[0] + y[1], kSpeed * std::cos(th));
  }
  Eigen::Vector4d rates(double t, const Eigen::Vector4d& y) const {
    const double w = scene.rate(t), th = scene.angle(t), across = kSpeed * std::sin(th) + 0.5 * kChord * w,
                 W = std::hypot(across, kSpeed * std::cos(th)), T = 0.5 * kChord / W;
    return {0.0455 / T * (0.165 * across - y[0]), 0.3 / T * (0.335 * across - y[1]),
            (slope * (effective(t, y) - zero) + M_PI * T * w - y[2]) / (1.7 * T),
            (point(y[2] / slope + zero) - y[3]) / (3 * T)};
  }
  double lift(double t, const Eigen::Vector4d& y) const {
    const double w = scene.rate(t), th = scene.angle(t),
                 W = std::hypot(kSpeed * std::sin(th) + 0.5 * kChord * w, kSpeed * std::cos(th)), a = effective(t, y),
                 f = point(a), full = slope * (a - zero);
    const double separated = f > 1 - 1e-9 ? 0.5 * full : (law(a).lift - full * f) / (1 - f);
    return full * y[3] + separated * (1 - y[3]) + M_PI * 0.5 * kChord / W * w;
  }
  void run(double to) {
    const double h = 1e-5;
    for (; time < to - 0.5 * h; time += h) {
      const Eigen::Vector4d a = rates(time, z), b = rates(time + h / 2, z + h / 2 * a),
                            c = rates(time + h / 2, z + h / 2 * b), d = rates(time + h, z + h * c);
      z += h / 6 * (a + 2 * b + 2 * c + d);
    }
  }
  const Pitching& scene;
  AirfoilLaw law;
  double zero = 0, slope = 0, time = 0;
  Eigen::Vector4d z{0, 0, 0, 1};
};

TEST(DynamicAirfoil, StallsAsItsEquationsIntegratedApart) {
  std::vector<NamedMethod> methods = every_method(2e-4, 1e-9);
  methods.push_back({"Radau", radau(1e-9)});
  methods.push_back({"BDF", bdf(1e-9)});
  methods.push_back({"Automatic", automatic(1e-8)});
  for (NamedMethod& method : methods) {
    Pitching scene(stalling());
    Apart apart(scene);
    const System system = assemble(scene.graph);
    State state = system.initial_state();
    Simulation simulation(system, *method.integrator);
    double worst = 0, least = 1;
    for (int i = 1; i <= 12; ++i) {
      const double t = 0.02 * i;
      simulation.run(state, t);
      apart.run(t);
      Snapshot now(system, state);
      double flow[4];
      scene.strip->flow().evaluate(now, {flow, 4});
      worst = std::max({worst, std::abs(flow[1] - apart.effective(t, apart.z)), std::abs(flow[2] - apart.z[3]),
                        std::abs(flow[3] - apart.lift(t, apart.z))});
      least = std::min(least, flow[2]);
    }
    EXPECT_LT(least, 0.5);
    expect_below("by " + method.name, worst, method.name.starts_with("index") ? 1e-6 : 1e-8);
  }
}

/// The loop of docs/site/catalogue/forces/airfoil.md: lift over angle, up and down.
TEST(DynamicAirfoil, HasTheLoopOfItsPage) {
  Pitching scene(stalling());
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  const Method method = radau(1e-9);
  Simulation simulation(system, *method);
  const double period = 2 * M_PI / scene.omega;
  simulation.run(state, 5 * period);
  const AirfoilLaw law = stalling();
  // Degrees, f, c_l, steady c_l.
  constexpr double shown[][4] = {
      {12, 0.876, 1.401, 1.209}, {17.66, 0.396, 1.303, 0.910}, {20, 0.102, 0.928, 0.812}, {17.66, 0.072, 0.851, 0.910},
      {12, 0.294, 0.937, 1.209}, {6.34, 0.795, 0.898, 0.869},  {4, 0.923, 0.740, 0.601},  {6.34, 0.931, 0.938, 0.869}};
  for (int i = 0; i < 16; ++i) {
    simulation.run(state, (5 + i / 16.0) * period);
    Snapshot now(system, state);
    double flow[4];
    scene.strip->flow().evaluate(now, {flow, 4});
    const double angle = scene.angle(state.time);
    if (i % 2 == 0) {
      const auto& [degrees, separation, lift, at_rest] = shown[i / 2];
      EXPECT_NEAR(angle * 180 / M_PI, degrees, 0.005);
      EXPECT_NEAR(flow[2], separation, 6e-4);
      EXPECT_NEAR(flow[3], lift, 6e-4);
      EXPECT_NEAR(law(angle).lift, at_rest, 6e-4);
    }
  }
}

// ---- as an element ----

TEST(DynamicAirfoil, HasItsTangentOnAllBodies) {
  const AirfoilLaw smooth = [](double a) {
    return AirfoilCoefficients{1.1 * std::sin(2 * a) + 0.2, 0.02 + 1.5 * std::sin(a) * std::sin(a), -0.05 - 0.1 * a};
  };
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const std::vector<Marker> markers = pair.draw(graph, {0.3, 0.5, -0.4});
    AirfoilStrip::Parameters p{.width = 0.3, .chord = 0.2, .twist = 0.1, .ahead = 0.05, .airfoil = smooth};
    p.wind = [](const Vector3& at, double t) {
      return Vector3(1 + 0.2 * at[2], -9 + std::sin(t), 2 + at[0] - 0.3 * at[1]);
    };
    auto& strip = add_strip(graph, markers[1], {.strip = p}, Vector6{{0.3, 0.2, 0.5, 0.6, 0, 0}});
    check_force(graph, strip, {.conservative = false, .tolerance = 1e-6, .difference = 1e-4});
  }
}

/// Along a beam each strip has the place of a steady one and states of its own: at the start attached, half of the
/// downwash at work.
TEST(DynamicAirfoilLoad, HasTheStripsOfTheSteadyOne) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& wing = graph.add<Beam>("wing", {.axis = BeamAxis::straight({0, 0, 0}, {3, 0, 0}, {0, 1, 0}),
                                        .sections = {{0, BeamSection::rectangle(0.3, 0.05, {7e10, 0.33, 2700})}},
                                        .elements = 3});
  graph.add<FixedJoint>("root", {graph.ground().marker({0, 0, 0}, wing.axes(0)), wing.marker(0)});
  const AirfoilLoad air{.stations = {{.chord = kChord, .twist = 0.1, .airfoil = stalling()},
                                     {.arc = 3, .chord = 0.5 * kChord, .airfoil = linear_airfoil()}},
                        .wind = along(kSpeed)};
  const auto steady = add_airfoil_load(graph, "steady", wing, air);
  const auto strips = add_dynamic_airfoil_load(graph, "air", wing, air);
  ASSERT_EQ(strips.size(), steady.size());
  EXPECT_EQ(strips[5]->name(), "air.5");
  const System system = assemble(graph);
  State state = system.initial_state();
  const Method method = radau(1e-6);
  Simulation simulation(system, *method);
  for (const double t : {0.0, 0.02}) {
    if (t > 0) simulation.run(state, t);
    Snapshot now(system, state);
    for (std::size_t i = 0; i < strips.size(); ++i) {
      double flow[4];
      strips[i]->flow().evaluate(now, {flow, 4});
      EXPECT_NEAR(flow[0], angle_of_attack(*steady[i]).value(now), 1e-14);
      const auto& lag = now.marker(strips[i]->markers()[1]).v;
      if (t == 0) {
        EXPECT_EQ(lag.norm(), 0);
        EXPECT_NEAR(std::tan(flow[1]), 0.5 * std::tan(flow[0]), 1e-14);
      } else {
        EXPECT_GT(std::abs(flow[1]), 0.52 * std::abs(flow[0]));
        EXPECT_GT((lag - now.marker(strips[(i + 1) % strips.size()]->markers()[1]).v).norm(), 1e-4);
      }
    }
  }
}

TEST(DynamicAirfoil, SaysWhatIsWrong) {
  const auto refused = [](const DynamicAirfoilStrip::Parameters& p) {
    return message_of<SceneError>([&] { DynamicAirfoilStrip strip(p); });
  };
  const AirfoilStrip::Parameters strip = strip_of(linear_airfoil());
  expect_says(refused({.strip = strip_of(linear_airfoil(-6))}), {"does not rise through zero"});
  expect_says(refused({.strip = strip_of(linear_airfoil(6, 0.8))}), {"does not rise through zero", "add_airfoil_load"});
  expect_says(refused({.strip = strip, .lags = {.wake_share_1 = 0.8}}), {"more than 1"});
  expect_says(refused({.strip = strip, .lags = {.pressure = 0}}), {"lags.pressure"});
  expect_says(refused({.strip = strip, .lags = {.wake_rate_2 = std::nan("")}}), {"lags.wake_rate_2"});
  AirfoilStrip::Parameters shapeless = strip;
  shapeless.airfoil = {};
  expect_says(refused({.strip = shapeless}), {"no airfoil"});
}

}  // namespace
}  // namespace lithe::test::dynamic_airfoil_test
