// Friction of rigid surfaces against closed forms: the reference problems C02 (incline), C06 (stick-slip) and C07
// (Painlevé's rod).
#include <gtest/gtest.h>

#include "tests/reference/contact_scene.h"

namespace lithe::test::contact_sliding_test {
namespace {

constexpr double g = 9.81;

class SlidingBy : public testing::TestWithParam<Stepper> {};
INSTANTIATE_TEST_SUITE_P(Steppers, SlidingBy, testing::Values(Stepper::moreau_jean, Stepper::generalized_alpha),
                         [](const auto& tested) {
                           return tested.param == Stepper::moreau_jean ? "MoreauJean" : "NonsmoothGeneralizedAlpha";
                         });

// ---- C02: sphere and block on an incline, the slope in two directions ----

/// A plane whose normal leans by `slope` towards the horizontal direction `turned`.
struct Incline {
  Matrix3 axes;  // x down the slope, z its normal
  Incline(double slope, double turned)
      : axes((Eigen::AngleAxisd(turned, Vector3::UnitZ()) * Eigen::AngleAxisd(slope, Vector3::UnitY())).matrix()) {}
  Vector3 down() const { return axes.col(0); }
  Vector3 normal() const { return axes.col(2); }
};

struct Slid {
  double distance, speed, spin, friction, aside;
};

Slid roll(Stepper stepper, double friction, double slope, double turned, double speed, double time) {
  const Incline incline(slope, turned);
  ContactScene scene;
  auto& ball = scene.sphere("ball", 0.1, 1, 0.1 * incline.normal(), speed * incline.down());
  const auto& contact = scene.contact({scene.plane({}, incline.axes), {ball.marker(), shape::sphere(0.1)}}, friction);
  scene.start(stepper, 1e-3);
  scene.run(time);
  const State& s = scene.state();
  const Sensor force = contact_force(contact, 1);
  Vector3 load;
  for (int i = 0; i < 3; ++i) load[i] = scene.read(force, i);
  const Vector3 path = s.q.head<3>() - 0.1 * incline.normal();
  return {path.dot(incline.down()), s.v.head<3>().dot(incline.down()),
          incline.axes.col(1).dot(scene.axes(0) * s.v.segment<3>(3)), -load.dot(incline.down()),
          std::abs(path.dot(incline.axes.col(1))) + std::abs(path.dot(incline.normal()))};
}

TEST_P(SlidingBy, a_sphere_rolls_and_slides_down_an_incline) {
  for (const double turned : {0.0, M_PI / 4}) {
    const Slid rolls = roll(GetParam(), 0.3, M_PI / 6, turned, 0, 2);
    EXPECT_NEAR(rolls.distance, 7.0071428571428571, 7e-6);
    EXPECT_NEAR(rolls.speed, 7.0071428571428571, 7e-6);
    EXPECT_NEAR(rolls.spin, 70.071428571428571, 7e-5);
    EXPECT_NEAR(rolls.friction, 1.4014285714285714, 1e-6);
    EXPECT_LT(rolls.aside, 1e-9);
    const Slid slides = roll(GetParam(), 0.1, M_PI / 6, turned, 0, 2);
    EXPECT_NEAR(slides.distance, 8.1108581577749314, 8e-6);
    EXPECT_NEAR(slides.spin, 42.478546055626716, 4e-5);
    EXPECT_NEAR(slides.friction, 0.84957092111253431, 1e-6);
    EXPECT_LT(slides.aside, 1e-9);
  }
}

TEST_P(SlidingBy, friction_is_the_same_in_all_directions_of_the_slope) {
  for (const double friction : {0.3, 0.1}) {
    const Slid straight = roll(GetParam(), friction, M_PI / 6, 0, 0.5, 0.5);
    const Slid turned = roll(GetParam(), friction, M_PI / 6, M_PI / 4, 0.5, 0.5);
    EXPECT_NEAR(straight.distance, turned.distance, 1e-11);
    EXPECT_NEAR(straight.spin, turned.spin, 1e-9);
  }
}

TEST_P(SlidingBy, a_thrown_sphere_slides_and_then_rolls_without_slip) {
  const Slid thrown = roll(GetParam(), 0.2, 0, 0, 5, 2);
  const double t = 0.72811999417504005, v = 3.5714285714285714, x = 3.1205142607501716;
  EXPECT_NEAR(thrown.speed, v, 3e-6);
  EXPECT_NEAR(thrown.distance, x + v * (2 - t), 5e-6);
  EXPECT_NEAR(thrown.speed - 0.1 * thrown.spin, 0, 1e-12);
}

TEST_P(SlidingBy, a_block_slides_stops_and_stays_on_an_incline) {
  for (const double turned : {0.0, M_PI / 4}) {
    const Incline incline(M_PI / 18, turned);
    const auto block_on = [&](double friction, double speed) {
      auto scene = std::make_unique<ContactScene>();
      auto& block = scene->box("block", {0.4, 0.4, 0.2}, 1, 0.1 * incline.normal(), incline.axes);
      scene->contact({scene->plane({}, incline.axes), {block.marker(), shape::box({0.4, 0.4, 0.2})}}, friction);
      scene->start(GetParam(), 5e-4);
      State s = scene->state();
      s.v.head<3>() = speed * incline.down();
      scene->set(s);
      return scene;
    };
    const auto place = [&](ContactScene& scene) { return scene.state().q.head<3>().dot(incline.down()); };
    auto sliding = block_on(0.1, 0);
    sliding->run(2);
    EXPECT_NEAR(place(*sliding), 1.4747844344152212, 1.5e-6);
    auto thrown = block_on(0.3, -2);
    thrown->run(0.5);
    const double stopped = place(*thrown);
    EXPECT_NEAR(stopped, -0.43461463580520036, 4e-7);
    thrown->run(10.5);
    EXPECT_NEAR(place(*thrown), stopped, 1e-12) << "creeps";
    EXPECT_LT(thrown->state().v.norm(), 1e-10);
  }
}

// ---- C06: a mass on a belt ----

/// A block on a belt that runs at 0.5 m/s, on a spring of 100 N/m; x is its place from where the spring is unstretched.
struct Belt {
  ContactScene scene;
  RigidBody* block;
  explicit Belt(double x, double speed) {
    auto& belt = scene.box("belt", {1, 1, 1}, 10, {0, 0, -0.5});
    const Matrix3 along = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY()).matrix();  // z along world x
    auto& guide = scene.graph.add<PrismaticJoint>(
        "guide", {scene.graph.ground().marker({0, 0, -0.5}, along), belt.marker({}, along)});
    scene.graph.add<CoordinateDrive>("drive", {guide.displacement()}, {.motion = ramp(0, 0.5)});
    block = &scene.box("block", {0.4, 0.4, 0.2}, 1, {x, 0, 0.1}, Matrix3::Identity(), {speed, 0, 0});
    scene.graph.add<SpringDamper>("spring", {scene.graph.ground().marker({-1, 0, 0}), block->marker({0, 0, -0.1})},
                                  {.stiffness = 100, .natural_length = 1});
    colliders = {{belt.marker({0, 0, 0.5}), shape::half_space()}, {block->marker(), shape::box({0.4, 0.4, 0.2})}};
  }
  std::vector<Collider> colliders;
  double x() const { return scene.state().q[7]; }
  double v() const { return scene.state().v[6]; }
};

TEST_P(SlidingBy, a_mass_on_a_belt_swings_with_the_amplitude_of_equal_coefficients) {
  const double x_k = 0.3 * g / 100;
  Belt belt(x_k, 0.5);
  belt.scene.contact(belt.colliders, 0.3);
  belt.scene.start(GetParam(), 1e-3);
  double amplitude = 0, error = 0, backward = 0;
  for (int k = 0; k < 1500; ++k) {
    belt.scene.step();
    amplitude = std::max(amplitude, std::abs(belt.x() - x_k));
    error = std::max(error, std::abs(belt.x() - x_k - 0.05 * std::sin(10 * belt.scene.state().time)));
    backward = std::max(backward, belt.v() - 0.5);
  }
  EXPECT_NEAR(amplitude, 0.05, 1e-5);
  EXPECT_LT(error, 1e-4);
  EXPECT_LT(backward, 1e-9) << "friction drives the mass beyond the belt";
}

// ---- C07: Painlevé's rod ----

struct Slide {
  double tip_along, tip_normal;  // velocity of the tip after a while, m/s
  double energy_gain, normal_force;
};

Slide slide_rod(double friction, double omega, double step, double time) {
  const double theta = std::atan(2.0);
  const Vector3 along(std::cos(theta), 0, std::sin(theta));  // from the tip up
  ContactScene scene;
  // z of the body points down the rod: the cone's tip.
  Matrix3 turned;
  turned.col(2) = -along, turned.col(1) = Vector3::UnitY(), turned.col(0) = Vector3::UnitY().cross(Vector3(-along));
  const Vector3 turn(0, -omega, 0);
  auto& rod = scene.graph.add<RigidBody>("rod", {.mass = 1,
                                                 .inertia = {1.0 / 12, 1.0 / 12, 1e-3},
                                                 .position = 0.5 * along,
                                                 .orientation = turned,
                                                 .velocity = Vector3(-1, 0, 0) + turn.cross(0.5 * along),
                                                 .angular_velocity = turned.transpose() * turn});
  const auto& contact = scene.contact({scene.plane(), {rod.marker(), shape::cone(0.01, 1)}}, friction);
  scene.start(Stepper::moreau_jean, step);
  const Sensor energy = total_energy(), force = contact_force(contact, 1), tip = velocity(rod.marker({0, 0, 0.5}));
  Slide found{};
  double lowest = scene.read(energy);
  do {
    scene.step();
    if (found.normal_force == 0) found.normal_force = scene.read(force, 2);
    const double now = scene.read(energy);
    found.energy_gain = std::max(found.energy_gain, now - lowest);
    lowest = std::min(lowest, now);
  } while (scene.state().time < time - step / 2);
  found.tip_along = scene.read(tip, 0), found.tip_normal = scene.read(tip, 2);
  return found;
}

TEST(ContactSliding, painleves_rod_slides_lifts_off_or_jams) {
  for (const double friction : {0.5, 1.2, 1.4, 1.8})
    for (const double omega : {0.0, 8.0}) {
      const Slide after = slide_rod(friction, omega, 1e-4, 1e-4);
      SCOPED_TRACE("friction " + std::to_string(friction) + ", omega " + std::to_string(omega));
      EXPECT_GT(after.tip_normal, -1e-9);
      EXPECT_LT(after.energy_gain, 1e-3);
      if (omega == 0 && friction < 4.0 / 3) {
        const double p = 1 + 3 * 0.2 - 3 * friction * 0.4;  // at tan θ = 2: cos² = 0.2, sin cos = 0.4
        EXPECT_NEAR(after.normal_force, g / p, 0.02 * g / p);
        EXPECT_LT(after.tip_along, -0.9);
      }
      // Zero where the impulse acts, in the middle of the step.
      if (omega == 0 && friction > 4.0 / 3) {
        EXPECT_NEAR(after.tip_along, 0, 1e-4) << "jams";
      }
      if (omega == 8 && friction < 4.0 / 3) {
        EXPECT_EQ(after.normal_force, 0);
      }
    }
}

TEST(ContactSliding, the_jam_of_painleves_rod_does_not_depend_on_the_step) {
  for (const double friction : {1.4, 1.8}) {
    const Slide coarse = slide_rod(friction, 0, 1e-4, 0.02), fine = slide_rod(friction, 0, 2.5e-5, 0.02);
    EXPECT_NEAR(coarse.tip_along, fine.tip_along, 1e-2);
    EXPECT_NEAR(coarse.tip_normal, fine.tip_normal, 1e-2);
    EXPECT_LT(coarse.energy_gain, 1e-3);
  }
}

}  // namespace
}  // namespace lithe::test::contact_sliding_test
