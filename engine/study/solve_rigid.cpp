#include <algorithm>
#include <utility>

#include "engine/study/solve_internal.h"

namespace lithe::solving {
namespace {

/// The motion with all modes, as far as it can be told without running them.
ModelRun predict(const Asked& asked, RigidMotion& rigid) {
  if (asked.bodies.count() == 0) return rigid.run;
  SystemGraph& graph = asked.graph;
  BodyModels& bodies = asked.bodies;
  rigid.deformed = model_error(graph, bodies, rigid.run, bodies.all(), Missing::modes, asked.sensors);
  ModelRun corrected = run_model(graph, bodies, bodies.rigid(), asked.sensors, asked.methods.by_tolerance,
                                 request(asked, kFirstTolerance, 1, true), rigid.deformed.feedback);
  if (!corrected.reached()) return rigid.run;
  rigid.corrected = std::move(corrected);
  return with_response(graph, bodies, *rigid.corrected, bodies.all(), rigid.deformed.response, asked.sensors);
}

/// Two rigid runs tell what a tolerance is worth here.
void find_tolerance(const Asked& asked, RigidMotion& rigid) {
  ModelRun tighter = run_logged(asked, asked.bodies.rigid(), request(asked, kFirstTolerance / 10, 1, false));
  if (!tighter.reached()) {
    rigid.time_worth = rigid.change;  // what a tolerance is worth is not known
    return;
  }
  rigid.time_worth = sample_differences(asked.sensors, tighter.samples, rigid.run.samples);
  for (double& worth : rigid.time_worth) worth /= kFirstTolerance;
  rigid.tighter = std::move(tighter);
  double tolerance = kLoosest;
  for (std::size_t w = 0; w < asked.count(); ++w) {
    const double worth = rigid.time_worth[w] + rigid.deformation[w];
    if (worth > 0) tolerance = std::min(tolerance, kTimeShare * rigid.bounds[w] / worth);
  }
  if (rigid.is_rough()) tolerance = std::min(tolerance, kTimeShare * kLoosest);
  rigid.tolerance = std::max(tolerance, kTightest);
}

}  // namespace

RigidMotion look_at_rigid(const Asked& asked) {
  RigidMotion rigid;
  rigid.tolerance = kFirstTolerance;
  rigid.amplification.assign(asked.count(), 1);
  rigid.run = run_logged(asked, asked.bodies.rigid(), request(asked, kFirstTolerance, 1, true));
  if (!rigid.run.reached()) return rigid;
  const ModelRun predicted = predict(asked, rigid);
  rigid.change = sample_changes(asked.sensors, predicted.samples);
  double amplitude = 0;
  for (const auto& c : rigid.deformed.coordinates) amplitude = std::max(amplitude, c.amplitude);
  if (amplitude > 0) rigid.elastic_scale = amplitude;
  rigid.deformation = sample_differences(asked.sensors, predicted.samples, rigid.run.samples);
  rigid.bounds = allowed(asked, rigid.change, rigid.run.samples);
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (asked.bodies.count() > 0 && rigid.deformed.effect[w] > 0)
      rigid.amplification[w] = std::max(1.0, rigid.deformation[w] / rigid.deformed.effect[w]);
  find_tolerance(asked, rigid);
  return rigid;
}

}  // namespace lithe::solving
