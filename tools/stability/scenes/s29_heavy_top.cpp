// S29: the heavy top over 67 nutations: a rotation of 0.75 rad a step is too much for RK4, and normalising hides it.
#include "bodies/rigid_body.h"
#include "engine/base/error.h"
#include "joints/spherical_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/free_body.h"

namespace lithe::lab {
namespace {

constexpr double kMass = 15, kArm = 1, kWeight = kMass * 9.81, kAcross = 0.234375, kAxial = 0.46875;
constexpr double kTotal = kAcross + kMass * kArm * kArm;    // about the fixed point
constexpr double kEnd = 50, kLimit = 1, kNormLimit = 1e-8;  // s, J
const Vector3 kOmega(0, 150, -4.61538);

/// y = (e, ω); the axis is the body's y.
VectorX top(double, const VectorX& y) {
  // The vertical in body axes, right for unit quaternions alone: what others compute as the norm drifts.
  const Vector3 up(2 * (y[1] * y[3] - y[0] * y[2]), 2 * (y[2] * y[3] + y[0] * y[1]),
                   1 - 2 * (y[1] * y[1] + y[2] * y[2]));
  const Vector3 w = y.tail<3>();
  VectorX out(7);
  out << quaternion_rates(y.head<4>(), w), (-kArm * kWeight * up.z() - (kTotal - kAxial) * w[1] * w[2]) / kTotal, 0,
      (kArm * kWeight * up.x() - (kAxial - kTotal) * w[0] * w[1]) / kTotal;
  return out;
}
double energy(const VectorX& y) {
  return 0.5 * (kTotal * (y[4] * y[4] + y[6] * y[6]) + kAxial * y[5] * y[5]) +
         kWeight * kArm * 2 * (y[2] * y[3] + y[0] * y[1]);
}

struct Result {
  double energy_error = 0, norm = 0, end = 0;  // J; |e| - 1; s
};
template <class Step>
Result follow(Step&& step, double h, bool normalised = false) {
  VectorX y(7);
  y << 1, 0, 0, 0, kOmega;
  const double start = energy(y);
  Result r;
  const long count = std::lround(kEnd / h);
  for (long k = 0; k < count; ++k) {
    y = step(top, 0, y, h);
    if (normalised) y.head<4>().normalize();
    r.end = h * static_cast<double>(k);
    if (!y.allFinite() || std::abs(y[4]) > 1e6) {
      r.energy_error = INFINITY;
      return r;
    }
    r.energy_error = std::max(r.energy_error, std::abs(energy(y) - start));
  }
  r.norm = y.head<4>().norm() - 1;
  return r;
}
Finding finding(const Result& r, double energy_error, double norm, const std::string& why) {
  return {std::abs(r.norm) > kNormLimit && std::isfinite(r.energy_error) ? Outcome::inaccurate
                                                                         : judged(r.energy_error, kLimit),
          {{"energy error to 50 s, J", r.energy_error, energy_error}, {"norm - 1 at 50 s", r.norm, norm, 2}},
          why};
}

Finding explicit_euler() {
  const Result r = follow(euler_step, 1e-3);
  return {std::isfinite(r.energy_error) ? Outcome::inaccurate : Outcome::unstable,
          {{"blows up at, s", r.end, 0.51}},
          "as S21"};
}
Finding midpoint() {
  Finding coarse = finding(follow(midpoint_step, 5e-3), 0.37, NAN, "bounded, second order");
  coarse.figures.push_back({"h = 2e-3: energy error, J", follow(midpoint_step, 2e-3).energy_error, 0.063});
  return coarse;
}

/// y = (φ, θ, ψ, φ̇, θ̇, ψ̇): precession about the vertical, nutation of the axis from it, spin. Lagrange's top; φ̇
/// follows from two momenta, over sin² θ.
Finding euler_angles() {
  const double spin = kAxial * kOmega[1];  // about the axis, and about the vertical: both conserved
  const double vertical = kTotal * kOmega[2];
  const Rates rates = [&](double, const VectorX& y) {
    const double s = std::sin(y[0]), c = std::cos(y[0]), turn = (vertical - spin * c) / (kTotal * s * s);
    return VectorX(
        Eigen::Vector3d(y[1], (kTotal * turn * turn * s * c - spin * turn * s + kWeight * kArm * s) / kTotal, turn));
  };
  const AdaptiveRun run =
      run_as_scipy(dormand_prince8(), rates, 0, kEnd, Vector3(M_PI / 2, -kOmega[0], 0), 1e-9, 1e-12, 1'000'000);
  const double angle = run.y[0];
  if (run.smallest_step < 1e-6)
    throw SimulationError("the rates of Euler's angles grow without bound as the axis comes to the vertical",
                          "the step fell to " + step_text(run.smallest_step) + " at best", "use quaternions");
  return {Outcome::converged, {{"smallest step, s", run.smallest_step}, {"nutation at the end, rad", angle}}, ""};
}

Finding judge(Integrator& method) {
  Bench scene({0, 0, -9.81}, [](SystemGraph& graph) {
    const Vector3 center(0, kArm, 0);
    auto& body = graph.add<RigidBody>("top", {.mass = kMass,
                                              .inertia = {kAcross, kAxial, kAcross},
                                              .position = center,
                                              .velocity = kOmega.cross(center),
                                              .angular_velocity = kOmega});
    graph.add<SphericalJoint>("tip", {graph.ground().marker(), body.marker(-center)});
  });
  const auto course = scene.run(method, kEnd, {}, 1e4);
  return {course.reached ? judged(course.energy_error, kLimit) : Outcome::unstable,
          {{"energy error to 50 s, J", course.energy_error},
           {"norm - 1 at 50 s", scene.state.q.segment<4>(3).norm() - 1},
           {"steps", static_cast<double>(course.steps)}},
          course.why};
}

const Registered scene{with_candidates(
    {"S29",
     "heavy top over long time",
     {{"explicit Euler h = 1e-3", explicit_euler},
      {"RK4 h = 5e-3",
       [] {
         return finding(follow(rk4_step, 5e-3), 279, -0.17, "rotation of 0.75 rad a step: dissipation of order h⁵");
       }},
      {"RK4 h = 5e-3, normalised",
       [] {
         return finding(follow(rk4_step, 5e-3, true), 309, NAN, "normalising hides the error, does not remove it");
       }},
      {"RK4 h = 2e-3", [] { return finding(follow(rk4_step, 2e-3), 43, -2e-3, "the same, smaller"); }},
      {"implicit midpoint h = 5e-3 / 2e-3", midpoint},
      {"Euler angles", euler_angles}}},
    {automatic(1e-7), runge_kutta8(1e-9), adams(1e-9), rattle(2e-3), alpha(2e-3)}, {1e-7, 2e-3}, judge)};

}  // namespace
}  // namespace lithe::lab
