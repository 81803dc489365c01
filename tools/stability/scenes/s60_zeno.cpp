// S60: a ball that bounces (C01): infinitely many impacts before t* = 4.0637 s, then rest.
#include "engine/base/error.h"
#include "engine/run/simulation.h"
#include "joints/point_on_plane_joint.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/contacts.h"

namespace lithe::lab {
namespace {

constexpr double kHeight = 1, kRadius = 0.1, kRestitution = 0.8, kEnd = 5;  // m, m, -, s
constexpr double kSmallGap = 1e-9, kShortFlight = 1e-9, kRestSpeed = 1e-4;  // m, s, m/s
constexpr int kMostEvents = 200, kCompared = 10;

double impact_time(int n) {  // s: of impact 0, 1, …
  const double fall = std::sqrt(2 * kHeight / kGravity), e = kRestitution;
  return fall * (1 + 2 * e * (1 - std::pow(e, n)) / (1 - e));
}
const double kLastImpact = impact_time(1000);

/// Largest error of the first ten, s.
double timing_error(const std::vector<double>& times) {
  double worst = times.size() < kCompared ? NAN : 0;
  for (int n = 0; n < kCompared && !std::isnan(worst); ++n)
    worst = std::max(worst, std::abs(times[n] - impact_time(n)));
  return worst;
}

enum class Floor { none, surface, joint };

/// q[2] is the gap.
class Ball : public Bench {
 public:
  explicit Ball(Floor floor)
      : Bench({0, 0, -kGravity}, [&](SystemGraph& graph) {
          auto& ball = graph.add<RigidBody>(
              "ball",
              {.mass = 1, .inertia = {4e-3, 4e-3, 4e-3}, .position = {0, 0, floor == Floor::joint ? 0 : kHeight}});
          if (floor == Floor::joint) graph.add<PointOnPlaneJoint>("rest", {graph.ground().marker(), ball.marker()});
          if (floor == Floor::surface)
            graph.add<Contact>("floor",
                               {{graph.ground().marker(Point(0, 0, -kRadius)), shape::half_space()},
                                {ball.marker(), shape::sphere(kRadius)}},
                               {.law = RigidSurfaces{.restitution = kRestitution}});
        }) {}
};

Event impact(Event::Action action, std::function<void(State&)> change) {
  return {.name = "impact",
          .function = [](Snapshot& now) { return now.state().q[2]; },
          .direction = Event::Direction::falling,
          .action = action,
          .change = std::move(change)};
}

/// Simulation refuses to go on; told to all the same, it meets the same again, until flights are too short to matter.
Finding without_cut_off() {
  Ball ball(Floor::none);
  const Method method = runge_kutta(1e-10);
  Simulation simulation(ball.system, *method);
  double last = 0, flight = INFINITY;
  long events = 0, events_then = 0;
  std::string why;
  simulation.on(impact(Event::Action::restart, [&](State& state) {
    state.v[2] *= -kRestitution;
    flight = 2 * state.v[2] / kGravity;
    if (flight >= kShortFlight) ++events, last = state.time;
  }));
  for (int tries = 0; tries < 20 && flight >= kShortFlight && ball.state.time < kEnd; ++tries) {
    try {
      simulation.run(ball.state, kEnd);
    } catch (const SimulationError& error) {
      if (why.empty()) why = error.what(), events_then = events;
    }
  }
  return {why.empty() ? judged(ball.state.q[2], kSmallGap) : Outcome::refused,
          {{"impacts before flights below 1 ns", static_cast<double>(events), 92},
           {"time of the last of them, s", last, 4.06371276, 9},
           {"impacts when Simulation gave up", static_cast<double>(events_then)}},
          why};
}

Finding with_threshold() {
  Ball ball(Floor::none);
  const Method method = runge_kutta(1e-12);
  Simulation simulation(ball.system, *method);
  std::vector<double> times;
  simulation.on(impact(Event::Action::stop, [&](State& state) {
    times.push_back(state.time);
    state.v[2] *= -kRestitution;
  }));
  do simulation.run(ball.state, kEnd);
  while (ball.state.time < kEnd && ball.state.v[2] > kRestSpeed && times.size() < kMostEvents);

  Ball resting(Floor::joint);
  resting.state.time = ball.state.time;
  const Method method_at_rest = runge_kutta(1e-12);
  const auto course = resting.run(*method_at_rest, kEnd);
  return {course.reached && times.size() < kMostEvents ? judged(resting.state.q[2], kSmallGap) : Outcome::unstable,
          {{"gap at 5 s, m", resting.state.q[2]},
           {"events", static_cast<double>(times.size())},
           {"time of rest less t*, s", ball.state.time - kLastImpact},
           {"error of the first ten impacts, s", timing_error(times)}},
          "slower than 1e-4 m/s the ball rests: a joint from there"};
}

Finding step(Integrator& method) {
  Ball ball(Floor::surface);
  std::vector<double> times;
  double before = 0, deepest = 0;
  const auto course = ball.run(method, kEnd, [&] {
    const double gap = ball.state.q[2], v = ball.state.v[2];
    if (before < 0 && v > 0)  // back along the flight to where it began
      times.push_back(ball.state.time -
                      2 * std::max(gap, 0.0) / (v + std::sqrt(v * v + 2 * kGravity * std::max(gap, 0.0))));
    before = v;
    deepest = std::max(deepest, -gap);
  });
  const double gap = std::max(std::abs(ball.state.q[2]), deepest);
  return {course.reached && times.size() < kMostEvents ? judged(gap, kSmallGap) : Outcome::unstable,
          {{"deepest overlap, or gap at 5 s, m", gap},
           {"bounces", static_cast<double>(times.size())},
           {"error of the first ten impacts, s", timing_error(times)},
           {"steps", static_cast<double>(course.steps)}},
          "bounces shorter than a step are not told from rest"};
}

const Registered scene{under_every_method(
    {"S60",
     "Zeno",
     {{"event driven without cut-off", without_cut_off},
      {"event driven with rest threshold", with_threshold},
      {"time stepping", [] { return step(*moreau(1e-3)); }},
      {"Moreau-Jean, h = 0.02", [] { return step(*moreau(0.02)); }, Role::ours},
      {"nonsmooth generalized-alpha, h = 1e-3", [] { return step(*nonsmooth_alpha(1e-3)); }, Role::ours}}},
    {1e-6, 1e-3}, step)};

}  // namespace
}  // namespace lithe::lab
