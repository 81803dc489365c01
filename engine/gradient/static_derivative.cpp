#include "engine/gradient/static_derivative.h"

#include <cmath>

#include "engine/analysis/equilibrium.h"
#include "engine/analysis/static_equations.h"
#include "engine/base/dense.h"
#include "engine/base/error.h"
#include "engine/gradient/differences.h"

namespace lithe {
namespace {

constexpr int kMostCorrections = 40;
constexpr double kApart = 1e-6;  // relative distance of frequencies that have derivatives of their own

ParametricScene at_rest(ParametricScene scene) {
  scene.integrator = nullptr;
  return scene;
}

}  // namespace

StaticDerivative::StaticDerivative(const ParametricScene& scene, const std::vector<DesignParameter>& parameters,
                                   const Drawing& nominal, const std::vector<Drawing::Place>& columns)
    : scene_(scene),
      nominal_(nominal),
      state_(find_equilibrium(nominal.system(), nominal.system().initial_state()).state),
      parameters_(at_rest(scene), parameters, nominal, {state_}, columns, ParameterDerivative::Grouping::apart),
      equations_(nominal.system(), parameters_) {
  solve();
}

void StaticDerivative::solve() {
  MatrixX force, rows;
  equations_.at(state_);
  equations_.parameter_columns(force, rows);
  Assembler assembler(nominal_.system());
  assembler.recall(state_.quarter_turns);
  StaticEquations balance(assembler);
  balance.evaluate(state_.time, state_.q, state_.lambda);
  const auto refuse = [&] {
    throw SceneError(
        "the equilibrium has no derivative: the bodies can move there without force, or it is about to "
        "buckle",
        "the gradient of scene '" + scene_.name + "'", "hold every free motion by a joint or a spring");
  };
  if (!balance.factorize(0, state_.lambda)) refuse();
  turns_.setZero(force.rows(), force.cols());
  multipliers_.setZero(rows.rows(), rows.cols());
  VectorX f, g;
  for (Eigen::Index k = 0; k < force.cols(); ++k) {
    LinearEquations::Direction x{VectorX::Zero(force.rows()), {}, {}, VectorX::Zero(rows.rows())};
    double last = 0;
    for (int i = 0;; ++i) {
      equations_.along(x, f, g);
      f += force.col(k);
      g += rows.col(k);
      for (int row : assembler.redundant_rows()) g[row] = 0;
      if (!balance.solve(f, g)) refuse();
      const double change = largest_entry(f), size = largest_entry(x.turn);
      x.turn -= f;
      x.multipliers -= g;
      if (i > 0 && (change <= 1e-13 * size || (change >= 0.5 * last && change <= 1e-9 * size))) break;
      if (change == 0) break;
      if (i == kMostCorrections || (i > 2 && change > 2 * last)) refuse();
      last = change;
    }
    turns_.col(k) = x.turn;
    multipliers_.col(k) = x.multipliers;
  }
}

double StaticDerivative::frequency(int number, VectorX& derivatives) {
  if (!small_motions_) small_motions_ = std::make_unique<Linearization>(linearize(nominal_.system(), state_));
  const Linearization& motions = *small_motions_;
  const auto refuse = [&](const std::string& what, const std::string& fix) {
    throw SceneError(what, "the gradient of scene '" + scene_.name + "'", fix);
  };
  if (motions.M.size() == 0)
    refuse("rows on velocities alone (rolling) leave no undamped frequencies", "hold the wheels");
  const Eigen::Index count = motions.M.rows();
  if (number < 0 || number >= count)
    refuse("there is no frequency " + std::to_string(number),
           "there are " + std::to_string(count) + ", counted from 0");
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> modes((motions.K + motions.K.transpose()) / 2, motions.M);
  const double square = modes.eigenvalues()[number], largest = modes.eigenvalues().cwiseAbs().maxCoeff();
  if (!(square > 1e-12 * largest))
    refuse("frequency " + std::to_string(number) + " is zero: it has no derivative", "ask for a higher one");
  for (const int other : {number - 1, number + 1})
    if (other >= 0 && other < count && std::abs(modes.eigenvalues()[other] - square) <= kApart * square)
      refuse("the frequencies " + std::to_string(std::min(other, number)) + " and " +
                 std::to_string(std::max(other, number)) + " are the same: they have no derivatives of their own",
             "make the scene less symmetric");
  // The axes of linearize() are the bodies': positions δp = A ρ.
  VectorX phi = motions.position_basis * modes.eigenvectors().col(number);
  for (const auto& b : nominal_.system().layout().bodies())
    if (b.frame) phi.segment<3>(b.v) = rotation_matrix(state_.q.segment<4>(b.q + 3)) * phi.segment<3>(b.v);
  // K φ - ω² M φ = -Gᵀ ν: [M Gᵀ; G 0] (0, -ν).
  VectorX stiff, rows, inert(phi.size());
  equations_.at(state_);
  equations_.along({phi, {}, {}, {}}, stiff, rows);
  Assembler assembler(nominal_.system());
  assembler.recall(state_.quarter_turns);
  assembler.evaluate(state_.time, state_.q, state_.v, Level::velocity);
  VectorX still(phi.size());
  assembler.residual(VectorX::Zero(phi.size()), state_.lambda, still);
  assembler.residual(phi, state_.lambda, inert);
  inert -= still;
  const double mass = phi.dot(inert), omega2 = phi.dot(stiff) / mass;
  VectorX load = stiff - omega2 * inert, nu = VectorX::Zero(rows.size());
  assembler.factorize({0, 0, 1}, state_.v_dot, state_.lambda, nullptr);
  assembler.solve(load, nu);
  nu = -nu;
  derivatives.resize(parameters_.count());
  VectorX force;
  for (int k = 0; k < parameters_.count(); ++k) {
    parameters_.along_path(k, state_, turns_.col(k), multipliers_.col(k), phi, omega2, force, rows);
    derivatives[k] = (phi.dot(force) + 2 * nu.dot(rows)) / mass;
  }
  const double hertz = std::sqrt(omega2) / (2 * M_PI);
  derivatives /= 8 * M_PI * M_PI * hertz;
  return hertz;
}

}  // namespace lithe
