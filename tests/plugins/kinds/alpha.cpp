#include "engine/plugin.h"
#include "integrators/generalized_alpha.h"

using namespace lithe;

/// Lithe's own generalized-alpha as a plug-in: an implicit method, in every function of the equations.
class Alpha final : public Integrator {
 public:
  struct Parameters {
    double step = 0;
  };
  static constexpr Field<Parameters> kParameters[] = {{"step", &Parameters::step}};
  explicit Alpha(Parameters parameters) : method_({.step = parameters.step}) {}

  std::string name() const override { return method_.name(); }
  void prepare(EquationsOfMotion& equations, State& state) override { method_.start(equations, state); }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    return method_.step(equations, state, t_stop);
  }
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override {
    bool kept = false;
    archive.group("method", [&] { kept = method_.history(archive, equations, state); });
    return kept;
  }
  const IntegratorStatistics& statistics() const override { return method_.statistics(); }

 private:
  GeneralizedAlpha method_;
};

LITHE_EXPORT_INTEGRATOR(Alpha, "alpha")
