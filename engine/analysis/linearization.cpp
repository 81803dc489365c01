#include "engine/analysis/linearization.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "engine/analysis/perturbation.h"
#include "engine/base/checks.h"
#include "engine/base/log.h"
#include "engine/base/number_text.h"
#include "engine/motion/projection.h"
#include "engine/observe/stop_run.h"

namespace lithe {
namespace {

constexpr double kOnConstraints = 1e-6;  // of g and ġ at the base
constexpr double kSteady = 1e-6;         // turning of Z beside the speed of the bodies
constexpr double kRoundOff = std::numeric_limits<double>::epsilon();

void check(const System& system, const State& state) {
  Evaluator equations(system);
  const Layout& layout = system.layout();
  if (state.q.size() != layout.q_count() || state.v.size() != layout.v_count())
    throw SceneError("the state to linearize about belongs to another system", "linearize",
                     "take it from this system's initial_state(), a simulation or find_equilibrium()");
  if (layout.row_count() == 0) return;
  VectorX rows(layout.row_count());
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  for (const Level level : {Level::position, Level::velocity}) {
    int row = 0;
    equations.constraint(level, rows);
    const double off = rows.cwiseAbs().maxCoeff(&row);
    const double scale = level == Level::position ? 1 : 1 + state.v.lpNorm<Eigen::Infinity>();
    if (!(off <= kOnConstraints * scale))
      throw SceneError("the state to linearize about is off its constraints: " + layout.row_name(row) + " by " +
                           std::to_string(off) + (level == Level::velocity ? " a second" : ""),
                       "linearize, " + time_text(state.time),
                       level == Level::velocity ? "give velocities that satisfy the joints and drives"
                                                : "give positions that close the joints");
  }
}

/// Whether A is positive definite by more than round-off: Cholesky's pivots, of which round-off leaves some n ε of the
/// diagonal where the matrix is singular, stay a hundred times above that.
bool surely_positive(const MatrixX& A) {
  const Eigen::LLT<MatrixX> factor(A);
  if (factor.info() != Eigen::Success) return false;
  const VectorX pivots = factor.matrixLLT().diagonal().cwiseAbs2();
  return (pivots.array() > 100 * kRoundOff * static_cast<double>(A.rows()) * A.diagonal().array()).all();
}

/// Eigenpairs of K x = ω² M x, K and M symmetric, lowest first, Φᵀ M Φ = E.
void undamped_modes(const MatrixX& K, const MatrixX& M, VectorX& values, MatrixX& vectors) {
  // A positive K is the better one to factorise: then low frequencies keep all digits beside very high ones. What
  // moves freely makes K singular; were a K that only round-off makes positive taken as it is, M x = μ K x would have a
  // μ beyond 1/ε of the others, and those its round-off.
  if (surely_positive(K)) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> solver(M, K);  // M x = μ K x
    if (solver.info() == Eigen::Success && solver.eigenvalues()[0] > 0) {
      const VectorX mu = solver.eigenvalues().reverse();
      values = mu.cwiseInverse();
      vectors = solver.eigenvectors().rowwise().reverse() * mu.cwiseSqrt().cwiseInverse().asDiagonal();
      return;
    }
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> solver(K, M);
  values = solver.eigenvalues();
  vectors = solver.eigenvectors();
}

/// Scales rows and columns of A by powers of two until they are alike (Parlett & Reinsch 1969); returns the scales d of
/// D⁻¹ A D.
VectorX balance(MatrixX& A) {
  VectorX scales = VectorX::Ones(A.rows());
  for (bool changed = true; changed;) {
    changed = false;
    for (int i = 0; i < A.rows(); ++i) {
      const double own = std::abs(A(i, i)), column = A.col(i).lpNorm<1>() - own, row = A.row(i).lpNorm<1>() - own;
      if (!(column > 0) || !(row > 0)) continue;
      const double f = std::exp2(std::round(0.5 * std::log2(row / column)));
      if (column * f + row / f >= 0.95 * (column + row)) continue;
      A.col(i) *= f, A.row(i) /= f, scales[i] *= f;
      changed = true;
    }
  }
  return scales;
}

/// Eigenvalues of ẋ = A x and shapes = to_shape · x, one of each conjugate pair.
std::vector<Mode> modes_of(MatrixX A, const MatrixX& to_shape) {
  std::vector<Mode> modes;
  if (A.rows() == 0) return modes;
  const VectorX scales = balance(A);
  const Eigen::EigenSolver<MatrixX> solver(A);
  const MatrixX back = to_shape * scales.asDiagonal();
  for (int k = 0; k < A.rows(); ++k) {
    if (solver.eigenvalues()[k].imag() < 0) continue;
    Mode mode{solver.eigenvalues()[k], back * solver.eigenvectors().col(k)};
    int largest = 0;
    if (mode.shape.cwiseAbs().maxCoeff(&largest) > 0) mode.shape /= std::complex<double>(mode.shape[largest]);
    modes.push_back(std::move(mode));
  }
  std::stable_sort(modes.begin(), modes.end(), [](const Mode& a, const Mode& b) {
    const auto x = a.eigenvalue, y = b.eigenvalue;
    return x.imag() != y.imag() ? x.imag() < y.imag() : x.real() < y.real();
  });
  return modes;
}

/// Φᵀ A Φ; one function, because each such expression takes seconds to compile.
MatrixX projected(const MatrixX& Phi, const MatrixX& A) { return Phi.transpose() * A * Phi; }

/// The columns of the second-order form's modes: coordinates in which stiff and soft modes are equally well scaled,
/// y = Φ s/ω, w' = Φᵀ M ẏ.
std::vector<Mode> holonomic_modes(const Linearization& l, const MatrixX& Phi, const MatrixX& to_shape) {
  const int n = static_cast<int>(Phi.cols());
  const VectorX omega = l.undamped.head(n).cwiseAbs().cwiseSqrt().cwiseMax(1e-3);
  const VectorX soft = omega.cwiseInverse();
  MatrixX A = MatrixX::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n) = omega.asDiagonal();
  A.bottomLeftCorner(n, n) = -projected(Phi, l.K) * soft.asDiagonal();
  A.bottomRightCorner(n, n) = -projected(Phi, l.C);
  MatrixX shapes = MatrixX::Zero(to_shape.rows(), 2 * n);
  shapes.leftCols(n) = to_shape * (Phi * soft.asDiagonal());
  return modes_of(std::move(A), shapes);
}

/// What modes not in use would change of the softest shape that is stable.
void estimate_left_out(const System& system, const MatrixX& Phi, const MatrixX& Zp_engine, Linearization& out) {
  if (std::none_of(out.left_out.begin(), out.left_out.end(), [](const auto& body) { return body.known(); })) return;
  const double rigid = 100 * kRoundOff * out.undamped[out.undamped.size() - 1];
  for (Eigen::Index k = 0; k < out.undamped.size(); ++k) {
    if (!(out.undamped[k] > rigid)) continue;
    out.frequency_left_out = frequency_left_out(system, out.state, Zp_engine * Phi.col(k),
                                                Phi.col(k).dot(out.M * Phi.col(k)), out.undamped[k]);
    break;
  }
  if (out.frequency_left_out > kLeftOutToTell) {
    char share[32];
    std::snprintf(share, sizeof share, "%.0f %%", 100 * out.frequency_left_out);
    log::warn(std::string("linearize: modes not in use would lower the lowest frequency by some ") + share +
              "\n  fix:  use more modes, or static modes of the loaded interfaces (Reduction::loaded).");
  }
}

}  // namespace

Linearization linearize(const System& system, const State& state, const LinearizeOptions& options) {
  check(system, state);
  require::at("linearize", [&] { require::positive(options.step, "step"); });
  Perturbation near(system, state, options.axes, options.step);
  Linearization out;
  out.state = near.base();
  out.left_out = deflection_left_out(system, out.state);

  // 1. What the rows allow: bases of positions and velocities.
  const MatrixX G_all = near.jacobian(), G = G_all(near.rows(), Eigen::all);
  const RowSpace velocity_rows(G);
  const std::vector<int>& rolling = system.velocity_rows();
  const bool holonomic = rolling.empty();
  out.velocity_basis = velocity_rows.null_space();
  if (holonomic) {
    out.position_basis = out.velocity_basis;
  } else {  // redundant rows among them: they may repeat the derivative of a velocity row
    std::vector<int> holonomic_rows;
    for (int row = 0; row < G_all.rows(); ++row)
      if (!std::binary_search(rolling.begin(), rolling.end(), row)) holonomic_rows.push_back(row);
    out.position_basis = RowSpace(G_all(holonomic_rows, Eigen::all)).null_space();
  }
  const MatrixX &Zp = out.position_basis, &Zv = out.velocity_basis;
  const int np = static_cast<int>(Zp.cols()), nw = static_cast<int>(Zv.cols());

  // 2. Mass, and the derivatives along velocities: ξ = Z_v w, accelerations as the rows then ask for.
  MatrixX M(nw, nw), C(nw, nw), K(nw, np), By(np, np);
  for (int j = 0; j < nw; ++j) M.col(j) = Zv.transpose() * near.mass_times(Zv.col(j));
  for (int j = 0; j < nw; ++j) {
    Perturbation::Direction along{{}, Zv.col(j), {}};
    along.acceleration = -velocity_rows.shortest(near.acceleration_rows(along));
    C.col(j) = Zv.transpose() * near.residual(along);
  }

  // 3. Along positions: ζ = Z_p y with the velocity P y and the acceleration that keep the rows.
  for (int j = 0; j < np; ++j) {
    Perturbation::Direction along{Zp.col(j), {}, {}};
    along.velocity = -velocity_rows.shortest(near.velocity_rows(along));
    along.acceleration = -velocity_rows.shortest(near.acceleration_rows(along));
    K.col(j) = Zv.transpose() * near.residual(along);
    By.col(j) = Zp.transpose() * (along.velocity - near.transport(Zp.col(j)));
  }
  const MatrixX Bw = Zp.transpose() * Zv;

  // 4. Is the motion steady in these axes? Ż = -G⁺ Ġ Z.
  if (!state.v.isZero(0) && nw > 0 && G.rows() > 0) {
    const MatrixX turning = near.jacobian_rate()(near.rows(), Eigen::all) * Zv;
    for (int j = 0; j < nw; ++j)
      out.unsteadiness = std::max(out.unsteadiness, velocity_rows.shortest(turning.col(j)).norm());
    if (out.unsteadiness > kSteady * (1 + state.v.lpNorm<Eigen::Infinity>()))
      log::warn("linearize: the motion at " + time_text(state.time) +
                " is not steady in these axes; eigenvalues are those of the frozen instant");
  }

  // 5. First-order form.
  out.E = MatrixX::Identity(np + nw, np + nw);
  out.E.bottomRightCorner(nw, nw) = M;
  out.A.resize(np + nw, np + nw);
  out.A << By, Bw, -K, -C;
  MatrixX Zp_engine(Zp.rows(), np);
  for (int j = 0; j < np; ++j) Zp_engine.col(j) = near.to_engine(Zp.col(j));
  if (!holonomic) {
    MatrixX shapes = MatrixX::Zero(Zp.rows(), np + nw);
    shapes.leftCols(np) = Zp_engine;
    out.modes = modes_of(out.E.partialPivLu().solve(out.A), shapes);
    return out;
  }

  // 6. Second-order form, w = ẏ - B_y y, and its modes.
  out.M = 0.5 * (M + M.transpose());
  out.C = C - M * By;
  out.K = K - C * By;
  if (nw == 0) return out;
  MatrixX Phi;
  undamped_modes(0.5 * (out.K + out.K.transpose()), out.M, out.undamped, Phi);
  const int kept = options.mode_count > 0 ? std::min(options.mode_count, nw) : nw;
  out.modes = holonomic_modes(out, Phi.leftCols(kept), Zp_engine);
  estimate_left_out(system, Phi, Zp_engine, out);
  return out;
}

VectorX Linearization::undamped_frequencies() const { return undamped.cwiseMax(0).cwiseSqrt() / (2 * M_PI); }

double Linearization::largest_growth() const {
  double largest = 0;
  for (std::size_t k = 0; k < modes.size(); ++k) largest = k ? std::max(largest, modes[k].growth()) : modes[k].growth();
  return largest;
}

State displaced(const System& system, const Linearization& about, const Mode& mode, double amplitude, double phase) {
  State state = about.state;
  const std::complex<double> turn = std::polar(amplitude, phase);
  system.layout().retract(about.state.q, (turn * mode.shape).real(), state.q);
  state.v += (turn * mode.eigenvalue * mode.shape).real();
  // The mode is a straight line; joints lead along a curve.
  Evaluator equations(system);
  Projector projector(equations);
  projector.position(state.time, state.q, 1e-13, 20);
  projector.velocity(state.time, state.q, state.v);
  return state;
}

void animate(const System& system, const Linearization& about, const Mode& mode, double amplitude, int frames,
             Observer& observer) {
  if (frames < 2)
    throw SceneError("an animation of " + std::to_string(frames) + " frames", "animate", "give two or more");
  const double frequency = mode.frequency() > 0 ? mode.frequency() : 1;
  Snapshot snapshot(system);
  for (int k = 0; k < frames; ++k) {
    const double share = static_cast<double>(k) / (frames - 1);
    State state = displaced(system, about, mode, amplitude, 2 * M_PI * share);
    state.time = share / frequency;
    snapshot.evaluate(state);
    try {
      observer.observe(snapshot);
    } catch (const StopRun&) {
      return;
    }
  }
}

}  // namespace lithe
