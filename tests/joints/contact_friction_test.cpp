#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/joints/contact_motion.h"

/// Friction of compliant contacts: regularised, and with the bristles of Canudas de Wit et al. (1995).
namespace lithe::test::contact_friction_test {
namespace {

using std::numbers::pi;

constexpr double kGravity = 9.81;

/// A block of 1 kg on a plane that presses it with N, pulled along it: its law has a memory of the last accepted state.
struct Block {
  ContactFriction friction;
  double N;
  std::function<Vector3(double, const Vector3&)> pull;  // N, across the normal, at a time and a displacement
  Vector3 x = Vector3::Zero(), v = Vector3::Zero(), bristle = Vector3::Zero();
  double time = 0;
  Compliance law = kPlain;

  ContactLoad load(const Vector3& slip, const Vector3& velocity) const {
    ContactMotion motion = still(-N);
    motion.velocity = velocity;
    motion.slip = slip;
    motion.bristle = bristle;
    return compliant_load(law, friction, motion);
  }
  void step(double h) {
    using State = Eigen::Matrix<double, 6, 1>;
    State y;
    y << Vector3::Zero(), v;
    const auto rate = [&](const State& s, double later) {
      Vector3 force = load(s.head<3>(), s.tail<3>()).force + pull(time + later, x + s.head<3>());
      force[0] = 0;
      State y_dot;
      y_dot << s.tail<3>(), force;
      return y_dot;
    };
    const State after = runge_kutta(rate, h, y);
    bristle = load(after.head<3>(), after.tail<3>()).bristle;
    x += after.head<3>();
    v = after.tail<3>();
    time += h;
  }
  void run(double end, double h) {
    const double start = time;
    const int steps = static_cast<int>(std::lround((end - start) / h));
    for (int i = 0; i < steps; ++i) step(h);
  }
};

const double kSlope = 10 * pi / 180;
const Vector3 kDown(0, 0.6, 0.8);
const Vector3 kWeight = kGravity * std::sin(kSlope) * kDown;
const double kPress = kGravity * std::cos(kSlope);

/// Steady where μ tanh(3 v / v_c) = tan α: v = v_c / 3 artanh(tan α / μ). Steeper than μ it runs away.
TEST(ContactFriction, RegularisedFrictionCreepsDownASlopeAtTheSpeedOfItsTangent) {
  Block block{{.coefficient = 0.3, .creep_speed = 1e-3}, kPress, [](double, const Vector3&) { return kWeight; }};
  block.run(0.02, 2e-5);
  const Vector3 start = block.x;
  block.run(0.12, 1e-4);
  const double speed = 1e-3 / 3 * std::atanh(std::tan(kSlope) / 0.3);
  EXPECT_LT((block.v - speed * kDown).norm(), 1e-12 * speed);
  EXPECT_LT((block.x - start - 0.1 * speed * kDown).norm(), 1e-10 * speed);

  Block slippery{{.coefficient = 0.1, .creep_speed = 1e-6}, kPress, [](double, const Vector3&) { return kWeight; }};
  slippery.v = kDown;
  slippery.run(1, 1e-2);
  const double acceleration = kGravity * (std::sin(kSlope) - 0.1 * std::cos(kSlope));
  EXPECT_LT((slippery.v - (1 + acceleration) * kDown).norm(), 1e-12);
}

const ContactFriction kBristles{.coefficient = 0.3, .bristle_stiffness = 1e5, .bristle_damping = 500};

TEST(ContactFriction, BristlesHoldABlockOnASlopeWithoutCreep) {
  Block block{kBristles, kPress, [](double, const Vector3&) { return kWeight; }};
  block.run(1, 1e-4);
  const Vector3 settled = block.x;
  block.run(11, 1e-4);
  EXPECT_LT((block.x - settled).norm(), 1e-12);
  EXPECT_LT(block.v.norm(), 1e-15);
  EXPECT_LT((block.bristle - std::tan(kSlope) / 1e5 * kDown).norm(), 1e-12 * block.bristle.norm());
}

/// Pulled one way with force f, the block moves by s: f = μ N (1 - exp(-σ₀ s / μ)), stiffness N σ₀ at first.
TEST(ContactFriction, BristlesAreASpringBeforeTheySlide) {
  for (double share : {1e-6, 0.01, 0.5, 0.7}) {
    // pulled ever more, then evenly, and damped beyond critical: it never swings back
    Block block{kBristles, kPress, [&](double t, const Vector3&) {
                  const double rise = std::sin(pi / 2 * std::min(t, 1.0));
                  return Vector3(share * rise * rise * 0.3 * kPress * kDown);
                }};
    block.run(2, 1e-4);
    const double moved = -0.3 / 1e5 * std::log1p(-share);
    EXPECT_LT((block.x - moved * kDown).norm(), 1e-9 * moved) << share;
    if (share == 1e-6) {
      EXPECT_NEAR(share * 0.3 * kPress / block.x.norm(), kPress * 1e5, 1e-6 * kPress * 1e5);
    }
  }
}

TEST(ContactFriction, BristlesBreakAwayAtTheStaticCoefficient) {
  ContactFriction friction = kBristles;
  friction.static_coefficient = 0.45;
  friction.stribeck_speed = 0.01;
  for (double share : {0.99, 1.01}) {
    Block block{friction, kPress,
                [&](double t, const Vector3&) { return Vector3(share * 0.45 * kPress * std::min(t, 1.0) * kDown); }};
    block.run(2, 1e-4);
    if (share < 1) {
      EXPECT_LT(block.x.norm(), 10 * 0.45 / 1e5);
      EXPECT_LT(block.v.norm(), 1e-9);
    } else {
      EXPECT_GT(block.v.dot(kDown), 0.5);
    }
  }
}

/// Sliding steadily, the force is N (μ(v) + σ₂ v), with bristles and (well above creep speed) without.
TEST(ContactFriction, SteadySlidingFollowsStribecksCurve) {
  ContactFriction bristles{.coefficient = 0.2,
                           .static_coefficient = 0.5,
                           .stribeck_speed = 0.1,
                           .bristle_stiffness = 1e4,
                           .bristle_damping = 30,
                           .viscous = 0.03};
  ContactFriction plain = bristles;
  plain.bristle_stiffness = plain.bristle_damping = 0;
  plain.creep_speed = 1e-4;
  for (double v : {1e-3, 0.05, 0.1, 0.3, 2.0}) {
    const double expected = 50 * (0.2 + 0.3 * std::exp(-v * v / 0.01) + 0.03 * v);
    ContactMotion motion = still(-50);
    motion.velocity = v * kDown;
    motion.slip = 0.1 * kDown;
    motion.bristle = {0, 2e-5, -3e-5};
    EXPECT_LT((compliant_load(kPlain, plain, motion).force.tail<2>() + expected * kDown.tail<2>()).norm(), 1e-12) << v;
    EXPECT_LT((compliant_load(kPlain, bristles, motion).force.tail<2>() + expected * kDown.tail<2>()).norm(), 1e-12);
  }
}

/// ż = v - σ₀ |v| z / μ along a straight path, from a deflection that points elsewhere.
TEST(ContactFriction, TheDeflectionFollowsItsEquationInOneStepOrMany) {
  const Vector3 first(0, 1e-6, -2e-6), path = 1e-5 * kDown, v = 3e-3 * kDown;
  const auto after = [&](const Vector3& from, const Vector3& slip) {
    ContactMotion motion = still(-2);
    motion.velocity = v;
    motion.slip = slip;
    motion.bristle = from;
    return compliant_load(kPlain, kBristles, motion).bristle;
  };
  const Vector3 once = after(first, path);
  Vector3 often = first, integrated = first;
  const int steps = 1000;
  const double h = path.norm() / v.norm() / steps;
  for (int i = 0; i < steps; ++i) {
    often = after(often, path / steps);
    integrated =
        runge_kutta([&](const Vector3& z, double) { return Vector3(v - 1e5 / 0.3 * v.norm() * z); }, h, integrated);
  }
  EXPECT_LT((often - once).norm(), 1e-13 * once.norm());
  EXPECT_LT((integrated - once).norm(), 1e-11 * once.norm());
  EXPECT_GT((once - first).norm(), 0.5 * first.norm());
  EXPECT_EQ(after(first, Vector3::Zero()), first);
  EXPECT_LT((after(first, Vector3(1e-18 * kDown)) - first - 1e-18 * kDown).norm(), 1e-17);
  EXPECT_LT((after(first, Vector3(100 * kDown)) - 0.3 / 1e5 * kDown).norm(), 1e-20);

  // and the force of it, with the rate by differences of that path
  ContactMotion motion = still(-2);
  motion.velocity = v;
  motion.bristle = once;
  const double t = 1e-7;
  const Vector3 rate = (after(once, t * v) - once) / t;
  const Vector3 force = -2 * (1e5 * once + 500 * rate);
  EXPECT_LT((compliant_load(kPlain, kBristles, motion).force - force - Vector3(2, 0, 0)).norm(), 1e-3 * force.norm());
}

/// A load that swings between the shares u and w of μ N without breaking away: forward f = μ N (1 - exp(-σ₀ s / μ)) and
/// back the same reversed let the block down by μ/σ₀ ln((1 - u²) / (1 - w²)) a cycle. Coulomb's block would stay: this
/// is the law's weakness.
TEST(ContactFriction, BristlesDriftUnderASwingingLoadByTheirOwnLaw) {
  const double u = 0.2, w = 0.8;
  Block block{kBristles, kPress, [&](double t, const Vector3&) {
                return Vector3(((u + w) / 2 - (w - u) / 2 * std::cos(2 * pi * t)) * 0.3 * kPress * kDown);
              }};
  block.run(2, 1e-4);
  const Vector3 start = block.x;
  block.run(5, 1e-4);
  const double drift = 0.3 / 1e5 * std::log((1 - u * u) / (1 - w * w));
  EXPECT_LT(((block.x - start) / 3 - drift * kDown).norm(), 1e-3 * drift);
}

/// I ω̇ = -σ N tanh(3 ω / ω_c): sinh(3 ω / ω_c) falls as exp(-3 σ N t / (I ω_c)); far above ω_c the spin falls evenly.
TEST(ContactFriction, SpinningAndRollingAreBrakedByAMomentOfTheNormalForce) {
  const double N = 20, inertia = 0.01, creep = 0.5;
  const ContactFriction friction{.rolling = 2e-3, .spinning = 3e-3, .creep_spin = creep};
  const auto spun_down = [&](const Vector3& axis, double start, double end) {
    double spin = start;
    const auto rate = [&](double w, double) {
      ContactMotion motion = still(-N);
      motion.spin = w * axis;
      const ContactLoad load = compliant_load(kPlain, friction, motion);
      EXPECT_LT(load.moment.cross(axis).norm(), 1e-15);
      return load.moment.dot(axis) / inertia;
    };
    for (int i = 0; i < 2000; ++i) spin = runge_kutta(rate, end / 2000, spin);
    return spin;
  };
  for (const auto& [axis, length] : {std::pair(Vector3(1, 0, 0), 3e-3), std::pair(kDown, 2e-3)})
    for (double end : {0.05, 0.3}) {
      const double expected =
          creep / 3 * std::asinh(std::sinh(3 / creep) * std::exp(-3 * length * N * end / inertia / creep));
      EXPECT_NEAR(spun_down(axis, 1, end), expected, 1e-10);
      EXPECT_NEAR(spun_down(axis, -1, end), -expected, 1e-10);
    }
  EXPECT_NEAR(spun_down({1, 0, 0}, 9, 1), 9 - 3e-3 * N / inertia, 1e-10);
}

/// A block on a belt, held by a spring: exact for Coulomb's friction with μ_s > μ_k. Slip about μ_k m g / k from the
/// break at μ_s m g / k with the belt's speed; then stick.
struct Belt {
  static constexpr double k = 100, speed = 0.5, still = 0.4, kinetic = 0.3;

  static double exact_period() {
    const double w = std::sqrt(k), d = (still - kinetic) * kGravity / k;
    return (2 * pi - 2 * std::atan(w * d / speed)) / w + 2 * d / speed;
  }
  /// Of bristles of stiffness σ₀: mean of two cycles after the first.
  static double period(double bristle_stiffness, double stribeck_speed, double h) {
    Block block{{.coefficient = kinetic,
                 .static_coefficient = still,
                 .stribeck_speed = stribeck_speed,
                 .bristle_stiffness = bristle_stiffness,
                 .bristle_damping = 2 * std::sqrt(bristle_stiffness / kGravity)},
                kGravity,
                // x of the block is that on the belt
                [](double t, const Vector3& x) { return Vector3(0, -k * (x[1] + speed * t), 0); }};
    block.x[1] = kinetic * kGravity / k - 0.01;
    double before = -1, times[4];
    for (int passes = 0; passes < 4;) {
      block.step(h);
      const double offset = block.x[1] + speed * block.time - kinetic * kGravity / k;
      if (before < 0 && offset >= 0) times[passes++] = block.time - h * offset / (offset - before);
      before = offset;
    }
    return (times[3] - times[1]) / 2;
  }
};

/// A bristle breaks away at less than μ_s where the load grows so fast that it moves at v_s before: stiff bristles need
/// v_s well above (load rate) / (N σ₀), and Coulomb's limit is v_s -> 0 with σ₀ v_s -> infinity.
TEST(ContactFriction, StickSlipOnABeltTendsToCoulombsPeriodAsBristlesStiffen) {
  const double exact = Belt::exact_period();
  EXPECT_NEAR(exact, 0.62881071913377278895, 1e-15);
  EXPECT_NEAR(Belt::period(1e6, 1e-3, 1e-5), exact, 2e-4);
  EXPECT_NEAR(Belt::period(1e7, 3e-4, 1e-5), exact, 1e-4);
  EXPECT_NEAR(Belt::period(1e5, 1e-4, 1e-5), 2 * pi / std::sqrt(Belt::k), 1e-6);  // never reaches μ_s
}

}  // namespace
}  // namespace lithe::test::contact_friction_test
