// 13_rolling_disc: a coin rolls in a circle, leaning inwards at a steady angle.
//
// Shows: a nonholonomic joint: rolling restricts velocities, not places.
// Expect: the steady lean of the closed form is kept for ten rounds, energy too, and the plane bears what it must.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. A disc of radius r whose axle is raised by `lean` above the horizontal, and whose centre circles at radius R
  // with rate Ω. Rolling: the spin about the axle is s = -Ω (R / r + sin(lean) ...) as below, from zero slip at the
  // contact.
  const double m = 0.1, r = 0.05, g = 9.81, lean = 0.3, R = 0.2;
  const double J_axle = m * r * r / 2, J = m * r * r / 4;
  // In axes (e radial outwards, t tangential, z up): axle a = (cos lean, 0, sin lean), contact at r u below the centre,
  // u = (-sin lean, 0, cos lean) upwards in the disc. ω = Ω z + s a; v = Ω R t = ω × r u.
  const double u_radial = -std::sin(lean), u_up = std::cos(lean);
  // v_t = r (ω_z u_r - ω_r u_z) = Ω R  with ω_r = s cos, ω_z = Ω + s sin
  //   s (sin u_r - cos u_z) = Ω (R / r - u_r)
  const double spin_per_rate = (R / r - u_radial) / (std::sin(lean) * u_radial - std::cos(lean) * u_up);
  // Moment about the centre: contact force (-m Ω² R, 0, m g) at -r u; L_r and L_z turn with Ω: L' = Ω z × L.
  //   L along the axle J_axle ω·a, across (in the plane e, z) J ω·u
  //   Ω L_r = moment about t = (-r u) × F |_t = -r (u_z F_r - u_r F_z)
  const double along = spin_per_rate + std::sin(lean), across = u_up;
  const double L_radial = J_axle * along * std::cos(lean) + J * across * u_radial;  // per Ω
  // Ω² L_r = r m (u_z Ω² R + u_r g)
  const double rate = std::sqrt(r * m * u_radial * g / (L_radial - r * m * u_up * R));

  SystemGraph graph{{.gravity = {0, 0, -g}}};
  Matrix3 axes;  // z of the disc along the axle, drawn at e = x, t = y
  axes.col(2) = Vector3(std::cos(lean), 0, std::sin(lean));
  axes.col(1) = Vector3(0, 1, 0);
  axes.col(0) = axes.col(1).cross(axes.col(2));
  const Vector3 omega(spin_per_rate * rate * std::cos(lean), 0, rate * (1 + spin_per_rate * std::sin(lean)));
  auto& coin = graph.add<RigidBody>("coin", {.mass = m,
                                             .inertia = {J, J, J_axle},
                                             .position = {R, 0, r * u_up},
                                             .orientation = axes,
                                             .velocity = {0, rate * R, 0},
                                             .angular_velocity = axes.transpose() * omega});
  auto& table = graph.add<RollingDisc>("table", {graph.ground().marker(), coin.marker()}, {.radius = r});

  // 2. Ten rounds.
  const System system = assemble(graph);
  State state = system.initial_state();
  Recorder recorder{
      {position(coin.marker(), "centre"), total_energy("energy"), reaction(table, 1, kWorldAxes, "contact")}};
  ExplicitRungeKutta integrator{{.tolerance = {.relative = 1e-10, .absolute = 1e-10}}};
  Simulation simulation{system, integrator};
  simulation.observe(recorder, every(0.01));
  simulation.run(state, 10 * 2 * M_PI / rate);
  recorder.write_csv("results/rolling_disc/coin.csv");

  // 3. Check the answer.
  const auto column = [&](const char* name) { return recorder.table().column(name); };
  const auto x = column("centre_x"), y = column("centre_y"), z = column("centre_z"), energy = column("energy");
  double off = 0, lost = 0, bears = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    off = std::max({off, std::abs(std::hypot(x[i], y[i]) - R), std::abs(z[i] - r * u_up)});
    lost = std::max(lost, std::abs(energy[i] - energy[0]));
    bears = std::max(bears, std::abs(column("contact_force_z")[i] - m * g));
  }
  std::printf("rate %.6f rad/s; off the circle by %.1e m, energy by %.1e J, weight borne within %.1e N\n", rate, off,
              lost, bears);
  return off < 1e-6 && lost < 1e-8 && bears < 1e-5 ? 0 : 1;
}
