// A hundred thousand steps: constraints stay met, energy stays or decays slowly.
#include <gtest/gtest.h>

#include <array>

#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test::long_run_test {
namespace {

struct Trial {
  Method method;
  double position, velocity, gain, loss;  // bounds: |g|, |G v|, J
};

TEST(HundredThousandSteps, KeepTheConstraintsAndTheEnergy) {
  for (Trial& run : std::array<Trial, 4>{
           Trial{runge_kutta_fixed(5e-3), 1e-12, 1e-12, 1e-8, 1e-6}, Trial{index3(5e-3, 0.8), 1e-11, 1e-3, 1e-4, 1e-2},
           Trial{index3(5e-3, 0.95), 1e-11, 1e-3, 1e-4, 1e-2}, Trial{index2(5e-3, 0.8), 1e-11, 1e-9, 1e-4, 1e-2}}) {
    Scene scene = mass_chain({M_PI / 3, M_PI / 3});
    const double start = scene.energy();
    double position = 0, velocity = 0, gain = 0, loss = 0;
    for (int k = 1; k <= 1000; ++k) {
      scene.run(*run.method, 0.5 * k);
      position = std::max(position, scene.violation(Level::position));
      velocity = std::max(velocity, scene.violation(Level::velocity));
      gain = std::max(gain, scene.energy() - start);
      loss = std::max(loss, start - scene.energy());
    }
    const std::string name = run.method->name() + ", " + std::to_string(run.method->statistics().steps) + " steps";
    expect_below(name + ", |g|", position, run.position);
    expect_below(name + ", |G v|", velocity, run.velocity);
    expect_below(name + ", energy gained (J)", gain, run.gain);
    expect_below(name + ", energy lost (J)", loss, run.loss);
  }
}

}  // namespace
}  // namespace lithe::test::long_run_test
