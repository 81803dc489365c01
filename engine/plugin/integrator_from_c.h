#pragma once

#include <exception>
#include <vector>

#include "engine/motion/integrator.h"
#include "engine/plugin/plugin_type.h"

namespace lithe {

/// An integrator whose class is behind a C table; it sees the equations of motion through another table.
class IntegratorFromC final : public Integrator {
 public:
  /// Throws SceneError: wrong parameters.
  IntegratorFromC(const IntegratorType& type, const ParameterList& parameters);

  std::string name() const override { return object_.description(); }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  /// Both throw SimulationError where the integrator fails, and what the equations threw at it.
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;
  /// The C table has no function for it: the plug-in restarts with its next step.
  void lose_factor() override { begins_anew_ = true; }

 private:
  /// The equations as C sees them; their address is the first argument of its functions.
  struct Border {
    EquationsOfMotion* equations = nullptr;
    VectorX increment, quarter_turns;  // some functions want a vector
    std::exception_ptr trouble;        // what the equations threw, held back until the plug-in has returned
    std::vector<lithe_body_slice> bodies;
    std::vector<lithe_row_slice> rows;
    std::vector<int32_t> redundant, on_velocity;
    lithe_equations table{};

    template <class F>
    static int32_t cross(void* border, F&& f) noexcept;
  };
  void bind(EquationsOfMotion& equations);
  void begin(State& state);
  void finish(int32_t code, const ErrorText& why);

  const lithe_integrator_type table_;
  const PluginObject object_;
  const std::string parameters_;  // as given, for checkpoints
  Border border_;
  IntegratorStatistics statistics_, before_;  // all; until the plug-in last began anew
  bool begins_anew_ = false;
};

}  // namespace lithe
