#include <gtest/gtest.h>

#include "engine/run/simulation.h"
#include "joints/gears/tooth_events.h"
#include "joints/prismatic_joint.h"
#include "tests/joints/gears/gear_scenes.h"
#include "tests/support/message_of.h"

/// Loss and return of contact of teeth, as events, and their damping.
namespace lithe::test::tooth_events_test {
namespace {

using gears::small;

constexpr double kPlay = 60e-6, kStiffness = 2e8;

/// Teeth between two bodies that move by one coordinate each; its inertias and efforts are of those. The approach of
/// the front flank grows by b_A and b_B times the coordinates' growth.
struct TeethScene {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  Shaft A;
  JointCoordinate moves_B;
  double b_A = 0, b_B = 0, damping = 0;
  std::function<std::vector<Event>(Event::Action)> events;

  double mobility(double J_A, double J_B) const { return b_A * b_A / J_A + b_B * b_B / J_B; }
};
struct Masses {
  double J_A, J_B, effort_A, effort_B, ratio = 0;
};
using Draw = std::unique_ptr<TeethScene> (*)(const Masses&);

ToothContact even() { return {.model = ToothStiffness::table, .stiffness = {kStiffness}}; }

template <class Teeth, class Parameters>
void mesh_of(TeethScene& s, Marker B, Parameters p, const Masses& m) {
  s.damping = m.ratio * critical_damping(p, m.J_A, m.J_B);
  p.teeth.damping = s.damping;
  auto& mesh = s.graph.add<Teeth>("mesh", {s.A.body->marker(), B}, p);
  s.events = [&mesh](Event::Action action) { return tooth_contact_events(mesh, action); };
  if (m.effort_A != 0) s.graph.add<PointForce>("on A", {s.A.body->marker()}, {.torque = {0, 0, m.effort_A}});
}

std::unique_ptr<TeethScene> spur(const Masses& m) {
  auto s = std::make_unique<TeethScene>();
  ToothedGearPair::Parameters p{.gears = small(), .teeth = even()};
  p.gears.backlash = kPlay;
  const GearGeometry g(p.gears);
  s->A = draw_shaft(s->graph, "A", m.J_A);
  const Shaft B = draw_shaft(s->graph, "B", m.J_B, {g.centre_distance, 0, 0});
  s->moves_B = B.angle(), s->b_A = g.A.base_radius, s->b_B = g.B.base_radius;
  mesh_of<ToothedGearPair>(*s, B.body->marker(), p, m);
  if (m.effort_B != 0) s->graph.add<PointForce>("on B", {B.body->marker()}, {.torque = {0, 0, m.effort_B}});
  return s;
}

/// Its rack moves along x. B's mass is J_B.
std::unique_ptr<TeethScene> rack(const Masses& m) {
  auto s = std::make_unique<TeethScene>();
  ToothedRack::Parameters p{.gears = {.module = 3e-3, .teeth_A = 20, .face_width = 20e-3, .backlash = kPlay},
                            .teeth = even()};
  const double r = 30e-3;
  s->A = draw_shaft(s->graph, "A", m.J_A);
  const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2);  // z along x
  auto& B = s->graph.add<RigidBody>("B", {.mass = m.J_B, .position = {0, -r, 0}});
  s->moves_B = s->graph.add<PrismaticJoint>("slide", {s->graph.ground().marker({0, -r, 0}, along), B.marker({}, along)})
                   .displacement();
  s->b_A = r * std::cos(gears::kPressure), s->b_B = -std::cos(gears::kPressure);
  mesh_of<ToothedRack>(*s, B.marker(), p, m);
  if (m.effort_B != 0) s->graph.add<PointForce>("on B", {B.marker()}, {.force = {m.effort_B, 0, 0}});
  return s;
}

std::unique_ptr<TeethScene> bevel(const Masses& m) {
  auto s = std::make_unique<TeethScene>();
  const double shaft_angle = 80 * kPi / 180;
  const BevelGearPair::Parameters p{.module = 3e-3,
                                    .teeth_A = 20,
                                    .teeth_B = 32,
                                    .shaft_angle = shaft_angle,
                                    .face_width = 15e-3,
                                    .backlash = kPlay,
                                    .teeth = even()};
  const Matrix3 across = rotation_about({1, 0, 0}, -shaft_angle);
  s->A = draw_shaft(s->graph, "A", m.J_A, {0, 0, 0.05});
  const Shaft B = draw_shaft(s->graph, "B", m.J_B, across * Vector3(0, 0, 0.04), across);
  s->moves_B = B.angle();
  s->b_A = 30e-3 * std::cos(gears::kPressure), s->b_B = 48e-3 * std::cos(gears::kPressure);
  mesh_of<BevelGearPair>(*s, B.body->marker(), p, m);
  if (m.effort_B != 0)
    s->graph.add<PointForce>("on B", {B.body->marker()},
                             {.torque = {0, 0, m.effort_B}, .axes = PointForce::Axes::marker});
  return s;
}

const std::pair<const char*, Draw> kKinds[] = {{"spur", spur}, {"rack", rack}, {"bevel", bevel}};

/// One body driven across its backlash by a constant effort, against one that does not give way: with
/// a = b Q / J and ω² = k b² / J it meets the flank at √(j/a), parts from it a swing about a/ω² later, of
/// 2 (π - atan(ω v/a))/ω, flies for 2 v/a and meets it again; v = √(a j).
TEST(ToothEvents, TellWhenTeethMeetAndPart) {
  constexpr double kHeavy = 1e12;
  for (const auto& [kind, draw] : kKinds)
    for (const bool by_A : {true, false})
      for (const double way : {1.0, -1.0})
        for (const Event::Action action : {Event::Action::record, Event::Action::restart}) {
          SCOPED_TRACE(std::string(kind) + (by_A ? " A " : " B ") + std::to_string(way));
          const bool slides = kind == std::string("rack") && !by_A;
          const double inertia = slides ? 2 : 2e-3, effort = slides ? 15 : 0.5;
          const auto scene = draw(by_A ? Masses{inertia, kHeavy, way * effort, 0}
                                       : Masses{kHeavy, inertia, 0, (slides ? -way : way) * effort});
          const double b = std::abs(by_A ? scene->b_A : scene->b_B), a = b * effort / inertia,
                       w = std::sqrt(kStiffness / inertia) * b, v = std::sqrt(a * kPlay), first = std::sqrt(kPlay / a),
                       taut = 2 / w * (kPi - std::atan(w * v / a));
          const System system = assemble(scene->graph);
          State state = system.initial_state();
          Method method = runge_kutta8(1e-13);
          Simulation simulation{system, *method};
          for (const Event& event : scene->events(action)) simulation.on(event);
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
  constexpr double kRatio = 0.1;
  for (const auto& [kind, draw] : kKinds) {
    SCOPED_TRACE(kind);
    const double J_A = 2e-3, J_B = kind == std::string("rack") ? 5 : 5e-3;
    const double pressed = 40 / draw({J_A, J_B, 0, 0})->b_A;  // N, along the line of action
    const auto probe = draw({J_A, J_B, 0, 0});
    const auto scene = draw({J_A, J_B, pressed * probe->b_A, pressed * probe->b_B, kRatio});
    const double mobility = scene->mobility(J_A, J_B);
    EXPECT_NEAR(scene->damping, 2 * kRatio * std::sqrt(kStiffness / mobility), 1e-12 * scene->damping);
    const double w = std::sqrt(kStiffness * mobility * (1 - kRatio * kRatio));
    const System system = assemble(scene->graph);
    State state = system.initial_state();
    // As deep as the efforts press them, and a speed that leaves them together.
    const double turn = (pressed / kStiffness + kPlay / 2) / scene->b_A;
    state.q.segment<4>(3) << std::cos(turn / 2), 0, 0, std::sin(turn / 2);
    state.v[5] = 0.05;
    Method method = runge_kutta8(1e-12);
    Simulation simulation{system, *method};
    const auto rate = [&] {
      return scene->b_A * gears::value(system, state, coordinate_rate(scene->A.angle(), "")) +
             scene->b_B * gears::value(system, state, coordinate_rate(scene->moves_B, ""));
    };
    const double before = rate();
    simulation.run(state, 2 * kPi / w);
    EXPECT_NEAR(rate() / before, std::exp(-2 * kPi * kRatio / std::sqrt(1 - kRatio * kRatio)), 1e-4);
  }
  const ToothedGearPair::Parameters spur_gears{.gears = small()};
  const ToothedRack::Parameters on_rack{.gears = {.module = 3e-3, .teeth_A = 20, .face_width = 20e-3}};
  const BevelGearPair::Parameters cones{.module = 3e-3, .teeth_A = 20, .teeth_B = 32, .face_width = 15e-3};
  expect_says(message_of<SceneError>([&] { critical_damping(spur_gears, 0, 1); }), {"inertia_A"});
  expect_says(message_of<SceneError>([&] { critical_damping(on_rack, 1, 0); }), {"mass_B"});
  expect_says(message_of<SceneError>([&] { critical_damping(cones, 1, -1); }), {"inertia_B"});
}

}  // namespace
}  // namespace lithe::test::tooth_events_test
