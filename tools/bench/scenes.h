#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bodies/flexible/flexible_body.h"
#include "engine/assembly/evaluator.h"
#include "engine/model/system_graph.h"
#include "integrators/generalized_alpha.h"
#include "tools/bench/measure.h"

namespace lithe::bench {

/// The scenes measured here: drawn and assembled, ready to step. Neither copied nor moved: the system borrows the
/// graph.
struct Scene {
  SystemGraph graph;
  Marker tip;
  const System system;

  explicit Scene(const std::function<Marker(SystemGraph&)>& draw, const Vector3& gravity = {0, 0, -9.81})
      : graph({.gravity = gravity}), system(drawn(draw)) {}
  Scene(const Scene&) = delete;

 private:
  System drawn(const std::function<Marker(SystemGraph&)>& draw) {
    tip = draw(graph);
    return assemble(graph);
  }
};

/// Unit rods (1 kg, 1 m) in a level row, each tied to the one before, the first to the ground; at rest. `bushing`: by
/// springs of 1e6 N/m and dampers of 1e3 N s/m in the three directions, turning freely; else by a joint of the
/// catalogue, or the same written as a residual alone (engine/model/joint_by_residual.h). Returns the
/// tip; `ends`, if given, gets the outboard end of each rod.
enum class ChainJoint { spherical, revolute, bushing, spherical_derived, revolute_derived };
Marker draw_chain(SystemGraph& graph, int count, ChainJoint joint, std::vector<Marker>* ends = nullptr);
/// "spherical", "revolute", "spherical-derived", "revolute-derived". Throws std::invalid_argument for another name.
ChainJoint chain_joint(const std::string& name);

/// The rod of examples/data/pendulum/hex8i: 16 bricks with incompatible modes, its matrices from CalculiX.
FiniteElementModel rod_model();
/// The same rod of 4,320 plain bricks.
FiniteElementModel fine_rod_model();

/// The rod, level and at rest, on a hinge at its lower edge: modes of the rod hung there, and a revolute joint; or,
/// with `fixation`, modes of the free rod seen from a frame of three nodes, and its three hinge nodes held.
struct PendulumVariant {
  int modes = 9;
  bool fixation = false;
};
Marker draw_pendulum(SystemGraph& graph, const FiniteElementModel& model, const PendulumVariant& variant);

/// Generalized-alpha with a fixed step, over `steps` steps from the start; the loop alone is timed.
struct Stepping {
  double step = 1e-3;  // s
  long steps = 1000;
  double spectral_radius = 0.9, newton_tolerance = 1e-9;
};
Cost measure(const Scene& scene, const Stepping& stepping);

}  // namespace lithe::bench
