// F20: a gear that rattles in its backlash, without damping. A step that is long beside a contact meets the flank too
// late or not at all: the gear bounces back faster or slower than it came.
#include <numbers>

#include "bodies/rigid_body.h"
#include "joints/gears/toothed_gear_pair.h"
#include "joints/revolute_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kInertia = 1e-3, kStiffness = 4e8, kBacklash = 60e-6, kSpeed = 3.5;  // kg m², N/m, m, rad/s
constexpr int kBounces = 50;
constexpr double kLimit = 0.01, kUnbounded = 0.5;

/// The gear against one that stands still.
class RattlingGear : public Bench {
 public:
  RattlingGear() : Bench(Vector3::Zero(), [](SystemGraph& drawing) { draw(drawing); }) { state.v[5] = kSpeed; }

 private:
  static void draw(SystemGraph& drawing) {
    auto& gear = drawing.add<RigidBody>("gear", {.mass = 1, .inertia = {kInertia, kInertia, kInertia}});
    drawing.add<RevoluteJoint>("pin", {drawing.ground().marker(), gear.marker()});
    const GearDesign gears{.module = 3e-3, .teeth_A = 20, .teeth_B = 30, .face_width = 20e-3, .backlash = kBacklash};
    drawing.add<ToothedGearPair>("mesh", {gear.marker(), drawing.ground().marker({75e-3, 0, 0})},
                                 {gears, {.model = ToothStiffness::table, .stiffness = {kStiffness}}});
  }
};

Finding rattles(Integrator& method) {
  RattlingGear bench;
  const double r_b = GearGeometry({.module = 3e-3, .teeth_A = 20, .teeth_B = 30, .face_width = 20e-3}).A.base_radius;
  const double contact = std::numbers::pi * std::sqrt(kInertia / (kStiffness * r_b * r_b));
  const double flight = kBacklash / (r_b * kSpeed);
  int bounces = 0;
  double before = kSpeed, growth = 0;
  const double start = bench.energy();
  // It ends in the middle of the backlash, as it began.
  const Bench::Course course = bench.run(
      method, kBounces * (contact + flight),
      [&] {
        growth = std::max(growth, bench.energy() / start - 1);
        if (bench.state.v[5] * before < 0) ++bounces;
        if (bench.state.v[5] != 0) before = bench.state.v[5];
      },
      1e3 * start);
  const double error = course.energy_error / start;
  return {growth > kUnbounded ? Outcome::unstable : judged(error, kLimit),
          {{"largest change of the energy in 50 bounces, relative", error},
           {"bounces", static_cast<double>(bounces)},
           {"a contact lasts, s", contact},
           {"steps", static_cast<double>(course.steps)}},
          course.why};
}

const Registered scene{with_candidates({"F20", "a gear that rattles in its backlash", {}},
                                       {automatic(1e-8), radau(1e-8), runge_kutta8(1e-8), alpha(2e-4), alpha(5e-5),
                                        alpha(1e-6), hht(1e-4), linearly_implicit(1e-4)},
                                       {1e-8, 5e-5}, rattles)};

}  // namespace
}  // namespace lithe::lab
