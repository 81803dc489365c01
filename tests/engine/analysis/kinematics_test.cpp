#include "engine/analysis/kinematics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/coordinate_drive.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/flexible_models.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::kinematics_test {

using lithe::test::message_of;
using testing::HasSubstr;

namespace {

constexpr double kGravity = 9.81;
const Matrix3 kAlongX = rotation_about({0, 1, 0}, M_PI / 2);  // marker z along world x

/// Planar slider-crank of 3-D joints (so with redundant rows), axes z, gravity along -y: crank r on the origin, rod l,
/// slider on the x axis. Uniform slender links.
struct SliderCrank {
  static constexpr double r = 0.15, l = 0.4, crank_mass = 0.36, rod_mass = 0.6, slider_mass = 0.8;
  SystemGraph graph{{.gravity = {0, -kGravity, 0}}};
  RigidBody *crank, *rod, *slider;
  RevoluteJoint* bearing;
  PrismaticJoint* guide;

  explicit SliderCrank(double theta) {
    const double phi = -std::asin(r / l * std::sin(theta));  // slope of the rod
    const Vector3 A = r * Vector3(std::cos(theta), std::sin(theta), 0), along(std::cos(phi), std::sin(phi), 0);
    const auto slender = [](double mass, double length) {
      const double J = mass * length * length / 12;
      return Inertia(1e-2 * J, J, J);
    };
    crank = &graph.add<RigidBody>("crank", {.mass = crank_mass,
                                            .inertia = slender(crank_mass, r),
                                            .position = 0.5 * A,
                                            .orientation = rotation_about({0, 0, 1}, theta)});
    rod = &graph.add<RigidBody>("rod", {.mass = rod_mass,
                                        .inertia = slender(rod_mass, l),
                                        .position = A + 0.5 * l * along,
                                        .orientation = rotation_about({0, 0, 1}, phi)});
    slider = &graph.add<RigidBody>("slider",
                                   {.mass = slider_mass, .inertia = {1e-3, 1e-3, 1e-3}, .position = A + l * along});
    bearing = &graph.add<RevoluteJoint>("main", {graph.ground().marker(), crank->marker({-r / 2, 0, 0})});
    graph.add<RevoluteJoint>("big end", {crank->marker({r / 2, 0, 0}), rod->marker({-l / 2, 0, 0})});
    graph.add<RevoluteJoint>("small end", {rod->marker({l / 2, 0, 0}), slider->marker()});
    guide = &graph.add<PrismaticJoint>("guide",
                                       {graph.ground().marker({0, 0, 0}, kAlongX), slider->marker({0, 0, 0}, kAlongX)});
  }

  static double position(double theta) {
    return r * std::cos(theta) + std::sqrt(l * l - r * r * std::pow(std::sin(theta), 2));
  }
  /// T = ½ I(θ) θ̇², V(θ), in closed form.
  static double inertia(double theta) {
    const double s = std::sin(theta), c = std::cos(theta), root = std::sqrt(l * l - r * r * s * s);
    const double phi_rate = -r * c / root, slider_rate = -r * s + r * s * phi_rate;
    const Vector3 rod_rate(-r * s - 0.5 * l * phi_rate * (-r / l * s), r * c + 0.5 * root * phi_rate, 0);
    return crank_mass * r * r / 3 + rod_mass * (rod_rate.squaredNorm() + l * l / 12 * phi_rate * phi_rate) +
           slider_mass * slider_rate * slider_rate;
  }
  static double potential(double theta) { return kGravity * (crank_mass * 0.5 + rod_mass * 0.5) * r * std::sin(theta); }
};

template <class Function>
double slope(Function&& f, double x) {
  const double h = 1e-3;
  return (f(x - 2 * h) - 8 * f(x - h) + 8 * f(x + h) - f(x + 2 * h)) / (12 * h);
}
template <class Function>
double curvature(Function&& f, double x) {
  const double h = 2e-3;
  return (-f(x - 2 * h) + 16 * f(x - h) - 30 * f(x) + 16 * f(x + h) - f(x + 2 * h)) / (12 * h * h);
}

}  // namespace

TEST(kinematics, a_slider_crank_follows_its_closed_form_through_dead_centres_and_its_motor_does_the_work) {
  const double omega = 12, alpha = -3;
  const auto angle = [=](double t) { return 0.4 + omega * t + 0.5 * alpha * t * t; };
  SliderCrank scene(0.4);
  auto& motor = scene.graph.add<CoordinateDrive>("motor", {scene.bearing->angle()}, {.motion = [=](double t) {
                                                   return Motion{angle(t), omega + alpha * t, alpha};
                                                 }});
  const System system = assemble(scene.graph);
  EXPECT_EQ(system.degrees_of_freedom(), 0);
  EXPECT_EQ(system.redundant_rows().size(), 3u);
  Kinematics kinematics({.step = 5e-3});
  Simulation simulation(system, kinematics);
  Recorder recorder({position(scene.slider->marker(), "x"), velocity(scene.slider->marker(), "v"),
                     acceleration(scene.slider->marker(), "a"), drive_force(motor, "torque"),
                     drive_power(motor, "power"), constraint_residual("g")});
  simulation.observe(recorder, every(0.01));
  State state = system.initial_state();
  simulation.run(state, 2);

  const Table& table = recorder.table();
  ASSERT_EQ(table.row_count(), 201);
  double worst_x = 0, worst_v = 0, worst_a = 0, worst_torque = 0, worst_power = 0, worst_g = 0;
  for (int i = 0; i < table.row_count(); ++i) {
    const double t = table.at(i, 0), theta = angle(t), rate = omega + alpha * t;
    const double dx = slope(SliderCrank::position, theta), ddx = curvature(SliderCrank::position, theta);
    const double torque = SliderCrank::inertia(theta) * alpha + 0.5 * slope(SliderCrank::inertia, theta) * rate * rate +
                          slope(SliderCrank::potential, theta);
    worst_x = std::max(worst_x, std::abs(table.at(i, 1) - SliderCrank::position(theta)));
    worst_v = std::max(worst_v, std::abs(table.at(i, 4) - dx * rate));
    worst_a = std::max(worst_a, std::abs(table.at(i, 7) - ddx * rate * rate - dx * alpha));
    worst_torque = std::max(worst_torque, std::abs(table.at(i, 10) - torque));
    worst_power = std::max(worst_power, std::abs(table.at(i, 11) - torque * rate));
    worst_g = std::max(worst_g, table.at(i, 12));
  }
  EXPECT_LT(worst_x, 1e-12);
  EXPECT_LT(worst_v, 1e-9);
  EXPECT_LT(worst_a, 1e-7);
  EXPECT_LT(worst_torque, 1e-8);
  EXPECT_LT(worst_power, 1e-7);
  EXPECT_LT(worst_g, 1e-11);
  std::printf("slider-crank: x %.1e m, v %.1e m/s, a %.1e m/s², torque %.1e N m, power %.1e W, |g| %.1e\n", worst_x,
              worst_v, worst_a, worst_torque, worst_power, worst_g);
}

TEST(kinematics, a_slider_driven_beyond_its_reach_locks_and_what_was_computed_is_kept) {
  SliderCrank scene(1.0);
  const double x0 = SliderCrank::position(1.0), speed = 0.1;
  scene.graph.add<CoordinateDrive>("push", {scene.guide->displacement()}, {.motion = [=](double t) {
                                     return Motion{x0 + speed * t, speed, 0};
                                   }});
  const System system = assemble(scene.graph);
  Kinematics kinematics({.step = 1e-2});
  Simulation simulation(system, kinematics);
  Recorder recorder({position(scene.slider->marker(), "x")});
  simulation.observe(recorder, every_step());
  State state = system.initial_state();
  const std::string message = message_of<SimulationError>([&] { simulation.run(state, 5); });
  EXPECT_THAT(message, HasSubstr("cannot follow its drives"));
  EXPECT_THAT(message, HasSubstr(" row "));
  const double locks = (SliderCrank::r + SliderCrank::l - x0) / speed;  // stretched straight
  EXPECT_NEAR(state.time, locks, 1e-3 * locks);
  EXPECT_LT(state.time, locks + 1e-9);
  EXPECT_NEAR(recorder.table().at(recorder.table().row_count() - 1, 0), state.time, 0);
  std::printf("lock-up at %.9f s, reached %.9f s\n%s\n", locks, state.time, message.c_str());
}

TEST(kinematics, a_flexible_arm_is_driven_by_its_dynamics_and_the_motor_pays_its_energy) {
  // Elastic freedoms are not driven: the kinematic analysis says so, the dynamic run gives the motor's torque.
  const FiniteElementModel model = test::pendulum_model("hex8i");
  SystemGraph graph;
  auto& arm = graph.add<FlexibleBody>("arm", {.basis = make_basis(model, test::frame_of(model, "clamp"), 4)});
  const Marker hub = graph.ground().marker(arm.basis().origin);
  auto& axle = graph.add<RevoluteJoint>("axle", {hub, arm.frame()});
  const double T = 0.5;
  auto& motor = graph.add<CoordinateDrive>(
      "motor", {axle.angle()}, {.motion = [=](double t) {
        const double w = 2 * M_PI / T;  // a turn of 1 rad, smooth
        return Motion{t / T - std::sin(w * t) / (w * T), (1 - std::cos(w * t)) / T, w * std::sin(w * t) / T};
      }});
  const System system = assemble(graph);
  State state = find_equilibrium(system, system.initial_state()).state;

  Kinematics kinematics({.step = 1e-2});
  Simulation prescribed(system, kinematics);
  State trial = state;
  EXPECT_THAT(message_of<SceneError>([&] { prescribed.run(trial, T); }), HasSubstr("arm: eta_"));

  GeneralizedAlpha integrator({.step = 5e-4, .spectral_radius = 0.9});
  Simulation simulation(system, integrator);
  Recorder recorder({drive_power(motor, "power"), total_energy("energy")});
  simulation.observe(recorder, every_step());
  simulation.run(state, T);
  double work = 0, largest = 0, worst = 0;
  const Table& table = recorder.table();
  for (int i = 1; i < table.row_count(); ++i) {
    work += 0.5 * (table.at(i, 1) + table.at(i - 1, 1)) * (table.at(i, 0) - table.at(i - 1, 0));
    largest = std::max(largest, std::abs(table.at(i, 2) - table.at(0, 2)));
    worst = std::max(worst, std::abs(work - (table.at(i, 2) - table.at(0, 2))));
  }
  EXPECT_LT(worst, 1e-3 * largest);
  std::printf("flexible arm: work and energy differ by %.1e of %.1e J\n", worst, largest);
}

TEST(kinematics, freedoms_without_a_drive_are_named) {
  SliderCrank scene(1.0);
  const System system = assemble(scene.graph);
  Kinematics kinematics({.step = 1e-2});
  Simulation simulation(system, kinematics);
  State state = system.initial_state();
  const std::string message = message_of<SceneError>([&] { simulation.run(state, 1); });
  EXPECT_THAT(message, HasSubstr("1 freedoms remain"));
  EXPECT_THAT(message, HasSubstr("omega_z"));
}

TEST(kinematics, an_overconstrained_parallelogram_passes_its_change_points) {
  // Two cranks of 0.3 m, a coupler of 1 m, four 3-D hinges; at 0 and π all links lie on a line.
  SystemGraph graph({.gravity = {0, -kGravity, 0}});
  const double r = 0.3, d = 1.0, start = 0.5 * M_PI, omega = 2;
  const Matrix3 up = rotation_about({0, 0, 1}, start);
  auto& left = graph.add<RigidBody>(
      "left", {.mass = 1, .inertia = {1e-3, 1e-2, 1e-2}, .position = Vector3(0, r / 2, 0), .orientation = up});
  auto& right = graph.add<RigidBody>(
      "right", {.mass = 1, .inertia = {1e-3, 1e-2, 1e-2}, .position = Vector3(d, r / 2, 0), .orientation = up});
  auto& coupler =
      graph.add<RigidBody>("coupler", {.mass = 2, .inertia = {1e-2, 0.2, 0.2}, .position = Vector3(d / 2, r, 0)});
  auto& pivot = graph.add<RevoluteJoint>("A0", {graph.ground().marker(), left.marker({-r / 2, 0, 0})});
  graph.add<RevoluteJoint>("A", {left.marker({r / 2, 0, 0}), coupler.marker({-d / 2, 0, 0})});
  graph.add<RevoluteJoint>("B", {coupler.marker({d / 2, 0, 0}), right.marker({r / 2, 0, 0})});
  graph.add<RevoluteJoint>("B0", {right.marker({-r / 2, 0, 0}), graph.ground().marker({d, 0, 0})});
  auto& motor = graph.add<CoordinateDrive>("motor", {pivot.angle()}, {.motion = [=](double t) {
                                             return Motion{start + omega * t, omega, 0};
                                           }});
  const System system = assemble(graph);
  EXPECT_EQ(system.redundant_rows().size(), 3u);
  for (double step : {0.013, M_PI / 4 / 25}) {  // beside the change points; and upon them, but for round-off
    Kinematics kinematics({.step = step});
    Simulation simulation(system, kinematics);
    Recorder recorder({position(coupler.marker(), "p"), drive_force(motor, "torque")});
    simulation.observe(recorder, every_step());
    State state = system.initial_state();
    simulation.run(state, 3);
    double worst = 0;
    for (int i = 0; i < recorder.table().row_count(); ++i) {
      const double theta = start + omega * recorder.table().at(i, 0);
      const Vector3 p(recorder.table().at(i, 1), recorder.table().at(i, 2), recorder.table().at(i, 3));
      worst = std::max(worst, (p - Vector3(d / 2 + r * std::cos(theta), r * std::sin(theta), 0)).norm());
      const double torque = (1 * 0.5 + 1 * 0.5 + 2) * kGravity * r * std::cos(theta);
      const double aside = std::abs(std::sin(theta));  // from a change point
      if (aside > 1e-3) {
        EXPECT_NEAR(recorder.table().at(i, 4), torque, 1e-6) << "theta " << theta;
      }
    }
    EXPECT_LT(worst, 1e-9);
    std::printf("parallelogram, step %.4f: %d states, error %.1e m\n", step, recorder.table().row_count(), worst);
  }
}

}  // namespace lithe::test::kinematics_test
