// A pendulum that hangs from a cart on a spring, with equations written by hand: what CVODES and IDAS say about its
// derivatives. A program of its own, since both define what the CVODE and IDA of the engine define.
//   sensitivities: for each package x and θ at the end and their derivatives by the seven parameters, a line each
#include <cvodes/cvodes.h>
#include <idas/idas.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <Eigen/LU>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "engine/base/sundials_context_internal.h"

namespace {

constexpr int kParameters = 7;  // cart, mass, inertia, length, stiffness, damping, speed
constexpr double kValues[kParameters] = {2, 0.8, 0.01, 0.3, 150, 3, 1.5};
constexpr double kGravity = 9.80665, kTilt = 0.5, kEnd = 0.8;
constexpr double kStep = 1e-30;  // of complex parameters: derivatives to round-off

template <class S>
using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1>;
using Complex = std::complex<double>;

Vector<Complex> parameters(int k = -1) {
  Vector<Complex> p(kParameters);
  for (int i = 0; i < kParameters; ++i) p[i] = Complex(kValues[i], i == k ? kStep : 0);
  return p;
}

void require(bool good, const char* what) {
  if (good) return;
  std::fprintf(stderr, "sensitivities: %s failed\n", what);
  std::exit(1);
}

// ---- two coordinates: y = (x, θ, ẋ, θ̇) ----
Vector<Complex> rates(const Vector<Complex>& y, const Vector<Complex>& p) {
  const Complex M = p[0], m = p[1], J = p[2], a = p[3], c = std::cos(y[1]), s = std::sin(y[1]);
  Eigen::Matrix<Complex, 2, 2> mass;
  mass << M + m, -m * a * c, -m * a * c, J + m * a * a;
  const Eigen::Matrix<Complex, 2, 1> force(-m * a * s * y[3] * y[3] - p[4] * y[0] - p[5] * y[2], -m * kGravity * a * s);
  Vector<Complex> y_dot(4);
  y_dot << y[2], y[3], mass.inverse() * force;
  return y_dot;
}

// ---- four coordinates, tied by the hinge: y = (x, X, Z, θ, their rates, λ) ----
// X and Z of the pendulum's centre, x of the cart; X = x - a sin θ, Z = -a cos θ, differentiated twice.
Vector<Complex> residual(const Vector<Complex>& y, const Vector<Complex>& y_dot, const Vector<Complex>& p) {
  const Complex a = p[3], c = std::cos(y[3]), s = std::sin(y[3]), w = y[7];
  const auto v_dot = y_dot.segment<4>(4);
  Vector<Complex> r(10);
  r.head<4>() = y_dot.head<4>() - y.segment<4>(4);
  r[4] = p[0] * v_dot[0] + p[4] * y[0] + p[5] * y[4] - y[8];
  r[5] = p[1] * v_dot[1] + y[8];
  r[6] = p[1] * (v_dot[2] + kGravity) + y[9];
  r[7] = p[2] * v_dot[3] + a * c * y[8] - a * s * y[9];
  r[8] = v_dot[1] - v_dot[0] + a * c * v_dot[3] - a * s * w * w;
  r[9] = v_dot[2] - a * s * v_dot[3] - a * c * w * w;
  return r;
}
/// y at the start; ẏ there from the equations, which are linear in v̇ and λ.
std::pair<Vector<Complex>, Vector<Complex>> start(const Vector<Complex>& p) {
  const Complex a = p[3], w = p[6];
  Vector<Complex> y = Vector<Complex>::Zero(10), y_dot = y;
  y.head<4>() << 0, -a * std::sin(kTilt), -a * std::cos(kTilt), kTilt;
  y.segment<4>(4) << 0, -a * std::cos(kTilt) * w, a * std::sin(kTilt) * w, w;
  y_dot.head<4>() = y.segment<4>(4);
  const Vector<Complex> r = residual(y, y_dot, p).tail<6>();
  Eigen::Matrix<Complex, 6, 6> A;
  for (int i = 0; i < 6; ++i) {
    Vector<Complex> y_moved = y, rate_moved = y_dot;
    (i < 4 ? rate_moved[4 + i] : y_moved[4 + i]) += 1;
    A.col(i) = residual(y_moved, rate_moved, p).tail<6>() - r;
  }
  const Vector<Complex> found = -A.partialPivLu().solve(r);
  y_dot.segment<4>(4) = found.head<4>();
  y.tail<2>() = found.tail<2>();
  return {y, y_dot};
}

Eigen::Map<Eigen::VectorXd> map(N_Vector v) { return {N_VGetArrayPointer(v), N_VGetLength(v)}; }
Vector<Complex> complex_of(N_Vector value, N_Vector part) {
  Vector<Complex> z = map(value).cast<Complex>();
  z.imag() = kStep * map(part);
  return z;
}

int ode(double, N_Vector y, N_Vector y_dot, void*) {
  map(y_dot) = rates(map(y).cast<Complex>(), parameters()).real();
  return 0;
}
int ode_derivatives(int, double, N_Vector y, N_Vector, N_Vector* s, N_Vector* s_dot, void*, N_Vector, N_Vector) {
  for (int k = 0; k < kParameters; ++k) map(s_dot[k]) = rates(complex_of(y, s[k]), parameters(k)).imag() / kStep;
  return 0;
}
int dae(double, N_Vector y, N_Vector y_dot, N_Vector r, void*) {
  map(r) = residual(map(y).cast<Complex>(), map(y_dot).cast<Complex>(), parameters()).real();
  return 0;
}
int dae_derivatives(int, double, N_Vector y, N_Vector y_dot, N_Vector, N_Vector* s, N_Vector* s_dot, N_Vector* r, void*,
                    N_Vector, N_Vector, N_Vector) {
  for (int k = 0; k < kParameters; ++k)
    map(r[k]) = residual(complex_of(y, s[k]), complex_of(y_dot, s_dot[k]), parameters(k)).imag() / kStep;
  return 0;
}

/// Of entries x and θ.
void print(const char* package, N_Vector y, N_Vector* s, int angle) {
  for (const int row : {0, angle}) {
    std::printf("%s %.17g", package, map(y)[row]);
    for (int k = 0; k < kParameters; ++k) std::printf(" %.17g", map(s[k])[row]);
    std::printf("\n");
  }
}

struct Problem {
  explicit Problem(int size) {
    y = N_VNew_Serial(size, context);
    s = N_VCloneVectorArray(kParameters, y);
    matrix = SUNDenseMatrix(size, size, context);
    solver = SUNLinSol_Dense(y, matrix, context);
    tolerances.assign(kParameters, 1e-13);
  }
  Problem(const Problem&) = delete;
  ~Problem() {
    SUNLinSolFree(solver);
    SUNMatDestroy(matrix);
    N_VDestroyVectorArray(s, kParameters);
    N_VDestroy(y);
    SUNContext_Free(&context);
  }
  SUNContext context = lithe::make_sundials_context();
  N_Vector y = nullptr;
  N_Vector* s = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver solver = nullptr;
  std::vector<double> tolerances;
};

void by_cvodes() {
  Problem problem(4);
  map(problem.y) << 0, kTilt, 0, kValues[6];
  for (int k = 0; k < kParameters; ++k) map(problem.s[k]).setZero();
  map(problem.s[6])[3] = 1;
  void* memory = CVodeCreate(CV_ADAMS, problem.context);
  double t = 0;
  require(CVodeInit(memory, ode, 0, problem.y) == 0 && CVodeSStolerances(memory, 1e-12, 1e-13) == 0 &&
              CVodeSetLinearSolver(memory, problem.solver, problem.matrix) == 0 &&
              CVodeSensInit(memory, kParameters, CV_STAGGERED, ode_derivatives, problem.s) == 0 &&
              CVodeSensSStolerances(memory, 1e-12, problem.tolerances.data()) == 0 &&
              CVodeSetSensErrCon(memory, SUNTRUE) == 0 && CVodeSetMaxNumSteps(memory, 1000000) == 0,
          "CVODES");
  require(CVode(memory, kEnd, problem.y, &t, CV_NORMAL) >= 0 && CVodeGetSens(memory, &t, problem.s) == 0, "CVODES");
  print("CVODES", problem.y, problem.s, 1);
  CVodeFree(&memory);
}

void by_idas() {
  Problem problem(10);
  N_Vector y_dot = N_VClone(problem.y);
  N_Vector* s_dot = N_VCloneVectorArray(kParameters, problem.y);
  for (int k = 0; k < kParameters; ++k) {
    const auto [y, rate] = start(parameters(k));
    map(problem.y) = y.real(), map(y_dot) = rate.real();
    map(problem.s[k]) = y.imag() / kStep, map(s_dot[k]) = rate.imag() / kStep;
  }
  N_Vector differential = N_VClone(problem.y);  // not λ, which the error test is to leave out
  map(differential) << Eigen::VectorXd::Ones(8), 0, 0;
  void* memory = IDACreate(problem.context);
  double t = 0;
  require(IDAInit(memory, dae, 0, problem.y, y_dot) == 0 && IDASStolerances(memory, 1e-12, 1e-13) == 0 &&
              IDASetLinearSolver(memory, problem.solver, problem.matrix) == 0 &&
              IDASensInit(memory, kParameters, IDA_STAGGERED, dae_derivatives, problem.s, s_dot) == 0 &&
              IDASensSStolerances(memory, 1e-12, problem.tolerances.data()) == 0 &&
              IDASetSensErrCon(memory, SUNTRUE) == 0 && IDASetId(memory, differential) == 0 &&
              IDASetSuppressAlg(memory, SUNTRUE) == 0 && IDASetMaxNumSteps(memory, 20000) == 0,
          "IDAS");
  require(IDASolve(memory, kEnd, &t, problem.y, y_dot, IDA_NORMAL) >= 0 && IDAGetSens(memory, &t, problem.s) == 0,
          "IDAS");
  print("IDAS", problem.y, problem.s, 3);
  IDAFree(&memory);
  N_VDestroyVectorArray(s_dot, kParameters);
  for (N_Vector x : {y_dot, differential}) N_VDestroy(x);
}

}  // namespace

int main() {
  by_cvodes();
  by_idas();
}
