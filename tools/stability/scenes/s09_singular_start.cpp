// S09: two windows released at rest exactly horizontal: several accelerations are possible.
#include "tools/stability/lab.h"
#include "tools/stability/methods/dense_equations.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/natural_rods.h"

namespace lithe::lab {
namespace {

constexpr NaturalRods::Parameters kHorizontal{.angle = M_PI / 2, .speed = 0};

/// Runs a tenth of a second. A method that goes on without a word is right only if it begins and stays on the motion
/// that keeps all windows parallelograms: the accelerations of all joints alike, -κ L.
Finding release(Integrator& method, const std::string& why) {
  Windows scene(kHorizontal);
  scene.equations.evaluate(0, scene.state.q, scene.state.v, Level::velocity);
  scene.equations.factorize({0, 0, 1}, VectorX::Zero(6), VectorX::Zero(5), nullptr);
  const MatrixX A = dense_matrix(scene.equations);
  const double rank = least_norm(A.bottomLeftCorner(5, 6), VectorX::Zero(5), 1e-12).rank;
  double spread = 0, residual = 0;
  method.start(scene.equations, scene.state);
  const double stiffness = parallelogram_stiffness(kHorizontal);
  for (int i = 0; i < 3; ++i) spread = std::max(spread, std::abs(scene.state.v_dot[2 * i + 1] / stiffness + 1));
  const auto course =
      scene.go_on(method, 0.1, [&] { residual = std::max(residual, scene.violation(Level::position)); });
  const double off = std::abs(scene.angle(0) - parallelogram_angle(kHorizontal, scene.state.time));
  const Outcome outcome = course.reached ? judged(std::max({spread, off, scene.mismatch()}), 1e-6) : Outcome::refused;
  return {outcome,
          {{"rank of 5 rows", rank, 3, 1},
           {"condition of the KKT matrix", condition(A), 4.5e16, 0},
           {"accelerations at the start off the parallelogram's, relative", spread},
           {"seconds run", course.end},
           {"largest |g|, m", residual},
           {"difference of uprights, rad", scene.mismatch()},
           {"angle off the parallelogram's, rad", off}},
          course.reached ? why : course.why};
}

Finding by(ExplicitIndex1::Solver solver, const std::string& why) {
  ExplicitIndex1 method({.step = 1e-3,
                         .stabilisation = ExplicitIndex1::Stabilisation::position_velocity,
                         .solver = solver,
                         .cut = 1e-10});
  return release(method, why);
}

const Registered scene{under_every_method(
    {"S09",
     "singular start",
     {{"LU of the KKT matrix", [] { return by(ExplicitIndex1::Solver::dense_lu, ""); }},
      {"minimum norm",
       [] { return by(ExplicitIndex1::Solver::least_norm, "picks one of several motions without saying so"); }},
      {"explicit Runge-Kutta 5(4), 1e-8", [] { return release(*runge_kutta(1e-8), ""); }, Role::ours},
      {"generalized-alpha, index 2", [] { return release(*alpha_index2(1e-3), ""); }, Role::ours}}},
    {1e-8, 1e-3}, [](Integrator& method) { return release(method, ""); })};

}  // namespace
}  // namespace lithe::lab
