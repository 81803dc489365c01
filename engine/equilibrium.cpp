#include "engine/equilibrium.h"

#include <kinsol/kinsol.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <cstdio>
#include <map>

#include "engine/assembler.h"
#include "engine/error.h"
#include "engine/observer.h"
#include "engine/projection.h"

namespace lithe {
namespace {

constexpr double kFirstMove = 0.05;    // m, rad: what the first load step lets the fastest body move
constexpr double kFarthestTurn = 0.5;  // rad a load step
constexpr double kGrowth = 4, kLateGrowth = 100, kShrink = 6;  // of τ; late: where bodies hardly move any more
constexpr double kHardlyMoves = 1e-2;                          // m, rad
constexpr double kLongest = 1e4, kShortest = 1e-16;            // τ, s²
constexpr double kRowsClosed = 1e-9;                           // |g| of an equilibrium
constexpr int kMaxIterations = 40;                             // of Newton, a load step

/// The unknowns of one load step, (d, λ), and KINSOL's objects.
class LoadStep {
 public:
  LoadStep(Assembler& equations, double force_scale)
      : equations_(equations),
        velocities_(equations.layout().v_count()),
        rows_(equations.layout().row_count()),
        redundant_(rows_, 0) {
    for (int row : equations.redundant_rows()) redundant_[row] = 1;
    for (VectorX* x : {&still_, &acceleration_}) x->setZero(velocities_);
    q_.setZero(equations.layout().q_count());
    set_up(force_scale);
  }
  LoadStep(const LoadStep&) = delete;
  ~LoadStep() {
    if (kinsol_) KINFree(&kinsol_);
    if (solver_) SUNLinSolFree(solver_);
    if (matrix_) SUNMatDestroy(matrix_);
    for (N_Vector x : {y_, unknown_scales_, equation_scales_})
      if (x) N_VDestroy(x);
    if (context_) SUNContext_Free(&context_);
  }

  /// Solves from `state` with pseudo-time tau; d and λ are the answer. False: not solved.
  bool solve(const State& state, double tau) {
    from_ = &state;
    tau_ = tau;
    map(y_) << still_, state.lambda;
    for (int i = 0; i < rows_; ++i)
      if (redundant_[i]) map(y_)[velocities_ + i] = 0;
    const int flag = KINSol(kinsol_, y_, KIN_LINESEARCH, unknown_scales_, equation_scales_);
    long iterations = 0;
    KINGetNumNonlinSolvIters(kinsol_, &iterations);
    iterations_ += static_cast<int>(iterations);
    if (!thrown_.empty())
      throw SimulationError("the forces cannot be evaluated: " + thrown_, "find_equilibrium",
                            "look at the law of that force, or start nearer to the equilibrium");
    // Where round-off ends the search the answer is as good as it gets: the caller judges it by its balance.
    return (flag >= 0 || flag == KIN_LINESEARCH_NONCONV || flag == KIN_LINESEARCH_BCFAIL ||
            flag == KIN_MAXITER_REACHED) &&
           map(y_).allFinite() && (flag >= 0 || norm() < 1e-6);
  }
  Eigen::Map<VectorX> d() const { return {N_VGetArrayPointer(y_), velocities_}; }
  Eigen::Map<VectorX> lambda() const { return {N_VGetArrayPointer(y_) + velocities_, rows_}; }
  int iterations() const { return iterations_; }

 private:
  static Eigen::Map<VectorX> map(N_Vector x) { return {N_VGetArrayPointer(x), N_VGetLength(x)}; }

  void set_up(double force_scale) {
    SUNContext_Create(nullptr, &context_);
    const sunindextype size = velocities_ + rows_;
    for (N_Vector* x : {&y_, &unknown_scales_, &equation_scales_}) *x = N_VNew_Serial(size, context_);
    matrix_ = SUNSparseMatrix(size, size, 10 * size, CSC_MAT, context_);
    solver_ = SUNLinSol_KLU(y_, matrix_, context_);
    kinsol_ = KINCreate(context_);
    bool done = y_ && unknown_scales_ && equation_scales_ && matrix_ && solver_ && kinsol_;
    if (done) {
      KINSetErrHandlerFn(
          kinsol_, [](int, const char*, const char*, char*, void*) {}, nullptr);
      done = KINInit(kinsol_, residual, y_) == KIN_SUCCESS && KINSetUserData(kinsol_, this) == KIN_SUCCESS &&
             KINSetLinearSolver(kinsol_, solver_, matrix_) == KIN_SUCCESS &&
             KINSetJacFn(kinsol_, jacobian) == KIN_SUCCESS;
    }
    if (!done) throw SimulationError("SUNDIALS cannot be set up", "find_equilibrium", "is the memory enough?");
    KINSetMaxSetupCalls(kinsol_, 1);  // Newton proper: a Jacobian every iteration
    KINSetNumMaxIters(kinsol_, kMaxIterations);
    KINSetFuncNormTol(kinsol_, 1e-14);
    KINSetScaledStepTol(kinsol_, 1e-15);
    map(unknown_scales_) << VectorX::Ones(velocities_), VectorX::Constant(rows_, 1e-3 / force_scale);
    map(equation_scales_) << VectorX::Constant(velocities_, 1 / force_scale), VectorX::Ones(rows_);
    KINSetMaxNewtonStep(kinsol_, 2 * std::sqrt(static_cast<double>(size)));
  }

  /// q = q₀ ⊕ d, at rest, with the acceleration d/τ whose inertia holds back the load.
  void load(N_Vector y) {
    equations_.layout().retract(from_->q, map(y).head(velocities_), q_);
    acceleration_ = map(y).head(velocities_) / tau_;
    equations_.evaluate(from_->time, q_, still_, Level::velocity);
  }

  template <class Work>
  int guarded(Work&& work) noexcept {
    try {
      return work() ? 0 : 1;
    } catch (const std::exception& error) {
      thrown_ = error.what();
    }
    return -1;
  }

  static int residual(N_Vector y, N_Vector F, void* user) {
    auto& self = *static_cast<LoadStep*>(user);
    return self.guarded([&] {
      self.load(y);
      self.equations_.residual(self.acceleration_, map(y).tail(self.rows_), map(F).head(self.velocities_));
      self.equations_.constraint(Level::position, map(F).tail(self.rows_));
      for (int i = 0; i < self.rows_; ++i)
        if (self.redundant_[i]) map(F)[self.velocities_ + i] = map(y)[self.velocities_ + i];
      return map(F).allFinite();
    });
  }

  static int jacobian(N_Vector y, N_Vector, SUNMatrix J, void* user, N_Vector, N_Vector) {
    auto& self = *static_cast<LoadStep*>(user);
    return self.guarded([&] { return self.write_jacobian(y, J); });
  }

  bool write_jacobian(N_Vector y, SUNMatrix J) {
    load(y);
    equations_.factorize({1, 0, 1 / tau_}, acceleration_, map(y).tail(rows_), nullptr);
    collect(map(y).head(velocities_));
    const int size = velocities_ + rows_;
    sparse_.resize(size, size);
    sparse_.setFromTriplets(entries_.begin(), entries_.end());
    sparse_.makeCompressed();
    if (SUNSparseMatrix_NNZ(J) < sparse_.nonZeros()) SUNSparseMatrix_Reallocate(J, sparse_.nonZeros());
    std::copy_n(sparse_.outerIndexPtr(), size + 1, SUNSparseMatrix_IndexPointers(J));
    std::copy_n(sparse_.innerIndexPtr(), sparse_.nonZeros(), SUNSparseMatrix_IndexValues(J));
    std::copy_n(sparse_.valuePtr(), sparse_.nonZeros(), SUNSparseMatrix_Data(J));
    SUNLinSol_KLUReInit(solver_, J, sparse_.nonZeros(), SUNKLU_REINIT_PARTIAL);  // the pattern may have changed
    return Eigen::Map<const VectorX>(sparse_.valuePtr(), sparse_.nonZeros()).allFinite();
  }

  /// The engine's blocks act on turns of the present state; those of d turn it by Jr(ψ). Compliant rows, which have no
  /// unknown here, are eliminated: Gᵀ κ G.
  void collect(ConstVectorRef d) {
    std::map<int, Matrix3> turns;  // by first velocity of a frame
    for (const auto& b : equations_.layout().bodies())
      if (b.frame) turns[b.v] = left_jacobian(d.segment<3>(b.v + 3)).transpose();
    const int constraints_end = velocities_ + rows_;
    struct CompliantRow {
      double compliance = 0;
      std::vector<std::pair<int, double>> across, down;  // columns of G as the unknowns see it, rows of Gᵀ
    };
    std::vector<CompliantRow> compliant;
    entries_.clear();
    const auto is_left_out = [&](int i) { return i >= velocities_ && redundant_[i - velocities_]; };

    equations_.visit_blocks([&](int row, int column, ConstMatrixRef block) {
      MatrixX values = block;
      if (column < velocities_ && block.cols() == 6)
        if (const auto turn = turns.find(column); turn != turns.end())
          values.rightCols<3>() = (block.rightCols<3>() * turn->second).eval();
      for (int k = 0; k < block.cols(); ++k)
        for (int i = 0; i < block.rows(); ++i) {
          const int r = row + i, c = column + k;
          if (r >= constraints_end || c >= constraints_end) {
            const auto place = static_cast<std::size_t>(std::max(r, c) - constraints_end);
            if (place >= compliant.size()) compliant.resize(place + 1);
            if (r >= constraints_end && c >= constraints_end) {
              compliant[place].compliance = -values(i, k);
            } else if (values(i, k) != 0 && !is_left_out(std::min(r, c))) {
              (r >= constraints_end ? compliant[place].across : compliant[place].down)
                  .emplace_back(std::min(r, c), values(i, k));
            }
          } else if (!is_left_out(r) && !is_left_out(c) && (values(i, k) != 0 || r == c)) {
            entries_.emplace_back(r, c, values(i, k));
          }
        }
    });
    for (const CompliantRow& row : compliant)
      for (const auto& [r, down] : row.down)
        for (const auto& [c, across] : row.across) entries_.emplace_back(r, c, down * across / row.compliance);
    for (int i = 0; i < rows_; ++i)
      if (redundant_[i]) entries_.emplace_back(velocities_ + i, velocities_ + i, 1.0);
  }

  double norm() const {
    double value = 0;
    KINGetFuncNorm(kinsol_, &value);
    return value;
  }

  Assembler& equations_;
  const int velocities_, rows_;
  std::vector<char> redundant_;
  const State* from_ = nullptr;
  double tau_ = 1;
  VectorX q_, still_, acceleration_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::SparseMatrix<double> sparse_;
  std::string thrown_;  // by the engine within a callback
  int iterations_ = 0;

  SUNContext context_ = nullptr;
  N_Vector y_ = nullptr, unknown_scales_ = nullptr, equation_scales_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
  void* kinsol_ = nullptr;
};

/// How far a state is from balance.
struct Balance {
  VectorX force;  // Gᵀ λ - f
  double largest = 0, gap = 0;
  int worst = 0;  // velocity index
};
Balance balance_of(Assembler& equations, const State& state) {
  Balance balance;
  const VectorX still = VectorX::Zero(state.v.size());
  balance.force = still;
  VectorX g(state.lambda.size());
  equations.evaluate(state.time, state.q, still, Level::velocity);
  equations.residual(still, state.lambda, balance.force);
  equations.constraint(Level::position, g);
  if (balance.force.size() > 0) balance.largest = balance.force.cwiseAbs().maxCoeff(&balance.worst);
  if (g.size() > 0) balance.gap = g.lpNorm<Eigen::Infinity>();
  return balance;
}

std::string short_number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

/// Largest turn of a body and largest motion of any coordinate in d.
std::pair<double, double> largest_move(const Layout& layout, ConstVectorRef d) {
  double turn = 0;
  for (const auto& b : layout.bodies())
    if (b.frame) turn = std::max(turn, d.segment<3>(b.v + 3).norm());
  return {turn, d.lpNorm<Eigen::Infinity>()};
}

}  // namespace

Equilibrium find_equilibrium(const System& system, const State& start, const EquilibriumOptions& options) {
  const Layout& layout = system.layout();
  if (start.q.size() != layout.q_count())
    throw SceneError("the state to start from belongs to another system", "find_equilibrium",
                     "start from system.initial_state()");
  Assembler equations(system);
  equations.recall(start.quadrants);
  Projector projector(equations);

  // 1. Rest at the start: positions on the constraints, multipliers and accelerations that the loads would cause.
  Equilibrium found;
  State& state = found.state;
  state = start;
  state.v.setZero(layout.v_count());
  state.v_dot.setZero(layout.v_count());
  state.lambda.setZero(layout.row_count());
  projector.position(state.time, state.q, 1e-13, 50);
  const auto dynamics = [&] { projector.accelerations(state.time, state.q, state.v, state.v_dot, state.lambda); };
  dynamics();
  const Balance unloaded =
      balance_of(equations, {state.time, state.q, state.v, {}, VectorX::Zero(layout.row_count()), {}});
  const double force_scale =
      std::max({unloaded.largest, state.lambda.size() > 0 ? state.lambda.lpNorm<Eigen::Infinity>() : 0.0, 1e-12});
  const double enough = options.tolerance * force_scale;

  // 2. Load steps, until the balance is as good as round-off lets it be.
  LoadStep step(equations, force_scale);
  Balance balance = balance_of(equations, state), trial;
  const double fastest = state.v_dot.lpNorm<Eigen::Infinity>();
  double tau = std::min(fastest > 0 ? kFirstMove / fastest : kLongest, kLongest);
  State moved = state;
  for (int failures = 0; found.load_steps < options.max_load_steps && tau > kShortest;) {
    if (balance.largest <= 1e-15 * force_scale) break;
    ++found.load_steps;
    bool good = step.solve(state, tau);
    const VectorX d = step.d();
    const auto [turn, move] = largest_move(layout, d);
    // Forces, those of the constraints included, must have done work: else Newton has gone uphill.
    good = good && turn <= kFarthestTurn && (move < 1e-6 || balance.force.dot(d) < 0);
    if (good) {
      moved = state;
      layout.retract(state.q, d, moved.q);
      moved.lambda = step.lambda();
      trial = balance_of(equations, moved);
      good = std::isfinite(trial.largest) && trial.gap < kRowsClosed;
    }
    const bool near_end = balance.largest <= enough && balance.gap < kRowsClosed;
    if (near_end && (!good || trial.largest > 0.5 * balance.largest)) break;  // round-off ends progress
    if (!good) {
      tau /= kShrink;
      ++failures;
      continue;
    }
    state.q = moved.q, state.lambda = moved.lambda;
    equations.track(state.quadrants);
    equations.recall(state.quadrants);
    balance = trial;
    tau = std::min(kLongest, tau * (move < kHardlyMoves ? kLateGrowth : kGrowth));
    if (move > kHardlyMoves) {  // what the constraints bear before they move on
      dynamics();
      balance = balance_of(equations, state);
    }
  }
  found.iterations = step.iterations();
  found.out_of_balance = balance.largest;

  // 3. Rest, or no rest.
  if (!(balance.largest <= enough) || !(balance.gap < kRowsClosed))
    throw SimulationError("no equilibrium was found in " + std::to_string(found.load_steps) +
                              " load steps: " + layout.velocity_name(balance.worst) + " stays out of balance by " +
                              short_number(balance.largest) + " (N or N m), joints are off by " +
                              short_number(balance.gap),
                          "find_equilibrium, " + time_text(state.time),
                          "does anything hold it? Add a spring, a joint or a lock; or start nearer to the equilibrium");
  state.v.setZero();
  state.v_dot.setZero();
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  equations.minimum_norm(state.lambda);
  return found;
}

}  // namespace lithe
