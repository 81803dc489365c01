// S66: a sphere that slides down a slope of 30 degrees, μ = 0.1 (C02), in every direction across the axes of the
// contact: with a pyramid for a cone friction depends on it.
#include "joints/contact/bullet_mlcp.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/contacts.h"

namespace lithe::lab {
namespace {

constexpr double kRadius = 0.1, kSlope = M_PI / 6, kFriction = 0.1, kEnd = 2, kLimit = 1e-6;  // m, rad, -, s, relative

/// The plane z = 0 stays, gravity leans towards `direction` (rad from x).
class Sphere : public Bench {
 public:
  explicit Sphere(double direction)
      : Bench(kGravity * Vector3(std::sin(kSlope) * std::cos(direction), std::sin(kSlope) * std::sin(direction),
                                 -std::cos(kSlope)),
              [](SystemGraph& graph) {
                const double inertia = 0.4 * kRadius * kRadius;
                auto& sphere = graph.add<RigidBody>(
                    "sphere", {.mass = 1, .inertia = {inertia, inertia, inertia}, .position = {0, 0, kRadius}});
                graph.add<Contact>(
                    "slope",
                    {{graph.ground().marker(), shape::half_space()}, {sphere.marker(), shape::sphere(kRadius)}},
                    {.law = RigidSurfaces{}, .friction = {.coefficient = kFriction}});
              }) {}
};

Finding turn(const std::function<Method()>& make, double published, const std::string& why) {
  constexpr int kDirections = 4;  // from 0 to 45 degrees
  double least = INFINITY, most = 0, distance = NAN, aside = 0;
  for (int i = 0; i <= kDirections; ++i) {
    const double angle = M_PI / 4 * i / kDirections;
    Sphere sphere(angle);
    const Method method = make();
    if (!sphere.run(*method, kEnd).reached) return {Outcome::unstable, {}, "stopped"};
    const double along = std::cos(angle) * sphere.state.q[0] + std::sin(angle) * sphere.state.q[1];
    aside = std::max(aside, std::abs(std::cos(angle) * sphere.state.q[1] - std::sin(angle) * sphere.state.q[0]));
    if (i == 0) distance = along;
    least = std::min(least, along), most = std::max(most, along);
  }
  const auto force = [](double d) { return kGravity * std::sin(kSlope) - 2 * d / (kEnd * kEnd); };
  return {judged((most - least) / distance, kLimit),
          {{"change of the distance after 2 s", (most - least) / distance},
           {"of the friction force", force(least) / force(most) - 1, published},
           {"distance at 0 deg, m", distance, 8.110858, 7},
           {"aside, m", aside}},
          why};
}

const Registered scene{under_every_method(
    {"S66",
     "friction pyramid",
     {{"linearised 4-sided cone",
       [] {
         return turn([] { return moreau(1e-3, std::make_unique<BulletMlcp>()); }, 0.41,
                     "Dantzig's method of Bullet: √2 times the friction between the axes, and not against the slip");
       }},
      {"second-order cone", [] { return turn([] { return moreau(1e-3); }, NAN, ""); }},
      {"Moreau-Jean, h = 0.01", [] { return turn([] { return moreau(0.01); }, NAN, ""); }, Role::ours},
      {"nonsmooth generalized-alpha, h = 1e-3", [] { return turn([] { return nonsmooth_alpha(1e-3); }, NAN, ""); },
       Role::ours}}},
    {1e-6, 1e-3}, [](const std::function<Method()>& make) { return turn(make, NAN, ""); })};

}  // namespace
}  // namespace lithe::lab
