#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "engine/base/error.h"
#include "tests/joints/contact_motion.h"

/// Laws of compliant contacts: along the normal, and what they share.
namespace lithe::test::contact_laws_test {
namespace {

using std::numbers::pi;

/// Steps until `crossing` is no longer positive, the last step cut to meet it; returns the time that took.
template <class State, class Rate, class Crossing>
double run_until(const Rate& rate, double h, State& y, const Crossing& crossing) {
  double time = 0;
  for (int i = 0; i < 50'000'000; ++i, time += h) {
    const State next = runge_kutta(rate, h, y);
    if (crossing(next) > 0) {
      y = next;
      continue;
    }
    double low = 0, high = h;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      (crossing(runge_kutta(rate, middle, y)) > 0 ? low : high) = middle;
    }
    y = runge_kutta(rate, high, y);
    return time + high;
  }
  ADD_FAILURE() << "never crosses";
  return time;
}

/// Gap and its rate.
using Line = Eigen::Vector2d;

struct Impact {
  double time, depth, restitution;
};

/// A mass m flies at v into a wall, under `law`.
Impact impact(const Compliance& law, double curvature, double m, double v, double h) {
  const auto rate = [&](const Line& y, double) {
    ContactMotion motion = still(y[0]);
    motion.curvature = curvature;
    motion.velocity[0] = y[1];
    motion.impact_speed = v;
    return Line(y[1], compliant_load(law, {}, motion).force[0] / m);
  };
  Line y(0, -v);
  Impact result{};
  result.time = run_until(rate, h, y, [](const Line& s) { return -s[1]; });
  result.depth = -y[0];
  result.time += run_until(rate, h, y, [](const Line& s) { return -s[0]; });
  result.restitution = y[1] / v;
  return result;
}

/// Hertz (1881): the depth from the energy, δ = (5 m v² / (4 k))^(2/5), the time 2 δ/v ∫ dx / sqrt(1 - x^(5/2)).
TEST(ContactLaws, AnElasticBallStaysOnAPlaneAsLongAsHertzSays) {
  const double E = effective_modulus(210e9, 0.3, 70e9, 0.33), R = 0.05, m = 2, v = 0.7;
  EXPECT_NEAR(1 / E, 0.91 / 210e9 + 0.8911 / 70e9, 1e-26);
  const double k = 4.0 / 3.0 * E * std::sqrt(R);
  const double depth = std::pow(1.25 * m * v * v / k, 0.4);
  const double time = 2 * std::sqrt(pi) * std::tgamma(1.4) / std::tgamma(0.9) * depth / v;
  EXPECT_NEAR(time, 2.9432 * depth / v, 1e-4 * depth / v);
  const Impact hit = impact({.effective_modulus = E}, 1 / R, m, v, depth / v / 2000);
  EXPECT_NEAR(hit.time, time, 1e-9 * time);
  EXPECT_NEAR(hit.depth, depth, 1e-10 * depth);
  EXPECT_NEAR(hit.restitution, 1, 1e-10);
}

TEST(ContactLaws, TheEnergyStoredIsTheWorkOfTheElasticForce) {
  for (double n : {1.0, 1.5, 2.2}) {
    const Compliance law{.stiffness = 3e4, .exponent = n};
    const double d = 2e-3, h = 1e-7;
    EXPECT_NEAR(compliant_load(law, {}, still(-d)).energy, 3e4 * std::pow(d, n + 1) / (n + 1), 1e-15);
    const double slope =
        (compliant_load(law, {}, still(-d - h)).energy - compliant_load(law, {}, still(-d + h)).energy) / (2 * h);
    EXPECT_NEAR(slope, compliant_load(law, {}, still(-d)).force[0], 1e-6 * slope);
  }
  // nothing at and above the surface, and no jump there
  ContactMotion motion = still(0);
  motion.velocity = {-3, 1, 2};
  motion.bristle = {0, 1e-3, 0};
  const Compliance law{.stiffness = 1e9, .restitution = 0.5};
  for (double gap : {0.0, 1e-9, 1.0}) {
    motion.gap = gap;
    const ContactLoad load = compliant_load(law, {.coefficient = 1, .bristle_stiffness = 1e3}, motion);
    EXPECT_EQ(load.force.norm() + load.moment.norm() + load.energy + load.bristle.norm(), 0);
  }
  motion.gap = -1e-14;
  EXPECT_LT(compliant_load(law, {.coefficient = 1}, motion).force.norm(), 1e-10);
}

TEST(ContactLaws, HertzNeedsARadiusOnlyWhereBothSurfacesAreFlat) {
  const Compliance law{.effective_modulus = 3e9}, flat{.effective_modulus = 3e9, .flat_radius = 0.02};
  EXPECT_THROW(compliant_load(law, {}, still(-1e-5)), SimulationError);
  EXPECT_EQ(compliant_load(law, {}, still(1e-5)).force.norm(), 0);
  ContactMotion curved = still(-1e-5);
  curved.curvature = 50;
  const double force = 4e9 * std::sqrt(0.02 * 1e-15);
  EXPECT_NEAR(compliant_load(law, {}, curved).force[0], force, 1e-12 * force);
  EXPECT_NEAR(compliant_load(flat, {}, still(-1e-5)).force[0], force, 1e-12 * force);
  curved.curvature = 5;
  EXPECT_GT(compliant_load(flat, {}, curved).force[0], 3 * force);  // its own radius, not that of flat surfaces
}

/// r of F = k δⁿ (1 + D δ̇) by separation of variables, whatever k, n and m: (1 + r) D v = ln((1 + D v) / (1 - r D v)).
double restitution_of(double d) {
  if (d == 0) return 1;
  double low = 0, high = std::min(1.0, 1 / d);
  for (int k = 0; k < 100; ++k) {
    const double r = (low + high) / 2;
    ((1 + r) * d < std::log1p(d) - std::log1p(-r * d) ? high : low) = r;
  }
  return low;
}

double dissipation_number(Dissipation law, double e) {
  switch (law) {
    case Dissipation::hunt_crossley:
      return 1.5 * (1 - e);
    case Dissipation::lankarani_nikravesh:
      return 0.75 * (1 - e * e);
    case Dissipation::flores:
      return 1.6 * (1 - e) / e;
    case Dissipation::exact:
    case Dissipation::fixed:
      break;
  }
  return 0;
}

TEST(ContactLaws, EachDissipationReachesTheRestitutionItsEquationHas) {
  double worst[3] = {};
  for (Dissipation law : {Dissipation::hunt_crossley, Dissipation::lankarani_nikravesh, Dissipation::flores})
    for (int tenths = 1; tenths <= 10; ++tenths) {
      const double e = 0.1 * tenths, theory = restitution_of(dissipation_number(law, e));
      for (double v : {0.3, 5.0}) {
        const double k = 1e5, m = 0.4, depth = std::pow(1.25 * m * v * v / k, 0.4);
        const Compliance normal{.stiffness = k, .restitution = e, .dissipation = law};
        const Impact hit = impact(normal, 0, m, v, depth / v / 1000);
        EXPECT_NEAR(hit.restitution, theory, 1e-8) << "law " << int(law) << ", e " << e << ", v " << v;
      }
      const Compliance linear{.stiffness = 900, .exponent = 1, .restitution = e, .dissipation = law};
      EXPECT_NEAR(impact(linear, 0, 0.4, 2, 1e-5).restitution, theory, 1e-7) << "law " << int(law) << ", e " << e;
      double& gap = worst[static_cast<int>(law) - static_cast<int>(Dissipation::hunt_crossley)];
      gap = std::max(gap, std::abs(theory - e));
      if (e > 0.85) {
        EXPECT_NEAR(theory, e, 0.014);
      }
    }
  // how good the closed forms are: Flores' everywhere, Hunt and Crossley's and Lankarani and Nikravesh's near 1
  EXPECT_LT(worst[2], 0.045);
  EXPECT_GT(worst[0], 0.4);
  EXPECT_GT(worst[1], 0.5);
}

TEST(ContactLaws, TheExactLawReachesTheRestitutionThatWasAskedFor) {
  for (double e : {0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0})
    for (double v : {0.3, 5.0}) {
      const double k = 1e5, m = 0.4, depth = std::pow(1.25 * m * v * v / k, 0.4);
      const Impact hit = impact({.stiffness = k, .restitution = e}, 0, m, v, depth / v / 1000);
      EXPECT_NEAR(hit.restitution, e, e < 0.1 ? 1e-6 : 1e-8) << "e " << e << ", v " << v;
    }
}

TEST(ContactLaws, TheDampingIsThatOfTheSpeedOfMeetingAndBounded) {
  const Compliance law{
      .stiffness = 1e4, .restitution = 0.5, .dissipation = Dissipation::hunt_crossley, .least_speed = 0.1};
  const auto share = [&](double velocity, double impact_speed) {
    ContactMotion motion = still(-1e-3);
    motion.velocity[0] = velocity;
    motion.impact_speed = impact_speed;
    return compliant_load(law, {}, motion).force[0] / compliant_load(law, {}, still(-1e-3)).force[0] - 1;
  };
  EXPECT_NEAR(share(-1, 2), 0.75 / 2, 1e-14);     // D δ̇ = 3/2 (1 - e) δ̇ / v
  EXPECT_NEAR(share(-2, 0), 0.75, 1e-14);         // they meet now
  EXPECT_NEAR(share(-0.01, 0), 0.075, 1e-14);     // as if at 0.1 m/s
  EXPECT_NEAR(share(-0.01, 0.05), 0.075, 1e-14);  // it was slower
  EXPECT_NEAR(share(0.05, 0), -0.375, 1e-14);     // they part
  EXPECT_EQ(share(10, 0.5), -1);                  // and never pull
}

/// Balls in a row that touch: speeds after all is over, for any stiffness and mass.
Eigen::VectorXd cradle(Eigen::VectorXd v, const Eigen::VectorXd& m, double k, double h, double end) {
  const Compliance law{.stiffness = k};
  const int n = static_cast<int>(v.size());
  using State = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 10, 1>;
  const auto rate = [&](const State& y, double) {
    State y_dot(2 * n);
    y_dot << y.tail(n), State::Zero(n);
    ContactMotion motion = still(0);
    for (int i = 0; i + 1 < n; ++i) {
      motion.gap = y[i + 1] - y[i];
      if (motion.gap > 0) continue;
      motion.velocity[0] = y[n + i + 1] - y[n + i];
      const double N = compliant_load(law, {}, motion).force[0];
      y_dot[n + i] -= N / m[i];
      y_dot[n + i + 1] += N / m[i + 1];
    }
    return y_dot;
  };
  State y(2 * n);
  y << State::Zero(n), v;
  for (double t = 0; t < end; t += h) y = runge_kutta(rate, h, y);
  for (int i = 0; i + 1 < n; ++i) EXPECT_TRUE(y[i + 1] > y[i] && y[n + i + 1] > y[n + i]) << "not yet apart";
  return y.tail(n);
}

/// Speeds from DOP853 at 1e-12 on the same chain (good to 9 digits, the longer chain to 8).
TEST(ContactLaws, TheLastBallOfNewtonsCradleLeavesAsHertzianContactsHaveIt) {
  Eigen::VectorXd v(3), expected(3), one = Eigen::VectorXd::Ones(5), masses(3);
  v << 1, 0, 0;
  expected << -0.07095235362800865, 0.07640303923556613, 0.9945493143924421;
  EXPECT_LT((cradle(v, one.head(3), 1, 2e-4, 30) - expected).norm(), 3e-9);
  // the same within a millisecond, of steel, at 2 m/s: k^(-2/5) m^(2/5) v^(-1/5) is the unit of time
  const double k = 2e9, mass = 0.1, unit = std::pow(mass * mass / (k * k * 2), 0.2);
  EXPECT_LT((cradle(2 * v, mass * one.head(3), k, 2e-4 * unit, 30 * unit) / 2 - expected).norm(), 3e-9);
  masses << 1, 2, 1;
  expected << -0.3619859205795395, 0.24961372867207243, 0.862758463235395;
  EXPECT_LT((cradle(v, masses, 1, 2e-4, 30) - expected).norm(), 3e-9);

  v.resize(5), expected.resize(5);
  v << 1, 0, 0, 0, 0;
  expected << -0.0710850136977438, -0.030273765648163406, -0.01446362934564549, 0.12704498565199143, 0.9887774230395607;
  EXPECT_LT((cradle(v, one, 1, 2e-4, 60) - expected).norm(), 1e-8);
  v << 1, 1, 0, 0, 0;
  expected << -0.11261497897760407, -0.04195950054057339, 0.2144857761996791, 0.8003666716634144, 1.1397220316550845;
  EXPECT_LT((cradle(v, one, 1, 2e-4, 60) - expected).norm(), 1e-8);
}

/// Any motion under pressure, with bristles deflected by at most `bristle`.
ContactMotion random_motion(std::mt19937& random, double bristle) {
  std::uniform_real_distribution<double> unit(-1, 1);
  ContactMotion motion = still(-1e-3 * std::abs(unit(random)));
  const double size = std::pow(10, 4 * unit(random));
  motion.velocity = size * Vector3(unit(random), unit(random), unit(random));
  motion.spin = size * Vector3(unit(random), unit(random), unit(random));
  motion.slip = 1e-5 * Vector3(0, unit(random), unit(random));
  motion.bristle = bristle * Vector3(0, unit(random), unit(random)) / std::sqrt(2);
  motion.curvature = 20;
  motion.impact_speed = std::abs(unit(random));
  return motion;
}

const ContactFriction kFriction{.coefficient = 0.3,
                                .static_coefficient = 0.5,
                                .stribeck_speed = 0.1,
                                .creep_speed = 0.2,
                                .viscous = 0.1,
                                .rolling = 1e-3,
                                .spinning = 2e-3};

TEST(ContactLaws, NoMotionTakesEnergyOutOfAContact) {
  std::mt19937 random(7);
  ContactFriction bristles = kFriction;
  bristles.bristle_stiffness = 1e4;
  for (Dissipation dissipation :
       {Dissipation::hunt_crossley, Dissipation::lankarani_nikravesh, Dissipation::flores, Dissipation::fixed})
    for (int i = 0; i < 5000; ++i) {
      const Compliance law{.effective_modulus = 1e8, .restitution = 0.4, .dissipation = dissipation, .damping = 2};
      const ContactMotion motion = random_motion(random, 0.5 / 1e4);
      const Vector3 &v = motion.velocity, &w = motion.spin;
      const ContactLoad load = compliant_load(law, kFriction, motion);
      ContactMotion held = motion;
      held.velocity.setZero();
      const double spring = compliant_load(law, kFriction, held).force[0];
      ASSERT_GE(load.force[0], 0);
      ASSERT_LE((load.force[0] - spring) * v[0], 1e-12 * spring * std::abs(v[0]));
      ASSERT_LE(load.force.tail<2>().dot(v.tail<2>()), 0);
      ASSERT_LE(load.moment.tail<2>().dot(w.tail<2>()), 0);
      ASSERT_LE(load.moment[0] * w[0], 0);
      ASSERT_LE(load.moment.tail<2>().norm(), 1e-3 * load.force[0] * (1 + 1e-14));
      ASSERT_LE(std::abs(load.moment[0]), 2e-3 * load.force[0] * (1 + 1e-14));

      // with bristles: power in is no less than what they store
      const ContactLoad stuck = compliant_load(law, bristles, motion);
      const Vector3 z = stuck.bristle, across(0, v[1], v[2]);
      const double speed = across.norm(), mu = 0.3 + 0.2 * std::exp(-100 * speed * speed);
      const Vector3 z_dot = across - 1e4 * speed / mu * z;
      const double stored = stuck.force[0] * 1e4 * z.dot(z_dot), taken = -stuck.force.tail<2>().dot(v.tail<2>());
      ASSERT_GE(taken, stored - 1e-9 * (std::abs(taken) + std::abs(stored)));
      ASSERT_EQ(z[0], 0);
      ASSERT_LE(1e4 * z.norm(), 0.5 * (1 + 1e-14));
    }
}

/// Turned about the normal, or seen from the other body, a contact does the same.
TEST(ContactLaws, TheLoadDependsNeitherOnTheAxesAcrossNorOnWhichBodyIsA) {
  std::mt19937 random(3);
  const Compliance law{.effective_modulus = 1e8, .restitution = 0.6};
  ContactFriction bristles = kFriction;
  bristles.bristle_stiffness = 1e4;
  bristles.bristle_damping = 20;
  const Matrix3 turn = Eigen::AngleAxisd(0.8, Vector3::UnitX()).toRotationMatrix();
  // B's frame: normal and one axis reversed; what B does relative to A is reversed too
  const Matrix3 other = -Vector3(-1, 1, -1).asDiagonal().toDenseMatrix();
  for (const ContactFriction& friction : {kFriction, bristles})
    for (int i = 0; i < 1000; ++i) {
      const ContactMotion motion = random_motion(random, 0.5 / 1e4);
      const ContactLoad load = compliant_load(law, friction, motion);
      for (const Matrix3& T : {turn, other}) {
        ContactMotion seen = motion;
        for (Vector3 ContactMotion::*part :
             {&ContactMotion::velocity, &ContactMotion::spin, &ContactMotion::slip, &ContactMotion::bristle})
          seen.*part = T * (motion.*part);
        const ContactLoad same = compliant_load(law, friction, seen);
        ASSERT_LE((same.force - T * load.force).norm(), 1e-13 * load.force.norm());
        ASSERT_LE((same.moment - T * load.moment).norm(), 1e-13 * load.moment.norm());
        ASSERT_LE((same.bristle - T * load.bristle).norm(), 1e-13 * load.bristle.norm());
        ASSERT_EQ(same.energy, load.energy);
      }
    }
}

TEST(ContactLaws, ParametersThatAreNoLawAreNamed) {
  const double nan = std::nan("");
  const auto problem = [](const auto& law) -> std::string {
    try {
      check(law);
    } catch (const SceneError& error) {
      return error.problem();
    }
    return "";
  };
  const auto names = [&](const auto& law, const std::string& name) {
    EXPECT_NE(problem(law).find(name), std::string::npos) << name << ": " << problem(law);
  };
  const Compliance good{.stiffness = 1e6};
  const ContactFriction bristles{.coefficient = 0.3, .bristle_stiffness = 1e5, .bristle_damping = 500};
  EXPECT_EQ(problem(good), "");
  EXPECT_EQ(problem(Compliance{.effective_modulus = 1e9}), "");
  EXPECT_EQ(problem(ContactFriction{}), "");
  EXPECT_EQ(problem(bristles), "");
  names(Compliance{}, "one of stiffness and effective_modulus");
  names(Compliance{.stiffness = 1, .effective_modulus = 1}, "one of stiffness and effective_modulus");
  names(Compliance{.exponent = 1, .effective_modulus = 1}, "exponent");
  names(Compliance{.stiffness = 1, .exponent = 0.9}, "exponent");
  names(Compliance{.stiffness = 1, .restitution = 1.1}, "restitution");
  names(Compliance{.stiffness = 1, .restitution = 0}, "restitution");
  names(Compliance{.stiffness = 1, .damping = 1}, "damping");
  names(Compliance{.stiffness = 1, .least_speed = 0}, "least_speed");
  for (const auto& [member, name] :
       {std::pair(&Compliance::stiffness, "stiffness"), std::pair(&Compliance::exponent, "exponent"),
        std::pair(&Compliance::effective_modulus, "effective_modulus"),
        std::pair(&Compliance::flat_radius, "flat_radius"), std::pair(&Compliance::restitution, "restitution"),
        std::pair(&Compliance::damping, "damping"), std::pair(&Compliance::least_speed, "least_speed")})
    for (double bad : {nan, -1.0, HUGE_VAL}) {
      Compliance law = good;
      law.*member = bad;
      names(law, name);
    }
  for (const auto& [member, name] :
       {std::pair(&ContactFriction::coefficient, "coefficient"),
        std::pair(&ContactFriction::static_coefficient, "static_coefficient"),
        std::pair(&ContactFriction::stribeck_speed, "stribeck_speed"),
        std::pair(&ContactFriction::creep_speed, "creep_speed"),
        std::pair(&ContactFriction::bristle_stiffness, "bristle_stiffness"),
        std::pair(&ContactFriction::bristle_damping, "bristle_damping"),
        std::pair(&ContactFriction::viscous, "viscous"), std::pair(&ContactFriction::rolling, "rolling"),
        std::pair(&ContactFriction::spinning, "spinning"), std::pair(&ContactFriction::creep_spin, "creep_spin")})
    for (double bad : {nan, -1.0, HUGE_VAL}) {
      ContactFriction law = bristles;
      law.*member = bad;
      names(law, name);
    }
  names(ContactFriction{.coefficient = 0.3, .static_coefficient = 0.2}, "static_coefficient");
  names(ContactFriction{.static_coefficient = 0.2, .bristle_stiffness = 1}, "bristles");
  names(ContactFriction{.coefficient = 0.2, .bristle_damping = 1}, "bristle_damping");
  EXPECT_THROW(effective_modulus(0, 0.3, 1, 0.3), SceneError);
  EXPECT_THROW(effective_modulus(1, 0.6, 1, 0.3), SceneError);
  EXPECT_THROW(effective_modulus(1, 0.3, 1, nan), SceneError);

  // and no motion that is not finite passes for a force
  ContactMotion motion = still(-1);
  motion.velocity[0] = nan;
  EXPECT_TRUE(std::isnan(compliant_load(good, {}, motion).force[0]));
  EXPECT_TRUE(std::isnan(compliant_load(good, {}, still(nan)).force[0]));
}

}  // namespace
}  // namespace lithe::test::contact_laws_test
