#pragma once

#include <algorithm>
#include <functional>
#include <random>

#include "bodies/flexible/flexible_body.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/contact/contact.h"
#include "tests/support/methods.h"

/// Scenes and methods whose runs are interrupted and resumed.
namespace lithe::test::restart {

// ---- scenes ----

inline const Matrix3 kAxisY = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y

/// How a scene is drawn: the ways in which another one may differ from it.
struct Drawing {
  double mass = 1, stiffness = 40;
  bool spare = false;
  const char* name = "rocker";
};

/// Crank, coupler and rocker, closed to a loop by hinges about y; a spring between coupler and ground.
void draw_loop(SystemGraph& graph, const Drawing& d);
/// The same, rubbing in a hinge by the reaction there.
void draw_rubbing(SystemGraph& graph);
/// Of the soft rod.
std::shared_ptr<const ModalBasis> rod_modes();
/// A soft rod on a hinge, swinging.
void draw_flexible(SystemGraph& graph);
/// A block thrown onto the floor, where bristles hold it, and a ball onto the block.
void draw_contact(SystemGraph& graph, Contact::Parameters parameters);
void draw_compliant(SystemGraph& graph);
void draw_rigid_contact(SystemGraph& graph);
/// Types known by name: a loaded joint, and a body behind its C table.
void draw_plug_ins(SystemGraph& graph);
/// Three frames that springs and beads couple as one body, on a hinge.
void draw_several_frames(SystemGraph& graph);
/// Two frames and the modes of two elastic bars as one body, on a pin.
void draw_frames_and_modes(SystemGraph& graph);
void draw_driven(SystemGraph& graph);

// ---- methods ----

using MakeMethod = std::function<Method(const System&)>;
template <class T>
MakeMethod of(typename T::Parameters parameters) {
  return [=](const System&) { return std::make_unique<T>(parameters); };
}
/// Lithe's own method behind a C table, as a plug-in has it: "guest", and "forgetful", which tells nothing of its past.
MakeMethod behind_a_table(const std::string& name);

struct Case {
  const char* name;
  MakeMethod make;
};
inline constexpr Tolerance kTolerance{1e-6, 1e-8};
const std::vector<Case>& smooth_methods();

// ---- what is compared ----

/// A scene that runs, made anew for each resumption.
struct Machine {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  System system;
  Method method;
  Recorder recorder;
  Simulation simulation;
  State state;

  Machine(const std::function<void(SystemGraph&)>& draw, const MakeMethod& make, int threads = 1)
      : system((draw(graph), assemble(graph, {.threads = threads}))),
        method(make(system)),
        recorder({coordinate_of_first()}),
        simulation(system, *method),
        state(system.initial_state()) {
    simulation.observe(recorder, every(7e-3));
    simulation.on({.name = "turns", .function = [](Snapshot& now) { return now.state().v[0] - 0.05; }});
  }
  /// A column of no meaning that all of the motion goes into.
  static Sensor coordinate_of_first() {
    return {"norm", {"norm"}, [](Snapshot& now, std::span<double> values) {
              values[0] = now.state().q.norm() + now.accelerations().norm() + now.multipliers().norm();
            }};
  }
  /// On through the times from `next` on, saving at each; returns all that there is to know at the last.
  std::vector<unsigned char> go_on(const std::vector<double>& times, std::size_t next, std::vector<Archive>* saved) {
    for (std::size_t i = next;; ++i) {
      simulation.run(state, times[i]);
      Archive archive;
      simulation.save(state, archive);
      if (i + 1 == times.size()) return archive.bytes();
      if (saved) saved->push_back(std::move(archive));
    }
  }
};

inline std::vector<double> random_times(double end, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(0.02 * end, 0.98 * end);
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(within(random));
  std::sort(times.begin(), times.end());
  times.push_back(end);
  return times;
}

}  // namespace lithe::test::restart
