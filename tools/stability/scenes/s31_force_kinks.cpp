// S31: a force law with kinks: error estimates of high order do not see all of a crossing. The published scene is the
// wheelset R15, whose creep force is cut off; here it is a spring that is stiffer on one side, of known motion.
#include "bodies/rigid_body.h"
#include "engine/run/simulation.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/prismatic_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/extrapolation.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kSoft = 40, kStop = 100, kSpeed = 1, kEnd = 10, kLimit = 1e-9;  // N/m, N/m, m/s, s, of v₀

/// 1 kg on a spring about x = 0, and on a linear stop beyond it.
class OneSided : public Bench {
 public:
  OneSided()
      : Bench(Vector3::Zero(), [](SystemGraph& graph) {
          auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1, 1, 1}, .velocity = {0, 0, kSpeed}});
          auto& guide = graph.add<PrismaticJoint>("guide", {graph.ground().marker(), mass.marker()});
          graph.add<CoordinateSpring>("spring", {guide.displacement()}, {.stiffness = kSoft});
          graph.add<CoordinateStop>("stop", {guide.displacement()}, {.upper = 0, .stiffness = kStop, .exponent = 1});
        }) {}
};

/// Of place and speed against half sines of two frequencies, relative to the largest of each.
double motion_error(double time, double x, double v) {
  const double in = std::sqrt(kSoft + kStop), out = std::sqrt(kSoft), t = std::fmod(time, M_PI / in + M_PI / out);
  const bool pressed = t < M_PI / in;
  const double phase = pressed ? in * t : out * (t - M_PI / in), side = pressed ? 1 : -1, w = pressed ? in : out;
  return std::max(std::abs(x - side * kSpeed / w * std::sin(phase)) * out,
                  std::abs(v - side * kSpeed * std::cos(phase))) /
         kSpeed;
}

/// The largest error at 40 instants.
double follow(const std::function<void(double time)>& run_to, const OneSided& scene) {
  double worst = 0;
  for (int i = 1; i <= 40; ++i) {
    run_to(kEnd * i / 40);
    worst = std::max(worst, motion_error(scene.state.time, scene.state.q[2], scene.state.v[2]));
  }
  return worst;
}
double alone(Integrator& method) {
  OneSided scene;
  method.start(scene.equations, scene.state);
  return follow([&](double time) { scene.go_on(method, time); }, scene);
}
double located(Integrator& method) {
  OneSided scene;
  Simulation simulation(scene.system, method);
  return follow([&](double time) { simulation.run(scene.state, time); }, scene);
}

/// The same outside the engine, in 80 bits, by the error estimate alone.
double extrapolated(int columns, double tolerance, double longest = INFINITY) {
  using Method = Extrapolation<2>;
  Method method({.columns = columns, .tolerance = tolerance, .longest = longest, .scale = {0.1, 1}});
  Method::Vector y{0, kSpeed};
  double worst = 0;
  for (int i = 1; i <= 40; ++i) {
    const auto rates = [](long double, const Method::Vector& x) -> Method::Vector {
      return {x[1], -(kSoft + (x[0] > 0 ? kStop : 0)) * x[0]};
    };
    if (!method.run(rates, kEnd * (i - 1) / 40, kEnd * i / 40, y)) return NAN;
    worst = std::max(worst, motion_error(kEnd * i / 40, static_cast<double>(y[0]), static_cast<double>(y[1])));
  }
  return worst;
}

Method order8(double tolerance) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8,
                                     .tolerance = {.relative = tolerance, .absolute = tolerance}});
}
Finding over_tolerances(const std::vector<double>& tolerances, const std::function<double(double tolerance)>& run,
                        const std::string& why) {
  std::vector<Figure> figures;
  double worst = 0;
  for (double tolerance : tolerances) {
    figures.push_back({"error, tolerance " + figure_text(tolerance), run(tolerance)});
    worst = std::max(worst, figures.back().value);
  }
  return {judged(worst, kLimit), figures, why};
}

const Registered scene{under_every_method(
    {"S31",
     "kinks in a force law",
     {{"order 18, error estimate only, tolerances 1e-12, 1e-14, 1e-15",
       [] {
         return over_tolerances(
             {1e-12, 1e-14, 1e-15}, [](double tol) { return extrapolated(9, tol); },
             "steps over the kinks, and the estimate is blind");
       }},
      {"order 8, steps limited to 1e-4 and 3e-5 s",
       [] {
         const double coarse = extrapolated(4, 1e-14, 1e-4), fine = extrapolated(4, 1e-14, 3e-5);
         return Finding{judged(fine, kLimit),
                        {{"error, steps to 3e-5 s", fine}, {"to 1e-4 s", coarse}},
                        "the local error of a kink's crossing is of order h²"};
       }},
      {"explicit Runge-Kutta 8(5,3), error estimate only",
       [] {
         return over_tolerances(
             {1e-10, 1e-12, 1e-13}, [](double tol) { return alone(*order8(tol)); }, "steps over the kinks");
       },
       Role::also},
      {"switch located (event)",
       [] {
         return over_tolerances(
             {1e-12, 1e-13}, [](double tol) { return located(*order8(tol)); }, "smooth on either side");
       }},
      {"default (automatic, tolerance 1e-12), switch located by Simulation",
       [] {
         const double error = located(*automatic(1e-12).make());
         return Finding{judged(error, kLimit), {{"error", error}}};
       },
       Role::ours}}},
    {1e-12, 1e-4}, [](Integrator& method) {
      const double error = located(method);
      return Finding{judged(error, kLimit), {{"error", error}}};
    })};

}  // namespace
}  // namespace lithe::lab
