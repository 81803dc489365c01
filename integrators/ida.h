#pragma once

#include <memory>

#include "engine/motion/integrator.h"

namespace lithe {

/// Variable-order, variable-step BDF of SUNDIALS (IDA; Hindmarsh et al. 2005) on the stabilized index-2 form
/// (stabilized_index2.h), linear systems by KLU. An independent code to compare with, and the choice for scenes with
/// much damping; λ and μ are left out of the error test.
class Ida final : public Integrator {
 public:
  struct Parameters {
    Tolerance tolerance{};
    double first_step = 0;  // s; 0: guessed
    double max_step = 0;    // s; 0: none
    int max_order = 5;      // 1 to 5; above 2 fast undamped oscillations may grow
  };

  /// Throws SceneError for a negative step or tolerance, or an order that there is not.
  explicit Ida(Parameters parameters);
  ~Ida() override;

  std::string name() const override { return "SUNDIALS IDA, stabilized index 2"; }
  /// Also moves the state onto the constraints: IDA needs a consistent start.
  const IntegratorStatistics& statistics() const override { return statistics_; }
  bool approximates_accelerations() const override { return true; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;

 private:
  struct Memory;  // all that SUNDIALS owns
  StepResult failed(int flag) const;
  void count();

  Parameters parameters_;
  IntegratorStatistics statistics_, before_;  // in all; until IDA last began anew
  std::unique_ptr<Memory> memory_;
};

}  // namespace lithe
