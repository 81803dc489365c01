#include <gtest/gtest.h>

#include "bodies/beam/beam.h"
#include "engine/observe/contact_sensors.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/contact/contact.h"
#include "joints/contact/shapes.h"
#include "joints/fixed_joint.h"
#include "joints/prismatic_joint.h"
#include "tests/joints/coulomb_friction_scenes.h"

/// Set-valued friction in joints together with contacts of rigid surfaces.
namespace lithe::test::joint_coulomb_contact_test {
namespace {

constexpr double kGravity = 9.81, kRadius = 0.1;
using coulomb_friction::methods;
using Friction = JointCoulombFriction::Parameters;

Matrix3 along_x() { return rotation_about({0, 1, 0}, kPi / 2); }

/// On a slide through its centre along the z axis of `along`.
PrismaticJoint& add_slide(SystemGraph& graph, const std::string& name, RigidBody& body, const Vector3& center,
                          const Matrix3& along, Friction friction) {
  auto& slide = graph.add<PrismaticJoint>(name, {graph.ground().marker(center, along), body.marker({}, along)});
  friction.joint = &slide;
  add_joint_coulomb_friction(graph, name + " rubs", {slide.displacement()}, friction);
  return slide;
}

/// The ground's half space across the slide, its surface at x, tilted about y.
Contact::Collider plate(SystemGraph& graph, double x, double tilt = 0) {
  return {graph.ground().marker({x, 0, 0}, rotation_about({0, 1, 0}, -kPi / 2 + tilt)), shape::half_space()};
}

double place(const Scene& scene, const PrismaticJoint& slide) {
  return read(scene, coordinate(slide.displacement(), "s"));
}
double speed(const Scene& scene, const PrismaticJoint& slide) {
  return read(scene, coordinate_rate(slide.displacement(), "s"));
}

/// Slides to a stop, rebounds with a part of its speed, and rests.
TEST(JointCoulombContact, ABlockReboundsFromAStopAndRests) {
  constexpr double kMu = 0.3, kSpeed = 2, kWay = 0.4, kRebound = 0.6;
  const double met = kSpeed * kSpeed - 2 * kMu * kGravity * kWay,
               back = kRebound * kRebound * met / (2 * kMu * kGravity);
  ASSERT_LT(back, kWay);
  for (const double h : {2e-3, 5e-4})
    for (auto& [name, method] : methods(h)) {
      SCOPED_TRACE(name);
      PrismaticJoint* slide = nullptr;
      Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
        auto& block = graph.add<RigidBody>("block", {.mass = 2, .velocity = {kSpeed, 0, 0}});
        slide = &add_slide(graph, "slide", block, Vector3::Zero(), along_x(), {.coefficient = kMu});
        graph.add<Contact>(
            "stop",
            std::vector<Contact::Collider>{plate(graph, kWay + kRadius), {block.marker(), shape::sphere(kRadius)}},
            Contact::Parameters{.law = RigidSurfaces{.restitution = kRebound}});
      });
      scene.run(*method, 1.5);
      // Over the step of the impact friction acts against the velocity after it: 2 μ g h of that too much at the most.
      expect_below(name + ": rest after a rebound, h = " + std::to_string(h) + ", m",
                   std::abs(place(scene, *slide) - (kWay - back)), 2 * h * kRebound * std::sqrt(met) + 1e-6);
      EXPECT_LT(std::abs(speed(scene, *slide)), 1e-13);
      const double rest = place(scene, *slide);
      scene.run(*method, 10);
      EXPECT_LT(std::abs(place(scene, *slide) - rest), 1e-12);
    }
}

/// An elastic block hits its like at rest, which goes on in its place: steps end at the impact.
TEST(JointCoulombContact, BlocksOnFrictionExchangeTheirSpeeds) {
  constexpr double kMu = 0.2, kSpeed = 1.5, kWay = 0.25, h = 1e-3;
  const double met = kSpeed * kSpeed - 2 * kMu * kGravity * kWay, on = met / (2 * kMu * kGravity);
  for (auto& [name, method] : methods(h)) {
    SCOPED_TRACE(name);
    PrismaticJoint *first = nullptr, *second = nullptr;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      auto& a = graph.add<RigidBody>("a", {.mass = 2, .velocity = {kSpeed, 0, 0}});
      const Vector3 other(kWay + 2 * kRadius, 0, 0);
      auto& b = graph.add<RigidBody>("b", {.mass = 2, .position = other});
      first = &add_slide(graph, "first", a, Vector3::Zero(), along_x(), {.coefficient = kMu});
      second = &add_slide(graph, "second", b, other, along_x(), {.coefficient = kMu});
      graph.add<Contact>(
          "blocks",
          std::vector<Contact::Collider>{{a.marker(), shape::sphere(kRadius)}, {b.marker(), shape::sphere(kRadius)}},
          Contact::Parameters{.law = RigidSurfaces{.restitution = 1}});
    });
    scene.run(*method, 2);
    expect_below(name + ": rest of the block that hits, m", std::abs(place(scene, *first) - kWay), 2e-4);
    expect_below(name + ": rest of the block that is hit, m", std::abs(place(scene, *second) - on), 3e-3);
    for (const auto* slide : {first, second}) EXPECT_LT(std::abs(speed(scene, *slide)), 1e-13);
  }
}

/// A follower in an upright slide presses a wedge of slope α aside, which rubs on level ground; R between them, S
/// across and V up on the follower, each slide pressed by what it has to bear:
///   m₂ a tan α = m₂ g - V - μ₂ S,   m₁ a = S - μ₁ (m₁ g + V),   S = R (sin α - μ cos α),   V = R (cos α + μ sin α)
struct Wedge {
  static constexpr double kWedge = 2, kFollower = 3, kSlope = 0.6, kMuWedge = 0.2, kMuFollower = 0.3;

  Wedge(double friction, double mu_wedge, double follower_mass = kFollower)
      : scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
          const Vector3 up(-std::sin(kSlope), 0, std::cos(kSlope));
          auto& wedge = graph.add<RigidBody>("wedge", {.mass = kWedge});
          auto& follower = graph.add<RigidBody>("follower", {.mass = follower_mass});
          aside = &add_slide(graph, "aside", wedge, Vector3::Zero(), along_x(), {.coefficient = mu_wedge});
          add_slide(graph, "down", follower, Vector3::Zero(), Matrix3::Identity(), {.coefficient = kMuFollower});
          contact = &graph.add<Contact>(
              "slope",
              std::vector<Contact::Collider>{
                  {wedge.marker(-(kRadius + 0.5) * up, rotation_about({0, 1, 0}, -kSlope)), shape::box({8, 1, 1})},
                  {follower.marker(), shape::sphere(kRadius)}},
              Contact::Parameters{.law = RigidSurfaces{}, .friction = {.coefficient = friction}});
        }) {}
  PrismaticJoint* aside = nullptr;
  Contact* contact = nullptr;
  Scene scene;
};

TEST(JointCoulombContact, AFollowerPressesAWedgeAside) {
  for (const double mu : {0.0, 0.15})
    for (auto& [name, method] : methods(1e-2)) {
      SCOPED_TRACE(name + ", friction between " + std::to_string(mu));
      Wedge wedge(mu, Wedge::kMuWedge);
      const double tan = std::tan(Wedge::kSlope), across = std::sin(Wedge::kSlope) - mu * std::cos(Wedge::kSlope),
                   up = std::cos(Wedge::kSlope) + mu * std::sin(Wedge::kSlope),
                   R = Wedge::kFollower * kGravity * (1 + tan * Wedge::kMuWedge) /
                       (Wedge::kFollower * tan * (across - Wedge::kMuWedge * up) / Wedge::kWedge + up +
                        Wedge::kMuFollower * across),
                   a = R * (across - Wedge::kMuWedge * up) / Wedge::kWedge - Wedge::kMuWedge * kGravity;
      ASSERT_GT(a, 1);
      wedge.scene.run(*method, 0.5);
      expect_below(name + ": speed of a wedge, m/s", std::abs(speed(wedge.scene, *wedge.aside) - 0.5 * a), 1e-7);
      expect_below(name + ": way of a wedge, m", std::abs(place(wedge.scene, *wedge.aside) - 0.125 * a), 1e-7);
      EXPECT_NEAR(read_vector(wedge.scene, contact_force(*wedge.contact, 1)).norm(), R * std::hypot(1, mu), 1e-5);
    }
}

/// With tan α below the friction of the ground it holds whatever presses, a hundred times its own weight too.
TEST(JointCoulombContact, AWedgeJams) {
  for (const double mass : {Wedge::kFollower, 100 * Wedge::kWedge})
    for (auto& [name, method] : methods(1e-2)) {
      SCOPED_TRACE(name + ", " + std::to_string(mass) + " kg");
      Wedge wedge(0, 0.75, mass);
      wedge.scene.run(*method, 5);
      EXPECT_LT(std::abs(place(wedge.scene, *wedge.aside)), 1e-12);
      EXPECT_GT(read_vector(wedge.scene, contact_force(*wedge.contact, 1)).norm(), mass);
    }
}

/// An impact on a plate tilted by β loads the slide too: with the velocity -e v after it, r cos β = m (1 + e) v + μ r
/// sin β. Without that friction r would be a fifth smaller.
TEST(JointCoulombContact, AnImpactLoadsTheSlideThatGuidesIt) {
  constexpr double kMu = 0.4, kTilt = 0.5, kMass = 2, kSpeed = 3, kRebound = 0.5, h = 1e-3;
  const double impulse = kMass * (1 + kRebound) * kSpeed / (std::cos(kTilt) - kMu * std::sin(kTilt));
  for (auto& [name, method] : methods(h)) {
    SCOPED_TRACE(name);
    PrismaticJoint* slide = nullptr;
    Contact* contact = nullptr;
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      auto& block = graph.add<RigidBody>("block", {.mass = kMass, .velocity = {kSpeed, 0, 0}});
      slide = &add_slide(graph, "slide", block, Vector3::Zero(), along_x(), {.coefficient = kMu});
      contact = &graph.add<Contact>(
          "stop", std::vector<Contact::Collider>{plate(graph, 0.3, kTilt), {block.marker(), shape::sphere(kRadius)}},
          Contact::Parameters{.law = RigidSurfaces{.restitution = kRebound}});
    });
    double most = 0;
    for (int i = 1; i <= 150; ++i) {
      scene.run(*method, i * h);
      most = std::max(most, h * read_vector(scene, contact_force(*contact, 1)).norm());
    }
    EXPECT_NEAR(speed(scene, *slide), -kRebound * kSpeed, 1e-9);
    EXPECT_NEAR(most, impulse, 1e-6 * impulse);
  }
}

/// A carriage with a light beam ahead, whose tip meets a plate at once and stays there, while the beam gives way until
/// ½ m v² = ½ k x² + F x; k x < F, so that friction holds the beam bent in.
TEST(JointCoulombContact, FrictionHoldsABeamAgainstAPlate) {
  constexpr double kLoad = 12, kMu = 0.5, kSpeed = 0.5, kStiffness = 200, kLength = 0.5, h = 1e-3;
  constexpr double F = kLoad * kMu;
  const double x = (-F + std::sqrt(F * F + kStiffness * kSpeed * kSpeed)) / kStiffness;
  ASSERT_LT(kStiffness * x, F);
  for (auto& [name, method] : methods(h)) {
    SCOPED_TRACE(name);
    PrismaticJoint* slide = nullptr;
    Contact* contact = nullptr;
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      auto& carriage = graph.add<RigidBody>("carriage", {.mass = 1, .velocity = {kSpeed, 0, 0}});
      const BeamSection section =
          BeamSection::diagonal({kStiffness * kLength, 1e4, 1e4, 50, 50, 50}, 1e-3, {1e-5, 1e-5, 1e-5});
      auto& beam = graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, 0}, {kLength, 0, 0}),
                                            .sections = {{0, section}},
                                            .elements = 2,
                                            .velocity = {kSpeed, 0, 0}});
      auto& tip = graph.add<RigidBody>("tip", {.mass = 0.2, .position = {kLength, 0, 0}, .velocity = {kSpeed, 0, 0}});
      graph.add<FixedJoint>("root", {carriage.marker(), beam.marker(0)});
      graph.add<FixedJoint>("end", {beam.marker(kLength), tip.marker()});
      slide = &add_slide(graph, "slide", carriage, Vector3::Zero(), along_x(), {.coefficient = kMu, .preload = kLoad});
      contact = &graph.add<Contact>(
          "stop",
          std::vector<Contact::Collider>{plate(graph, kLength + kRadius), {tip.marker(), shape::sphere(kRadius)}},
          Contact::Parameters{.law = RigidSurfaces{}});
    });
    scene.run(*method, 1);
    expect_below(name + ": a beam held bent in, m", std::abs(place(scene, *slide) - x), 1e-4);
    EXPECT_LT(std::abs(speed(scene, *slide)), 1e-10);
    EXPECT_NEAR(read_vector(scene, contact_force(*contact, 1))[0], -kStiffness * x, 0.05);
  }
}

}  // namespace
}  // namespace lithe::test::joint_coulomb_contact_test
