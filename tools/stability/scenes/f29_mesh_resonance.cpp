// F29: a gear on teeth whose stiffness varies with twice its natural frequency, damped by a little less than what makes
// it rest: it swings up. Methods that damp say that it comes to rest.
#include "bodies/rigid_body.h"
#include "engine/base/dense.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/revolute_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kFrequency = 500, kInertia = 1e-3, kVaries = 0.2;  // rad/s, kg m²; ε
constexpr double kRatio = 0.042;                                    // of critical damping; threshold ε / 4
constexpr int kCycles = 60;
const double kPeriod = 2 * M_PI / kFrequency;

double acceleration(double t, double x, double v) {
  return -kFrequency * kFrequency * (1 + kVaries * std::cos(2 * kFrequency * t)) * x - 2 * kRatio * kFrequency * v;
}

/// Of φ'' + 2 ζ ω φ' + ω² (1 + ε cos 2 ω t) φ = 0: what a period of the stiffness, half a cycle, makes of (φ, φ'), by
/// Runge-Kutta in 20,000 steps.
struct Floquet {
  Floquet() {
    constexpr int kSteps = 20000;
    const double h = kPeriod / 2 / kSteps;
    Eigen::Matrix2d all;
    for (int column = 0; column < 2; ++column) {
      Eigen::Vector2d y = Eigen::Vector2d::Unit(column);
      const auto f = [](double t, const Eigen::Vector2d& at) {
        return Eigen::Vector2d(at[1], acceleration(t, at[0], at[1]));
      };
      for (int i = 0; i < kSteps; ++i) {
        const double t = i * h;
        const Eigen::Vector2d a = f(t, y), b = f(t + h / 2, y + h / 2 * a), c = f(t + h / 2, y + h / 2 * b),
                              d = f(t + h, y + h * c);
        y += h / 6 * (a + 2 * b + 2 * c + d);
      }
      all.col(column) = y;
    }
    const Eigen::EigenSolver<MatrixX> solver{MatrixX(all)};
    Eigen::Index largest = 0;
    solver.eigenvalues().cwiseAbs().maxCoeff(&largest);
    multiplier = std::abs(solver.eigenvalues()[largest]);
    motion = solver.eigenvectors().col(largest).real();
    motion *= 1e-3 / motion[0];
  }
  double multiplier;
  Eigen::Vector2d motion;  // that grows by it alone
};

Finding swings_up(Integrator& method) {
  const Floquet exact;
  Bench bench({0, 0, 0}, [](SystemGraph& graph) {
    auto& gear = graph.add<RigidBody>("gear", {.mass = 1, .inertia = {kInertia, kInertia, kInertia}});
    auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker(), gear.marker()});
    graph.add<CoordinateMotor>("teeth", {pin.angle()}, {.effort = [](double t, double x, double v) {
                                 return kInertia * acceleration(t, x, v);
                               }});
  });
  bench.state.q.segment<4>(3) << std::cos(exact.motion[0] / 2), 0, 0, std::sin(exact.motion[0] / 2);
  bench.state.v[5] = exact.motion[1];
  const Bench::Course course = bench.run(method, kCycles * kPeriod);
  const double angle = 2 * std::atan2(bench.state.q[6], bench.state.q[3]);
  const double growth = angle / exact.motion[0], expected = std::pow(exact.multiplier, 2 * kCycles);
  return {judged(growth / expected - 1, 0.05),
          {{"swing after 60 cycles, of the first", growth},
           {"by Floquet's multiplier", expected},
           {"steps a cycle", static_cast<double>(course.steps) / kCycles}},
          course.why};
}

const Registered scene{with_candidates({"F29", "gear teeth at parametric resonance", {}},
                                       {automatic(1e-8), radau(1e-8), runge_kutta8(1e-8), alpha(kPeriod / 20),
                                        alpha(kPeriod / 500), hht(kPeriod / 50), linearly_implicit(kPeriod / 200)},
                                       {1e-8, kPeriod / 500}, swings_up)};

}  // namespace
}  // namespace lithe::lab
