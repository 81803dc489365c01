// andrews_raw: Andrews' squeezer without an engine: its seven relative angles and six closing equations written by hand
// (Hairer & Wanner, Solving ODEs II, VII.7), solved by general solvers. What examples of Lithe are measured beside.
//
//   --method ida_ggl     IDA on the stabilised equations of index 2 (q, v, λ, μ), dense linear algebra
//            ida_index1  IDA on q' = v, v' = a(q, v), the multipliers eliminated
//            dop853      Dormand & Prince 8(5,3) on the same
//   --tol 1e-6  relative and absolute; without it 1e-3 ... 1e-14   --repeat 5  runs, the cheapest counts
//
// One JSON line a tolerance; digits: of the worst angle at 0.03 s, relative.
#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <Eigen/Cholesky>

#include "engine/base/math.h"
#include "engine/base/sundials_context_internal.h"
#include "integrators/runge_kutta_tableau.h"
#include "tools/bench/measure.h"
#include "tools/bench/peers/mechanisms.h"

namespace lithe::bench {
namespace {

namespace data = peers::andrews;
using Angles = Eigen::Matrix<double, 7, 1>;  // β, Θ, γ, Φ, δ, Ω, ε
using Loops = Eigen::Matrix<double, 6, 1>;
using State = Eigen::Matrix<double, 14, 1>;  // angles, rates
constexpr double kEnd = 0.03;                // s

/// M q̈ + Gᵀ λ = f, g = 0, G q̈ = γ at one state.
struct Squeezer {
  // The mass matrix: pairs (β, Θ), (Φ, δ), (Ω, ε) and γ alone.
  double m11, m12, m22, m33, m44, m45, m55, m66, m67, m77;
  Angles f;
  Eigen::Matrix<double, 6, 7> G;
  Loops gap, gamma;

  void evaluate(const double* q, const double* v) {
    using namespace data;
    const double *m = kMass, *I = kInertia;
    const double cb = std::cos(q[0]), sb_ = std::sin(q[0]), ct = std::cos(q[1]), st = std::sin(q[1]);
    const double cg = std::cos(q[2]), sg = std::sin(q[2]), cp = std::cos(q[3]), sp = std::sin(q[3]);
    const double cd = std::cos(q[4]), sd_ = std::sin(q[4]), co = std::cos(q[5]), so = std::sin(q[5]);
    const double ce = std::cos(q[6]), se = std::sin(q[6]);
    // Sums of angles: β + Θ, Φ + δ, Ω + ε.
    const double cbt = cb * ct - sb_ * st, sbt = sb_ * ct + cb * st, cpd = cp * cd - sp * sd_, spd = sp * cd + cp * sd_;
    const double coe = co * ce - so * se, soe = so * ce + co * se;
    constexpr double p = e - ea, r = zf - fa;

    m22 = m[1] * da * da + I[1];
    m12 = m22 - m[1] * da * rr * ct;
    m11 = m[0] * ra * ra + m[1] * (rr * rr - 2 * da * rr * ct + da * da) + I[0] + I[1];
    m33 = m[2] * (sa * sa + sb * sb) + I[2];
    m44 = m[3] * p * p + I[3];
    m45 = m44 + m[3] * zt * p * sp;
    m55 = m[3] * (zt * zt + 2 * zt * p * sp + p * p) + m[4] * (ta * ta + tb * tb) + I[3] + I[4];
    m66 = m[5] * r * r + I[5];
    m67 = m66 - m[5] * u * r * so;
    m77 = m[5] * (r * r - 2 * u * r * so + u * u) + m[6] * (ua * ua + ub * ub) + I[5] + I[6];

    // The spring pulls D on K3 towards C.
    const double dx = sd * cg + sc * sg, dy = sd * sg - sc * cg;  // D from B
    const double lx = kB[0] + dx - kC[0], ly = kB[1] + dy - kC[1], length = std::sqrt(lx * lx + ly * ly);
    const double pull = -kStiffness * (length - kRestLength) / length;
    f << kTorque - m[1] * da * rr * v[1] * (v[1] + 2 * v[0]) * st, m[1] * da * rr * v[0] * v[0] * st,
        pull * (ly * dx - lx * dy), m[3] * zt * p * v[4] * v[4] * cp, -m[3] * zt * p * v[3] * (v[3] + 2 * v[4]) * cp,
        -m[5] * u * r * v[6] * v[6] * co, m[5] * u * r * v[5] * (v[5] + 2 * v[6]) * co;

    // E by way of K2, less E by way of K3, K4 and K6.
    const double x = rr * cb - d * cbt, y = rr * sb_ - d * sbt;
    gap << x - ss * sg - kB[0], y + ss * cg - kB[1], x - e * spd - zt * cd - kA[0], y + e * cpd - zt * sd_ - kA[1],
        x - zf * coe - u * se - kA[0], y - zf * soe + u * ce - kA[1];
    G << -y, d * sbt, -ss * cg, 0, 0, 0, 0,                   //
        x, -d * cbt, -ss * sg, 0, 0, 0, 0,                    //
        -y, d * sbt, 0, -e * cpd, -e * cpd + zt * sd_, 0, 0,  //
        x, -d * cbt, 0, -e * spd, -e * spd - zt * cd, 0, 0,   //
        -y, d * sbt, 0, 0, 0, zf * soe, zf * soe - u * ce,    //
        x, -d * cbt, 0, 0, 0, -zf * coe, -zf * coe - u * se;
    // Every point turns about its pin: g̈ at rest of q̈ is the centripetal acceleration.
    const double w1 = v[0] * v[0], w2 = (v[0] + v[1]) * (v[0] + v[1]), w3 = v[2] * v[2], w5 = v[4] * v[4];
    const double w4 = (v[3] + v[4]) * (v[3] + v[4]), w6 = (v[5] + v[6]) * (v[5] + v[6]), w7 = v[6] * v[6];
    const double ax = rr * cb * w1 - d * cbt * w2, ay = rr * sb_ * w1 - d * sbt * w2;
    gamma << ax - ss * sg * w3, ay + ss * cg * w3, ax - e * spd * w4 - zt * cd * w5, ay + e * cpd * w4 - zt * sd_ * w5,
        ax - zf * coe * w6 - u * se * w7, ay - zf * soe * w6 + u * ce * w7;
  }

  Angles times_mass(const Angles& a) const {
    Angles b;
    b << m11 * a[0] + m12 * a[1], m12 * a[0] + m22 * a[1], m33 * a[2], m44 * a[3] + m45 * a[4], m45 * a[3] + m55 * a[4],
        m66 * a[5] + m67 * a[6], m67 * a[5] + m77 * a[6];
    return b;
  }
  /// q̈, and λ: (G M⁻¹ Gᵀ) λ = G M⁻¹ f - γ, the mass matrix pair by pair.
  Angles accelerations(Loops& multipliers) const {
    Eigen::Matrix<double, 7, 7> columns;  // M⁻¹ (Gᵀ, f)
    columns.leftCols<6>() = G.transpose();
    columns.col(6) = f;
    const auto divide = [&](int i, double a, double b, double c) {
      const double s = 1 / (a * c - b * b);
      const Eigen::Matrix<double, 1, 7> first = columns.row(i), second = columns.row(i + 1);
      columns.row(i) = (s * c) * first - (s * b) * second;
      columns.row(i + 1) = (s * a) * second - (s * b) * first;
    };
    divide(0, m11, m12, m22);
    columns.row(2) /= m33;
    divide(3, m44, m45, m55);
    divide(5, m66, m67, m77);
    const Eigen::Matrix<double, 6, 7> product = G * columns;
    multipliers = product.leftCols<6>().llt().solve(product.col(6) - gamma);
    return columns.col(6) - columns.leftCols<6>() * multipliers;
  }
};

State start() {
  State y = State::Zero();
  y.head<7>() = Eigen::Map<const Angles>(data::kStart);
  return y;
}

void rates(Squeezer& squeezer, const double* y, double* y_dot) {
  Loops multipliers;
  squeezer.evaluate(y, y + 7);
  Eigen::Map<Angles>(y_dot + 7) = squeezer.accelerations(multipliers);
  Eigen::Map<Angles>{y_dot} = Eigen::Map<const Angles>(y + 7);
}

struct Run {
  double seconds = 0;
  long steps = 0, evaluations = 0;
  bool finished = true;
  Angles end;
};

/// Hairer's step control; the step starts at a thousandth of the whole.
Run dop853(double tolerance) {
  const RungeKuttaTableau& method = dormand_prince8();
  const int stages = method.stages;
  Squeezer squeezer{};
  std::array<State, 16> k;
  State y = start(), end;
  Run run;
  const double started = cpu_seconds();
  rates(squeezer, y.data(), k[0].data());
  double t = 0, h = 1e-3 * kEnd;
  while (t < kEnd) {
    h = std::min(h, kEnd - t);
    for (int i = 1; i < stages; ++i) {
      State sum = State::Zero();
      for (int j = 0; j < i; ++j)
        if (method.a[i][j] != 0) sum += method.a[i][j] * k[j];
      end = y + h * sum;
      rates(squeezer, end.data(), k[i].data());
    }
    run.evaluations += stages - 1;
    State first = State::Zero(), second = State::Zero();
    for (int j = 0; j < stages; ++j) first += method.error[j] * k[j], second += method.second_error[j] * k[j];
    const State weight = tolerance * (1 + y.cwiseAbs().cwiseMax(end.cwiseAbs()).array());
    const double e1 = first.cwiseQuotient(weight).squaredNorm(), e2 = second.cwiseQuotient(weight).squaredNorm();
    const double size = e1 + 0.01 * e2;
    const double error = size > 0 ? h * e1 / std::sqrt(14 * size) : 0;
    const double factor = std::clamp(0.9 * std::pow(std::max(error, 1e-10), -1.0 / 8), 1.0 / 3, 6.0);
    if (error <= 1) {
      t = kEnd - t <= h ? kEnd : t + h;
      y = end;
      k[0] = k[stages - 1];
      ++run.steps;
    }
    h *= error <= 1 ? factor : std::min(1.0, factor);
  }
  run.seconds = cpu_seconds() - started;
  run.end = y.head<7>();
  return run;
}

/// IDA with dense linear algebra and differenced Jacobians.
class Ida {
 public:
  explicit Ida(bool stabilized) : stabilized_(stabilized), size_(stabilized ? 26 : 14) {}

  Run run(double tolerance) {
    create(tolerance);
    Run result;
    double reached = 0;
    const double started = cpu_seconds();
    result.finished = IDASolve(ida_, kEnd, &reached, y_, y_dot_, IDA_NORMAL) >= 0;
    result.seconds = cpu_seconds() - started;
    IDAGetNumSteps(ida_, &result.steps);
    long differenced = 0;
    IDAGetNumResEvals(ida_, &result.evaluations);
    IDAGetNumLinResEvals(ida_, &differenced);
    result.evaluations += differenced;
    result.end = Eigen::Map<const Angles>(N_VGetArrayPointer(y_));
    destroy();
    return result;
  }

 private:
  void create(double tolerance) {
    context_ = lithe::make_sundials_context();
    y_ = N_VNew_Serial(size_, context_);
    y_dot_ = N_VNew_Serial(size_, context_);
    id_ = N_VNew_Serial(size_, context_);
    double *y = N_VGetArrayPointer(y_), *y_dot = N_VGetArrayPointer(y_dot_), *id = N_VGetArrayPointer(id_);
    N_VConst(0, y_);
    N_VConst(0, y_dot_);
    Eigen::Map<State>{y} = start();
    std::fill(id, id + size_, 0.0);
    std::fill(id, id + 14, 1.0);
    Loops multipliers;
    squeezer_.evaluate(y, y + 7);
    Eigen::Map<Angles>(y_dot + 7) = squeezer_.accelerations(multipliers);
    if (stabilized_) Eigen::Map<Loops>(y + 14) = multipliers;

    ida_ = IDACreate(context_);
#if SUNDIALS_VERSION_MAJOR < 7
    IDASetErrFile(ida_, nullptr);
#else
    SUNContext_ClearErrHandlers(context_);
#endif
    IDAInit(ida_, stabilized_ ? &stabilized_residual : &index1_residual, 0, y_, y_dot_);
    IDASetUserData(ida_, &squeezer_);
    // The multipliers' rounding grows as 1/h: a fine tolerance on them would stop Newton at the first steps.
    N_Vector floor = N_VNew_Serial(size_, context_);
    N_VConst(tolerance, floor);
    if (stabilized_) std::fill_n(N_VGetArrayPointer(floor) + 14, 12, 1.0);
    IDASVtolerances(ida_, tolerance, floor);
    N_VDestroy(floor);
    IDASetMaxNumSteps(ida_, 1000000);
    IDASetStopTime(ida_, kEnd);
    IDASetInitStep(ida_, 1e-6);
    if (stabilized_) {
      IDASetId(ida_, id_);
      IDASetSuppressAlg(ida_, 1);
    }
    matrix_ = SUNDenseMatrix(size_, size_, context_);
    solver_ = SUNLinSol_Dense(y_, matrix_, context_);
    IDASetLinearSolver(ida_, solver_, matrix_);
  }
  void destroy() {
    IDAFree(&ida_);
    SUNLinSolFree(solver_);
    SUNMatDestroy(matrix_);
    for (N_Vector vector : {y_, y_dot_, id_}) N_VDestroy(vector);
    SUNContext_Free(&context_);
  }

  /// Index 2 after Gear, Gupta & Leimkuhler: q' = v - Gᵀ μ,   M v' = f - Gᵀ λ,   G v = 0,   g = 0.
  static int stabilized_residual(double, N_Vector y_vector, N_Vector y_dot_vector, N_Vector residual, void* user) {
    auto& s = *static_cast<Squeezer*>(user);
    const double *y = N_VGetArrayPointer(y_vector), *y_dot = N_VGetArrayPointer(y_dot_vector);
    double* r = N_VGetArrayPointer(residual);
    const Eigen::Map<const Angles> v(y + 7), q_dot(y_dot), v_dot(y_dot + 7);
    const Eigen::Map<const Loops> lambda(y + 14), mu(y + 20);
    s.evaluate(y, y + 7);
    Eigen::Map<Angles>{r} = q_dot - v + s.G.transpose() * mu;
    Eigen::Map<Angles>(r + 7) = s.times_mass(v_dot) - s.f + s.G.transpose() * lambda;
    Eigen::Map<Loops>(r + 14) = s.G * v;
    Eigen::Map<Loops>(r + 20) = s.gap;
    return 0;
  }
  static int index1_residual(double, N_Vector y, N_Vector y_dot, N_Vector residual, void* user) {
    double* r = N_VGetArrayPointer(residual);
    rates(*static_cast<Squeezer*>(user), N_VGetArrayPointer(y), r);
    Eigen::Map<State>{r} = Eigen::Map<const State>(N_VGetArrayPointer(y_dot)) - Eigen::Map<const State>(r);
    return 0;
  }

  const bool stabilized_;
  const int size_;
  Squeezer squeezer_{};
  SUNContext context_ = nullptr;
  N_Vector y_ = nullptr, y_dot_ = nullptr, id_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
  void* ida_ = nullptr;
};

Run run_once(const std::string& method, double tolerance) {
  return method == "dop853" ? dop853(tolerance) : Ida(method == "ida_ggl").run(tolerance);
}

/// Returns whether the solver came to the end.
bool report(const std::string& method, double tolerance, int repeats) {
  Run best = run_once(method, tolerance);
  if (!best.finished) {
    std::fprintf(stderr, "%s gives up at the tolerance %g\n", method.c_str(), tolerance);
    return false;
  }
  for (int i = 1; i < repeats; ++i) {
    const Run again = run_once(method, tolerance);
    if (again.seconds < best.seconds) best = again;
  }
  std::array<double, 7> end{};
  Eigen::Map<Angles>(end.data()) = best.end;
  JsonLine line;
  line.add("program", "andrews_raw").add("method", method).add("tol", tolerance).add("cpu_seconds", best.seconds, 5);
  line.add("digits", -std::log10(data::worst_angle(end)), 4).add("steps", best.steps);
  line.add("evaluations", best.evaluations).print();
  return true;
}

}  // namespace
}  // namespace lithe::bench

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const std::string method = arguments.text("method", "");
    const double tolerance = arguments.number("tol", 0);
    const int repeats = arguments.integer("repeat", 5);
    arguments.finish();
    const std::vector<std::string> known = {"ida_ggl", "ida_index1", "dop853"};
    if (!method.empty() && std::find(known.begin(), known.end(), method) == known.end())
      throw std::invalid_argument("no method '" + method + "'; known are ida_ggl, ida_index1, dop853");
    for (const std::string& one : known) {
      if (!method.empty() && one != method) continue;
      bool going_on = true;
      for (int power = 3; tolerance == 0 && going_on && power <= 14; ++power)
        going_on = report(one, std::pow(10.0, -power), repeats);
      if (tolerance > 0) report(one, tolerance, repeats);
    }
  });
}
