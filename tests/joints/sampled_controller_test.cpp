// Sampled controllers: against exact recursions from sample to sample, and their limit of stability.
#include "joints/control/sampled_controller.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "engine/archive/archive.h"
#include "engine/run/simulation.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/prismatic_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/message_of.h"

namespace lithe::test::sampled_controller_test {
namespace {

constexpr double kMass = 2, kStart = 0.3;

SampledLaw pd_law(double stiffness, double damping) {
  return discrete_state_space(MatrixX(0, 0), MatrixX(0, 2), MatrixX(1, 0), -Eigen::RowVector2d(stiffness, damping));
}

/// A mass on a slide, pushed by a sampled controller of its place and speed.
struct Slide {
  Slide(SampledLaw law, double interval, double delay, Method with)
      : block(graph.add<RigidBody>("block", {.mass = kMass, .position = {0, 0, kStart}})),
        slide(graph.add<PrismaticJoint>("slide", {graph.ground().marker(), block.marker()})),
        push(graph.add<Input>("push", {.unit = "N"})),
        motor(graph.add<CoordinateMotor>("motor", {slide.displacement()}, {.effort = push})),
        method(std::move(with)),
        controller({.name = "pd",
                    .interval = interval,
                    .delay = delay,
                    .inputs = {{coordinate(slide.displacement(), "x")}, {coordinate_rate(slide.displacement(), "v")}},
                    .outputs = {&push},
                    .law = std::move(law)}) {
    controller.join(simulation);
  }
  double place() const { return state.q[2]; }

  SystemGraph graph{{.gravity = Vector3::Zero()}};
  RigidBody& block;
  PrismaticJoint& slide;
  Input& push;
  CoordinateMotor& motor;
  Method method;
  System system = assemble(graph);
  Simulation simulation{system, *method};
  State state = system.initial_state();
  SampledController controller;
};

/// The same by hand: force constant from arrival to arrival.
class ByHand {
 public:
  double x = kStart, v = 0;
  void run(double stiffness, double damping, double interval, double delay, int samples) {
    std::vector<std::pair<double, double>> forces = {{0, 0}};  // from when
    double now = 0, force = 0;
    const auto move = [&](double to) {
      const double h = to - now;
      x += h * v + h * h / 2 * force / kMass, v += h * force / kMass, now = to;
    };
    std::size_t next = 1;
    for (int k = 0; k < samples; ++k) {
      forces.push_back({interval * k + delay, -stiffness * x - damping * v});
      while (next < forces.size() && forces[next].first < interval * (k + 1) - 1e-12) {
        move(forces[next].first);
        force = forces[next++].second;
      }
      move(interval * (k + 1));
    }
  }
};

TEST(SampledController, MovesAMassAsItsRecursionSays) {
  const double k = 40, d = 9, T = 0.05;
  for (auto* make : {+[] { return runge_kutta(1e-9); }, +[] { return radau(1e-9); }, +[] { return automatic(1e-9); },
                     +[] { return bdf(1e-9); }, +[] { return index2(1e-3); }})
    for (const double delay : {0.0, 0.02, 0.05, 0.13}) {
      Slide slide(pd_law(k, d), T, delay, make());
      slide.simulation.run(slide.state, 0.4);
      slide.simulation.run(slide.state, 20 * T);
      ByHand by_hand;
      by_hand.run(k, d, T, delay, 20);
      EXPECT_NEAR(slide.place(), by_hand.x, 1e-6) << slide.method->name() << ", delay " << delay;
    }
}

/// z² + a z + b of the mass under sampled PD, m = 1: a = k T²/2 + d T - 2, b = 1 + k T²/2 - d T. Stable within
/// k T < 2 d and d T < 2 (Jury).
TEST(SampledController, GrowsBeyondTheLimitOfItsPolynomial) {
  const double T = 0.1, d = 3;
  for (const auto& [relative, limit] : {std::pair(0.95, 2 * d / T), {1.05, 2 * d / T}}) {
    const double k = relative * limit, a = k * T * T / 2 + d * T - 2, b = 1 + k * T * T / 2 - d * T;
    const std::complex<double> root = std::sqrt(std::complex<double>(a * a / 4 - b));
    const double radius = std::max(std::abs(-a / 2 + root), std::abs(-a / 2 - root));
    EXPECT_EQ(radius > 1, relative > 1);
    Slide slide(pd_law(kMass * k, kMass * d), T, 0, radau(1e-9));
    const auto size = [&] {  // the quadratic form that a pair of complex roots b scales by |z|² a sample
      return std::hypot(slide.place(), slide.state.v[2] / std::sqrt(k));
    };
    double first = 0, last = 0;
    for (int i = 0; i < 40; ++i)
      slide.simulation.run(slide.state, T * (i + 1)), first = std::max(first, i < 20 ? size() : 0);
    for (int i = 40; i < 80; ++i)
      slide.simulation.run(slide.state, T * (i + 1)), last = std::max(last, i < 60 ? size() : 0);
    EXPECT_NEAR(std::log(last / first) / 40, std::log(radius), 0.02 * std::abs(std::log(radius)) + 1e-3);
  }
}

TEST(SampledController, FiltersAsItsDifferenceEquation) {
  const std::vector<double> b = {0.2, 0.5, -0.1}, a = {2, -1.2, 0.5};
  const SampledLaw law = difference_equation(b, a);
  VectorX x = law.start, u(1), y(1);
  std::vector<double> us, ys;
  for (int k = 0; k < 12; ++k) {
    us.push_back(u[0] = std::sin(1.3 * k) + 0.2 * k);
    law.step(0, u, x, y);
    double expected = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if (k < static_cast<int>(i)) continue;
      expected += b[i] * us[static_cast<std::size_t>(k) - i];
      if (i > 0) expected -= a[i] * ys[static_cast<std::size_t>(k) - i];
    }
    ys.push_back(expected / a[0]);
    EXPECT_NEAR(y[0], ys.back(), 1e-13) << k;
  }
}

TEST(SampledController, ResumesWithTheSameBits) {
  const auto law = [] {
    MatrixX A(1, 1), B(1, 2), C(1, 1), D(1, 2);
    A << 0.9;
    B << 0.1, 0;
    C << -5;
    D << -30, -8;
    return discrete_state_space(A, B, C, D);
  };
  for (const double delay : {0.0, 0.03, 0.07}) {
    Slide whole(law(), 0.05, delay, radau(1e-8)), begins(law(), 0.05, delay, radau(1e-8)),
        goes_on(law(), 0.05, delay, radau(1e-8));
    whole.simulation.run(whole.state, 0.52), whole.simulation.run(whole.state, 1.2);
    begins.simulation.run(begins.state, 0.52);
    Archive archive;
    begins.simulation.save(begins.state, archive);
    archive.rewind();
    goes_on.state = goes_on.simulation.resume(archive);
    goes_on.simulation.run(goes_on.state, 1.2);
    EXPECT_EQ(goes_on.state.q, whole.state.q) << delay;
    EXPECT_EQ(goes_on.state.v, whole.state.v) << delay;
  }
}

TEST(SampledController, StartsAnewWithARunFromTheStart) {
  Slide slide(pd_law(40, 9), 0.05, 0.02, radau(1e-9));
  slide.simulation.run(slide.state, 0.7);
  const double first = slide.place();
  slide.state = slide.system.initial_state();
  slide.simulation.run(slide.state, 0.7);
  EXPECT_EQ(slide.place(), first);
}

TEST(SampledController, SaysWhatIsWrongAndHowToFixIt) {
  const auto refused = [](SampledLaw law, double interval, double delay) {
    return message_of<SceneError>([&] { Slide(std::move(law), interval, delay, radau(1e-6)); });
  };
  expect_says(refused(pd_law(1, 1), 0, 0), {"'pd'", "interval is 0 s", "above 0"});
  expect_says(refused(pd_law(1, 1), 0.1, -1), {"delay is -1 s"});
  expect_says(refused(difference_equation({1}, {1}), 0.1, 0), {"1 inputs and 1 outputs", "given 2 and 1"});
  expect_says(message_of<SceneError>([] {
                difference_equation({1}, {1, -1.25});
              }),
              {"unstable", "magnitude 1.25", "within the unit circle"});
  EXPECT_NO_THROW(difference_equation({1}, {1, -1}));  // an integrator
  expect_says(message_of<SceneError>([] {
                discrete_state_space(MatrixX::Zero(2, 2), MatrixX::Zero(2, 1), MatrixX::Zero(1, 3),
                                     MatrixX::Zero(1, 1));
              }),
              {"C 1 x 3", "do not fit"});
  SampledLaw broken{.inputs = 2, .outputs = 1, .step = [](double t, const VectorX&, VectorX&, VectorX& y) {
                      y.setConstant(1, t < 0.25 ? 1 : std::nan(""));
                    }};
  Slide slide(broken, 0.1, 0, radau(1e-6));
  expect_says(message_of<SimulationError>([&] { slide.simulation.run(slide.state, 1); }),
              {"the output to 'push' is nan", "'pd', t = 0.3"});
}

}  // namespace
}  // namespace lithe::test::sampled_controller_test
