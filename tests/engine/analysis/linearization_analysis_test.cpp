#include "engine/analysis/linearization.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/campbell.h"
#include "engine/analysis/describe.h"
#include "engine/analysis/equilibrium.h"
#include "engine/observe/recorder.h"
#include "engine/observe/stop_run.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/spring_damper.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/bodies/flexible_models.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::linearization_analysis_test {

using lithe::test::message_of;
using testing::HasSubstr;

namespace {

constexpr double kGravity = 9.81;
const Matrix3 kAxisY = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y
const Matrix3 kAxisX = rotation_about({0, 1, 0}, M_PI / 2);   // marker z along world x

}  // namespace

TEST(linearization, a_pendulum_swings_with_the_frequency_of_its_length) {
  // A point mass at 0.7 m (its inertia counted out by hand), turned aside about y by whatever axis it is pinned with.
  const double m = 1.3, l = 0.7, J = 0.02;
  SystemGraph graph;
  auto& bob = graph.add<RigidBody>("bob", {.mass = m, .inertia = {0.01, J, 0.03}, .position = Vector3(0, 0, -l)});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, kAxisY), bob.marker({0, 0, l}, kAxisY)});
  const System system = assemble(graph);
  const Linearization small = linearize(system, system.initial_state());
  ASSERT_EQ(small.modes.size(), 1u);
  const double omega = std::sqrt(m * kGravity * l / (m * l * l + J));
  EXPECT_NEAR(small.modes[0].eigenvalue.imag(), omega, 1e-10 * omega);
  EXPECT_NEAR(small.modes[0].eigenvalue.real(), 0, 1e-10);
  EXPECT_NEAR(small.undamped_frequencies()[0], omega / (2 * M_PI), 1e-10);
  std::printf("pendulum: relative error %.1e\n", small.modes[0].eigenvalue.imag() / omega - 1);
  // The shape: a turn about -y of 1 rad, the mass moving 0.7 m aside.
  EXPECT_NEAR(std::abs(small.modes[0].shape[4]), 1, 1e-12);
  EXPECT_NEAR(std::abs(small.modes[0].shape[0]), l, 1e-10);
}

TEST(linearization, a_damped_mass_on_a_spring_has_the_textbook_roots) {
  const double m = 2, k = 300, c = 8;
  SystemGraph graph({.gravity = {0, 0, 0}});
  auto& mass = graph.add<RigidBody>("mass", {.mass = m, .inertia = {1, 1, 1}, .position = Vector3(0, 0, 1)});
  graph.add<PrismaticJoint>("guide", {graph.ground().marker(), mass.marker()});
  graph.add<SpringDamper>("spring", {graph.ground().marker(), mass.marker()}, {.stiffness = k, .damping = c});
  const System system = assemble(graph);
  const Linearization small = linearize(system, system.initial_state());
  ASSERT_EQ(small.modes.size(), 1u);
  EXPECT_NEAR(small.M(0, 0), m, 1e-12);
  EXPECT_NEAR(small.C(0, 0), c, 1e-8);
  EXPECT_NEAR(small.K(0, 0), k, 1e-7);
  EXPECT_NEAR(small.modes[0].eigenvalue.real(), -c / (2 * m), 1e-9);
  EXPECT_NEAR(small.modes[0].eigenvalue.imag(), std::sqrt(k / m - c * c / (4 * m * m)), 1e-8);
  EXPECT_NEAR(small.modes[0].damping_ratio(), c / (2 * std::sqrt(k * m)), 1e-9);
}

TEST(linearization, a_double_pendulum_has_its_two_frequencies) {
  // Two equal rods of 1 m: M = m l² [4/3 1/2; 1/2 1/3], K = m g l/2 [3 0; 0 1] in absolute angles.
  SystemGraph graph;
  Marker last = graph.ground().marker({0, 0, 0}, kAxisY);
  for (int i = 0; i < 2; ++i) {
    auto& rod =
        graph.add<RigidBody>("rod " + std::to_string(i),
                             {.mass = 1, .inertia = {1.0 / 12, 1.0 / 12, 1e-3}, .position = Vector3(0, 0, -0.5 - i)});
    graph.add<RevoluteJoint>("pin " + std::to_string(i), {last, rod.marker({0, 0, 0.5}, kAxisY)});
    last = rod.marker({0, 0, -0.5}, kAxisY);
  }
  const System system = assemble(graph);
  const Linearization small = linearize(system, system.initial_state());
  Eigen::Matrix2d M, K;
  M << 4.0 / 3, 0.5, 0.5, 1.0 / 3;
  K << 1.5 * kGravity, 0, 0, 0.5 * kGravity;
  const VectorX squares = test::symmetric_eigenvalues(K, M);
  ASSERT_EQ(small.modes.size(), 2u);
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(small.modes[k].eigenvalue.imag(), std::sqrt(squares[k]), 1e-9);
  EXPECT_LT((small.K - small.K.transpose()).norm(), 1e-9);
}

TEST(linearization, a_clamped_flexible_body_has_the_frequencies_of_its_finite_elements) {
  const FiniteElementModel model = test::pendulum_model("hex8i");
  const auto reduced = make_basis(model, test::frame_of(model, "clamp"), 12);
  for (int modes : {kAllNodal, 12}) {
    SystemGraph graph({.gravity = {0, 0, 0}});
    auto& beam = graph.add<FlexibleBody>(
        "beam", {.basis = modes == 12 ? reduced : make_basis(model, test::frame_of(model, "clamp"), modes)});
    graph.add<FixedJoint>("clamp", {graph.ground().marker(beam.basis().origin), beam.frame()});
    const System system = assemble(graph);
    const Linearization small = linearize(system, system.initial_state(), {.mode_count = 12});
    double worst = 0;
    ASSERT_EQ(small.modes.size(), 12u);
    for (int k = 0; k < 12; ++k)
      worst = std::max(worst, std::abs(small.modes[k].frequency() / reduced->frequencies[k] - 1));
    EXPECT_LT(worst, 1e-7) << modes << " modes";
    std::printf("cantilever, %d modes: relative error of 12 frequencies %.1e\n", modes, worst);
  }
}

TEST(linearization, a_pinned_flexible_body_has_the_hinged_frequencies_of_its_finite_elements) {
  // Without gravity, the free swing at zero; the hinge removes what its edge does. CalculiX: frequencies.csv, hinged.
  const FiniteElementModel model = test::pendulum_model("hex8i");
  SystemGraph graph({.gravity = {0, 0, 0}});
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, test::frame_of(model, "frameB"), kAllNodal)});
  for (int id : model.node_set("hinge"))
    graph.add<SphericalJoint>("hinge " + std::to_string(id),
                              {graph.ground().marker(model.nodes.col(model.node_index(id))), rod.node(id)});
  const System system = assemble(graph);
  const Linearization small = linearize(system, system.initial_state(), {.mode_count = 5});
  const VectorX f = small.undamped_frequencies();
  EXPECT_LT(f[0], 1e-3);
  EXPECT_NEAR(f[1], 3.572230585007, 1e-6);
  EXPECT_NEAR(f[2], 22.878511070280, 1e-5);
  EXPECT_NEAR(f[3], 22.898176655722, 1e-5);
}

TEST(linearization, a_rotating_cantilever_softens_in_the_plane_of_rotation_and_not_across_it) {
  // Linear floating frame: flap ω₀², lag ω₀² - Ω² (no stiffening by spin). Modes that are purely transverse.
  const FiniteElementModel model = test::pendulum_model("hex8i");
  const auto basis = make_basis(model, test::frame_of(model, "clamp"), 6);
  for (double speed : {0.0, 6.0, 15.0}) {
    SystemGraph graph({.gravity = {0, 0, 0}});
    auto& beam = graph.add<FlexibleBody>("beam", {.basis = basis, .angular_velocity = Vector3(0, 0, speed)});
    const Marker hub = graph.ground().marker(basis->origin);
    auto& axle = graph.add<RevoluteJoint>("axle", {hub, beam.frame()});
    graph.add<CoordinateDrive>("motor", {axle.angle()}, {.motion = [speed](double t) {
                                 return Motion{speed * t, speed, 0};
                               }});
    const System system = assemble(graph);
    State state = system.initial_state();
    // The steady deformation by spin is not asked for here: η = 0 is where the beam's own frequencies are told.
    state.v.tail(6).setZero();
    const Linearization small = linearize(system, state);
    ASSERT_EQ(small.modes.size(), 6u);
    EXPECT_LT(small.unsteadiness, 1e-6);
    // In the basis of the modes themselves: K = K^ - Ω² (mass of the in-plane part of the modes).
    MatrixX expected = (2 * M_PI * basis->frequencies).cwiseAbs2().asDiagonal();
    for (int axis = 0; axis < 2; ++axis) {
      MatrixX in_plane(basis->nodes.cols(), 6);
      for (int i = 0; i < in_plane.rows(); ++i) in_plane.row(i) = basis->modes.row(3 * i + axis);
      expected -= speed * speed * test::congruence(in_plane, basis->nodal_mass);
    }
    const MatrixX modal = small.position_basis.bottomRows(6).transpose();  // Zᵀ: orthogonal within η alone
    EXPECT_LT((test::congruence(modal, small.K) - expected).norm(), 1e-8 * expected.norm());
    // C = 2 Ω ∫ φ_k · (z × φ_l) dm
    MatrixX x(basis->nodes.cols(), 6), y = x;
    for (int i = 0; i < x.rows(); ++i) x.row(i) = basis->modes.row(3 * i), y.row(i) = basis->modes.row(3 * i + 1);
    const MatrixX xy = test::product(x.transpose(), test::product(basis->nodal_mass, y));
    const MatrixX coriolis = 2 * speed * (xy.transpose() - xy);
    EXPECT_LT((test::congruence(modal, small.C) - coriolis).norm(), 1e-8 * (1 + coriolis.norm()));
    std::printf("spin %4.1f rad/s: %.5f %.5f Hz\n", speed, small.modes[0].frequency(), small.modes[1].frequency());
  }
}

namespace {

/// A disc of polar inertia Jp and diametral Jd, spinning about z, pinned at its centre; held upright by four springs.
struct Rotor {
  static constexpr double mass = 2, Jp = 0.04, Jd = 0.025, arm = 0.2, stiffness = 1500;
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  Rotor(double speed, double stiffness_y) {
    auto& disc =
        graph.add<RigidBody>("disc", {.mass = mass, .inertia = {Jd, Jd, Jp}, .angular_velocity = Vector3(0, 0, speed)});
    graph.add<SphericalJoint>("centre", {graph.ground().marker(), disc.marker()});
    for (const auto& [direction, k] : {std::pair(Vector3(1, 0, 0), stiffness), {Vector3(0, 1, 0), stiffness_y}})
      for (double side : {-1.0, 1.0})
        graph.add<SpringDamper>(
            "spring " + std::to_string(graph.forces().size()),
            {graph.ground().marker(Vector3(0, 0, arm) + side * 1000 * direction), disc.marker({0, 0, arm})},
            {.stiffness = k / 2, .natural_length = 1000});
  }
};

/// Jd θ̈x + Jp Ω θ̇y + k y arm² θx = 0, Jd θ̈y - Jp Ω θ̇x + k x arm² θy = 0: squares of its two frequencies.
std::pair<double, double> precession(double speed, double stiffness_y) {
  const double a = Rotor::stiffness * Rotor::arm * Rotor::arm, b = stiffness_y * Rotor::arm * Rotor::arm;
  const double J = Rotor::Jd, g = Rotor::Jp * speed;
  const double p = (a + b) / J + g * g / (J * J), q = a * b / (J * J);
  const double root = std::sqrt(p * p / 4 - q);
  return {std::sqrt(q / (p / 2 + root)), std::sqrt(p / 2 + root)};
}

}  // namespace

TEST(campbell, a_gyroscopic_rotor_splits_into_forward_and_backward_precession) {
  for (double stiffness_y : {Rotor::stiffness, 1.5 * Rotor::stiffness}) {
    std::vector<double> speeds;
    for (int i = 0; i <= 20; ++i) speeds.push_back(10.0 * i);
    const Campbell diagram = campbell(speeds, [&](double speed) {
      Rotor rotor(speed, stiffness_y);
      const System system = assemble(rotor.graph);
      const Linearization small = linearize(system, system.initial_state(), {.axes = PerturbationAxes::world});
      EXPECT_LT(small.unsteadiness, 1e-9);
      return small;
    });
    ASSERT_EQ(diagram.branches.size(), 2u);
    double worst = 0;
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      const auto [slow, fast] = precession(speeds[i], stiffness_y);
      ASSERT_EQ(diagram.branches[0].speed.size(), speeds.size());
      ASSERT_EQ(diagram.branches[1].speed.size(), speeds.size());
      double a = 2 * M_PI * diagram.branches[0].frequency[i], b = 2 * M_PI * diagram.branches[1].frequency[i];
      if (i > 0 && speeds[1] > 0 && diagram.branches[0].frequency[1] > diagram.branches[1].frequency[1])
        std::swap(a, b);
      worst = std::max({worst, std::abs(a / slow - 1), std::abs(b / fast - 1)});
    }
    EXPECT_LT(worst, 2e-6);  // springs 1000 m long are straight to 1e-7
    std::printf("precession: relative error %.1e\n", worst);
    const test::ScratchFolder folder;
    diagram.write_csv(folder.path("campbell.csv"));
    diagram.write_chart(folder.path("campbell"), "Rotor on springs");
  }
}

TEST(linearization, a_spinning_rotor_has_the_same_whirl_in_body_axes_less_its_speed) {
  const double speed = 50;
  Rotor rotor(speed, Rotor::stiffness);
  const System system = assemble(rotor.graph);
  const Linearization turning = linearize(system, system.initial_state(), {.axes = PerturbationAxes::body});
  const auto [backward, forward] = precession(speed, Rotor::stiffness);
  std::vector<double> expected = {backward + speed, std::abs(forward - speed)};
  std::sort(expected.begin(), expected.end());
  ASSERT_EQ(turning.M.rows(), 3);
  const std::size_t n = turning.modes.size();
  EXPECT_NEAR(turning.modes[n - 2].eigenvalue.imag(), expected[0], 1e-4);
  EXPECT_NEAR(turning.modes[n - 1].eigenvalue.imag(), expected[1], 1e-4);
}

TEST(linearization, a_sleeping_top_wakes_below_its_critical_speed) {
  // Upright heavy top, fixed point: stable while Jz Ω > 2 sqrt(m g l J).  J about the point.
  const double m = 1, l = 0.3, Jz = 0.01, Jd = 0.008, J = Jd + m * l * l;
  const double critical = 2 * std::sqrt(m * kGravity * l * J) / Jz;
  for (double speed : {0.98 * critical, 1.02 * critical}) {
    SystemGraph graph;
    auto& top = graph.add<RigidBody>(
        "top",
        {.mass = m, .inertia = {Jd, Jd, Jz}, .position = Vector3(0, 0, l), .angular_velocity = Vector3(0, 0, speed)});
    graph.add<SphericalJoint>("point", {graph.ground().marker(), top.marker({0, 0, -l})});
    const System system = assemble(graph);
    for (PerturbationAxes axes : {PerturbationAxes::body, PerturbationAxes::world}) {
      const Linearization small = linearize(system, system.initial_state(), {.axes = axes});
      if (speed > critical) {
        EXPECT_LT(small.largest_growth(), 1e-3);
        // Both precessions, ω = (Jz Ω ± sqrt((Jz Ω)² - 4 J m g l))/2J, in world axes.
        const double root = std::sqrt(std::pow(Jz * speed, 2) - 4 * J * m * kGravity * l);
        if (axes == PerturbationAxes::world) {
          const std::size_t n = small.modes.size();
          EXPECT_NEAR(small.modes[n - 1].eigenvalue.imag(), (Jz * speed + root) / (2 * J), 1e-5);
          EXPECT_NEAR(small.modes[n - 2].eigenvalue.imag(), (Jz * speed - root) / (2 * J), 1e-5);
        }
      } else {
        const double growth = std::sqrt(4 * J * m * kGravity * l - std::pow(Jz * speed, 2)) / (2 * J);
        EXPECT_NEAR(small.largest_growth(), growth, 1e-5 * growth);
      }
    }
  }
}

TEST(linearization, a_pendulum_on_a_carousel_swings_as_the_centrifugal_field_says) {
  // Arm R turning at Ω, a point mass on a string of length l below its end in balance: relative equilibrium tan a =
  // Ω² (R + l sin a)/g; ω² of the swing in the turning plane = (g/cos a)/l - Ω² cos² a ... by the effective potential.
  const double R = 0.5, l = 0.8, Omega = 2.5, m = 1.2;
  double a = 0.3;
  for (int i = 0; i < 200; ++i) a = std::atan(Omega * Omega * (R + l * std::sin(a)) / kGravity);
  SystemGraph graph;
  const double x = R + l * std::sin(a), z = -l * std::cos(a);
  auto& hub = graph.add<RigidBody>("hub", {.mass = 1, .inertia = {1, 1, 1}, .angular_velocity = Vector3(0, 0, Omega)});
  const double tiny = 1e-9;
  auto& bob = graph.add<RigidBody>("bob", {.mass = m,
                                           .inertia = {tiny, tiny, tiny},
                                           .position = Vector3(x, 0, z),
                                           .orientation = rotation_about({0, 1, 0}, -a),
                                           .velocity = Vector3(0, Omega * x, 0),
                                           .angular_velocity = rotation_about({0, 1, 0}, a) * Vector3(0, 0, Omega)});
  auto& axle = graph.add<RevoluteJoint>("axle", {graph.ground().marker(), hub.marker()});
  graph.add<CoordinateDrive>("motor", {axle.angle()}, {.motion = [=](double t) {
                               return Motion{Omega * t, Omega, 0};
                             }});
  graph.add<RevoluteJoint>("pin", {hub.marker({R, 0, 0}, kAxisY), bob.marker({0, 0, l}, kAxisY)});
  const System system = assemble(graph);
  const Linearization small = linearize(system, system.initial_state());
  // V_eff = -m g l cos a - ½ m Ω² (R + l sin a)²
  const double stiffness =
      m * kGravity * l * std::cos(a) -
      m * Omega * Omega * (l * l * std::cos(a) * std::cos(a) - l * std::sin(a) * (R + l * std::sin(a)));
  ASSERT_EQ(small.modes.size(), 1u);
  EXPECT_NEAR(small.modes[0].eigenvalue.imag(), std::sqrt(stiffness / (m * l * l)), 1e-7);
  EXPECT_LT(small.unsteadiness, 1e-6);
}

TEST(linearization, a_state_displaced_along_a_mode_keeps_to_the_rows_and_its_potential_is_the_stiffness) {
  SystemGraph graph;
  auto& rod = graph.add<RigidBody>("rod", {.mass = 2, .inertia = {0.2, 0.2, 0.01}, .position = Vector3(0, 0, -0.5)});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, kAxisY), rod.marker({0, 0, 0.5}, kAxisY)});
  const System system = assemble(graph);
  const Linearization small = linearize(system, system.initial_state());
  const State aside = displaced(system, small, small.modes[0], 1e-3, 0);
  Snapshot now(system, aside), still(system, small.state);
  EXPECT_LT(constraint_residual().value(now), 1e-12);
  EXPECT_NEAR(potential_energy().value(now) - potential_energy().value(still), 0.5 * 2 * kGravity * 0.5 * 1e-6, 1e-8);
  Recorder recorder({height(rod.marker())});
  animate(system, small, small.modes[0], 0.1, 25, recorder);
  EXPECT_EQ(recorder.table().row_count(), 25);

  struct EndsAtTheThird final : Observer {
    int seen = 0;
    void observe(Snapshot& /*now*/) override {
      if (++seen >= 3) throw StopRun{"an observer"};
    }
  } ends;
  animate(system, small, small.modes[0], 0.1, 25, ends);
  EXPECT_EQ(ends.seen, 3);
}

TEST(linearization, a_state_off_its_joints_is_refused) {
  SystemGraph graph;
  auto& rod = graph.add<RigidBody>("rod", {.mass = 2, .inertia = {0.2, 0.2, 0.01}, .position = Vector3(0, 0, -0.5)});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, kAxisY), rod.marker({0, 0, 0.5}, kAxisY)});
  const System system = assemble(graph);
  State state = system.initial_state();
  state.q[0] += 0.1;
  EXPECT_THAT(message_of<SceneError>([&] { linearize(system, state); }), HasSubstr("'pin' row"));
}

TEST(describe, names_freedoms_and_redundant_rows) {
  SystemGraph graph;
  auto& door = graph.add<RigidBody>("door", {.mass = 20, .inertia = {1, 1, 1}, .position = Vector3(0.4, 0, 0)});
  graph.add<RevoluteJoint>("upper hinge", {graph.ground().marker({0, 0, 1}), door.marker({-0.4, 0, 1})});
  graph.add<RevoluteJoint>("lower hinge", {graph.ground().marker({0, 0, -1}), door.marker({-0.4, 0, -1})});
  auto& handle =
      graph.add<RigidBody>("handle", {.mass = 0.2, .inertia = {1e-3, 1e-3, 1e-3}, .position = Vector3(0.8, 0, 0)});
  graph.add<RevoluteJoint>("spindle", {door.marker({0.4, 0, 0}, kAxisY), handle.marker({0, 0, 0}, kAxisY)});
  const System system = assemble(graph);
  const std::string text = describe(system);
  EXPECT_THAT(text, HasSubstr("2 bodies, 14 coordinates, 12 velocities, 15 constraint rows of rank 10, 2 degrees"));
  EXPECT_THAT(text, HasSubstr("'lower hinge' row"));
  EXPECT_THAT(text, HasSubstr("repeats"));
  EXPECT_THAT(text, HasSubstr("handle: omega_y"));
  EXPECT_THAT(text, testing::AnyOf(HasSubstr("omega_z, with"), HasSubstr("p_y, with")));
}

}  // namespace lithe::test::linearization_analysis_test
