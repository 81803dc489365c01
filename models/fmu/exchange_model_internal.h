#pragma once

#include <optional>
#include <span>
#include <vector>

#include "models/fmu/fmu_library_internal.h"

namespace lithe {

/// The equations of an instance for model exchange, by either version of the standard:
///   ż = f(t, z, u),  y = g(t, z, u),  events where indicators change sign and at times that it names.
/// Errors as of FmuLibrary.
class ExchangeModel {
 public:
  /// Variables of type Float64 that are set and read at each point, arrays as a whole.
  struct Connected {
    std::vector<unsigned> inputs, outputs;  // value references
  };
  ExchangeModel(FmuLibrary& library, const FmuContents& contents, Connected connected);

  struct Event {
    bool states_changed = false;
    std::optional<double> next{};  // s, of the next time event
  };
  /// From initialization into continuous time.
  Event begin();
  /// An event at the point moved to last.
  Event handle_event();
  /// After a step of the integrator to the point moved to last; true: an event is to follow at once.
  bool complete_step();

  /// The functions of a point return false where the unit discards it.
  bool set_inputs(std::span<const double> inputs);
  void set_time(double time) { library_.call(set_time_, time); }
  bool move_to(double time, std::span<const double> states, std::span<const double> inputs);
  bool get_derivatives(std::span<double> out) { return library_.try_call(derivatives_, out.data(), out.size()); }
  bool get_outputs(std::span<double> out);
  bool get_indicators(std::span<double> out) { return library_.try_call(indicators_, out.data(), out.size()); }
  void get_states(std::span<double> out) { library_.call(states_, out.data(), out.size()); }
  /// Directional derivative of (f, g) along (z, u) = `seed`.
  void differentiate(std::span<const double> seed, std::span<double> out);

 private:
  struct EventInfo2 {
    int again, terminate, nominals_changed, states_changed, has_next;
    double next;
  };
  using References = const unsigned*;

  FmuLibrary& library_;
  const bool two_;
  const Connected connected_;
  std::vector<unsigned> knowns_, unknowns_;
  FmuFunction<> enter_event_mode_, enter_continuous_time_;
  FmuFunction<double> set_time_;
  FmuFunction<const double*, std::size_t> set_states_;
  FmuFunction<double*, std::size_t> states_, derivatives_, indicators_;
  // Where the versions differ.
  FmuFunction<EventInfo2*> update2_{"fmi2NewDiscreteStates"};
  FmuFunction<bool*, bool*, bool*, bool*, bool*, double*> update3_{"fmi3UpdateDiscreteStates"};
  FmuFunction<int, int*, int*> complete2_{"fmi2CompletedIntegratorStep"};
  FmuFunction<bool, bool*, bool*> complete3_{"fmi3CompletedIntegratorStep"};
  FmuFunction<References, std::size_t, const double*> set2_{"fmi2SetReal"};
  FmuFunction<References, std::size_t, const double*, std::size_t> set3_{"fmi3SetFloat64"};
  FmuFunction<References, std::size_t, double*> get2_{"fmi2GetReal"};
  FmuFunction<References, std::size_t, double*, std::size_t> get3_{"fmi3GetFloat64"};
  FmuFunction<References, std::size_t, References, std::size_t, const double*, double*> differentiate2_{
      "fmi2GetDirectionalDerivative"};
  FmuFunction<References, std::size_t, References, std::size_t, const double*, std::size_t, double*, std::size_t>
      differentiate3_{"fmi3GetDirectionalDerivative"};
};

}  // namespace lithe
