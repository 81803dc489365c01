#pragma once

#include <limits>
#include <mutex>
#include <optional>

#include "engine/base/math.h"
#include "models/fmu/exchange_model_internal.h"
#include "models/fmu/fmu_file_internal.h"

namespace lithe {

/// The equations of an FMU for model exchange as the elements of a scene evaluate them, at any state and in any order,
/// and its discrete state between events:
///   ż = f(t, z, u),  y = g(t, z, u)
/// Until a run begins the instance follows the first state: it is initialized there, with the inputs of that state.
/// From then on its discrete state is that since the last event, and what lies before is refused. All but the constant
/// functions are called under lock().
class ExchangeEquations {
 public:
  struct Parameters {
    std::vector<std::pair<std::string, double>> values{};  // of parameters and inputs, at the start
    ExchangeModel::Connected connected{};
    VectorX inputs{};            // u at the start
    int output_count = 0;        // numbers of y
    bool differentiable = true;  // directional derivatives of all of (f, g) may be asked for
  };
  /// Makes an instance and initializes it at t = 0. Throws as FmuFile::make_instance(), and SimulationError where the
  /// FMU refuses its values.
  ExchangeEquations(std::unique_ptr<const FmuFile> file, Parameters parameters);

  const FmuFile& file() const { return *file_; }
  int state_count() const { return file_->contents().state_count; }
  int input_count() const { return static_cast<int>(p_.inputs.size()); }
  /// z of the first initialization.
  const VectorX& initial_states() const { return initial_states_; }

  std::unique_lock<std::mutex> lock() { return std::unique_lock(guard_); }
  /// Where it is evaluated next; to be filled in place.
  VectorX z, u;
  /// (f, g) at (t, z, u); NaN where the FMU discards the point.
  const VectorX& rates(double time);
  const VectorX& indicators(double time);
  double value(double time, const std::string& name, const FmuNumber& number);
  /// ∂(f, g)/∂(z, u), by the FMU's directional derivatives, else by central differences.
  const MatrixX& jacobian(double time);

  // ---- the run ----
  void join() { joined_ = true; }  // somebody looks for events
  void reset();
  /// At the first state (t, z, u) of a run, and after each step: an event may be asked for, at once.
  void see(double time);
  /// At an event; z changes where the FMU says so. Nothing where this time's has been handled.
  void handle_event(double time);
  /// Passes from above to below zero at the next time event.
  double until_time_event(double time) const;
  void history(Archive& archive);
  /// Another instance, in the discrete state of the scene's beginning, is evaluated; or that of the run again.
  void set_as_drawn(bool drawn);

 private:
  template <class Work>
  decltype(auto) guarded(double time, Work&& work);
  void initialize(double time);
  bool settle(ExchangeModel::Event event, double time);
  void prepare(double time);
  bool move_to(double time);
  const VectorX& rates_at(double time);

  const std::unique_ptr<const FmuFile> file_;
  const Parameters p_;
  std::mutex guard_;
  VectorX initial_states_;
  bool joined_ = false;
  /// An instance and where its run is.
  struct Run {
    std::unique_ptr<FmuLibrary> library;   // null: to be made, or after a failure
    std::unique_ptr<ExchangeModel> model;  // of the library
    bool begun = false;
    double since = 0;  // of the discrete state, s: the initialization or the last event
    double seen = 0;   // the last state of the run, s
    std::optional<double> next;
    VectorX first_u;
  };
  Run run_;
  std::optional<Run> kept_;  // the run, while another instance is as drawn
  // The point that the FMU stands at, and what has been asked of it there.
  double at_time_ = std::numeric_limits<double>::quiet_NaN();
  VectorX at_z_, at_u_;
  bool accepted_ = false, has_rates_ = false, has_indicators_ = false;
  VectorX rates_, indicators_, seed_, plus_;
  MatrixX jacobian_;
};

}  // namespace lithe
