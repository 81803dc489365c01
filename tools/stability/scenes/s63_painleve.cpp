// S63: Painlevé's rod (C07): slides on its lower end, leaning back. Beyond a friction of 4/3 accelerations and forces
// that satisfy Coulomb's law do not exist, or are two; impulses do.
#include "tools/stability/scenes/contacts.h"

namespace lithe::lab {
namespace {

constexpr double kLength = 1, kMass = 1, kInertia = kMass * kLength * kLength / 12, kSliding = 1;  // m, kg, kg m², m/s
constexpr double kTipRadius = 1e-6, kEnd = 0.02, kLimit = 1e-5;     // m, s, of the energy: order 1
const double kSin = 2 / std::sqrt(5.0), kCos = 1 / std::sqrt(5.0);  // tan θ = 2

/// Normal acceleration of the sliding tip, p N + b.
struct Tip {
  double p, b;
  Tip(double friction, double omega) {
    const double x = -kLength / 2 * kCos, z = -kLength / 2 * kSin;  // of the tip from the centre
    p = 1 / kMass + x * (x - friction * z) / kInertia;
    b = -omega * omega * z - kGravity;
  }
  /// Of p N + b >= 0 ⊥ N >= 0.
  double solution_count() const { return (b >= 0 ? 1 : 0) + (-b / p > 0 ? 1 : 0); }
};

Finding accelerations() {
  const double none = Tip(1.4, 0).solution_count(), two = Tip(1.4, 8).solution_count();
  const bool unique = none == 1 && two == 1 && Tip(1.8, 0).solution_count() == 1 && Tip(1.8, 8).solution_count() == 1;
  return {unique ? Outcome::converged : Outcome::refused,
          {{"solutions, μ = 1.4, ω = 0", none, 0},
           {"ω = 8 rad/s", two, 2},
           {"μ = 1.2, ω = 0", Tip(1.2, 0).solution_count(), 1},
           {"p, μ = 1.4, 1/kg", Tip(1.4, 0).p, -0.08},
           {"μ = 1.8", Tip(1.8, 0).p, -0.56},
           {"b, ω = 8 rad/s, m/s²", Tip(1.4, 8).b, 18.8117, 6}},
          "p < 0: a force presses the tip into the floor"};
}

/// In the plane x, z; the tip slides along -x; ω turns from x to z.
class Rod : public Bench {
 public:
  Rod(double friction, double omega)
      : Bench({0, 0, -kGravity}, [&](SystemGraph& graph) {
          const Vector3 axis(kCos, 0, kSin);
          const Matrix3 along = axis * axis.transpose();
          const double rate = kLength / 2 * omega;
          auto& rod = graph.add<RigidBody>("rod", {.mass = kMass,
                                                   .inertia = Matrix3(kInertia * (Matrix3::Identity() - 0.99 * along)),
                                                   .position = kLength / 2 * axis + Vector3(0, 0, kTipRadius),
                                                   .velocity = {-kSliding - rate * kSin, 0, rate * kCos},
                                                   .angular_velocity = {0, -omega, 0}});
          graph.add<Contact>("floor",
                             {{graph.ground().marker(), shape::half_space()},
                              {rod.marker(Point(-kLength / 2 * axis)), shape::sphere(kTipRadius)}},
                             {.law = RigidSurfaces{}, .friction = {.coefficient = friction}});
        }) {}
  /// Along x, m/s.
  double tip_speed() {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    const Matrix3 R = rotation_matrix(state.q.segment<4>(3));
    const Vector3 arm = -kLength / 2 * (R * Vector3(kCos, 0, kSin)), omega = R * state.v.tail<3>();
    return (state.v.head<3>() + omega.cross(arm))[0];
  }
};

/// Energy gained after any step, over that at the start; state at the end.
struct Course {
  double gain = 0, tip_speed_then = NAN;
  VectorX end;
};
Course slide(double friction, double omega, Integrator& method) {
  Rod rod(friction, omega);
  Course out;
  const double start = rod.energy();
  double lowest = start;
  const auto course = rod.run(method, kEnd, [&] {
    const double now = rod.energy();
    out.gain = std::max(out.gain, (now - lowest) / start);
    lowest = std::min(lowest, now);
    if (std::isnan(out.tip_speed_then)) out.tip_speed_then = rod.tip_speed();
  });
  if (!course.reached) out.gain = NAN;
  out.end = rod.state.v;
  return out;
}

Finding stepping(const std::function<Method(double step)>& make, double step) {
  double gain = 0, change = 0, jammed = NAN;
  for (double friction : {1.4, 1.8})
    for (double omega : {0.0, 8.0}) {
      const Course coarse = slide(friction, omega, *make(step)), fine = slide(friction, omega, *make(step / 10));
      for (const Course* c : {&coarse, &fine}) gain = std::isnan(c->gain) ? NAN : std::max(gain, c->gain);
      change = std::max(change, (coarse.end - fine.end).norm());
      if (friction == 1.4 && omega == 0) jammed = fine.tip_speed_then;
    }
  return {judged(gain, kLimit, 1),
          {{"energy gained, of that at the start", gain},
           {"tip speed after the first step, m/s, of 1; μ = 1.4, ω = 0", jammed},
           {"change of velocities at 0.02 s by a tenth of the step", change}},
          "an impact without collision: the tip jams"};
}

const Registered scene{
    {"S63",
     "Painleve rod",
     {{"acceleration-level rigid contact", accelerations},
      {"velocity-level time stepping", [] { return stepping([](double h) { return moreau(h); }, 1e-4); }},
      {"Moreau-Jean, h = 1e-3", [] { return stepping([](double h) { return moreau(h); }, 1e-3); }, Role::ours},
      {"nonsmooth generalized-alpha, h = 1e-4",
       [] { return stepping([](double h) { return nonsmooth_alpha(h); }, 1e-4); }, Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
