#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/model/input.h"
#include "engine/observe/observer.h"
#include "engine/observe/sensors.h"

namespace lithe {

class Simulation;

/// What a sampled controller does at each sample: from the readings u and its memory x the outputs y, and the next x.
struct SampledLaw {
  using Step = std::function<void(double time, const VectorX& u, VectorX& x, VectorX& y)>;
  VectorX start{};  // x at the first sample
  int inputs = 0, outputs = 0;
  Step step{};
};
/// y_k = C x_k + D u_k,  x_{k+1} = A x_k + B u_k. Throws SceneError for matrices that do not fit or are not finite, and
/// for an A with an eigenvalue outside the unit circle: such a controller grows by itself.
SampledLaw discrete_state_space(const MatrixX& A, const MatrixX& B, const MatrixX& C, const MatrixX& D,
                                const VectorX& start = {});
/// y_k = Σ b_i u_{k-i} - Σ a_i y_{k-i}, i from 0 and from 1; coefficients over a_0, by rising delay. Throws likewise.
SampledLaw difference_equation(std::vector<double> b, std::vector<double> a);

/// A controller as a computer runs it: every interval T it reads sensors, computes, and its outputs, given to Inputs of
/// the scene, are held until the next:
///   auto& torque = graph.add<Input>("torque", {.unit = "N m"});
///   graph.add<CoordinateMotor>("motor", {hinge.angle()}, {.effort = torque});
///   SampledController pd({.name = "pd", .interval = 1e-3, .delay = 5e-4, .inputs = {{angle}, {speed}},
///                         .outputs = {&torque}, .law = discrete_state_space(...)});
///   pd.join(simulation);
/// Steps end at the samples and where outputs arrive, `delay` later; before the first arrives, inputs hold the values
/// that they were drawn with. Checkpoints hold its memory: a resumed run has the same bits. A run that starts anew
/// starts it anew. Not for several simulations at once.
class SampledController final : public Observer {
 public:
  struct Reading {
    Sensor sensor;
    int column = 0;
  };
  struct Parameters {
    std::string name = "sampled controller";
    double interval = 0;  // T, s
    double delay = 0;     // from a sample to its outputs, s; any
    std::vector<Reading> inputs{};
    std::vector<Input*> outputs{};
    SampledLaw law{};
  };
  /// Throws SceneError for an interval that is not positive, a negative delay, outputs to inputs that do not hold their
  /// value or to one twice, columns that sensors do not have, and a law of other numbers of inputs and outputs.
  explicit SampledController(Parameters parameters);

  const std::string& name() const { return parameters_.name; }
  /// Adds it to the simulation's observers, at its interval.
  void join(Simulation& simulation);
  /// Throws SimulationError, with its name, the time and the sensor or output, for what is not finite.
  void observe(Snapshot& snapshot) override;
  void history(Archive& archive) override;

 private:
  const Parameters parameters_;
  VectorX u_, x_, y_;
  bool begun_ = false;
  double origin_ = 0, time_ = 0;  // of the first sample and the last one, s
};

}  // namespace lithe
