#pragma once

#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/model/deformable_body.h"
#include "engine/model/state.h"
#include "engine/model/system_graph.h"
#include "engine/motion/make_integrator.h"
#include "engine/observe/sensors.h"
#include "engine/output/table.h"
#include "engine/study/recorded_wrench.h"

namespace lithe {

/// The deformable bodies of a scene that have candidate modes, and how they are modelled.
class BodyModels {
 public:
  explicit BodyModels(SystemGraph& graph);
  const std::vector<DeformableBody*>& bodies() const { return bodies_; }
  int count() const { return static_cast<int>(bodies_.size()); }
  std::vector<Fidelity> current() const;
  void set(const std::vector<Fidelity>& models);
  /// Each with all its candidates.
  std::vector<Fidelity> all(Deflection deflection = Deflection::linear) const;
  std::vector<Fidelity> rigid() const { return std::vector<Fidelity>(bodies_.size()); }

 private:
  std::vector<DeformableBody*> bodies_;
};

/// "rigid"; "3 of 20 modes, stiffened"; of several bodies: "link: rigid; rod: 3 of 20 modes".
std::string model_text(const BodyModels& bodies, const std::vector<Fidelity>& models);

/// One run of a scene at one fidelity, sampled at evenly spaced instants.
struct ModelRun {
  std::vector<Fidelity> models;           // of BodyModels::bodies()
  std::vector<Layout::BodySlice> slices;  // of all bodies in the states below
  std::vector<State> states;              // accelerations and multipliers are those of the equations of motion
  Table samples;                          // "t", then the columns of the sensors
  std::string integrator, why;            // why it did not reach the end; empty if it did
  Tolerance tolerance{};                  // 0: by fixed steps
  double step = 0;                        // s; 0: by tolerance
  IntegratorStatistics statistics{};
  double residual = 0;  // largest |g| at the samples, in the units of the rows
  double cost = 0;      // s of CPU: set-up and run
  bool reached() const { return why.empty(); }
};

struct RunRequest {
  double duration = 1;  // s
  int samples = 100;    // instants after the first
  Tolerance tolerance{};
  bool simplify = false;       // the graph first (engine/simplify/), islands by themselves (engine/run/simulation.h)
  bool dynamics = true;        // whether accelerations and multipliers of the samples are wanted: what estimates need
  bool meets_samples = false;  // steps end at every sample: nothing is looked at in between
};
/// Runs the scene with its bodies so modelled, under wrenches on their frames if there are any; the graph is left at
/// that fidelity. `why` says what stopped a run; errors of the scene are thrown.
ModelRun run_model(SystemGraph& graph, BodyModels& bodies, const std::vector<Fidelity>& models,
                   const std::vector<Sensor>& sensors, const MakeIntegratorBy<Tolerance>& make,
                   const RunRequest& request, const std::vector<RecordedWrench::Parameters>& wrenches = {});

}  // namespace lithe
