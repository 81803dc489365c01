// F21: a car on a slope with its brakes on. Slip is a quotient of speeds: at rest it is 0/0. Regularised, it lets the
// car creep, or makes its brakes so stiff that explicit methods chatter; deflections of the carcass hold it.
#include "bodies/rigid_body.h"
#include "joints/forces/first_order_states.h"
#include "joints/tyre/tyre.h"
#include "models/read_tir.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kMass = 1600, kAlong = 1.2, kNormal = 9.7, kSettled = 10, kEnd = 40;  // kg, m/s², s
constexpr double kAllowed = 1e-6;                                                      // m in 30 s

TyreCoefficients tyre() {
  TyreCoefficients c = read_tir(LITHE_EXAMPLE_DATA "/tyres/car.tir");
  c.vertical_damping = 3000;
  return c;
}

/// All of the car on one braked wheel: m v̇ = m g_x + F_x(κ), κ = -v / (|v| + v_d).
Finding quotient(double v_d, double h) {
  const MagicFormula formula(tyre());
  const Rates rates = [&](double, const VectorX& y) {
    const double kappa = -y[1] / (std::abs(y[1]) + v_d);
    const double F = 4 * formula.at({.kappa = kappa, .load = kMass * kNormal / 4, .speed = y[1]}).Fx;
    VectorX out(2);
    out << y[1], kAlong + F / kMass;
    return out;
  };
  VectorX y = VectorX::Zero(2);
  double way = 0, fastest = 0;
  for (double t = 0; t < kEnd; t += h) {
    const VectorX next = rk4_step(rates, t, y, h);
    if (t > kSettled) way += std::abs(next[0] - y[0]), fastest = std::max(fastest, std::abs(next[1]));
    y = next;
  }
  return {judged(way, kAllowed), {{"way in 30 s, m", way}, {"largest speed, m/s", fastest}}};
}

Finding carcass(Integrator& method) {
  Bench scene({kAlong, 0.5, -kNormal}, [](SystemGraph& graph) {
    auto& box = graph.add<RigidBody>("car", {.mass = kMass, .inertia = {500, 2000, 2100}, .position = {0, 0, 0.6}});
    auto& states = graph.add<FirstOrderStates>("carcasses", {.start = VectorX::Zero(12)});
    for (int i = 0; i < 4; ++i) {
      const double side = i % 2 == 0 ? 1 : -1;
      graph.add<Tyre>(
          "tyre " + std::to_string(i),
          {graph.ground().marker(),
           box.marker({i < 2 ? 1.3 : -1.3, 0.75 * side, -0.3}, rotation_about({1, 0, 0}, -M_PI / 2)), states.point(i)},
          {.coefficients = tyre(), .mirrored = side < 0});
    }
  });
  Vector3 last = scene.state.q.head<3>();
  double way = 0;
  const auto course = scene.run(method, kEnd, [&] {
    const Vector3 here = scene.state.q.head<3>();
    if (scene.state.time > kSettled) way += (here - last).norm();
    last = here;
  });
  if (!course.reached) return {Outcome::unstable, {{"stopped at, s", course.end}}, course.why};
  return {judged(way, kAllowed), {{"way in 30 s, m", way}, {"steps", static_cast<double>(course.steps)}}};
}

const Registered scene{
    with_candidates({"F21",
                     "a tyre at standstill",
                     {{"slip over |v| + 0.1 m/s, RK4 h = 1e-4", [] { return quotient(0.1, 1e-4); }, Role::also},
                      {"slip over |v| + 1e-5 m/s, RK4 h = 1e-3", [] { return quotient(1e-5, 1e-3); }, Role::also}}},
                    {automatic(1e-7), radau(1e-7), alpha(1e-2)}, {1e-7, 1e-2}, carcass)};

}  // namespace
}  // namespace lithe::lab
