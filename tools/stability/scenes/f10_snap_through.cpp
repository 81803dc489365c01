// F10: Lee's frame snaps through and back: under a load that only grows the path of equilibria is lost at its first
// limit, under a displacement that only grows where the frame snaps back.
#include "bodies/beam/beam.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/equilibrium_path.h"
#include "engine/assembly/evaluated.h"
#include "engine/base/error.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/lab.h"

namespace lithe::lab {
namespace {

// Inch and pound-force, as published: a column and a beam of 120, hinged at the foot and at the wall, a dead load down
// on the beam 24 from the corner. Limit loads by shooting (tests/data/beams/S09_lee_frame.json).
constexpr double kSide = 120, kPlace = 24, kEA = 4.32e7, kEI = 1.44e7, kUpper = 18556.7, kLower = -9414.4;
constexpr double kMost = 2e4, kDown = 95, kGap = 0.1;  // load, displacement, of the side: between two states of a path

struct LoadedMarker {
  Marker loaded;
};

/// The marker is a base before Bench, so that what draws the graph can fill it.
class Frame : private LoadedMarker, private Bench {
 public:
  enum class Led { by_load, by_displacement };
  explicit Frame(Led led)
      : Bench(Vector3::Zero(), [&](SystemGraph& graph) {
          const BeamSection section =
              BeamSection::diagonal({kEA, 10 * kEA, 10 * kEA, 10 * kEI, 10 * kEI, kEI}, 1, {2, 1, 1});
          auto& column = graph.add<Beam>("column", {.axis = BeamAxis::straight({0, 0, 0}, {0, kSide, 0}, {-1, 0, 0}),
                                                    .sections = {{0, section}},
                                                    .elements = 20});
          auto& beam = graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, kSide, 0}, {kSide, kSide, 0}, {0, 1, 0}),
                                                .sections = {{0, section}},
                                                .elements = 20,
                                                .stations = {kPlace}});
          graph.add<FixedJoint>("corner",
                                {column.marker(kSide), beam.marker(0, {}, beam.axes(0).transpose() * column.axes(0))});
          graph.add<RevoluteJoint>("foot", {graph.ground().marker({0, 0, 0}, column.axes(0)), column.marker(0)});
          graph.add<RevoluteJoint>("wall", {graph.ground().marker({kSide, kSide, 0}), beam.marker(kSide)});
          loaded = beam.marker(kPlace);
          const Marker ground = graph.ground().marker({kPlace, kSide, 0});
          if (led == Led::by_load)
            graph.add<UserForce>("load", {loaded}, {[](double share, const MarkerView&) {
                                   return force({0, -kMost * share, 0});
                                 }});
          else
            graph.add<CoordinateDrive>("press", {displacement_between(ground, loaded, 1)}, {.motion = ramp(0, -kDown)});
        }) {}

  /// Where the loaded point is.
  Vector3 place(const State& state) {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    return marker_kinematics(equations, loaded, Level::position).p;
  }
  /// Equilibria one after the other, at times from 0 to 1; as far as they are found.
  std::vector<State> in_steps(int count, std::string& why) {
    std::vector<State> states{find_equilibrium(system, state).state};
    try {
      for (int i = 1; i <= count; ++i) {
        State next = states.back();
        next.time = static_cast<double>(i) / count;
        states.push_back(find_equilibrium(system, next).state);
      }
    } catch (const SimulationError& error) {
      why = error.what();
    }
    return states;
  }
  std::vector<State> along_the_path() {
    return follow_equilibria(system, find_equilibrium(system, state).state, {.max_turn = 0.1, .max_step = 1}).states;
  }
};

/// How far the loaded point jumps between two states, and how far the path leads.
Finding finding(Frame& frame, const std::vector<State>& states, const std::string& why) {
  double gap = 0;
  for (std::size_t i = 1; i < states.size(); ++i)
    gap = std::max(gap, (frame.place(states[i]) - frame.place(states[i - 1])).norm() / kSide);
  return {judged(gap, kGap),
          {{"largest jump between two equilibria, of the frame's side", gap},
           {"states", static_cast<double>(states.size())},
           {"loaded point went down by, of the side", (kSide - frame.place(states.back()).y()) / kSide}},
          why};
}
Finding by_steps(Frame::Led led, const std::string& why) {
  Frame frame(led);
  std::string trouble;
  const std::vector<State> states = frame.in_steps(100, trouble);
  Finding found = finding(frame, states, why + (trouble.empty() ? "" : "; " + trouble));
  if (!trouble.empty()) found.outcome = Outcome::refused;
  return found;
}
Finding by_arc_length() {
  Frame frame(Frame::Led::by_load);
  const std::vector<State> states = frame.along_the_path();
  Finding found = finding(frame, states, "the load is an unknown, the length of the path is given");
  double upper = 0, lower = 0;
  bool turned = false;
  for (std::size_t i = 1; i < states.size(); ++i) {
    turned |= states[i].time < states[i - 1].time;
    if (!turned) upper = kMost * states[i].time;
    lower = std::min(lower, kMost * states[i].time);
  }
  found.figures.push_back({"upper limit load, over the reference", upper / kUpper});
  found.figures.push_back({"lower limit load", lower / kLower});
  if (found.outcome == Outcome::converged)
    found.outcome = judged(std::max(std::abs(upper / kUpper - 1), std::abs(lower / kLower - 1)), 0.02);
  return found;
}

const Registered scene{
    {"F10",
     "snap-through",
     {{"load steps", [] { return by_steps(Frame::Led::by_load, "beyond the limit the next equilibrium is elsewhere"); },
       Role::also},
      {"displacement steps", [] { return by_steps(Frame::Led::by_displacement, "the loaded point itself turns back"); },
       Role::also},
      {"arc length (follow_equilibria)", by_arc_length, Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
