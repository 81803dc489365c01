#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "joints/bearings/ball_bearing.h"
#include "joints/bearings/hertz.h"
#include "joints/bearings/roller_bearing.h"
#include "tests/support/joint_checks.h"
#include "tests/support/message_of.h"
#include "tests/support/motion.h"
#include "tests/support/pairs.h"

/// Rolling bearings against Hertz' integrals, Harris' equations and published examples, written apart.
namespace lithe::test::rolling_bearing_test {
namespace {

/// Harris' angular-contact ball bearing 218 and cylindrical roller bearing 209.
const BallBearing::Parameters k218{.balls = 16,
                                   .ball_diameter = 22.23e-3,
                                   .pitch_diameter = 125.3e-3,
                                   .inner_groove_radius = 11.63e-3,
                                   .outer_groove_radius = 11.63e-3,
                                   .contact_angle = 40 * M_PI / 180};
const RollerBearing::Parameters k209{
    .rollers = 14, .roller_diameter = 10e-3, .roller_length = 9.6e-3, .pitch_diameter = 65e-3, .clearance = 0.0406e-3};

/// A bearing without markers' motion: its statics alone.
template <class Bearing>
struct Alone {
  SystemGraph graph;
  Bearing& bearing;
  explicit Alone(const typename Bearing::Parameters& p)
      : bearing(graph.add<Bearing>("bearing", {graph.ground().marker(), graph.ground().marker()}, p)) {}
};

double relative(double actual, double expected) { return std::abs(actual / expected - 1); }

/// Where f, which grows, is zero.
template <class F>
double root(F&& f, double low, double high) {
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (f(middle) < 0 ? low : high) = middle;
  }
  return low;
}

// ---- elements ----

/// Sizes of metres, and all elements far from losing contact.
template <class Bearing>
void check_between_all_pairs(const typename Bearing::Parameters& parameters) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const std::vector<Marker> markers = pair.draw(graph, Vector3::Zero());
    check_force(graph, graph.add<Bearing>("bearing", markers, parameters));
  }
}

constexpr BearingLosses kLosses{.damping_time = 0.1, .load_factor = 0.2, .speed_factor = 0.3, .creep_speed = 4};

TEST(BallBearing, PushesByWhatItsPotentialLosesAndLosesPower) {
  check_between_all_pairs<BallBearing>({.balls = 5,
                                        .ball_diameter = 0.2,
                                        .pitch_diameter = 2,
                                        .inner_groove_radius = 0.5,
                                        .outer_groove_radius = 3.5,
                                        .contact_angle = 0.5,
                                        .clearance = -10,
                                        .material = {.youngs_modulus = 10},
                                        .losses = kLosses});
  check_between_all_pairs<BallBearing>({.balls = 5,
                                        .ball_diameter = 0.2,
                                        .pitch_diameter = 2,
                                        .inner_groove_radius = 0.5,
                                        .outer_groove_radius = 3.5,
                                        .contact_angle = 0.5,
                                        .clearance = -10,
                                        .speed = 10,
                                        .ball_density = 50,
                                        .material = {.youngs_modulus = 10},
                                        .losses = kLosses});
}

TEST(RollerBearing, PushesByWhatItsPotentialLosesAndLosesPower) {
  check_between_all_pairs<RollerBearing>({.rollers = 4,
                                          .roller_diameter = 0.2,
                                          .roller_length = 1,
                                          .pitch_diameter = 2,
                                          .clearance = -20,
                                          .slices = 5,
                                          .losses = kLosses});
}

// ---- contacts ----

/// Landau & Lifshitz, Theory of Elasticity, §9: A, B and the approach as integrals over the ellipse of contact.
TEST(HertzPoint, SolvesTheIntegralEquationsOfTheEllipse) {
  const BearingMaterial steel;
  for (double ratio : {1.0, 1.3, 8.0, 60.0, 2000.0}) {
    const double rho_a = 40, rho_b = 40 * ratio;
    const HertzPoint contact(rho_a, rho_b, steel);
    const double a = contact.ellipticity;  // times the shorter semi-axis
    double height = 0, along = 0, across = 0;
    constexpr int n = 4000;
    for (int i = 0; i < n; ++i) {
      const double t = M_PI / 2 * (i + 0.5) / n, c2 = std::pow(std::cos(t), 2), s2 = 1 - c2;
      const double f = M_PI / n / std::sqrt(a * a * c2 + s2);
      height += f, along += f * c2 / (a * a * c2 + s2), across += f * c2;
    }
    EXPECT_LT(relative(across / along, ratio), 1e-6);
    const double D = 1.5 * (1 - 0.3 * 0.3) / 2.07e11, Q = 1000;
    const double b3 = Q * D / M_PI * across / (rho_b / 2), approach = Q * D / M_PI * height / std::cbrt(b3);
    EXPECT_LT(relative(contact.stiffness * std::pow(approach, 1.5), Q), 1e-6) << ratio;
  }
}

// ---- statics ----

/// Harris, Rolling Bearing Analysis (4th ed.), the 218 under 17,800 N: the angle rises from 40° to 41.6°. (He reads the
/// stiffness from Jones' chart; with his own equations of the contacts, as here, it is a tenth higher.)
TEST(BallBearing, TakesHarrisContactAngleUnderAxialLoad) {
  const Alone<BallBearing> alone(k218);
  const double axial = 17800, A = 2 * 11.63e-3 - 22.23e-3, alpha0 = 40 * M_PI / 180;
  Vector5 load = Vector5::Zero();
  load[2] = axial;
  const Vector5 e = alone.bearing.deflection(load);
  const double k = alone.bearing.contact_stiffness(), alpha = alone.bearing.element_loads(e)[3].contact_angle;
  const auto force = [&](double angle) {
    return 16 * k * std::pow(A * (std::cos(alpha0) / std::cos(angle) - 1), 1.5) * std::sin(angle);
  };
  const double expected = root([&](double angle) { return force(angle) - axial; }, alpha0, 1.2);
  EXPECT_LT(relative(alpha, expected), 1e-9);
  EXPECT_LT(relative(e[2], A * std::sin(expected - alpha0) / std::cos(expected)), 1e-7);
  EXPECT_LT(relative(alone.bearing.element_loads(e)[3].force, axial / (16 * std::sin(expected))), 1e-9);
  EXPECT_LT(relative(alone.bearing.stiffness(e)(2, 2),
                     derivative(
                         [&](double x) {
                           return force(std::atan((A * std::sin(alpha0) + e[2] + x) / (A * std::cos(alpha0))));
                         },
                         1e-8)),
            1e-7);

  EXPECT_NEAR(alpha * 180 / M_PI, 41.6, 0.15);
  EXPECT_LT(relative(alone.bearing.element_loads(e)[3].force, axial / (16 * std::sin(41.6 * M_PI / 180))), 0.005);
}

/// Harris' equations of a ball at speed (Advanced Concepts of Bearing Technology, ch. 3), by the inner ring's angle:
/// the outer one's follows from the balance of the ball, the angles must close the radial distance of the grooves.
TEST(BallBearing, TakesHarrisContactAnglesAtSpeed) {
  const double D = k218.ball_diameter, pitch = k218.pitch_diameter, L = k218.inner_groove_radius - D / 2,
               Z = k218.balls, gamma = D / pitch * std::cos(k218.contact_angle), cosine = std::cos(k218.contact_angle),
               sine = std::sin(k218.contact_angle);
  const BearingMaterial steel;
  const double across = 2 / D - 1 / k218.inner_groove_radius,
               k_i = HertzPoint(across, 2 / D * (1 + gamma / (1 - gamma)), steel).stiffness,
               k_o = HertzPoint(across, 2 / D * (1 - gamma / (1 + gamma)), steel).stiffness;
  for (const double rpm : {1e-3, 6000.0, 15000.0})
    for (const double axial : {2000.0, 17800.0}) {
      SCOPED_TRACE(std::to_string(rpm) + " rpm, " + std::to_string(axial) + " N");
      BallBearing::Parameters p = k218;
      p.speed = rpm * M_PI / 30;
      const Alone<BallBearing> alone(p);
      const double F = 7800 * M_PI / 6 * D * D * D * pitch / 2 * std::pow(0.5 * (1 - gamma) * p.speed, 2);
      double outer = 0, w = 0;
      const auto gap = [&](double inner) {
        const double Q_i = axial / Z / std::sin(inner);
        outer = std::atan2(axial / Z, Q_i * std::cos(inner) + F);
        const double to_ball = L + std::pow(axial / Z / std::sin(outer) / k_o, 2.0 / 3),
                     on = L + std::pow(Q_i / k_i, 2.0 / 3);
        w = to_ball * std::sin(outer) + on * std::sin(inner) - 2 * L * sine;
        return 2 * L * cosine - to_ball * std::cos(outer) - on * std::cos(inner);
      };
      const double inner = root(gap, 0.1, 1.5);
      gap(inner);
      Vector5 load = axial * Vector5::Unit(2);
      const Vector5 e = alone.bearing.deflection(load);
      for (const RollingElementLoad& ball : alone.bearing.element_loads(e)) {
        EXPECT_NEAR(ball.contact_angle, inner, 1e-9);
        EXPECT_NEAR(ball.outer_angle, outer, 1e-9);
        EXPECT_LT(relative(ball.force * std::sin(inner), axial / Z), 1e-9);
        EXPECT_LT(relative(ball.outer_force * std::sin(outer), axial / Z), 1e-9);
      }
      EXPECT_NEAR(e[2], w, 1e-9 * L);
      if (rpm > 1000) {
        EXPECT_GT(inner - outer, 1e-2);
      }
    }
}

/// Balls that the inner ring does not reach lie on the outer one and load nothing; the energy has no step there.
TEST(BallBearing, BallsAtSpeedLeaveTheInnerRing) {
  BallBearing::Parameters p = k218;
  p.speed = 1500;
  const Alone<BallBearing> alone(p);
  const Vector5 e = -5e-4 * Vector5::Unit(2);
  EXPECT_EQ(alone.bearing.load(e).norm(), 0);
  const RollingElementLoad ball = alone.bearing.element_loads(e)[0];
  EXPECT_EQ(ball.force, 0);
  EXPECT_GT(ball.outer_force, 1000);
  EXPECT_NEAR(ball.outer_angle, 0, 1e-12);
}

/// A deep-groove bearing by another program (MASTA, its figures as github.com/minzhun/ISO16281 lists them): deflections
/// under radial and axial loads, their sum, and a moment; 7 balls of 11.5 mm on 43.5 mm, E = 210 GPa.
TEST(BallBearing, DeflectsLikeAnotherProgram) {
  struct Case {
    double clearance, radial, axial, moment;  // m, N, N m
    double u, w, tilt;                        // µm, µm from the middle, mrad; 0: not told
  };
  for (const Case& c :
       {Case{0, 1000, 0, 0, 15.1101, 0, 0}, Case{0, 0, 1000, 0, 0, 133.5381, 0}, Case{10e-6, 1000, 0, 0, 21.223, 0, 0},
        Case{10e-6, 0, 1000, 0, 0, 149.1717, 0}, Case{10e-6, 1000, 1000, 0, 19.5923, 146.4603, 2.6872},
        Case{0, 0, 0, 1, 0, 0, 3.6957}, Case{10e-6, 1000, 1000, 1, 19.7144, 146.3084, 2.7239}}) {
    const Alone<BallBearing> alone({.balls = 7,
                                    .ball_diameter = 11.5e-3,
                                    .pitch_diameter = 43.5e-3,
                                    .inner_groove_radius = 0.52 * 11.5e-3,
                                    .outer_groove_radius = 0.53 * 11.5e-3,
                                    .clearance = c.clearance,
                                    .material = {.youngs_modulus = 2.1e11}});
    Vector5 load;
    load << c.radial, 0, c.axial, c.moment, 0;
    const Vector5 e = alone.bearing.deflection(load);
    if (c.u > 0) {
      EXPECT_LT(relative(std::hypot(e[0], e[1]), 1e-6 * c.u), 2e-4);
    }
    if (c.w > 0) {
      EXPECT_LT(relative(e[2], 1e-6 * c.w), 2e-4);
    }
    // The standard's moment has the lever of the pitch circle, this one that of the groove's centres: a hundredth.
    if (c.tilt > 0) {
      EXPECT_LT(relative(std::hypot(e[3], e[4]), 1e-3 * c.tilt), 0.015);
    }
  }
}

/// The 209 with clearance under 4,450 N, its rollers one by one; and many thin ones by Harris' radial load integral of
/// line contact, Q_max = F_r / (Z J_r(ε)), ε = ½ (1 - s / (2 δ)).
TEST(RollerBearing, CarriesHarrisRadialLoadWithClearance) {
  for (int times : {1, 10}) {
    RollerBearing::Parameters p = k209;
    p.profile_place = {-4.8e-3, 4.8e-3}, p.profile_drop = {0, 0};
    p.rollers *= times, p.roller_diameter /= times;
    const double load = 4450 * times, K = 35948 * std::pow(9.6, 8.0 / 9), clearance = 0.0406;  // N, mm
    const Alone<RollerBearing> alone(p);
    const Vector5 e = alone.bearing.deflection(load * Vector5::Unit(0));
    const auto radial = [&](double delta) {
      double sum = 0;
      for (int j = 0; j < p.rollers; ++j) {
        const double c = std::cos(2 * M_PI * j / p.rollers), depth = delta * c - clearance / 2;
        if (depth > 0) sum += K * std::pow(depth, 10.0 / 9) * c;
      }
      return sum;
    };
    const double delta = root([&](double x) { return radial(x) - load; }, 0, 1);
    EXPECT_LT(relative(e[0] * 1e3, delta), 1e-9);
    const double largest = alone.bearing.element_loads(e)[0].force;
    EXPECT_LT(relative(largest, K * std::pow(delta - clearance / 2, 10.0 / 9)), 1e-9);

    const double span = 0.5 * (1 - clearance / (2 * delta)), end = std::acos(1 - 2 * span);
    double J = 0;
    constexpr int n = 2000;
    for (int i = 0; i < n; ++i) {
      const double psi = end * (i + 0.5) / n;
      J += std::pow(1 - (1 - std::cos(psi)) / (2 * span), 10.0 / 9) * std::cos(psi) * end / n / M_PI;
    }
    EXPECT_LT(relative(largest, load / (p.rollers * J)), times == 1 ? 0.04 : 1e-3);
  }
}

template <class Bearing>
void check_stiffness(const Bearing& bearing, const Vector5& e, double step) {
  const Matrix5 K = bearing.stiffness(e, 0.2);
  EXPECT_LT((K - K.transpose()).norm(), 1e-12 * K.norm());
  Vector5 scale;
  scale << 1, 1, 1, 0.05, 0.05;
  for (int j = 0; j < 5; ++j) {
    const Vector5 by =
        derivative([&](double h) { return bearing.load(e + h * Vector5::Unit(j) / scale[j], 0.2); }, step);
    EXPECT_LT((K.col(j) / scale[j] - by).cwiseQuotient(scale).norm(), 1e-6 * K(0, 0)) << "column " << j;
  }
  EXPECT_LT((bearing.deflection(bearing.load(e, 0.2), 0.2) - e).cwiseProduct(scale).norm(), 1e-9 * e.norm());
}

TEST(BallBearing, StiffnessIsTheDerivativeOfItsLoad) {
  BallBearing::Parameters p = k218;
  p.preload = 3000;
  Vector5 e;
  e << 6e-6, -4e-6, 8e-6, 5e-5, -3e-5;
  check_stiffness(Alone<BallBearing>(p).bearing, e, 1e-9);
  p.speed = 1500;
  e *= 3;
  check_stiffness(Alone<BallBearing>(p).bearing, e, 1e-9);
  // The mirror image: loads along z change their sign, tilts with them.
  BallBearing::Parameters mirror = p;
  mirror.contact_angle = -p.contact_angle;
  Vector5 flip;
  flip << 1, 1, -1, -1, -1;
  const Vector5 load = Alone<BallBearing>(p).bearing.load(e),
                image = flip.cwiseProduct(Alone<BallBearing>(mirror).bearing.load(flip.cwiseProduct(e)));
  EXPECT_LT((load - image).norm(), 1e-12 * load.norm());
}

TEST(RollerBearing, StiffnessIsTheDerivativeOfItsLoadAndTiltLoadsTheEnds) {
  Vector5 e;
  e << 3.5e-5, 1e-5, 0, 1e-4, 3e-4;
  RollerBearing::Parameters p = k209;
  p.slices = 31;
  check_stiffness(Alone<RollerBearing>(p).bearing, e, 1e-9);
  const Alone<RollerBearing> alone(k209);
  Vector5 tilted = Vector5::Zero();
  tilted << 4e-5, 0, 0, 0, 2e-3;
  EXPECT_GT(alone.bearing.load(tilted)[4], 0.5);  // N m, against the tilt
  // The profile relieves the ends: tilted it carries less than a roller without.
  p.profile_place = {-5e-3, 5e-3}, p.profile_drop = {0, 0};
  EXPECT_LT(alone.bearing.load(tilted)[4], Alone<RollerBearing>(p).bearing.load(tilted)[4]);
}

TEST(BallBearing, PreloadIsTheAxialLoadAsDrawnAndStiffens) {
  double last = 0;
  for (double preload : {200.0, 1000.0, 5000.0}) {
    BallBearing::Parameters p = k218;
    p.preload = preload;
    const Alone<BallBearing> alone(p);
    EXPECT_LT(relative(alone.bearing.load(Vector5::Zero())[2], preload), 1e-9);
    const double stiffness = alone.bearing.stiffness(Vector5::Zero())(2, 2);
    EXPECT_GT(stiffness, 1.5 * last);
    last = stiffness;
  }
  // Deep groove: radial clearance leaves a free range both ways.
  BallBearing::Parameters deep = k218;
  deep.contact_angle = 0, deep.clearance = 20e-6;
  const Alone<BallBearing> alone(deep);
  const double A = 2 * 11.63e-3 - 22.23e-3, play = std::sqrt(A * A - std::pow(A - 10e-6, 2));
  EXPECT_EQ(alone.bearing.load(0.99 * play * Vector5::Unit(2)).norm(), 0);
  EXPECT_GT(alone.bearing.load(1.01 * play * Vector5::Unit(2))[2], 0);
  EXPECT_LT(alone.bearing.load(-1.01 * play * Vector5::Unit(2))[2], 0);
}

TEST(RollingBearing, FrequenciesFollowPureRolling) {
  const Alone<BallBearing> alone(k218);
  const BearingFrequencies f = alone.bearing.frequencies(100);
  const double gamma = 22.23 / 125.3 * std::cos(40 * M_PI / 180);
  EXPECT_NEAR(f.cage, 50 * (1 - gamma), 1e-9);
  EXPECT_NEAR(f.outer_pass, 800 * (1 - gamma), 1e-9);
  EXPECT_NEAR(f.inner_pass, 800 * (1 + gamma), 1e-9);
  EXPECT_NEAR(f.spin, 50 * 125.3 / 22.23 * (1 - gamma * gamma), 1e-9);
}

// ---- refusals ----

template <class Bearing>
std::string refusal(const typename Bearing::Parameters& p) {
  return message_of<SceneError>([&] { Alone<Bearing> alone(p); });
}

TEST(RollingBearing, RefusesWhatDoesNotRollAndSaysWhy) {
  BallBearing::Parameters b = k218;
  b.balls = 20;
  expect_says(refusal<BallBearing>(b), {"20 balls", "0.02223", "do not fit", "fewer or smaller"});
  b = k218, b.balls = 2;
  expect_says(refusal<BallBearing>(b), {"has 2 balls", "three or more"});
  b = k218, b.inner_groove_radius = 11e-3;
  expect_says(refusal<BallBearing>(b), {"inner_groove_radius", "0.011", "0.515"});
  b = k218, b.contact_angle = 40;
  expect_says(refusal<BallBearing>(b), {"contact_angle 40", "radians"});
  b = k218, b.clearance = 20e-3;
  expect_says(refusal<BallBearing>(b), {"clearance 0.02", "grooves"});
  b = k218, b.preload = 1e9;
  expect_says(refusal<BallBearing>(b), {"preload", "beyond"});
  b = k218, b.preload = std::nan("");
  expect_says(refusal<BallBearing>(b), {"preload"});
  b = k218, b.material.poissons_ratio = 0.7;
  expect_says(refusal<BallBearing>(b), {"poissons_ratio 0.7"});
  b = k218, b.speed = std::nan("");
  expect_says(refusal<BallBearing>(b), {"speed"});
  b = k218, b.ball_density = 0;
  expect_says(refusal<BallBearing>(b), {"ball_density"});
  b = k218, b.losses.damping_time = -1;
  expect_says(refusal<BallBearing>(b), {"damping_time"});
  RollerBearing::Parameters r = k209;
  r.profile_place = {0, 1e-3}, r.profile_drop = {0};
  expect_says(refusal<RollerBearing>(r), {"2 places and 1 drops"});
  r.profile_drop = {0, 0};
  expect_says(refusal<RollerBearing>(r), {"not over the roller"});
  r.profile_place = {1e-3, 0};
  expect_says(refusal<RollerBearing>(r), {"does not ascend at entry 1"});
  r = k209, r.slices = 0;
  expect_says(refusal<RollerBearing>(r), {"slices is 0"});
  const Alone<RollerBearing> alone(k209);
  expect_says(message_of<SceneError>([&] { alone.bearing.deflection(Vector5::Unit(2) * 100); }),
              {"no deflection", "no axial load"});
  const auto drawn_apart = [] {
    SystemGraph graph;
    auto& shaft = graph.add<RigidBody>("shaft", {});
    graph.add<BallBearing>("bearing", {shaft.marker({0.02, 0, 0}), graph.ground().marker()}, k218);
    assemble(graph);
  };
  expect_says(message_of<SceneError>(drawn_apart), {"bearing", "0.02 m apart", "centre"});
}

}  // namespace
}  // namespace lithe::test::rolling_bearing_test
