#include "integrators/ida.h"

#include <ida/ida.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <string>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/motion/projection.h"
#include "integrators/stabilized_index2.h"
#include "integrators/sundials_internal.h"

namespace lithe {
namespace {

constexpr int kMaxStalled = 10;  // steps in a row that do not move time

}  // namespace

struct Ida::Memory : SundialsMemory<Ida::Memory> {
  EquationsOfMotion& equations;
  StabilizedIndex2 form;
  Tolerance tolerance;
  std::vector<int> left_out;  // rows, for as long as these objects live
  int stalled = 0;
  N_Vector y = nullptr, y_dot = nullptr, id = nullptr, errors = nullptr, weights = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver solver = nullptr;
  void* ida = nullptr;

  Memory(EquationsOfMotion& of, const Tolerance& allowed)
      : equations(of), form(of), tolerance(allowed), left_out(of.redundant_rows()) {
    for (N_Vector* x : {&y, &y_dot, &id, &errors, &weights}) *x = N_VNew_Serial(form.size(), context);
  }
  ~Memory() {
    if (ida) IDAFree(&ida);
    if (solver) SUNLinSolFree(solver);
    if (matrix) SUNMatDestroy(matrix);
    for (N_Vector x : {y, y_dot, id, errors, weights})
      if (x) N_VDestroy(x);
  }

  static int residual(double time, N_Vector y, N_Vector y_dot, N_Vector F, void* user) {
    return guarded(user, [&](Memory& m) {
      m.form.residual(time, map(y), map(y_dot), map(F));
      return map(F).allFinite();
    });
  }

  static int jacobian(double time, double c, N_Vector y, N_Vector y_dot, N_Vector, SUNMatrix J, void* user, N_Vector,
                      N_Vector, N_Vector) {
    return guarded(user, [&](Memory& m) {
      m.write_pattern(J);
      m.form.jacobian(time, map(y), map(y_dot), c, SUNSparseMatrix_Data(J));
      return Eigen::Map<VectorX>(SUNSparseMatrix_Data(J), SUNSparseMatrix_NNZ(J)).allFinite();
    });
  }

  static int error_weights(N_Vector y, N_Vector out, void* user) {
    return guarded(user, [&](Memory& m) {
      m.form.allowances(map(y), m.tolerance, map(out));
      map(out) = map(out).cwiseInverse();
      return true;
    });
  }

  void write_pattern(SUNMatrix J) const {
    std::copy(form.column_starts().begin(), form.column_starts().end(), SUNSparseMatrix_IndexPointers(J));
    std::copy(form.row_indices().begin(), form.row_indices().end(), SUNSparseMatrix_IndexValues(J));
  }

  void require(bool done, const char* what) const { SundialsMemory::require(done, what, "Ida"); }
};

Ida::Ida(Parameters parameters) : parameters_(parameters) { check_sundials("Ida", parameters, 5); }

Ida::~Ida() = default;

void Ida::prepare(EquationsOfMotion& equations, State& state) {
  // 1. A consistent start: positions, velocities, accelerations and multipliers.
  if (!resumes()) statistics_ = {};
  before_ = statistics_;
  Projector projector(equations);
  projector.position(state.time, state.q, 1e-13, 10, Projector::Factor::first);
  projector.velocity(state.time, state.q, state.v);
  state.v_dot.resize(equations.layout().v_count());
  state.lambda.resize(equations.layout().row_count());
  projector.accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);

  // 2. IDA's own objects.
  memory_ = std::make_unique<Memory>(equations, parameters_.tolerance);
  Memory& m = *memory_;
  m.require(m.context && m.y && m.y_dot && m.id && m.errors && m.weights, "vectors");
  m.form.pack(state, Memory::map(m.y), Memory::map(m.y_dot));
  m.ida = IDACreate(m.context);
  m.require(m.ida, "IDACreate");
#if SUNDIALS_VERSION_MAJOR < 7
  IDASetErrHandlerFn(m.ida, Memory::message, &m);
#endif
  m.require(IDAInit(m.ida, Memory::residual, state.time, m.y, m.y_dot) == IDA_SUCCESS, "IDAInit");
  IDASetUserData(m.ida, &m);
  m.require(IDAWFtolerances(m.ida, Memory::error_weights) == IDA_SUCCESS, "tolerances");
  Memory::map(m.id).setZero();
  Memory::map(m.id).head(m.form.differential_count()).setOnes();
  IDASetId(m.ida, m.id);
  IDASetSuppressAlg(m.ida, SUNTRUE);
  IDASetMaxOrd(m.ida, parameters_.max_order);
  if (parameters_.first_step > 0) IDASetInitStep(m.ida, parameters_.first_step);
  if (parameters_.max_step > 0) IDASetMaxStep(m.ida, parameters_.max_step);

  // 3. The sparse matrix and its solver; a first evaluation tells the pattern.
  m.form.jacobian(state.time, Memory::map(m.y), Memory::map(m.y_dot), 1.0, nullptr);
  m.matrix = SUNSparseMatrix(m.form.size(), m.form.size(), static_cast<sunindextype>(m.form.row_indices().size()),
                             CSC_MAT, m.context);
  m.require(m.matrix, "matrix");
  m.write_pattern(m.matrix);
  m.solver = SUNLinSol_KLU(m.y, m.matrix, m.context);
  m.require(m.solver && IDASetLinearSolver(m.ida, m.solver, m.matrix) == IDA_SUCCESS &&
                IDASetJacFn(m.ida, Memory::jacobian) == IDA_SUCCESS,
            "linear solver");
  SUNLinSol_KLUGetCommon(m.solver)->btf = 0;  // no matching first: rows have no diagonal
}

StepResult Ida::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!memory_ || &memory_->equations != &equations) prepare(equations, state);
  if (!(t_stop > state.time)) return {};
  Memory& m = *memory_;
  m.thrown.clear(), m.said.clear();
  double reached = state.time;
  IDASetStopTime(m.ida, t_stop);
  const int flag = IDASolve(m.ida, t_stop, &reached, m.y, m.y_dot, IDA_ONE_STEP);
  count();
  if (flag < 0) {
    // IDA's unknowns are those of one choice of rows; where the pose asks for another, it begins anew with that.
    const StepResult failure = failed(flag);
    const std::vector<int> left_out = m.left_out;
    if (left_out.empty()) return failure;
    State again = state;
    const IntegratorStatistics so_far = statistics_;
    prepare(equations, again);
    statistics_ = before_ = so_far;
    if (memory_->left_out == left_out) return failure;
    state = again;
    return advance(equations, state, t_stop);
  }
  // Where the equations give no finite values beyond some time, IDA closes in on it with steps that no longer move
  // time.
  m.stalled = flag != IDA_TSTOP_RETURN && reached - state.time <= 1e-15 * std::abs(reached) ? m.stalled + 1 : 0;
  if (m.stalled > kMaxStalled)
    return {StepResult::Outcome::failed,
            "the step shrinks to nothing: the equations give no finite values just ahead, or jump"};
  state.time = flag == IDA_TSTOP_RETURN ? t_stop : reached;
  m.form.unpack(Memory::map(m.y), Memory::map(m.y_dot), state);
  return {};
}

/// IDA has no way to tell its past or to take one.
bool Ida::keep(Archive& archive, EquationsOfMotion& /*equations*/, const State& /*state*/) {
  archive.same("first_step", parameters_.first_step);
  archive.same("max_step", parameters_.max_step);
  archive.same("max_order", parameters_.max_order);
  archive.same("relative tolerance", parameters_.tolerance.relative);
  archive.same("absolute tolerance", parameters_.tolerance.absolute);
  return false;
}

void Ida::count() {
  long steps = 0, evaluations = 0, setups = 0, error_fails = 0, solver_fails = 0, iterations = 0;
  int order = 0, next_order = 0;
  double first = 0, last = 0, next = 0, time = 0;
  IDAGetIntegratorStats(memory_->ida, &steps, &evaluations, &setups, &error_fails, &order, &next_order, &first, &last,
                        &next, &time);
  IDAGetNonlinSolvStats(memory_->ida, &iterations, &solver_fails);
  statistics_ = {.steps = before_.steps + steps,
                 .rejected = before_.rejected + error_fails + solver_fails,
                 .newton_iterations = before_.newton_iterations + iterations,
                 .factorizations = before_.factorizations + setups,
                 .evaluations = before_.evaluations + evaluations};
}

StepResult Ida::failed(int flag) const {
  const Memory& m = *memory_;
  std::string why;
  switch (flag) {
    case IDA_ERR_FAIL:
      why = "the local error stays above the tolerance at the smallest step";
      break;
    case IDA_CONV_FAIL:
    case IDA_NLS_FAIL:
      why = "Newton does not converge at the smallest step";
      break;
    case IDA_LSETUP_FAIL:
    case IDA_LSOLVE_FAIL:
      why = "the iteration matrix is singular";
      break;
    case IDA_RES_FAIL:
      why = "the equations cannot be evaluated" + (m.thrown.empty() ? "" : ": " + m.thrown);
      break;
    case IDA_REP_RES_ERR:
    case IDA_FIRST_RES_FAIL:
      why = "the equations give no finite values, at small steps too";
      break;
    case IDA_TOO_MUCH_ACC:
      why = "the tolerance is below round-off";
      break;
    default:
      why = m.said;
  }
  // The component that erred most, of those tested.
  if ((flag == IDA_ERR_FAIL || flag == IDA_CONV_FAIL || flag == IDA_NLS_FAIL) &&
      IDAGetEstLocalErrors(m.ida, m.errors) == IDA_SUCCESS && IDAGetErrWeights(m.ida, m.weights) == IDA_SUCCESS) {
    Eigen::Index worst = 0;
    Memory::map(m.errors)
        .cwiseProduct(Memory::map(m.weights))
        .head(m.form.differential_count())
        .cwiseAbs()
        .maxCoeff(&worst);
    why += "; largest error in " + m.form.name(static_cast<int>(worst));
  }
  return {StepResult::Outcome::failed, why + " (IDA: " + m.said + ")"};
}

}  // namespace lithe
