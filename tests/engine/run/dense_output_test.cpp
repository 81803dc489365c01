#include <gtest/gtest.h>

#include <cmath>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "engine/motion/integrator.h"
#include "tests/bodies/bar_model.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test::dense_output_test {

namespace {

/// Errors of the dense output of one long step between exact ends.
struct Errors {
  double q = 0, v = 0, v_dot = 0;
};

/// The motion that `make` draws, from time 0 in one step of h with the ends of an accurate run.
template <class Make>
Errors errors_of_dense_output(Make&& make, double h) {
  const auto state_at = [&](double t) {
    Scene scene = make();
    const Method method = runge_kutta(1e-13);
    method->start(scene.equations, scene.state);
    while (scene.state.time < t) {
      const StepResult result = method->step(scene.equations, scene.state, t);
      EXPECT_TRUE(result.ok()) << result.why;
    }
    return scene.state;
  };
  const Scene scene = make();
  const Layout& layout = scene.system.layout();
  const State from = state_at(0), to = state_at(h);
  const Method method = runge_kutta(1e-6);
  Errors worst;
  State out;
  for (double s : {0.2, 0.5, 0.7}) {
    method->interpolate(layout, from, to, s * h, out);
    const State exact = state_at(s * h);
    EXPECT_EQ(out.time, s * h);
    VectorX d(layout.v_count());
    layout.difference(exact.q, out.q, d);
    worst.q = std::max(worst.q, d.cwiseAbs().maxCoeff());
    worst.v = std::max(worst.v, (out.v - exact.v).cwiseAbs().maxCoeff());
    worst.v_dot = std::max(worst.v_dot, (out.v_dot - exact.v_dot).cwiseAbs().maxCoeff());
  }
  return worst;
}

template <class Make>
void expect_orders(const std::string& what, Make&& make, double h) {
  const Errors coarse = errors_of_dense_output(make, h), fine = errors_of_dense_output(make, h / 2);
  EXPECT_NEAR(std::log2(coarse.q / fine.q), 6, 0.4) << what << ": q " << coarse.q << " " << fine.q;
  EXPECT_NEAR(std::log2(coarse.v / fine.v), 5, 0.4) << what << ": v " << coarse.v << " " << fine.v;
  EXPECT_NEAR(std::log2(coarse.v_dot / fine.v_dot), 4, 0.4) << what << ": v_dot " << coarse.v_dot << " " << fine.v_dot;
}

}  // namespace

TEST(dense_output, of_a_tumbling_body_has_order_6_in_angles_5_in_speeds_4_in_accelerations) {
  expect_orders(
      "tumbling",
      [] {
        return free_body({1, 2, 2.5}, {3, 1, -2});
      },
      0.2);
}

TEST(dense_output, of_a_top_on_its_tip_has_the_same_orders) {
  expect_orders(
      "top",
      [] {
        return heavy_top(2, 0.4, 0.3, 0.1, {0.5, 12, 1});
      },
      0.1);
}

TEST(dense_output, of_an_elastic_bar_that_tumbles_has_the_same_orders) {
  const FiniteElementModel model =
      bar_model({.size = {0.3, 0.04, 0.03}, .bricks = {4, 1, 1}, .young = 3e6, .density = 1000});
  const auto basis = make_basis(model, ThreeNodeFrame{model.node_set("start")[0], model.node_set("end")[0], 2}, 4);
  FlexibleBody::Parameters bar{.basis = basis};
  bar.angular_velocity = {8, 5, -6};
  bar.modal_coordinates = 1e-3 * VectorX::LinSpaced(4, 1, -0.5);
  const auto make = [&] { return Scene({0, 0, 0}, [&](SystemGraph& graph) { graph.add<FlexibleBody>("bar", bar); }); };
  expect_orders("bar", make, 2e-3);
}

TEST(dense_output, meets_both_ends) {
  Scene scene = heavy_top(2, 0.4, 0.3, 0.1, {0.5, 12, 1});
  const Method method = runge_kutta(1e-6);
  method->start(scene.equations, scene.state);
  const State from = scene.state;
  ASSERT_TRUE(method->step(scene.equations, scene.state, 1).ok());
  State out;
  for (const State* end : {&from, static_cast<const State*>(&scene.state)}) {
    method->interpolate(scene.system.layout(), from, scene.state, end->time, out);
    EXPECT_LT((out.q - end->q).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((out.v - end->v).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((out.v_dot - end->v_dot).cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_LT((out.lambda - end->lambda).cwiseAbs().maxCoeff(), 1e-12);
  }
}

/// A steady spin of 1.6 π in one step: the short way between the ends would go backwards.
TEST(dense_output, follows_the_motion_beyond_half_a_turn) {
  Scene scene = free_body({1, 1, 1}, {0, 0, 1.6 * M_PI});
  const Method method = runge_kutta_fixed(1);
  method->start(scene.equations, scene.state);
  const State from = scene.state;
  State to = from, out;
  to.time = 1;
  to.q.segment<4>(3) = rotated(from.q.segment<4>(3), {0, 0, 1.6 * M_PI});
  method->interpolate(scene.system.layout(), from, to, 0.5, out);
  EXPECT_NEAR(out.q[3], std::cos(0.4 * M_PI), 1e-12);  // half the angle of 0.8 π
  EXPECT_NEAR(out.q[6], std::sin(0.4 * M_PI), 1e-12);
  EXPECT_NEAR(out.v[5], 1.6 * M_PI, 1e-12);
}

TEST(dense_output, the_component_with_the_largest_share_limits) {
  const Tolerance tolerance{.relative = 1e-3, .absolute = 1e-6};
  VectorX error(3), size(3);
  error << 1e-3, 2e-5, -1e-4;
  size << 100, 1e-3, 1;
  EXPECT_EQ(largest_share(error, size, tolerance), 1);  // shares 0.01, 10, 0.1
  error[2] = -1;
  EXPECT_EQ(largest_share(error, size, tolerance), 2);
  error[0] = std::nan("");
  EXPECT_EQ(largest_share(error, size, tolerance), 0);
  EXPECT_EQ(largest_share(VectorX(), VectorX(), tolerance), -1);
}

}  // namespace lithe::test::dense_output_test
