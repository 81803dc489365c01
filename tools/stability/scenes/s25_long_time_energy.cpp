// S25: a pendulum for 2000 s: methods that lose a little energy every swing, and those that do not.
#include "joints/revolute_joint.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 2000, kLimit = 1e-3;  // s; J, from the first tenth to the last

/// The energy's error, J: largest in the first tenth, in the last one, and at the end.
struct Loss {
  double first = 0, last = 0, end = 0;
  void add(double time, double error) {
    if (time < 0.1 * kEnd) first = std::max(first, std::abs(error));
    if (time > 0.9 * kEnd) last = std::max(last, std::abs(error));
    end = error;
  }
};

struct Swing {
  double angle = M_PI / 2, rate = 0;
  double energy() const { return rate * rate / 2 - kGravity * std::cos(angle); }
};
double acceleration(double angle) { return -kGravity * std::sin(angle); }

/// A step of the angle's own equation, by `step(swing, h)`.
template <class Step>
Loss follow(double h, Step&& step) {
  Swing swing;
  Loss loss;
  const long count = std::lround(kEnd / h);
  for (long k = 1; k <= count; ++k) {
    step(swing, h);
    loss.add(h * static_cast<double>(k), swing.energy());
  }
  return loss;
}

void rk4(Swing& s, double h) {
  static const Rates rates = [](double, const VectorX& y) { return VectorX(Vector3(y[1], acceleration(y[0]), 0)); };
  const VectorX y = rk4_step(rates, 0, Vector3(s.angle, s.rate, 0), h);
  s = {y[0], y[1]};
}
void verlet(Swing& s, double h) {
  s.rate += h / 2 * acceleration(s.angle);
  s.angle += h * s.rate;
  s.rate += h / 2 * acceleration(s.angle);
}

/// Chung & Hulbert's method on the angle.
class Alpha {
 public:
  explicit Alpha(double rho) : am_((2 * rho - 1) / (rho + 1)), af_(rho / (rho + 1)) {
    gamma_ = 0.5 + af_ - am_;
    beta_ = 0.25 * (gamma_ + 0.5) * (gamma_ + 0.5);
  }
  void operator()(Swing& s, double h) {
    const double free = (af_ * w_dot_ - am_ * a_) / (1 - am_), c = (1 - af_) / (1 - am_);
    const double start = s.angle + h * s.rate + h * h * ((0.5 - beta_) * a_ + beta_ * free), per = h * h * beta_ * c;
    double angle = start + per * w_dot_;
    for (int k = 0; k < 50; ++k) {
      const double d = -(angle - start - per * acceleration(angle)) / (1 + per * kGravity * std::cos(angle));
      angle += d;
      if (std::abs(d) < 1e-15) break;
    }
    w_dot_ = acceleration(angle);
    const double a = free + c * w_dot_;
    s = {angle, s.rate + h * ((1 - gamma_) * a_ + gamma_ * a)};
    a_ = a;
  }

 private:
  double am_, af_, gamma_, beta_;
  double w_dot_ = acceleration(M_PI / 2), a_ = w_dot_;
};

Outcome outcome(const Loss& loss) { return judged(loss.last - loss.first, kLimit); }

Finding change(const Loss& coarse, const Loss& fine, double published_coarse, double published_fine, int digits,
               const std::string& why) {
  return {outcome(coarse),
          {{"energy change at 2000 s, h = 0.05, J", coarse.end, published_coarse, digits},
           {"h = 0.01", fine.end, published_fine, digits}},
          why};
}

Finding judge(Integrator& method) {
  Bench scene({0, -kGravity, 0}, [](SystemGraph& graph) {
    auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1e-3, 1e-3, 1e-3}, .position = {1, 0, 0}});
    graph.add<RevoluteJoint>("pin", {graph.ground().marker(), mass.marker({-1, 0, 0})});
  });
  Loss loss;
  const double start = scene.energy();
  const auto course = scene.run(method, kEnd, [&] { loss.add(scene.state.time, scene.energy() - start); });
  if (!course.reached) return {Outcome::unstable, {{"stopped at, s", course.end}}, course.why};
  return {outcome(loss),
          {{"energy change at 2000 s, J", loss.end},
           {"largest in the first tenth", loss.first},
           {"in the last tenth", loss.last}}};
}

const Registered scene{with_candidates(
    {"S25",
     "long-time energy",
     {{"RK4",
       [] {
         return change(follow(0.05, rk4), follow(0.01, rk4), -0.045, -1.5e-5, 2, "dissipation of order h⁵ a step");
       }},
      {"generalized-alpha rho = 0.8",
       [] {
         return change(follow(0.05, Alpha(0.8)), follow(0.01, Alpha(0.8)), -0.18, -1.5e-3, 2,
                       "second-order damping of slow motion");
       }},
      {"Stoermer-Verlet",
       [] {
         const Loss coarse = follow(0.05, verlet), fine = follow(0.01, verlet);
         return Finding{outcome(coarse),
                        {{"largest energy error, h = 0.05, J", coarse.last, 0.050}, {"h = 0.01", fine.last, 2.0e-3}},
                        "symplectic: no drift"};
       }},
      {"generalized-alpha rho = 1 (angle coordinate)",
       [] {
         // The published figures, -8.6e-6 and -6.8e-5 J, are sums of round-off and of Newton's tolerance.
         return change(follow(0.05, Alpha(1)), follow(0.01, Alpha(1)), NAN, NAN, 2,
                       "no constraint here, so S05 does not apply");
       }}}},
    {automatic(1e-9), rattle(0.05), runge_kutta8(1e-10), alpha(0.05)}, {1e-9, 0.05}, judge)};

}  // namespace
}  // namespace lithe::lab
