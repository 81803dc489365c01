#include <gtest/gtest.h>

#include "engine/run/simulation.h"
#include "joints/gears/tooth_events.h"
#include "tests/joints/gears/gear_scenes.h"
#include "tests/support/message_of.h"

/// Loss and return of contact of toothed gears, as events.
namespace lithe::test::tooth_events_test {
namespace {

using gears::GearScene, gears::small;

constexpr double kInertia = 2e-3, kTorque = 0.5, kPlay = 60e-6, kStiffness = 2e8;

ToothedGearPair::Parameters with_play() {
  ToothedGearPair::Parameters p{.gears = small(), .teeth = {.model = ToothStiffness::table, .stiffness = {kStiffness}}};
  p.gears.backlash = kPlay;
  return p;
}

/// A gear driven across its backlash by a constant torque, against one that does not give way: with
/// a = r_b T / J and ω² = k r_b² / J it meets the flank at √(j/a), parts from it a swing about a/ω² later, of
/// 2 (π - atan(ω v/a))/ω, flies for 2 v/a and meets it again; v = √(a j).
TEST(ToothEvents, TellWhenTeethMeetAndPart) {
  for (const double way : {1.0, -1.0})
    for (const Event::Action action : {Event::Action::record, Event::Action::restart}) {
      GearScene scene(with_play(), kInertia, 1e12, way * kTorque, 0);
      const double r_b = scene.mesh->geometry().A.base_radius, a = r_b * kTorque / kInertia,
                   w = std::sqrt(kStiffness / kInertia) * r_b, v = std::sqrt(a * kPlay), first = std::sqrt(kPlay / a),
                   taut = 2 / w * (kPi - std::atan(w * v / a));
      const System system = assemble(scene.graph);
      State state = system.initial_state();
      Method method = runge_kutta8(1e-12);
      Simulation simulation{system, *method};
      for (const Event& event : tooth_contact_events(*scene.mesh, action)) simulation.on(event);
      simulation.run(state, first + taut + 2 * v / a + 0.5 * taut);
      const auto& events = simulation.events();
      ASSERT_EQ(events.size(), 3u);
      const std::string side = way > 0 ? "mesh front " : "mesh back ";
      const double times[] = {first, first + taut, first + taut + 2 * v / a};
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(events[i].name, side + (i == 1 ? "parts" : "meets"));
        EXPECT_NEAR(events[i].time, times[i], (action == Event::Action::record ? 1e-6 : 1e-9) * times[i]);
      }
    }
}

/// Teeth that swing on each other, damped by a tenth of the critical damping: a swing is e^(-2 π ζ / √(1 - ζ²)) of the
/// one before.
TEST(ToothEvents, DampingIsARatioOfTheCriticalOne) {
  constexpr double kRatio = 0.1, J_A = 2e-3, J_B = 5e-3;
  ToothedGearPair::Parameters p = with_play();
  p.teeth.damping = kRatio * critical_damping(p, J_A, J_B);
  GearScene scene(p, J_A, J_B, 40, 40 * 31.0 / 20);  // in balance, pressed together
  const GearGeometry& g = scene.mesh->geometry();
  const double mobility = std::pow(g.A.base_radius, 2) / J_A + std::pow(g.B.base_radius, 2) / J_B;
  const double w = std::sqrt(kStiffness * mobility * (1 - kRatio * kRatio));
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  // As deep as the torque presses them, and a speed that leaves them together.
  const double deep = 40 / g.A.base_radius / kStiffness;
  const double turn = (deep + kPlay / 2) / g.A.base_radius;
  state.q.segment<4>(3) << std::cos(turn / 2), 0, 0, std::sin(turn / 2);
  state.v[5] = 0.05;
  Method method = runge_kutta8(1e-12);
  Simulation simulation{system, *method};
  const auto rate = [&] {
    return g.A.base_radius * gears::value(system, state, coordinate_rate(scene.A.angle(), "")) +
           g.B.base_radius * gears::value(system, state, coordinate_rate(scene.B.angle(), ""));
  };
  const double before = rate();
  simulation.run(state, 2 * kPi / w);
  EXPECT_NEAR(rate() / before, std::exp(-2 * kPi * kRatio / std::sqrt(1 - kRatio * kRatio)), 1e-4);
  EXPECT_THROW(critical_damping(p, 0, J_B), SceneError);
}

}  // namespace
}  // namespace lithe::test::tooth_events_test
