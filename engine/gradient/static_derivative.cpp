#include "engine/gradient/static_derivative.h"

#include <cmath>

#include "engine/analysis/equilibrium.h"
#include "engine/analysis/static_equations.h"
#include "engine/base/dense.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/gradient/differences.h"

namespace lithe {
namespace {

constexpr int kMostCorrections = 40;
constexpr double kApart = 1e-6;  // relative distance of frequencies that have derivatives of their own

/// Longer steps than a run's: stiff bodies leave much round-off, and equilibria are smooth.
std::vector<DesignParameter> longer(std::vector<DesignParameter> parameters) {
  for (DesignParameter& p : parameters) p.step *= 5;
  return parameters;
}

ParametricScene at_rest(ParametricScene scene) {
  scene.integrator = nullptr;
  return scene;
}

/// Hz of the mode of the differenced equations that is next to φ and ω²: inverse iteration by (K - sM)⁻¹, s near ω²,
/// with the elements' tangents, then corrections at right angles to φ; Rayleigh's quotient.
double hertz_near(const Drawing& drawing, const State& rest, VectorX phi, double omega_squared) {
  constexpr double kShift = 1e-3;  // of ω², by which s is beside it
  constexpr int kTurns = 4, kMostTurns = 40;
  TangentEquations equations(drawing.system());
  Evaluator evaluator(drawing.system());
  evaluator.recall(rest.quarter_turns);
  StaticEquations balance(evaluator);
  balance.evaluate(rest.time, rest.q, rest.lambda);
  VectorX stiff, rows = VectorX::Zero(rest.lambda.size());
  const auto failed = [&] {
    return SimulationError("the mode near " + std::to_string(std::sqrt(omega_squared) / (2 * M_PI)) +
                               " Hz was not found beside the equilibrium",
                           "the gradient of a frequency", "give the parameters smaller steps");
  };
  if (!balance.factorize((kShift - 1) * omega_squared, rest.lambda)) throw failed();
  for (int i = 0; i < kTurns; ++i) {
    phi = balance.mass_times(phi, rest.lambda);
    rows.setZero();
    if (!balance.solve(phi, rows)) throw failed();
    phi /= largest_entry(phi);
  }
  equations.at(rest);
  double last = 0;
  for (int i = 0;; ++i) {
    equations.along({phi, {}, {}, {}}, stiff, rows);
    const VectorX inert = balance.mass_times(phi, rest.lambda);
    const double mass = phi.dot(inert);
    omega_squared = phi.dot(stiff) / mass;
    for (int row : evaluator.redundant_rows()) rows[row] = 0;
    VectorX change = stiff - omega_squared * inert;
    if (!balance.solve(change, rows)) throw failed();
    change -= (inert.dot(change) / mass) * phi;
    const double size = largest_entry(change);
    if (i > 1 && size > 0.5 * last && size < 1e-6) break;
    if (i == kMostTurns) throw failed();
    phi -= change;
    last = size;
  }
  return std::sqrt(omega_squared) / (2 * M_PI);
}

}  // namespace

StaticDerivative::StaticDerivative(const ParametricScene& scene, const std::vector<DesignParameter>& parameters,
                                   const Drawing& nominal, const std::vector<Drawing::Place>& columns)
    : scene_(scene),
      drawn_(longer(parameters)),
      nominal_(nominal),
      state_(find_equilibrium(nominal.system(), nominal.system().initial_state()).state),
      parameters_(at_rest(scene), drawn_, nominal, {state_}, columns, ParameterDerivative::Grouping::apart),
      equations_(nominal.system(), &parameters_, nullptr, true) {
  solve();
}

void StaticDerivative::solve() {
  MatrixX force, rows;
  equations_.at(state_);
  equations_.parameter_columns(force, rows);
  Evaluator evaluator(nominal_.system());
  evaluator.recall(state_.quarter_turns);
  StaticEquations balance(evaluator);
  balance.evaluate(state_.time, state_.q, state_.lambda);
  const auto refuse = [&] {
    throw SceneError(
        "the equilibrium has no derivative: the bodies can move there without force, or it is about to "
        "buckle",
        "the gradient of scene '" + scene_.name + "'", "hold every free motion by a joint or a spring");
  };
  if (!balance.factorize(0, state_.lambda)) refuse();
  turns_.setZero(force.rows(), force.cols());
  VectorX f, g;
  for (Eigen::Index k = 0; k < force.cols(); ++k) {
    LinearEquations::Direction x{VectorX::Zero(force.rows()), {}, {}, VectorX::Zero(rows.rows())};
    double last = 0;
    for (int i = 0;; ++i) {
      equations_.along(x, f, g);
      f += force.col(k);
      g += rows.col(k);
      for (int row : evaluator.redundant_rows()) g[row] = 0;
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
  }
}

/// φ of linearize(), in the engine's axes of velocities.
VectorX StaticDerivative::mode(int number, double& omega_squared) {
  const Linearization motions = linearize(nominal_.system(), state_);
  const auto refuse = [&](const std::string& what, const std::string& fix) {
    throw SceneError(what, "the gradient of scene '" + scene_.name + "'", fix);
  };
  if (motions.M.size() == 0)
    refuse("rows on velocities alone (rolling) leave no undamped frequencies", "hold the wheels");
  const Eigen::Index count = motions.M.rows();
  if (number < 0 || number >= count)
    refuse("there is no frequency " + std::to_string(number),
           "there are " + std::to_string(count) + ", counted from 0");
  const MatrixX K = (motions.K + motions.K.transpose()) / 2;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> modes(K, motions.M);
  const double square = modes.eigenvalues()[number], largest = modes.eigenvalues().cwiseAbs().maxCoeff();
  if (!(square > 1e-12 * largest))
    refuse("frequency " + std::to_string(number) + " is zero: it has no derivative", "ask for a higher one");
  for (const int other : {number - 1, number + 1})
    if (other >= 0 && other < count && std::abs(modes.eigenvalues()[other] - square) <= kApart * square)
      refuse("the frequencies " + std::to_string(std::min(other, number)) + " and " +
                 std::to_string(std::max(other, number)) + " are the same: they have no derivatives of their own",
             "make the scene less symmetric");
  omega_squared = square;
  // The axes of linearize() are the bodies': positions δp = A ρ.
  VectorX phi = motions.position_basis * modes.eigenvectors().col(number);
  for (const auto& b : nominal_.system().layout().bodies())
    if (b.frame) phi.segment<3>(b.v) = rotation_matrix(state_.q.segment<4>(b.q + 3)) * phi.segment<3>(b.v);
  return phi;
}

double StaticDerivative::frequency(int number, VectorX& derivatives) {
  double omega_squared = 0;
  const VectorX phi = mode(number, omega_squared);
  derivatives.setZero(parameters_.count());
  for (int k = 0; k < parameters_.count(); ++k) {
    const log::Quiet quiet;
    const double h = drawn_[static_cast<std::size_t>(k)].step;
    for (const Offset& offset : kOffsets) {
      const Drawing drawing(scene_, moved_parameter(drawn_, k, offset.steps));
      State start = state_;
      start.q.resize(state_.q.size());
      drawing.system().layout().retract(state_.q, offset.steps * h * turns_.col(k), start.q);
      const State rest = find_equilibrium(drawing.system(), start).state;
      derivatives[k] += offset.weight / h * hertz_near(drawing, rest, phi, omega_squared);
    }
  }
  return hertz_near(nominal_, state_, phi, omega_squared);
}

}  // namespace lithe
