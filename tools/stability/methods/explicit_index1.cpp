#include "tools/stability/methods/explicit_index1.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>

#include "tools/stability/methods/dense_equations.h"
#include "tools/stability/methods/step_pattern.h"

namespace lithe::lab {
namespace {

/// q̇ of plain coordinates: ė = ½ e ∘ (0, ω).
void coordinate_rates(const Layout& layout, ConstVectorRef q, ConstVectorRef v, VectorRef q_dot) {
  for (const Layout::BodySlice& b : layout.bodies()) {
    int iq = b.q, iv = b.v;
    if (b.frame) {
      Vector4 omega;
      omega << 0, v.segment<3>(iv + 3);
      q_dot.segment<3>(iq) = v.segment<3>(iv);
      q_dot.segment<4>(iq + 3) = 0.5 * quaternion_product(q.segment<4>(iq + 3), omega);
      iq += 7, iv += 6;
    }
    q_dot.segment(iq, b.linear) = v.segment(iv, b.linear);
  }
}

void normalise(const Layout& layout, VectorRef q) {
  for (const Layout::BodySlice& b : layout.bodies())
    if (b.frame) q.segment<4>(b.q + 3).normalize();
}

}  // namespace

void ExplicitIndex1::prepare(EquationsOfMotion& equations, State& state) {
  const Layout& layout = equations.layout();
  statistics_ = {};
  trouble_.clear();
  choose_ = true;
  q_dot_.setZero(layout.q_count(), 4);
  v_dot_.setZero(layout.v_count(), 4);
  for (VectorX* x : {&v_, &dv_, &zero_v_}) x->setZero(layout.v_count());
  for (VectorX* x : {&lambda_, &rows_, &zero_rows_}) x->setZero(layout.row_count());
  q_ = state.q, v_ = state.v;
  rates(equations, state.time, 0);
  state.v_dot = v_dot_.col(0), state.lambda = lambda_;
}

/// [M Gᵀ; G 0] (x, y) = (rv, rl) in place, at the state evaluated last.
void ExplicitIndex1::solve(EquationsOfMotion& equations, VectorRef rv, VectorRef rl) {
  equations.factorize({0, 0, 1}, zero_v_, zero_rows_, nullptr);
  if (parameters_.solver == Solver::engine) return equations.solve(rv, rl);
  const int nv = static_cast<int>(rv.size()), rows = static_cast<int>(rl.size());
  MatrixX A = dense_matrix(equations);
  VectorX b(nv + rows);
  b << rv, rl;
  switch (parameters_.solver) {
    case Solver::least_norm:
      b = lab::least_norm(A, b, parameters_.cut).x;
      break;
    case Solver::regularised:
      A.bottomRightCorner(rows, rows).diagonal().array() -= parameters_.cut;
      b = A.partialPivLu().solve(b);
      break;
    case Solver::dense_lu: {
      const Eigen::PartialPivLU<MatrixX> lu(A);
      const VectorX pivots = lu.matrixLU().diagonal().cwiseAbs();
      constexpr double kSingular = 1e-14;  // smallest pivot over largest
      if (!(pivots.minCoeff() > kSingular * pivots.maxCoeff()))
        trouble_ = "the matrix of accelerations and multipliers is singular to working precision: " +
                   std::to_string((pivots.array() <= kSingular * pivots.maxCoeff()).count()) + " pivots are zero";
      b = lu.solve(b);
      break;
    }
    default: {
      if (choose_ || parameters_.solver == Solver::rows_every_stage) {
        Eigen::ColPivHouseholderQR<MatrixX> qr(A.block(0, nv, nv, rows));
        qr.setThreshold(parameters_.cut);
        const auto& order = qr.colsPermutation().indices();
        chosen_.assign(order.data(), order.data() + qr.rank());
        choose_ = false;
      }
      const int count = static_cast<int>(chosen_.size());
      MatrixX part(nv + count, nv + count);
      part.setZero();
      part.topLeftCorner(nv, nv) = A.topLeftCorner(nv, nv);
      VectorX x(nv + count);
      x.head(nv) = rv;
      for (int i = 0; i < count; ++i) {
        part.row(nv + i).head(nv) = A.row(nv + chosen_[i]).head(nv);
        part.col(nv + i).head(nv) = A.col(nv + chosen_[i]).head(nv);
        x[nv + i] = rl[chosen_[i]];
      }
      x = part.partialPivLu().solve(x).eval();
      b.setZero();
      b.head(nv) = x.head(nv);
      for (int i = 0; i < count; ++i) b[nv + chosen_[i]] = x[nv + i];
    }
  }
  rv = b.head(nv);
  rl = b.tail(rows);
}

/// q_ and v_ back onto the constraints, as far as wished.
void ExplicitIndex1::project(EquationsOfMotion& equations, double time) {
  const Stabilisation how = parameters_.stabilisation;
  if (rows_.size() == 0) return;
  if (how == Stabilisation::position_velocity) {
    constexpr int kMaxIterations = 10;
    constexpr double kClosed = 1e-15;  // in the units of the rows
    double last = INFINITY;
    for (int k = 0; k < kMaxIterations; ++k) {
      equations.evaluate(time, q_, zero_v_, Level::position);
      equations.constraint(Level::position, rows_);
      const double size = rows_.cwiseAbs().maxCoeff();
      if (size <= kClosed || !(size < 0.5 * last)) break;  // or round-off ends progress
      last = size;
      dv_.setZero();
      rows_ *= -1;
      solve(equations, dv_, rows_);
      equations.layout().retract(q_, dv_, q_);
    }
  }
  if (how == Stabilisation::position_velocity || how == Stabilisation::velocity) {
    equations.evaluate(time, q_, v_, Level::velocity);
    equations.constraint(Level::velocity, rows_);
    dv_.setZero();
    rows_ *= -1;
    solve(equations, dv_, rows_);
    v_ += dv_;
  }
}

/// The rates at (time, q_, v_), into a column of q_dot_ and v_dot_.
void ExplicitIndex1::rates(EquationsOfMotion& equations, double time, int stage) {
  coordinate_rates(equations.layout(), q_, v_, q_dot_.col(stage));
  equations.evaluate(time, q_, v_, Level::acceleration);
  equations.residual(zero_v_, zero_rows_, v_dot_.col(stage));  // -f
  v_dot_.col(stage) *= -1;
  equations.constraint(Level::acceleration, lambda_);
  if (parameters_.stabilisation == Stabilisation::baumgarte) {
    equations.constraint(Level::velocity, rows_);
    lambda_ -= 2 * parameters_.alpha * rows_;
    equations.constraint(Level::position, rows_);
    lambda_ -= parameters_.beta * parameters_.beta * rows_;
  }
  solve(equations, v_dot_.col(stage), lambda_);
  ++statistics_.evaluations;
}

StepResult ExplicitIndex1::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  const double h = next_step(Steps::constant, parameters_.step, 0, t_stop - state.time);
  const auto stage = [&](int i, double part) {
    q_ = state.q + part * h * q_dot_.col(i - 1);
    v_ = state.v + part * h * v_dot_.col(i - 1);
    rates(equations, state.time + part * h, i);
  };
  // 1. The classical four stages, or one.
  choose_ = true;
  q_ = state.q, v_ = state.v;
  rates(equations, state.time, 0);
  if (parameters_.method == Method::euler) {
    q_ = state.q + h * q_dot_.col(0);
    v_ = state.v + h * v_dot_.col(0);
  } else {
    stage(1, 0.5), stage(2, 0.5), stage(3, 1);
    q_ = state.q + h / 6 * (q_dot_.col(0) + 2 * q_dot_.col(1) + 2 * q_dot_.col(2) + q_dot_.col(3));
    v_ = state.v + h / 6 * (v_dot_.col(0) + 2 * v_dot_.col(1) + 2 * v_dot_.col(2) + v_dot_.col(3));
  }
  if (parameters_.normalise) normalise(equations.layout(), q_);
  // 2. Back onto the constraints, as far as wished.
  const double time = h == t_stop - state.time ? t_stop : state.time + h;
  project(equations, time);
  if (!trouble_.empty()) return {StepResult::Outcome::failed, trouble_};
  if (!q_.allFinite() || !v_.allFinite())
    return {StepResult::Outcome::failed, "the coordinates are not finite any more"};
  state.time = time;
  state.q = q_, state.v = v_;
  state.v_dot = v_dot_.col(0), state.lambda = lambda_;
  ++statistics_.steps;
  return {};
}

}  // namespace lithe::lab
