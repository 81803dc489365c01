// Automatic steps, t_stop, failure.
#include <gtest/gtest.h>

#include <array>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"
#include "integrators/automatic.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/ida.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test::step_control_test {
namespace {

Method automatic_alpha(double tolerance, GeneralizedAlpha::Form form) {
  return std::make_unique<GeneralizedAlpha>(
      GeneralizedAlpha::Parameters{.form = form, .tolerance = {.relative = tolerance, .absolute = tolerance}});
}
Method automatic_index3(double tolerance) { return automatic_alpha(tolerance, GeneralizedAlpha::Form::index3); }
Method automatic_index2(double tolerance) {
  return automatic_alpha(tolerance, GeneralizedAlpha::Form::stabilized_index2);
}

const State& exact_chain() {
  static const State exact = [] {
    Scene scene = box_chain(3, true);
    scene.run(*runge_kutta(1e-13), 0.5);
    return scene.state;
  }();
  return exact;
}

struct Automatic {
  const char* name;
  Method (*make)(double tolerance);
  double from, to, exponent, factor;  // tolerances, ten by ten; bound of the error: factor * pow(tolerance, exponent)
};

TEST(AutomaticStep, MeetsTheTolerance) {
  // The tolerance holds for a step; over a run of many a method of order p errs as tolerance to the p / (p + 1).
  const Automatic methods[] = {{"explicit Runge-Kutta", runge_kutta, 1e-4, 1e-11, 1, 15},
                               {"IDA", ida, 1e-4, 1e-10, 1, 100},
                               {"generalized-alpha, index 3", automatic_index3, 1e-3, 1e-6, 2. / 3, 10},
                               {"generalized-alpha, index 2", automatic_index2, 1e-3, 1e-6, 2. / 3, 10}};
  for (const Automatic& method : methods) {
    double last = 1e300, before = 1e300;
    for (double tolerance = method.from; tolerance > method.to / 2; tolerance /= 10) {
      Scene scene = box_chain(3, true);
      Method integrator = method.make(tolerance);
      scene.run(*integrator, 0.5);
      const double error = (scene.state.q - exact_chain().q).cwiseAbs().maxCoeff();
      const std::string name = std::string(method.name) + ", tolerance " + step_text(tolerance) + " (" +
                               std::to_string(integrator->statistics().steps) + " steps, " +
                               std::to_string(integrator->statistics().rejected) + " rejected)";
      expect_below(name + ", error", error, method.factor * std::pow(tolerance, method.exponent));
      // Which steps a method takes hangs on rounding, and with it a factor of two or three from one tolerance to the
      // next.
      EXPECT_LT(error, 0.3 * before) << name << ": no better than at a hundred times the tolerance";
      before = last, last = error;
    }
  }
}

TEST(StopTime, IsHitExactly) {
  for (Method& method : std::array<Method, 5>{runge_kutta(1e-6), runge_kutta_fixed(3e-3), ida(1e-6), index3(3e-3),
                                              automatic_index2(1e-4)}) {
    Scene scene = box_chain(2, false);
    method->start(scene.equations, scene.state);
    for (double t_stop : {0.1, 0.1 + 1e-7, 1.0 / 3}) {
      while (scene.state.time < t_stop) {
        ASSERT_TRUE(method->step(scene.equations, scene.state, t_stop).ok()) << method->name();
        EXPECT_LE(scene.state.time, t_stop) << method->name();
      }
      EXPECT_EQ(scene.state.time, t_stop) << method->name();
    }
    // Nothing is left to do.
    const VectorX q = scene.state.q;
    EXPECT_TRUE(method->step(scene.equations, scene.state, 1.0 / 3).ok());
    EXPECT_EQ(q, scene.state.q);
  }
}

TEST(StopTime, SplitInTwoGivesTheSameAnswer) {
  struct Split {
    Method (*make)(double);
    double parameter, difference;
  };
  const Split methods[] = {
      {runge_kutta, 1e-9, 1e-8},
      {runge_kutta_fixed, 1e-3, 1e-9},
      {ida, 1e-9, 1e-7},
      {[](double h) { return index3(h); }, 1e-3, 2e-5},
      {[](double h) { return index2(h); }, 1e-3, 2e-5},
      {automatic_index3, 1e-6, 1e-5},
  };
  for (const auto& [make, parameter, difference] : methods) {
    Scene whole = box_chain(3, true), split = box_chain(3, true);
    Method first = make(parameter), second = make(parameter);
    whole.run(*first, 0.5);
    split.run(*second, 0.20337);  // no multiple of the step
    split.run(*second, 0.5);
    expect_below(first->name() + ", t_stop split, q", (whole.state.q - split.state.q).cwiseAbs().maxCoeff(),
                 difference);
    expect_below(first->name() + ", t_stop split, λ (relative)",
                 (whole.state.lambda - split.state.lambda).norm() / whole.state.lambda.norm(), 100 * difference);
  }
}

TEST(StepEnd, IsConsistent) {
  // The state that a step leaves satisfies the equations of motion, up to the method's own error.
  struct End {
    Method method;
    double violation, acceleration;  // |g| and |ġ|; relative
  };
  for (End& end : std::array<End, 3>{End{runge_kutta(1e-6), 1e-11, 1e-10}, End{ida(1e-9), 1e-8, 1e-4},
                                     End{index2(1e-3), 1e-9, 1e-3}}) {
    Scene scene = box_chain(4, true);
    scene.run(*end.method, 0.4);
    const std::string name = end.method->name();
    expect_below(name + ", |g|", scene.violation(Level::position), end.violation);
    expect_below(name + ", |G v|", scene.violation(Level::velocity), end.violation);
    VectorX v_dot = scene.state.v_dot, lambda = scene.state.lambda;
    Projector(scene.equations).accelerations(scene.state.time, scene.state.q, scene.state.v, v_dot, lambda);
    expect_below(name + ", accelerations", (v_dot - scene.state.v_dot).norm() / v_dot.norm(), end.acceleration);
    expect_below(name + ", multipliers", (lambda - scene.state.lambda).norm() / lambda.norm(), end.acceleration);
  }
}

/// Pushes its marker with a force that ends in NaN after a while.
class BrokenForce final : public Force<1, 0> {
 public:
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    rows.add_load(markers[0], force({0, time > 0.1 ? std::nan("") : 1.0, 0}));
  }
};

TEST(Failure, IsAResultThatNamesTheCoordinate) {
  for (Method& method : std::array<Method, 3>{runge_kutta(1e-6), runge_kutta_fixed(1e-2), ida(1e-6)}) {
    Scene scene({0, 0, 0}, [](SystemGraph& graph) {
      auto& body = graph.add<RigidBody>("probe", {.mass = 2});
      graph.add<BrokenForce>("push", {body.marker()});
    });
    method->start(scene.equations, scene.state);
    StepResult result;
    for (int i = 0; i < 10000 && result.ok() && scene.state.time < 1; ++i)
      result = method->step(scene.equations, scene.state, 1);
    EXPECT_FALSE(result.ok()) << method->name();
    EXPECT_LE(scene.state.time, 0.1) << method->name();
    EXPECT_TRUE(scene.state.q.allFinite() && scene.state.v.allFinite()) << method->name();
    const std::string expected = method->name().starts_with("explicit") ? "probe: p_" : "no finite";
    EXPECT_NE(result.why.find(expected), std::string::npos) << result.why;
  }
}

TEST(Parameters, OutOfRangeAreRefused) {
  EXPECT_THROW(ExplicitRungeKutta({.step = -1}), SceneError);
  EXPECT_THROW(ExplicitRungeKutta({.tolerance = {.relative = 0, .absolute = 0}}), SceneError);
  EXPECT_THROW(Ida({.tolerance = {.relative = 1e-6, .absolute = 0}}), SceneError);
  EXPECT_THROW(Ida({.max_order = 6}), SceneError);
  EXPECT_THROW(GeneralizedAlpha({.spectral_radius = 1}), SceneError);
}

}  // namespace
}  // namespace lithe::test::step_control_test
