// S27: a pole of 1 kg on a cart of 1e-6 kg turns over within a microsecond: step control that steps over it reports
// success.
#include "joints/distance_joint.h"
#include "joints/prismatic_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/extrapolation.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

constexpr double kCart = 1e-6, kEnd = 10, kLimit = 1e-6;  // kg, s, rad
constexpr double kExact = -1.54912944189482817;           // θ at 10 s, R17 in 34 digits

/// y = (x, θ, ẋ, θ̇)
VectorX cart_pole(double, const VectorX& y) {
  const double s = std::sin(y[1]), c = std::cos(y[1]);
  const double a = (y[3] * y[3] + kGravity * c) * s / (kCart + s * s);
  return Vector4(y[2], y[3], a, -a * c - kGravity * s);
}
Finding scipy(const RungeKuttaTableau& tableau, double relative, double absolute, double published,
              const std::string& why) {
  const AdaptiveRun run = run_as_scipy(tableau, cart_pole, 0, kEnd, Vector4(0, M_PI / 2, 0, 0), relative, absolute);
  const double error = std::abs(run.y[1] - kExact);
  return {run.reached ? judged(error, kLimit) : Outcome::unstable,
          // Ours steps as SciPy does, but not digit by digit: what is left after eleven missed peaks is of that size.
          {{"θ error at 10 s, rad", error, published, 0},
           {"evaluations", static_cast<double>(run.evaluations)},
           {"smallest step, s", run.smallest_step}},
          why};
}

Finding extrapolated() {
  using Method = Extrapolation<4>;
  Method method({.columns = 9, .tolerance = 1e-16, .scale = {1, 1, 3, 3}});
  Method::Vector y{0, M_PIl / 2, 0, 0};
  const bool reached = method.run(
      [](long double, const Method::Vector& x) -> Method::Vector {
        constexpr long double g = 9.81L, M = 1e-6L;
        const long double s = std::sin(x[1]), c = std::cos(x[1]), a = (x[3] * x[3] + g * c) * s / (M + s * s);
        return {x[2], x[3], a, -a * c - g * s};
      },
      0, kEnd, y);
  const double error = std::abs(static_cast<double>(y[1] + 1.54912944189482817L));
  return {reached ? judged(error, kLimit) : Outcome::unstable, {{"θ error at 10 s, rad", error}}, "order 18"};
}

class LightCart : public Bench {
 public:
  LightCart()
      : Bench({0, -kGravity, 0}, [](SystemGraph& graph) {
          const Matrix3 along_x = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), Vector3::UnitX()).matrix();
          auto& cart = graph.add<RigidBody>("cart", {.mass = kCart, .inertia = {kCart, kCart, kCart}});
          auto& tip = graph.add<RigidBody>("tip", {.mass = 1, .inertia = {1, 1, 1}, .position = {1, 0, 0}});
          graph.add<PrismaticJoint>("rail",
                                    {graph.ground().marker({0, 0, 0}, along_x), cart.marker({0, 0, 0}, along_x)});
          graph.add<DistanceJoint>("pole", {cart.marker(), tip.marker()}, {.length = 1});
        }) {}
  double angle() const {
    const Vector3 d = state.q.segment<3>(7) - state.q.head<3>();
    return std::atan2(d.x(), -d.y());
  }
};
Finding judge(Integrator& method) {
  LightCart scene;
  const auto course = scene.run(method, kEnd);
  if (!course.reached) return {Outcome::refused, {{"stopped at, s", course.end}}, course.why};
  const double error = std::abs(std::remainder(scene.angle() - kExact, 2 * M_PI));
  return {judged(error, kLimit),
          {{"θ error at 10 s, rad", error},
           {"energy error, J", course.energy_error},
           {"evaluations", static_cast<double>(method.statistics().evaluations)},
           {"smallest step, s", course.smallest_step}}};
}
template <class Type>
Finding at_scipy_defaults(const std::string& why) {
  typename Type::Parameters parameters;
  parameters.tolerance = {.relative = 1e-3, .absolute = 1e-6};
  Type method(parameters);
  Finding finding = judge(method);
  finding.why = why;
  return finding;
}

const Registered scene{with_candidates(
    {"S27",
     "light bodies and step control",
     {{"RK45 default", [] { return scipy(dormand_prince5(), 1e-3, 1e-6, 2.8, "microsecond peaks stepped over"); }},
      {"DOP853 default", [] { return scipy(dormand_prince8(), 1e-3, 1e-6, 0.031, "the same"); }, Role::also},
      {"Radau default",
       [] {
         return at_scipy_defaults<Radau>("our method at the tolerances of SciPy's, relative 1e-3, absolute 1e-6");
       }},
      {"BDF default",
       [] {
         return at_scipy_defaults<LieBdf>("our method at the tolerances of SciPy's, relative 1e-3, absolute 1e-6");
       }},
      {"RK45 1e-8", [] { return scipy(dormand_prince5(), 1e-8, 1e-8, 2.9e-6, "close to the mark"); }},
      {"extrapolation, 80 bit, 1e-16", extrapolated}}},
    {automatic(1e-10), runge_kutta5(1e-11), runge_kutta8(1e-11)}, {1e-10, 1e-3}, judge)};

}  // namespace
}  // namespace lithe::lab
