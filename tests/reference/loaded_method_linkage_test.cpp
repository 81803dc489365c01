// A parallelogram passes the pose where it lies flat with methods behind a C table as with those of the library: the
// host crosses it and the plug-in begins anew.
#include <gtest/gtest.h>

#include "engine/plugin.h"
#include "engine/plugin/registry.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"
#include "tests/reference/linkages.h"

namespace lithe::test::loaded_method_linkage_test {
namespace {

constexpr double kTolerance = 1e-11;

/// A method of the library, as a plug-in has it.
template <class Method>
class Guest final : public Integrator {
 public:
  struct Parameters {
    double tolerance = 0;
  };
  static constexpr Field<Parameters> kParameters[] = {{"tolerance", &Parameters::tolerance}};
  explicit Guest(Parameters parameters) : method_({.tolerance = {parameters.tolerance, parameters.tolerance}}) {}
  std::string name() const override { return method_.name(); }
  const IntegratorStatistics& statistics() const override { return method_.statistics(); }
  void prepare(EquationsOfMotion& equations, State& state) override { method_.start(equations, state); }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    return method_.step(equations, state, t_stop);
  }

 private:
  Method method_;
};

struct Passage {
  int passed = 0;
  double energy = 0, parallel = 0, gap = 0;  // largest change, J; of the uprights' middles, m; |g|
  long steps = 0;
};

Passage run(const std::string& guest) {
  Registry registry;
  registry.add<Guest<LieBdf>>("bdf");
  registry.add<Guest<Radau>>("radau");
  const auto method = registry.integrator(guest, {{"tolerance", kTolerance}});
  const Linkage linkage = parallelogram();
  Scene scene = draw(linkage, all_drawings(linkage).front(), Matrix3::Identity(), start_velocities(linkage));
  const double energy = scene.energy();
  const Vector3 across = scene.position(2) - scene.position(0);
  method->start(scene.equations, scene.state);
  Passage out;
  long last = 0;
  while (scene.state.time < linkage.duration) {
    const StepResult step = method->step(scene.equations, scene.state, linkage.duration);
    EXPECT_TRUE(step.ok()) << step.why;
    if (!step.ok()) break;
    out.passed += step.why.find("lose rank") != std::string::npos;
    out.energy = std::max(out.energy, std::abs(scene.energy() - energy));
    out.parallel = std::max(out.parallel, (scene.position(2) - scene.position(0) - across).norm());
    out.gap = std::max(out.gap, scene.violation(Level::position));
    EXPECT_GE(method->statistics().steps, last);  // counts go on where the plug-in begins anew
    last = method->statistics().steps;
  }
  out.steps = last;
  return out;
}

class LoadedMethod : public testing::TestWithParam<const char*> {};

TEST_P(LoadedMethod, IsTakenAcrossThePosesWhereAParallelogramLiesFlat) {
  const Passage found = run(GetParam());
  EXPECT_GE(found.passed, 1);
  EXPECT_GT(found.steps, 100);
  EXPECT_LT(found.energy, 1e-4);
  EXPECT_LT(found.parallel, 1e-6);  // uprights that part lie on the other branch, decimetres away
  EXPECT_LT(found.gap, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Linkages, LoadedMethod, testing::Values("bdf", "radau"),
                         [](const auto& at) { return std::string(at.param); });

}  // namespace
}  // namespace lithe::test::loaded_method_linkage_test
