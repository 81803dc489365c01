// S10: joints drawn in space whose rows repeat each other (R12: 20 of rank 17; R04: 30 of rank 29).
#include "tools/stability/lab.h"
#include "tools/stability/methods/dense_equations.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/mechanisms.h"

namespace lithe::lab {
namespace {

constexpr double kLimit = 1e-6;  // m

using Solver = ExplicitIndex1::Solver;
ExplicitIndex1 rk4(Solver solver, double step, double cut) {
  return ExplicitIndex1(
      {.step = step, .stabilisation = ExplicitIndex1::Stabilisation::position_velocity, .solver = solver, .cut = cut});
}

Finding lu() {
  FourBar scene;
  scene.equations.evaluate(0, scene.state.q, scene.state.v, Level::velocity);
  scene.equations.factorize({0, 0, 1}, VectorX::Zero(18), VectorX::Zero(20), nullptr);
  const MatrixX A = dense_matrix(scene.equations);
  const double rank = least_norm(A.bottomLeftCorner(20, 18), VectorX::Zero(20), 1e-10).rank;
  ExplicitIndex1 method = rk4(Solver::dense_lu, 1e-3, 0);
  const auto course = scene.run(method, 0.1);
  // Going on with an exactly singular matrix would be worse than stopping.
  const Outcome outcome = course.reached ? judged(course.energy_error, kLimit) : Outcome::refused;
  return {outcome,
          // The published condition, 4.6e18, is one over round-off.
          {{"rank of 20 rows", rank, 17, 2}, {"condition of the KKT matrix", condition(A)}},
          course.why};
}

/// Positions at the end of both mechanisms against the tables.
Finding motion(Integrator& four_bar, Integrator& bricard, const std::string& why) {
  FourBar r12;
  Bricard r04;
  const auto first = r12.run(four_bar, 5), second = r04.run(bricard, 10);
  const double B = first.reached ? (r12.B() - FourBar::B_after_5_s()).norm() : NAN;
  const double P3 = second.reached ? (r04.P3() - Bricard::P3_after_10_s()).norm() : NAN;
  return {judged(std::isnan(B) || std::isnan(P3) ? NAN : std::max(B, P3), kLimit),
          {{"R12: B at 5 s, m", B},
           {"R04: P3 at 10 s, m", P3},
           {"energy error of R12, J", first.energy_error},
           {"of R04, J", second.energy_error}},
          why};
}

Finding once_a_step() {
  ExplicitIndex1 four_bar = rk4(Solver::rows_once_a_step, 1e-3, 1e-9),
                 bricard = rk4(Solver::rows_once_a_step, 2.5e-3, 1e-9);
  return motion(four_bar, bricard, "motion is unique, reactions are not");
}

/// [M Gᵀ; G -ε]: error of the accelerations of R12 at the start: the largest of m/s² and rad/s²; in which norm
/// the published 5.9 ε is, is not told.
Finding regularised() {
  FourBar scene;
  const auto accelerations = [&](Solver solver, double cut) {
    ExplicitIndex1 method = rk4(solver, 1e-3, cut);
    method.start(scene.equations, scene.state);
    return VectorX(scene.state.v_dot);
  };
  const VectorX exact = accelerations(Solver::engine, 0);
  const auto error = [&](double eps) {
    return (accelerations(Solver::regularised, eps) - exact).lpNorm<Eigen::Infinity>();
  };
  return {judged(error(1e-9), kLimit),
          {{"error of accelerations, eps = 1e-9, m/s²", error(1e-9), 5.9e-9, 0},
           {"1e-6", error(1e-6), 5.9e-6, 0},
           {"relative to the largest, 1e-9", error(1e-9) / exact.lpNorm<Eigen::Infinity>()}},
          "compliance in the joints; eps 1e-9 is harmless"};
}

/// The rank of R04 decided where the stages are: off the constraints no row is exactly dependent.
Finding every_stage() {
  constexpr double kEnd = 1, kEnergy = 0.01, kCut = 1e-6;  // s, J, of the largest pivot
  const auto holds = [&](Solver solver, double step) {
    Bricard scene;
    ExplicitIndex1 method = rk4(solver, step, kCut);
    const auto course = scene.run(method, kEnd, {}, kEnergy);
    return course.reached;
  };
  const auto limit = [&](Solver solver) {
    return largest_stable_step([&](double step) { return holds(solver, step); }, 5e-4, 0.1, 0.05);
  };
  const double once = limit(Solver::rows_once_a_step), every = limit(Solver::rows_every_stage);
  // The step collapses: less than a tenth of what the mechanism allows.
  return {
      every < 0.1 * once ? Outcome::unstable : Outcome::converged,
      {{"largest step with an energy error below 0.01 J, s", every, 2e-3, 0}, {"rank once a step, s", once, 5e-2, 0}},
      "the 30th pivot is not zero off the constraints: garbage multipliers",
      every > 0 ? every : NAN};
}

const Registered scene{
    under_every_method({"S10",
                        "redundant rows",
                        {{"LU of the KKT matrix", lu},
                         {"minimum norm or rank-revealing QR once per step", once_a_step},
                         {"diagonal -eps in the multiplier block", regularised},
                         {"rank decided at every stage off the manifold", every_stage},
                         {"explicit Runge-Kutta 5(4), 1e-9",
                          [] { return motion(*runge_kutta(1e-9), *runge_kutta(1e-9), ""); }, Role::ours}}},
                       {1e-9, 1e-3}, [](const std::function<Method()>& make) { return motion(*make(), *make(), ""); })};

}  // namespace
}  // namespace lithe::lab
