#include "integrators/adams.h"

#include <cvode/cvode.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/motion/projection.h"
#include "integrators/sundials_internal.h"

namespace lithe {
namespace {

constexpr int kMaxStalled = 10;  // steps in a row that do not move time
constexpr int kMaxProjections = 10;
// CVODE lets every step err by all that is allowed and does not extrapolate, so errors add up over a run. Told a tenth,
// runs err about as they do by Runge-Kutta methods told all.
constexpr double kShare = 0.1;
// Growth of the step from which it is worth while: CVODE's own 1.5 spares Jacobians, which there are none of here, and
// keeps the order low (measured: twice the evaluations for a spinning top).
constexpr double kLeastGrowth = 1.2;
constexpr double kPositionTolerance = 1e-14;  // |g| after a step, in the units of the rows; or round-off if larger

}  // namespace

struct Adams::Memory : SundialsMemory<Adams::Memory> {
  EquationsOfMotion& equations;
  const Layout& layout;
  Projector projector;
  Tolerance tolerance;
  int nq, nv, rows;
  std::vector<int> rotations;   // first of each e within q
  std::vector<int> velocities;  // the velocity that each component of y belongs to
  double evaluation_tolerance;  // |g| where f is evaluated
  long evaluations = 0, factorizations = 0;
  int stalled = 0;
  double begin = 0, end = 0;                   // of the last step, s
  VectorX offset, offset_before;               // what y is off the constraints, set aside; of its end and of its begin
  VectorX q, v, v_dot, lambda, dv, dl, place;  // the state evaluated last; scratch
  N_Vector y = nullptr, within = nullptr, errors = nullptr, weights = nullptr;
  SUNNonlinearSolver solver = nullptr;
  void* cvode = nullptr;

  Memory(EquationsOfMotion& of, const Tolerance& allowed)
      : equations(of),
        layout(of.layout()),
        projector(of),
        tolerance(allowed),
        nq(layout.q_count()),
        nv(layout.v_count()),
        rows(layout.row_count()),
        // A thousandth of what a step may err: no more is felt, and the last factor gets there in few iterations.
        evaluation_tolerance(
            std::clamp(1e-3 * kShare * (allowed.absolute + allowed.relative), kPositionTolerance, 1e-6)) {
    for (const Layout::BodySlice& b : layout.bodies()) {
      if (b.frame) rotations.push_back(b.q + 3);
      for (int i = 0; i < (b.frame ? 7 : 0) + b.linear; ++i)
        velocities.push_back(b.v + (b.frame && i >= 3 ? std::max(i - 1, 3) : i));
    }
    for (int i = 0; i < nv; ++i) velocities.push_back(i);
    for (VectorX* x : {&offset, &offset_before}) x->setZero(nq + nv);
    for (VectorX* x : {&q, &place}) x->setZero(nq);
    for (VectorX* x : {&v, &v_dot, &dv}) x->setZero(nv);
    for (VectorX* x : {&lambda, &dl}) x->setZero(rows);
    for (N_Vector* x : {&y, &within, &errors, &weights}) *x = N_VNew_Serial(nq + nv, context);
  }
  ~Memory() {
    if (cvode) CVodeFree(&cvode);
    if (solver) SUNNonlinSolFree(solver);
    for (N_Vector x : {y, within, errors, weights})
      if (x) N_VDestroy(x);
  }
  void require(bool done, const char* what) const { SundialsMemory::require(done, what, "Adams"); }

  void normalize(VectorRef coordinates) const {
    for (int r : rotations) coordinates.segment<4>(r).normalize();
  }

  /// q and v of y, q on g = 0 within `allowed`: the last factor is near enough, or else new ones are made.
  bool project_position(double time, ConstVectorRef at, double allowed) {
    q = at.head(nq) - offset.head(nq);
    v = at.tail(nv) - offset.tail(nv);
    normalize(q);
    place = q;
    if (projector.position(time, q, allowed, kMaxProjections, Projector::Factor::last).converged) return true;
    q = place;
    return projector.position(time, q, allowed, kMaxProjections, Projector::Factor::fresh).converged;
  }

  static int rate(double time, N_Vector y, N_Vector y_dot, void* user) {
    return guarded(user, [&](Memory& m) {
      if (!m.project_position(time, map(y), m.evaluation_tolerance)) return false;
      m.projector.velocity(time, m.q, m.v);  // makes the factor
      m.projector.accelerations(time, m.q, m.v, m.v_dot, m.lambda,
                                m.rows > 0 ? Projector::Factor::last : Projector::Factor::fresh);
      ++m.evaluations, ++m.factorizations;
      m.coordinate_rates(map(y_dot));
      return map(y_dot).allFinite();
    });
  }

  /// (q̇, v̇) of the state evaluated last.
  void coordinate_rates(VectorRef out) const {
    for (const Layout::BodySlice& b : layout.bodies()) {
      if (b.frame) {
        Vector4 omega;
        omega << 0, v.segment<3>(b.v + 3);
        out.segment<3>(b.q) = v.segment<3>(b.v);
        out.segment<4>(b.q + 3) = 0.5 * quaternion_product(q.segment<4>(b.q + 3), omega);
      }
      out.segment(b.q + (b.frame ? 7 : 0), b.linear) = v.segment(b.v + (b.frame ? 6 : 0), b.linear);
    }
    out.tail(nv) = v_dot;
  }

  /// The state at the end of a step: y on the constraints to round-off, by the factor of the last evaluation, which was
  /// made there but for the last correction of y. What y is off them is set aside.
  bool settle(double time) {
    if (!project_position(time, map(y), kPositionTolerance)) return false;
    double before = std::numeric_limits<double>::infinity();
    for (int i = 0; rows > 0 && i < kMaxProjections; ++i) {
      equations.evaluate(time, q, v, Level::velocity);
      equations.constraint(Level::velocity, dl);
      const double size = dl.cwiseAbs().maxCoeff();
      if (!(size > kPositionTolerance && size < 0.5 * before)) break;
      before = size;
      dv.setZero();
      dl = -dl;
      equations.solve(dv, dl);
      v += dv;
    }
    const auto factor = rows > 0 ? Projector::Factor::last : Projector::Factor::fresh;
    projector.accelerations(time, q, v, v_dot, lambda, factor);
    ++evaluations;
    if (factor == Projector::Factor::fresh) ++factorizations;
    offset_before.swap(offset);
    offset.head(nq) = map(y).head(nq) - q;
    offset.tail(nv) = map(y).tail(nv) - v;
    return q.allFinite() && v_dot.allFinite();
  }

  static int error_weights(N_Vector y, N_Vector out, void* user) {
    return guarded(user, [&](Memory& m) {
      const double a = kShare * m.tolerance.absolute, r = kShare * m.tolerance.relative;
      map(out) = (a + r * (map(y) - m.offset).array().abs()).inverse();
      for (int at : m.rotations) map(out).segment<4>(at).setConstant(2 / (a + r));  // e turns by half
      return true;
    });
  }

  /// The velocity whose motion erred most in the last step; -1: none.
  int worst_velocity() {
    if (CVodeGetEstLocalErrors(cvode, errors) != CV_SUCCESS || CVodeGetErrWeights(cvode, weights) != CV_SUCCESS)
      return -1;
    Eigen::Index worst = 0;
    if (nv > 0) map(errors).cwiseProduct(map(weights)).cwiseAbs().maxCoeff(&worst);
    return nv > 0 ? velocities[static_cast<std::size_t>(worst)] : -1;
  }
};

Adams::Adams(Parameters parameters) : parameters_(parameters) { check_sundials("Adams", parameters, 12); }

Adams::~Adams() = default;

void Adams::prepare(EquationsOfMotion& equations, State& state) {
  // 1. A consistent start: positions, velocities, accelerations and multipliers.
  if (!resumes()) statistics_ = {};
  memory_ = std::make_unique<Memory>(equations, parameters_.tolerance);
  Memory& m = *memory_;
  m.projector.position(state.time, state.q, kPositionTolerance, kMaxProjections, Projector::Factor::first);
  m.projector.velocity(state.time, state.q, state.v);
  state.v_dot.resize(m.nv);
  state.lambda.setZero(m.rows);
  m.projector.accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  m.begin = m.end = state.time;

  // 2. CVODE's own objects.
  m.require(m.context && m.y && m.within && m.errors && m.weights, "vectors");
  Memory::map(m.y).head(m.nq) = state.q;
  Memory::map(m.y).tail(m.nv) = state.v;
  m.cvode = CVodeCreate(CV_ADAMS, m.context);
  m.require(m.cvode, "CVodeCreate");
#if SUNDIALS_VERSION_MAJOR < 7
  CVodeSetErrHandlerFn(m.cvode, Memory::message, &m);
#endif
  m.require(CVodeInit(m.cvode, Memory::rate, state.time, m.y) == CV_SUCCESS, "CVodeInit");
  CVodeSetUserData(m.cvode, &m);
  m.require(CVodeWFtolerances(m.cvode, Memory::error_weights) == CV_SUCCESS, "tolerances");
  CVodeSetEtaFixedStepBounds(m.cvode, 0, kLeastGrowth);
  CVodeSetMaxOrd(m.cvode, parameters_.max_order);
  if (parameters_.first_step > 0) CVodeSetInitStep(m.cvode, parameters_.first_step);
  if (parameters_.max_step > 0) CVodeSetMaxStep(m.cvode, parameters_.max_step);
  m.solver = SUNNonlinSol_FixedPoint(m.y, 0, m.context);
  m.require(m.solver && CVodeSetNonlinearSolver(m.cvode, m.solver) == CV_SUCCESS, "fixed-point iteration");
}

StepResult Adams::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!memory_ || &memory_->equations != &equations) prepare(equations, state);
  if (!(t_stop > state.time)) return {};
  Memory& m = *memory_;
  m.thrown.clear(), m.said.clear();
  // What is left is halved rather than ended by a sliver, after which the step would have to grow again.
  double next = 0, reached = state.time;
  const double left = t_stop - state.time;
  CVodeGetCurrentStep(m.cvode, &next);
  const bool halve = next < left * (1 - 1e-9) && left < 2 * next;
  CVodeSetStopTime(m.cvode, halve ? state.time + left / 2 : t_stop);
  const int flag = CVode(m.cvode, t_stop, m.y, &reached, CV_ONE_STEP);
  count();
  // An exception ends the run, though CVODE would try shorter steps.
  if (!m.thrown.empty()) return failed(CV_RHSFUNC_FAIL);
  if (flag < 0) return failed(flag);
  const bool stopped = flag == CV_TSTOP_RETURN;
  m.stalled = !stopped && reached - state.time <= 1e-15 * std::abs(reached) ? m.stalled + 1 : 0;
  if (m.stalled > kMaxStalled)
    return {StepResult::Outcome::failed,
            "the step shrinks to nothing: the equations give no finite values just ahead, or jump"};
  const double time = stopped && !halve ? t_stop : reached;
  if (!m.settle(time)) return {StepResult::Outcome::failed, "the end of the step cannot be moved onto the constraints"};
  m.begin = state.time, m.end = time;
  state.time = time;
  state.q = m.q;
  state.v = m.v;
  state.v_dot = m.v_dot;
  state.lambda = m.lambda;
  count();
  return {};
}

/// CVODE has no way to tell its past or to take one.
bool Adams::keep(Archive& archive, EquationsOfMotion& /*equations*/, const State& /*state*/) {
  archive.same("first_step", parameters_.first_step);
  archive.same("max_step", parameters_.max_step);
  archive.same("max_order", parameters_.max_order);
  archive.same("relative tolerance", parameters_.tolerance.relative);
  archive.same("absolute tolerance", parameters_.tolerance.absolute);
  return false;
}

void Adams::interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const {
  if (!memory_ || memory_->begin != from.time || memory_->end != to.time || !(to.time > from.time))
    return Integrator::interpolate(layout, from, to, time, out);
  Memory& m = *memory_;
  const double s = (time - from.time) / (to.time - from.time);
  if (CVodeGetDky(m.cvode, time, 1, m.errors) != CV_SUCCESS || CVodeGetDky(m.cvode, time, 0, m.within) != CV_SUCCESS)
    return Integrator::interpolate(layout, from, to, time, out);
  Memory::map(m.within) -= (1 - s) * m.offset_before + s * m.offset;
  out.time = time;
  out.q = Memory::map(m.within).head(m.nq);
  m.normalize(out.q);
  out.v = Memory::map(m.within).tail(m.nv);
  out.v_dot = Memory::map(m.errors).tail(m.nv);
  out.lambda = (1 - s) * from.lambda + s * to.lambda;
  out.quarter_turns = from.quarter_turns;
  out.contacts = from.contacts;
}

void Adams::count() {
  long steps = 0, evaluations = 0, setups = 0, error_fails = 0, iterations = 0, solver_fails = 0;
  int order = 0, next_order = 0;
  double first = 0, last = 0, next = 0, time = 0;
  CVodeGetIntegratorStats(memory_->cvode, &steps, &evaluations, &setups, &error_fails, &order, &next_order, &first,
                          &last, &next, &time);
  CVodeGetNonlinSolvStats(memory_->cvode, &iterations, &solver_fails);
  statistics_ = {.steps = steps,
                 .rejected = error_fails + solver_fails,
                 .newton_iterations = iterations,
                 .factorizations = memory_->factorizations,
                 .evaluations = memory_->evaluations,
                 .newton_failures = solver_fails,
                 .limiting = steps > 0 ? memory_->worst_velocity() : -1};
}

StepResult Adams::failed(int flag) {
  Memory& m = *memory_;
  std::string why;
  switch (flag) {
    case CV_ERR_FAILURE:
      why = "the local error stays above the tolerance at the smallest step";
      break;
    case CV_CONV_FAILURE:
    case CV_NLS_FAIL:
      why = "the corrector does not converge at the smallest step: too stiff for it";
      break;
    case CV_RHSFUNC_FAIL:
      why = "the equations cannot be evaluated: " + m.thrown;
      break;
    case CV_FIRST_RHSFUNC_ERR:
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR:
      why = "the equations give no finite values, at small steps too";
      break;
    case CV_TOO_MUCH_ACC:
      why = "the tolerance is below round-off";
      break;
    default:
      why = "no step can be taken";
  }
  const int worst = flag == CV_ERR_FAILURE || flag == CV_CONV_FAILURE ? m.worst_velocity() : -1;
  if (worst >= 0) why += "; largest error in " + m.layout.velocity_name(worst);
  if (!m.said.empty()) why += " (CVODE: " + m.said + ")";
  return {StepResult::Outcome::failed, why};
}

}  // namespace lithe
