#pragma once

#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "engine/archive/archive.h"
#include "engine/assembly/evaluator.h"
#include "engine/gradient/event_derivative.h"
#include "engine/motion/step_derivative.h"

namespace lithe {

/// The states of one run between its steps, to be gone through forwards or backwards. As many as memory allows are
/// kept; else checkpoints at equal numbers of steps, from which stretches are run again: with the same bits, since a
/// checkpoint holds the integrator's history. The run itself is that of Simulation, step by step; a step that passes an
/// event or a kink of a force law is taken again to end there. One that its method cuts in two counts as one, likewise
/// the steps to a kink and on from there.
class RecordedRun {
 public:
  using Look = std::function<void(const State&)>;
  /// Runs; `look` is told of the first state and of each step's end. Throws SceneError where the method or a step
  /// cannot be differentiated, SimulationError where the run fails.
  RecordedRun(const ParametricScene& scene, const Drawing& drawing, std::size_t memory, const Look& look);
  ~RecordedRun();

  /// Of the states; twice where an event changes the state.
  const std::vector<double>& times() const { return times_; }
  /// The number of the event that led to this state from the one before; -1: a step did.
  int event_before(long state) const;
  long steps() const { return static_cast<long>(times_.size()) - 1; }
  /// Null: forwards by repeated steps alone.
  StepDerivative* derivative() { return derivative_.get(); }
  /// Whether some step's derivative is to be found by taking it again, forwards.
  bool repeats() const { return repeats_; }
  bool passes_kinks() const { return !kinks_.empty(); }
  const DifferentiableSteps& method() const { return *method_; }
  std::string method_name() const { return integrator_->name(); }
  std::size_t bytes() const { return bytes_; }  // of the tape, at most
  double seconds() const { return seconds_; }   // CPU of the run alone
  int checkpoints() const { return static_cast<int>(checkpoints_.size()); }
  const std::vector<State>& probes() const { return probes_; }      // a few states from begin to end
  const std::vector<State>& touching() const { return touching_; }  // the first at which contacts remember something
  Eigen::Index memory_at_end() const { return memory_at_end_; }     // numbers that contacts remember there

  /// The stretches in order: states first() … first() + size - 1; neighbours share one state.
  int stretch_count() const;
  long first(int stretch) const;
  struct Taken {
    State state;
    std::shared_ptr<const StepRecord> record;  // of the step that led there
    std::vector<PassedKink> kinks;             // in it
  };
  const std::vector<Taken>& stretch(int number);

 private:
  struct Checkpoint {
    State state;
    Archive history;
  };
  void refuse_contacts();
  void find_probes();
  void keep(const State& state, long step);
  void record(const State& state, double stop);
  void add(const State& state, long step, const Integrator& integrator);
  void thin();
  void advance(Integrator& integrator, Evaluator& equations, State& state, double stop) const;
  void jump(int event, Integrator& integrator, Evaluator& equations, State& state) const;

  const ParametricScene& scene_;
  const Drawing& drawing_;
  Evaluator equations_;
  std::unique_ptr<Integrator> integrator_;
  const DifferentiableSteps* method_ = nullptr;
  std::unique_ptr<StepDerivative> derivative_;
  bool repeats_ = false;
  std::size_t memory_, state_bytes_ = 0, states_bytes_ = 0, checkpoint_bytes_ = 0, bytes_ = 0;
  double seconds_ = 0;
  long stride_ = 32;
  bool all_ = true;            // states_ are all of the run
  std::vector<Taken> states_;  // of the run, or of the stretch that was run again last
  int present_ = -1;
  std::vector<double> times_;
  std::vector<double> stops_;                      // s: what each step was not to pass
  std::map<long, int> events_;                     // by the number of the state that they led to
  std::map<long, std::vector<PassedKink>> kinks_;  // likewise
  std::vector<Checkpoint> checkpoints_;            // of every stride_-th step
  std::vector<State> probes_, touching_;
  Eigen::Index memory_at_end_ = 0;
};

}  // namespace lithe
