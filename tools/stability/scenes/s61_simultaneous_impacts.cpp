// S61: Newton's cradle (C05): what a row of balls does depends on the law of impacts, and momentum and energy, which
// all keep, do not tell which.
#include "tools/stability/scenes/contacts.h"

namespace lithe::lab {
namespace {

constexpr double kRadius = 0.05, kStep = 1e-3, kLimit = 0.02;  // m, s, of the speed: Hertz's own answer is within it

/// N balls of 1 kg along x; the first arrives with 1 m/s. v[6 i] is ball i's.
class Cradle : public Bench {
 public:
  Cradle(int n, double gap, const std::variant<Compliance, RigidSurfaces, Sensing>& law)
      : Bench(Vector3::Zero(), [&](SystemGraph& graph) {
          std::vector<Collider> balls;
          for (int i = 0; i < n; ++i) {
            auto& ball = graph.add<RigidBody>("ball" + std::to_string(i), {.mass = 1,
                                                                           .inertia = {1e-3, 1e-3, 1e-3},
                                                                           .position = {i * (2 * kRadius + gap), 0, 0},
                                                                           .velocity = {i == 0 ? 1.0 : 0.0, 0, 0}});
            balls.push_back({ball.marker(), shape::sphere(kRadius)});
          }
          graph.add<Contact>("balls", balls, {.law = law});
        }) {}
};

const RigidSurfaces kElastic{.restitution = 1};

/// Speeds of all after `end`, m/s.
VectorX speeds(int n, double gap, const std::variant<Compliance, RigidSurfaces, Sensing>& law, Integrator& method,
               double end) {
  Cradle scene(n, gap, law);
  const auto course = scene.run(method, end);
  VectorX out(n);
  for (int i = 0; i < n; ++i) out[i] = course.reached ? scene.state.v[6 * i] : NAN;
  return out;
}

Finding judge(const VectorX& three, const VectorX& five, double published3, double published5, int digits,
              const std::string& why) {
  const auto off = [](const VectorX& v) { return std::abs(v[v.size() - 1] - 1); };
  const auto invariants = [](const VectorX& v) {
    return std::max(std::abs(v.sum() - 1), std::abs(v.squaredNorm() - 1));
  };
  return {judged(std::isfinite(off(three) + off(five)) ? std::max(off(three), off(five)) : NAN, kLimit, 10),
          {{"speed of the last ball, N = 3, m/s", three[2], published3, digits},
           {"N = 5", five[4], published5, digits},
           {"of the first, N = 3", three[0]},
           {"momentum and energy off by", std::max(invariants(three), invariants(five))}},
          why};
}

VectorX rigid(int n, double gap, Impacts impacts, std::unique_ptr<ConeSolver> solver = nullptr, double h = kStep) {
  return speeds(n, gap, kElastic, *moreau(h, std::move(solver), impacts), 20 * h);
}

Finding one_problem() {
  Finding finding = judge(rigid(3, 0, Impacts::simultaneous), rigid(5, 0, Impacts::simultaneous), 0.667, 0.4, 3,
                          "shares the impulse evenly; its invariants are right");
  auto sweeps = std::make_unique<GaussSeidel>(GaussSeidel::Parameters{.sweeps = 10000, .exact_blocks = false});
  finding.figures.push_back(
      {"converged projected Gauss-Seidel, N = 5", rigid(5, 0, Impacts::simultaneous, std::move(sweeps))[4], 0.4, 3});
  return finding;
}

Finding one_after_another(double gap) {
  return judge(rigid(3, gap, Impacts::sequential), rigid(5, gap, Impacts::sequential), 1, 1, 4,
               "the limit of small gaps");
}

Finding hertz() {
  constexpr double kStiffness = 1e6;  // N/m^1.5; the answer does not know it
  const double end = 60 * std::pow(1 / kStiffness, 0.4);
  const auto run = [&](int n) { return speeds(n, 0, Compliance{.stiffness = kStiffness}, *runge_kutta(1e-11), end); };
  return judge(run(3), run(5), 0.99455, 0.98878, 5, "elastic balls in touch: its own physical answer");
}

const Registered scene{
    {"S61",
     "simultaneous impacts",
     {{"one LCP or converged PGS, Newton restitution", one_problem},
      {"sequence of binary impacts", [] { return one_after_another(1e-6); }},
      {"Hertz contacts in time", hertz},
      {"Moreau-Jean, Impacts::sequential, in touch", [] { return one_after_another(0); }, Role::ours},
      {"Moreau-Jean, simultaneous, gaps of 1e-6 m, h = 5e-7",
       [] {
         return judge(rigid(3, 1e-6, Impacts::simultaneous, nullptr, 5e-7),
                      rigid(5, 1e-6, Impacts::simultaneous, nullptr, 5e-7), 1, 1, 4, "one impact a step");
       },
       Role::also}}}};

}  // namespace
}  // namespace lithe::lab
