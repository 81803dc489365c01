#include "engine/study/model_run.h"

#include "engine/assembly/batch_of.h"
#include "engine/assembly/evaluator.h"
#include "engine/base/number_text.h"
#include "engine/motion/projection.h"
#include "engine/run/simulation.h"
#include "engine/study/certificate.h"
#include "engine/study/study_run.h"

namespace lithe {
namespace {

/// Reads the motion between steps by the integrator's dense output.
class Sampler final : public Observer {
 public:
  /// Without an integrator every sample must be a state of its own.
  Sampler(const System& system, const Integrator* integrator, const std::vector<Sensor>& sensors,
          const RunRequest& request, ModelRun& run)
      : integrator_(integrator),
        sensors_(sensors),
        request_(request),
        run_(run),
        snapshot_(system),
        projector_(snapshot_.evaluator()) {
    run_.samples.columns = {"t"};
    for (const Sensor& sensor : sensors)
      run_.samples.columns.insert(run_.samples.columns.end(), sensor.columns().begin(), sensor.columns().end());
    row_.resize(run_.samples.columns.size());
  }

  void observe(Snapshot& now) override {
    const State& to = now.state();
    const double slack = 1e-9 * request_.duration;
    for (; next_ <= request_.samples && time(next_) <= to.time + slack; ++next_) {
      if (time(next_) < to.time - slack) {
        integrator_->interpolate(now.system().layout(), from_, to, time(next_), at_);
        at_.lambda.resize(0);
        look(time(next_));
      } else {
        at_ = to;
        look(to.time);
      }
    }
    from_ = to;
  }

 private:
  double time(int sample) const { return request_.duration * sample / request_.samples; }

  void look(double time) {
    at_.time = time;
    if (request_.dynamics) {
      at_.lambda.setZero(snapshot_.system().layout().row_count());
      at_.v_dot.resize(at_.v.size());
      projector_.accelerations(time, at_.q, at_.v, at_.v_dot, at_.lambda);
    }
    snapshot_.evaluate(at_);
    row_[0] = time;
    read();
    for (std::size_t i = 0; i < row_.size(); ++i)
      if (!std::isfinite(row_[i]))
        throw SimulationError("'" + run_.samples.columns[i] + "' is not finite", time_text(time),
                              "look what its sensor divides by");
    run_.samples.add_row(row_);
    VectorX g(snapshot_.system().layout().row_count());
    if (g.size() > 0) {
      snapshot_.evaluator().constraint(Level::position, g);
      run_.residual = std::max(run_.residual, g.cwiseAbs().maxCoeff());
    }
    if (request_.dynamics) run_.states.push_back(at_);
  }

  void read() {
    std::size_t column = 1;
    for (const Sensor& sensor : sensors_) {
      sensor.evaluate(snapshot_, std::span<double>(row_).subspan(column, sensor.columns().size()));
      column += sensor.columns().size();
    }
  }

  const Integrator* integrator_;
  const std::vector<Sensor>& sensors_;
  const RunRequest& request_;
  ModelRun& run_;
  Snapshot snapshot_;
  Projector projector_;
  State from_, at_;
  std::vector<double> row_;
  int next_ = 0;
};

/// The graph with wrenches on its bodies.
std::unique_ptr<SystemGraph> under(const std::vector<RecordedWrench::Parameters>& wrenches, SystemGraph& graph) {
  auto loaded = SystemGraph::part_of(graph);
  for (std::size_t i = 1; i < graph.bodies().size(); ++i) loaded->share(graph.bodies()[i]);
  for (const auto& c : graph.constraints()) loaded->share(c, c.markers);
  const auto share = [&](const auto& entry) { loaded->share(entry, entry.markers); };
  graph.for_each_load(share, share);
  for (const RecordedWrench::Parameters& wrench : wrenches)
    loaded->add<RecordedWrench>("feedback on " + wrench.marker.body->name(), {wrench.marker}, wrench);
  return loaded;
}

/// Steps of the integrator's own, read by its dense output where they pass samples.
void run_whole(SystemGraph& graph, const std::vector<Sensor>& sensors, const MakeIntegratorBy<Tolerance>& make,
               const RunRequest& request, ModelRun& run) {
  const System system = assemble(graph);
  const std::unique_ptr<Integrator> integrator = make(request.tolerance);
  Sampler sampler(system, integrator.get(), sensors, request, run);
  Simulation simulation(system, *integrator);
  simulation.observe(sampler, request.meets_samples ? every(request.duration / request.samples) : every_step());
  State state = system.initial_state();
  try {
    simulation.run(state, request.duration);
  } catch (const SimulationError& error) {
    run.why = error.problem();
  }
  run.slices = system.layout().bodies();
  run.integrator = integrator->name();
  run.statistics = simulation.statistics();
}

/// Islands that meet at every sample.
void run_simplified(SystemGraph& graph, const std::vector<Sensor>& sensors, const MakeIntegratorBy<Tolerance>& make,
                    const RunRequest& request, ModelRun& run) {
  Simulation simulation(graph, [&] { return make(request.tolerance); }, {.simplify = true});
  Sampler sampler(simulation.observed(), nullptr, sensors, request, run);
  simulation.observe(sampler, every(request.duration / request.samples));
  State state = simulation.start();
  try {
    simulation.run(state, request.duration);
  } catch (const SimulationError& error) {
    run.why = error.problem();
  }
  run.slices = simulation.observed().layout().bodies();
  for (const auto& island : simulation.islands()) {
    run.integrator = island.integrator;
    run.statistics.steps += island.statistics.steps;
    run.statistics.evaluations += island.statistics.evaluations;
    run.statistics.newton_iterations += island.statistics.newton_iterations;
  }
}

}  // namespace

template std::unique_ptr<ForceBatch> make_force_batch<RecordedWrench>();

BodyModels::BodyModels(SystemGraph& graph) {
  for (const auto& entry : graph.bodies())
    if (auto* body = dynamic_cast<DeformableBody*>(entry.body); body && body->candidate_stiffness().size() > 0)
      bodies_.push_back(body);
}

std::vector<Fidelity> BodyModels::current() const {
  std::vector<Fidelity> models;
  for (const DeformableBody* body : bodies_) models.push_back(body->fidelity());
  return models;
}

void BodyModels::set(const std::vector<Fidelity>& models) {
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (!(bodies_[i]->fidelity() == models[i])) bodies_[i]->set_fidelity(models[i]);
}

std::vector<Fidelity> BodyModels::all(Deflection deflection) const {
  std::vector<Fidelity> models;
  for (const DeformableBody* body : bodies_) {
    models.push_back({{}, std::min(deflection, body->finest_deflection())});
    for (int k = 0; k < body->candidate_stiffness().size(); ++k) models.back().modes.push_back(k);
  }
  return models;
}

std::string model_text(const BodyModels& bodies, const std::vector<Fidelity>& models) {
  std::string text;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const Fidelity& model = models[i];
    if (i > 0) text += "; ";
    if (models.size() > 1) text += bodies.bodies()[i]->name() + ": ";
    text += model_text(model, static_cast<int>(bodies.bodies()[i]->candidate_stiffness().size()));
  }
  return models.empty() ? "rigid" : text;
}

ModelRun run_model(SystemGraph& graph, BodyModels& bodies, const std::vector<Fidelity>& models,
                   const std::vector<Sensor>& sensors, const MakeIntegratorBy<Tolerance>& make,
                   const RunRequest& request, const std::vector<RecordedWrench::Parameters>& wrenches) {
  ModelRun run;
  const double begun = thread_seconds();
  bodies.set(models);
  const auto loaded = wrenches.empty() ? nullptr : under(wrenches, graph);
  SystemGraph& drawn = loaded ? *loaded : graph;
  if (request.simplify)
    run_simplified(drawn, sensors, make, request, run);
  else
    run_whole(drawn, sensors, make, request, run);
  run.models = models;
  run.tolerance = request.tolerance;
  run.cost = thread_seconds() - begun;
  return run;
}

}  // namespace lithe
