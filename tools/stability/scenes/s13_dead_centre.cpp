// S13: the slider-crank through its dead centres, R11.
#include <random>

#include "engine/study/study_run.h"
#include "tools/stability/lab.h"
#include "tools/stability/methods/dense_equations.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/mechanisms.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 5, kEnergy = 1e-5, kBranch = 1e-6;  // s, J, m

struct Result {
  double energy = 0, branch = 0;  // J, m
  bool reached = false;
};

Result follow(const SliderCrank::Variant& variant, Integrator& method, double noise = 0) {
  SliderCrank scene(variant);
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  Result result;
  const auto course = scene.run(
      method, kEnd,
      [&] {
        result.branch = std::max(result.branch, scene.branch_error());
        for (int i = 0; noise > 0 && i < scene.state.q.size(); ++i) scene.state.q[i] += noise * normal(generator);
      },
      1e6);
  result.energy = course.energy_error;
  result.reached = course.reached;
  return result;
}

ExplicitIndex1 rk4(double step) {
  return ExplicitIndex1({.step = step, .stabilisation = ExplicitIndex1::Stabilisation::position_velocity});
}

Outcome judge(const Result& r) {
  if (!r.reached) return Outcome::unstable;
  return r.energy < kEnergy && r.branch < kBranch ? Outcome::converged : Outcome::inaccurate;
}

/// The published energies are those of (θ, φ, x) as coordinates; ours are of six a body: the same order, other sizes.
Finding passes(const SliderCrank::Variant& variant, double published_fine, double published_coarse,
               const std::string& why) {
  ExplicitIndex1 fine = rk4(1e-3), coarse = rk4(1e-2);
  const Result at_fine = follow(variant, fine), at_coarse = follow(variant, coarse);
  return {judge(at_fine),
          {{"energy error at h = 1e-3 s, J", at_fine.energy, published_fine, 0},
           {"at 1e-2", at_coarse.energy, published_coarse, 0},
           {"off its branch, m", at_fine.branch}},
          why};
}

/// θ by x: the velocities with ẋ = 1 of the slider, from G v = 0 and that row. At the dead centre there are none.
Finding slider_as_coordinate() {
  const auto solve = [](double before) {
    SliderCrank::Variant variant = SliderCrank::kA;
    const double r = variant.crank, l = variant.rod, x = r + l - before;
    variant.angle = before > 0 ? std::acos((x * x + r * r - l * l) / (2 * x * r)) : 0;
    variant.speed = 0;
    SliderCrank scene(variant);
    scene.equations.evaluate(0, scene.state.q, scene.state.v, Level::velocity);
    scene.equations.factorize({0, 0, 1}, VectorX::Zero(18), VectorX::Zero(20), nullptr);
    const MatrixX G = dense_matrix(scene.equations).block(18, 0, 20, 18);
    MatrixX A(21, 18);
    A << G, Eigen::RowVectorXd::Unit(18, 12);
    return least_norm(A, VectorX::Unit(21, 20), 1e-10);
  };
  const auto slope = [&](double before) { return std::abs(solve(before).x[5]); };
  // Variant A starts in its dead centre: with x given, one of the others is undetermined.
  const int rank = solve(0).rank;
  return {rank < 18 ? Outcome::refused : Outcome::converged,
          {{"slope of the angle 1e-6 m before the dead centre, 1/m", slope(1e-6), 1491, 3},
           {"1e-4 m", slope(1e-4), 149, 3},
           {"1e-2 m", slope(1e-2), 15.2, 3},
           {"rank of 18 at the start", static_cast<double>(rank)}},
          "infinite slope: partitioning must change; the start is refused"};
}

Finding disturbed() {
  ExplicitIndex1 method = rk4(1e-3);
  const Result noisy = follow(SliderCrank::kB, method, 1e-6);
  return {judge(noisy),
          {{"energy error, J", noisy.energy}, {"off its branch, m", noisy.branch}},
          "rank 1 of 2 at 90 deg; our projection keeps the branch, the noise's own work is seen in the energy"};
}

Finding ours(Method a, Method b) {
  const Result first = follow(SliderCrank::kA, *a), second = follow(SliderCrank::kB, *b);
  const bool good = judge(first) == Outcome::converged && judge(second) == Outcome::converged;
  return {good                                 ? Outcome::converged
          : judge(first) == Outcome::converged ? judge(second)
                                               : judge(first),
          {{"energy error of A, J", first.energy},
           {"of B, J", second.energy},
           {"A off its branch, m", first.branch},
           {"B", second.branch}}};
}

const Registered scene{under_every_method(
    {"S13",
     "slider-crank dead centre",
     {{"A: crank angle or all three coordinates, LU",
       [] { return passes(SliderCrank::kA, 3.1e-9, 6.7e-5, "constraint matrix keeps rank 2 for r < l"); }},
      {"A: slider as independent coordinate", slider_as_coordinate},
      {"B (r = l): three coordinates, LU or least squares",
       [] { return passes(SliderCrank::kB, 1.3e-6, 8.4e-2, "the branch is kept because nothing disturbs it"); }},
      {"B with the step falling on 90 deg or noise 1e-6", disturbed},
      {"explicit Runge-Kutta 5(4), 1e-9", [] { return ours(runge_kutta(1e-9), runge_kutta(1e-9)); }, Role::ours}}},
    {1e-9, 1e-3}, [](const std::function<Method()>& make) { return ours(make(), make()); })};

}  // namespace
}  // namespace lithe::lab
