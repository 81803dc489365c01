// 06_joint_coordinates: a slider-crank is started by a motor that follows a prescribed motion.
//
// Shows: joints measure themselves (pin.angle(), slide.displacement()); a drive, a spring, a sensor act on such a
// coordinate. Expect: the slider follows r cos φ + sqrt(l² - r² sin² φ); what the drive gives is what the bodies and
// the spring take.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. Crank, rod and slider in the plane z = 0; hinges turn about z, the slide runs along x.
  const double r = 0.1, l = 0.3;
  SystemGraph graph{{.gravity = {0, -9.81, 0}}};
  auto& crank = graph.add<RigidBody>("crank", {.mass = 1, .inertia = {1e-4, 1e-3, 1e-3}, .position = {r / 2, 0, 0}});
  auto& rod = graph.add<RigidBody>("rod", {.mass = 0.5, .inertia = {1e-4, 4e-3, 4e-3}, .position = {r + l / 2, 0, 0}});
  auto& slider =
      graph.add<RigidBody>("slider", {.mass = 0.8, .inertia = {1e-3, 1e-3, 1e-3}, .position = {r + l, 0, 0}});
  const Matrix3 along_x = rotation_about({0, 1, 0}, M_PI / 2);
  auto& bearing = graph.add<RevoluteJoint>("bearing", {graph.ground().marker(), crank.marker({-r / 2, 0, 0})});
  graph.add<CylindricalJoint>("crank pin", {crank.marker({r / 2, 0, 0}), rod.marker({-l / 2, 0, 0})});
  graph.add<SphericalJoint>("gudgeon pin", {rod.marker({l / 2, 0, 0}), slider.marker()});
  auto& slide = graph.add<PrismaticJoint>(
      "slide", {graph.ground().marker({0, 0, 0}, along_x), slider.marker({0, 0, 0}, along_x)});

  // 2. A motor brings the crank to 20 rad/s within a second, and three turns on; a spring draws the slider back.
  auto& motor = graph.add<CoordinateDrive>(
      "motor", {bearing.angle()}, {.motion = [](double t) {
        const double s = std::min(t, 1.0), end = t - s;  // rate 10 (1 - cos πs), smooth at both ends
        return Motion{10 * s - 10 / M_PI * std::sin(M_PI * s) + 20 * end, 10 * (1 - std::cos(M_PI * s)),
                      t < 1 ? 10 * M_PI * std::sin(M_PI * s) : 0};
      }});
  auto& spring = graph.add<CoordinateSpring>("spring", {slide.displacement()}, {.stiffness = 200, .free_value = 0.2});

  // 3. Run, and watch coordinates by name.
  const System system = assemble(graph);
  State state = system.initial_state();
  Recorder recorder{{coordinate(bearing.angle(), "angle"), coordinate(slide.displacement(), "stroke"),
                     drive_force(motor, "torque"), power(motor, "power"), joint_reaction(bearing, "bearing"),
                     potential_energy(spring, "spring"), total_energy("energy")}};
  GeneralizedAlpha integrator{{.step = 5e-4, .form = GeneralizedAlpha::Form::stabilized_index2}};
  Simulation simulation{system, integrator};
  simulation.observe(recorder, every(5e-4));
  simulation.run(state, 2.0);
  recorder.write_csv("results/joint_coordinates/slider_crank.csv");
  const auto t = recorder.table().column("t"), angle = recorder.table().column("angle"),
             stroke = recorder.table().column("stroke"), given = recorder.table().column("power"),
             energy = recorder.table().column("energy"), torque = recorder.table().column("torque");
  write_chart({.title = "Torque of the motor",
               .x_label = "time (s)",
               .y_label = "torque (N m)",
               .lines = {{.title = "torque", .x = t, .y = torque}}},
              "results/joint_coordinates/torque");

  // 4. Check the answer: closed form of the stroke, whole turns counted, and energy against work.
  double gap = 0, work = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double s = r * std::sin(angle[i]);
    gap = std::max(gap, std::abs(stroke[i] - r * std::cos(angle[i]) - std::sqrt(l * l - s * s)));
    if (i > 0) work += (given[i] + given[i - 1]) / 2 * (t[i] - t[i - 1]);
  }
  const double unaccounted = energy.back() - energy.front() - work;
  std::printf("angle at the end %.9f rad (30 wanted), stroke off by %.1e m, work %.4f J, unaccounted %.1e J\n",
              angle.back(), gap, work, unaccounted);
  return std::abs(angle.back() - 30) < 1e-9 && gap < 1e-9 && std::abs(unaccounted) < 2e-3 ? 0 : 1;
}
