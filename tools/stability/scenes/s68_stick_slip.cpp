// S68: a mass on a spring, dragged by a belt (C06): sticks and slips with a period of 0.628811 s.
#include "engine/run/simulation.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/user_force.h"
#include "joints/prismatic_joint.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/contacts.h"

namespace lithe::lab {
namespace {

constexpr double kMass = 1, kStiffness = 100, kBelt = 0.5, kStatic = 0.4, kKinetic = 0.3;  // kg, N/m, m/s, -, -
constexpr double kPeriod = 0.62881071913377, kEnd = 8 * kPeriod, kLimit = 1e-4;            // s, s, relative
constexpr double kWeight = kMass * kGravity;                                               // N
constexpr double kBreak = kStatic * kWeight / kStiffness, kMiddle = kKinetic * kWeight / kStiffness;  // m
constexpr double kStart = 2 * kMiddle - kBreak;  // m, sticking from there

using Effort = std::function<double(double time, double x, double v)>;

/// q[2] and v[2] are the mass's.
class Belt : public Bench {
 public:
  explicit Belt(const Effort& effort)
      : Bench(Vector3::Zero(), [&](SystemGraph& graph) {
          auto& mass = graph.add<RigidBody>(
              "mass", {.mass = kMass, .inertia = {1, 1, 1}, .position = {0, 0, kStart}, .velocity = {0, 0, kBelt}});
          auto& guide = graph.add<PrismaticJoint>("guide", {graph.ground().marker(), mass.marker()});
          graph.add<CoordinateMotor>("spring and friction", {guide.displacement()}, {effort});
        }) {}
};

double last_period(const std::vector<double>& times) {
  return times.size() < 2 ? NAN : times.back() - times[times.size() - 2];
}

/// Of the last period, relative. vd: of Stribeck's curve and of the regularisation.
double regularised(double vd, Integrator& method) {
  const ContactFriction law{
      .coefficient = kKinetic, .static_coefficient = kStatic, .stribeck_speed = vd, .creep_speed = vd};
  Belt belt([&](double, double x, double v) { return regularised_friction(law, kWeight, v - kBelt) - kStiffness * x; });
  belt.state.v[2] = kBelt * (1 - 1e-6);
  Simulation simulation(belt.system, method);
  simulation.on({.name = "middle",
                 .function = [](Snapshot& now) { return now.state().q[2] - kMiddle; },
                 .direction = Event::Direction::falling});
  simulation.run(belt.state, kEnd);
  std::vector<double> times;
  for (const EventRecord& event : simulation.events()) times.push_back(event.time);
  return last_period(times) / kPeriod - 1;
}

/// A block on a surface with bristles, seen from the belt: the spring's end moves away.
Finding bristles() {
  constexpr double kNormal = 1e5, kGap = kWeight / 4 / kNormal;  // N/m a corner, m
  const Vector3 edges(0.2, 0.2, 0.02);
  Bench bench({0, 0, -kGravity}, [&](SystemGraph& graph) {
    auto& block = graph.add<RigidBody>(
        "block", {.mass = kMass, .inertia = box_inertia(edges, kMass), .position = {kStart, 0, 0.5 * edges[2] - kGap}});
    graph.add<Contact>(
        "belt", {{graph.ground().marker(), shape::half_space()}, {block.marker(), shape::box(edges)}},
        {.law = Compliance{.stiffness = kNormal, .exponent = 1, .dissipation = Dissipation::fixed, .damping = 10},
         .friction = {.coefficient = kKinetic,
                      .static_coefficient = kStatic,
                      .stribeck_speed = 1e-3,
                      .bristle_stiffness = 1e6,
                      .bristle_damping = 100}});
    graph.add<UserForce>("spring", {block.marker()}, {[](double time, const MarkerView& at) -> Wrench {
                           return force({-kStiffness * (at.p[0] + kBelt * time), 0, 0});
                         }});
  });
  const Method method = runge_kutta(1e-8);
  Simulation simulation(bench.system, *method);
  simulation.on({.name = "middle",
                 .function = [](Snapshot& now) { return now.state().q[0] + kBelt * now.time() - kMiddle; },
                 .direction = Event::Direction::falling});
  simulation.run(bench.state, kEnd);
  std::vector<double> times;
  for (const EventRecord& event : simulation.events())
    if (event.name == "middle") times.push_back(event.time);
  const double error = last_period(times) / kPeriod - 1;
  return {judged(error, kLimit),
          {{"error of the period after 8 cycles, relative", error}},
          "bristles of 1e6 1/m; Stribeck's speed 1e-3 m/s"};
}

/// Sticking and sliding are two motions, changed at the events between them.
Finding event_driven(Integrator& method) {
  bool sticking = true;
  Belt belt([&](double, double x, double) { return sticking ? 0 : kKinetic * kWeight - kStiffness * x; });
  Simulation simulation(belt.system, method);
  std::vector<double> times;
  int changes = 0;
  simulation.on({.name = "breaks away",
                 .function = [&](Snapshot& now) { return sticking ? now.state().q[2] - kBreak : -1; },
                 .direction = Event::Direction::rising,
                 .action = Event::Action::restart,
                 .change =
                     [&](State& state) {
                       sticking = false;
                       times.push_back(state.time);
                       ++changes;
                     }});
  simulation.on({.name = "sticks",
                 .function = [&](Snapshot& now) { return sticking ? -1 : now.state().v[2] - kBelt; },
                 .direction = Event::Direction::rising,
                 .action = Event::Action::restart,
                 .change =
                     [&](State& state) {
                       sticking = true;
                       state.v[2] = kBelt;
                       ++changes;
                     }});
  simulation.run(belt.state, kEnd);
  const double error = last_period(times) / kPeriod - 1;
  return {
      judged(error, kLimit),
      {{"error of the period after 8 cycles, relative", error}, {"changes of motion", static_cast<double>(changes)}},
      "no law to smooth"};
}

Finding one_law() {
  const double error = regularised(0.1, *runge_kutta(1e-10));
  return {judged(error, kLimit),
          {{"error of the period after 8 cycles, relative", error, 1.7e-3}},
          "slides while it sticks"};
}
Finding two_laws() {
  const double coarse = regularised(0.01, *runge_kutta(1e-10)), fine = regularised(0.001, *runge_kutta(1e-10));
  return {judged(std::max(std::abs(coarse), std::abs(fine)), kLimit),
          {{"error of the period after 8 cycles, relative, vd = 0.001", fine, -5.4e-4}, {"vd = 0.01", coarse, -8.6e-5}},
          "breaks away at the peak of Stribeck's curve, before the belt's speed"};
}

const Registered scene{
    under_every_method({"S68",
                        "stick-slip",
                        {{"regularised, vd = 0.1", one_law},
                         {"regularised, vd = 0.01 / 0.001", two_laws},
                         {"event driven", [] { return event_driven(*runge_kutta(1e-12)); }},
                         {"default (automatic, tolerance 1e-9), events of Simulation",
                          [] { return event_driven(*automatic(1e-9).make()); }, Role::ours},
                         {"compliant contact with bristles (LuGre)", bristles, Role::also, Cost::slow}}},
                       {1e-9, 1e-3}, event_driven)};

}  // namespace
}  // namespace lithe::lab
