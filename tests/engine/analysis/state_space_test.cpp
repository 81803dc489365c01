// Inputs and outputs of a linearized mechanism: against closed forms and differences of the equations themselves.
#include "engine/analysis/state_space.h"
#include "engine/analysis/perturbation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bodies/beam/beam.h"
#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/integral_state.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/kinematics.h"
#include "engine/motion/projection.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_file.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/pid_controller.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/flexible_models.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::state_space_test {
namespace {

constexpr double kGravity = 9.81;
const Matrix3 kAxisY = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y

double relative_error(Complex value, Complex exact) { return std::abs(value - exact) / std::abs(exact); }

/// A rod hanging from a hinge about y: J about the hinge, weight m g at l.
struct HangingRod {
  static constexpr double m = 1.3, l = 0.7, own = 0.02, J = own + m * l * l;
  SystemGraph graph;
  RigidBody& rod = graph.add<RigidBody>("rod", {.mass = m, .inertia = {own, own, own}, .position = {0, 0, -l}});
  RevoluteJoint& pin =
      graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, kAxisY), rod.marker({0, 0, l}, kAxisY)});
};

/// J φ̈ = T - m g l φ.
TEST(StateSpace, of_a_pendulum_under_a_torque_is_that_of_the_text_book) {
  HangingRod scene;
  auto& torque = scene.graph.add<Input>("torque", {.unit = "N m", .lower = -5, .upper = 5});
  scene.graph.add<CoordinateMotor>("motor", {scene.pin.angle()}, {.effort = torque});
  const System system = assemble(scene.graph);
  const auto s = linearize(system, system.initial_state(), {&torque},
                           {coordinate(scene.pin.angle(), "angle"), coordinate_rate(scene.pin.angle(), "rate"),
                            coordinate_acceleration(scene.pin.angle(), "acceleration")});
  const double J = HangingRod::J, k = HangingRod::m * kGravity * HangingRod::l;
  ASSERT_EQ(s.A.rows(), 2);
  EXPECT_EQ(s.inputs, std::vector<std::string>{"torque"});
  EXPECT_EQ(s.outputs, (std::vector<std::string>{"angle", "rate", "acceleration"}));
  EXPECT_EQ(s.input_units[0], "N m");
  EXPECT_EQ(s.output_units, (std::vector<std::string>{"rad", "rad/s", "rad/s²"}));
  EXPECT_TRUE(s.B_rate.isZero(0) && s.B_acceleration.isZero(0) && s.D_rate.isZero(0) && s.D_acceleration.isZero(0));
  for (const Complex p : s.poles()) EXPECT_LT(std::abs(std::abs(p.imag()) - std::sqrt(k / J)), 1e-8);
  for (const double w : {0.3, 2.0, 17.0}) {
    const Complex i_w(0, w), exact = 1.0 / (k - J * w * w);
    for (const auto& H : {s.response(i_w), s.descriptor_response(i_w)}) {
      EXPECT_LT(relative_error(H(0, 0), exact), 1e-9);
      EXPECT_LT(relative_error(H(1, 0), i_w * exact), 1e-9);
      EXPECT_LT(relative_error(H(2, 0), -w * w * exact), 1e-9);
    }
  }
  const TransferFunction h = s.transfer_function(0, 0);
  EXPECT_TRUE(h.zeros.empty());
  EXPECT_NEAR(h.gain, 1 / J, 1e-8);
  EXPECT_NEAR(s.D(2, 0), 1 / J, 1e-9);
  EXPECT_EQ(s.zeros(0, 2).size(), 2u);  // s² in the numerator
  for (const Complex z : s.zeros(0, 2)) EXPECT_LT(std::abs(z), 1e-4);
}

/// A drive prescribes φ: the torque that it needs is J φ̈ + m g l φ, the end of the rod moves by l φ.
TEST(StateSpace, of_a_drive_has_the_torque_by_value_and_acceleration) {
  HangingRod scene;
  auto& angle = scene.graph.add<Input>("angle", {.unit = "rad", .between = Input::Between::smooth});
  auto& drive = scene.graph.add<CoordinateDrive>("drive", {scene.pin.angle()}, {.motion = angle});
  const System system = assemble(scene.graph);
  const auto s =
      linearize(system, system.initial_state(), {&angle},
                {drive_force(drive), position(scene.rod.marker(), "rod"), velocity(scene.rod.marker(), "v")});
  EXPECT_EQ(s.A.rows(), 0);
  const double J = HangingRod::J, k = HangingRod::m * kGravity * HangingRod::l;
  EXPECT_NEAR(s.D(0, 0), k, 1e-8);
  EXPECT_NEAR(s.D_rate(0, 0), 0, 1e-8);
  EXPECT_NEAR(s.D_acceleration(0, 0), J, 1e-9);
  EXPECT_NEAR(s.D(1, 0), -HangingRod::l, 1e-9);
  EXPECT_NEAR(s.D_rate(4, 0), -HangingRod::l, 1e-9);
  for (const double w : {0.3, 2.0, 17.0}) {
    const Complex i_w(0, w);
    const auto H = s.descriptor_response(i_w);
    EXPECT_LT(relative_error(H(0, 0), k - J * w * w), 1e-8);
    EXPECT_LT(relative_error(H(1, 0), -HangingRod::l), 1e-8);
    EXPECT_LT(relative_error(H(4, 0), -HangingRod::l * i_w), 1e-8);
  }
  // k + J s²
  const auto zeros = s.zeros(0, 0);
  ASSERT_EQ(zeros.size(), 2u);
  for (const Complex z : zeros) EXPECT_NEAR(std::abs(z.imag()), std::sqrt(k / J), 1e-7);
}

/// Two masses on springs: where the first is pushed and watched, the second alone is the zero.
TEST(StateSpace, has_the_zeros_of_what_absorbs) {
  const double m1 = 2, m2 = 0.5, k1 = 300, k2 = 80, c2 = 0.4;
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  const Matrix3 along_x = rotation_about({0, 1, 0}, M_PI / 2);
  auto& push = graph.add<Input>("push", {.unit = "N", .lower = -1, .upper = 1});
  auto& first = graph.add<RigidBody>("first", {.mass = m1, .inertia = {1, 1, 1}, .position = {1, 0, 0}});
  auto& second = graph.add<RigidBody>("second", {.mass = m2, .inertia = {1, 1, 1}, .position = {2, 0, 0}});
  graph.add<PrismaticJoint>("a", {graph.ground().marker({0, 0, 0}, along_x), first.marker({0, 0, 0}, along_x)});
  graph.add<PrismaticJoint>("b", {graph.ground().marker({0, 0, 0}, along_x), second.marker({0, 0, 0}, along_x)});
  graph.add<SpringDamper>("k1", {graph.ground().marker(), first.marker()}, {.stiffness = k1});
  graph.add<SpringDamper>("k2", {first.marker(), second.marker()}, {.stiffness = k2, .damping = c2});
  graph.add<PointForce>("force", {first.marker()}, {.force = {1, 0, 0}, .factor = push});
  const System system = assemble(graph);
  const auto s = linearize(system, system.initial_state(), {&push},
                           {position(first.marker(), "first"), position(second.marker(), "second")});
  const auto exact = [&](Complex p, bool of_second) {
    const Complex link = k2 + c2 * p, own = m2 * p * p + link;
    const Complex det = (m1 * p * p + k1 + link) * own - link * link;
    return (of_second ? link : own) / det;
  };
  for (const Complex p : {Complex(0, 3), Complex(0, 14), Complex(-1, 20), Complex(2, 0.5)}) {
    EXPECT_LT(relative_error(s.response(p)(0, 0), exact(p, false)), 1e-9);
    EXPECT_LT(relative_error(s.response(p)(3, 0), exact(p, true)), 1e-9);
    EXPECT_LT(relative_error(s.transfer_function(0, 0)(p), exact(p, false)), 1e-7);
    EXPECT_LT(relative_error(s.transfer_function(0, 3)(p), exact(p, true)), 1e-7);
  }
  const auto collocated = s.zeros(0, 0), other = s.zeros(0, 3);
  ASSERT_EQ(collocated.size(), 2u);
  const Complex absorber(-c2 / (2 * m2), std::sqrt(k2 / m2 - std::pow(c2 / (2 * m2), 2)));
  EXPECT_LT(std::min(std::abs(collocated[0] - absorber), std::abs(collocated[1] - absorber)), 1e-6);
  ASSERT_EQ(other.size(), 1u);
  EXPECT_NEAR(other[0].real(), -k2 / c2, 1e-5);
}

// ---- against differences of the equations ----

/// A flexible rod that hangs from a motor, pushed at its end, on a spring whose free length is an input; a controller
/// whose target has a rate.
struct Arm {
  SystemGraph graph;
  Input& torque = graph.add<Input>("torque", {.unit = "N m", .lower = -2, .upper = 2});
  Input &push, &length;
  Input& target = graph.add<Input>("target", {.unit = "rad", .between = Input::Between::smooth});
  FlexibleBody* rod;
  RevoluteJoint* pin;
  Marker tip;

  /// Controlled: without weight and spring, at rest as drawn.
  explicit Arm(bool controlled)
      : graph({.gravity = {0, 0, controlled ? 0 : -kGravity}}),
        push(graph.add<Input>("push", {.unit = "N", .value = controlled ? 0 : 0.3, .lower = -4, .upper = 4})),
        length(graph.add<Input>("length", {.unit = "m", .value = 0.25, .lower = 0.05, .upper = 0.5})) {
    const auto basis = make_basis(brick_mesh({.size = {0.4, 0.02, 0.02},
                                              .divisions = {4, 1, 1},
                                              .type = "C3D8I",
                                              .material = {2e8, 0.3, 1200},
                                              .name = "rod"}),
                                  MeanAxisFrame{}, 4);
    rod = &graph.add<FlexibleBody>("rod", {.basis = basis, .position = {0, 0, -0.01}});  // nodes 1 and 2 on the hinge
    pin = &graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, kAxisY), rod->average({1, 2}, kAxisY)});
    tip = rod->node(basis->node_ids.back());
    graph.add<CoordinateMotor>("motor", {pin->angle()}, {.effort = torque});
    graph.add<PointForce>("push it", {tip}, {.force = {0.2, 0, 1}, .factor = push});
    if (!controlled) {
      graph.add<SpringDamper>("spring", {graph.ground().marker({0.3, 0, 0.3}), tip},
                              {.stiffness = 60, .damping = 0.3, .natural_length = length});
      return;
    }
    auto& memory = graph.add<IntegralState>("memory");
    graph.add<PidController>("servo", {pin->angle(), memory.coordinate()},
                             {.target = target, .proportional = 3, .integral = 4, .derivative = 0.4});
  }
};

/// At rest ẇ = Zᵀ v̇ (y, w, u) exactly, and sensors are functions of (q, v, v̇, λ): each column of A, B, C, D once more
/// from the nonlinear equations, by differences of second order with Richardson's step.
TEST(StateSpace, is_the_derivative_of_the_equations_with_its_inputs) {
  Arm arm(false);
  const System system = assemble(arm.graph);
  const State rest = find_equilibrium(system, system.initial_state()).state;
  const std::vector<const Input*> inputs{&arm.torque, &arm.push, &arm.length};
  const std::vector<Sensor> outputs{coordinate(arm.pin->angle(), "angle"),
                                    position(arm.tip, "tip"),
                                    velocity(arm.tip, "v"),
                                    acceleration(arm.tip, "a"),
                                    joint_reaction(*arm.pin),
                                    elastic_energy(*arm.rod)};
  const auto s = linearize(system, rest, inputs, outputs);
  const Linearization& l = s.about;
  const Eigen::Index np = l.position_basis.cols(), nw = l.velocity_basis.cols();
  Perturbation axes(system, rest, PerturbationAxes::body);
  Evaluator equations(system);
  Projector projector(equations);
  Snapshot now(system);
  // (ẇ, outputs) at a small change.
  const auto at = [&](const VectorX& x, const Input* input, double du) {
    State state = l.state;
    const VectorX zeta = axes.to_engine(l.position_basis * x.head(np));
    system.layout().retract(l.state.q, zeta, state.q);
    projector.position(0, state.q, 1e-14, 20);
    state.v = axes.to_engine(l.velocity_basis * x.tail(nw));
    projector.velocity(0, state.q, state.v);
    if (input) input->force({input->value(0) + du, 0, 0});
    projector.accelerations(0, state.q, state.v, state.v_dot, state.lambda);
    now.evaluate(state);
    VectorX out(nw + static_cast<Eigen::Index>(s.outputs.size()));
    out.head(nw) = l.velocity_basis.transpose() * axes.to_axes(state.v_dot);
    Eigen::Index place = nw;
    for (const Sensor& sensor : outputs) {
      sensor.evaluate(now, {out.data() + place, sensor.columns().size()});
      place += static_cast<Eigen::Index>(sensor.columns().size());
    }
    if (input) input->release();
    return out;
  };
  const auto derivative = [&](const VectorX& x, const Input* input, double du, double h) {
    const auto central = [&](double step) {
      return VectorX((at(step * x, input, step * du) - at(-step * x, input, -step * du)) / (2 * step));
    };
    return VectorX((4 * central(h) - central(2 * h)) / 3);
  };
  const VectorX none = VectorX::Zero(np + nw);
  const auto close = [](const VectorX& a, const VectorX& b, double bound, const std::string& what) {
    EXPECT_LT((a - b).norm(), bound * (b.norm() + 1e-30)) << what << ": " << a.transpose() << " for " << b.transpose();
  };
  // Each input alone is linear but for the length, whose spring turns with it not at all at rest: 1e-9.
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const VectorX exact = derivative(none, inputs[i], 1, 1e-2);
    const auto column = static_cast<Eigen::Index>(i);
    close(s.B.col(column).tail(nw), exact.head(nw), 1e-9, "B by " + inputs[i]->name());
    EXPECT_TRUE(s.B.col(column).head(np).isZero(1e-15));
    close(s.D.col(column), exact.tail(exact.size() - nw), 1e-9, "D by " + inputs[i]->name());
  }
  for (Eigen::Index j = 0; j < np + nw; ++j) {
    const VectorX exact = derivative(VectorX::Unit(np + nw, j), nullptr, 0, 1e-4);
    close(s.A.col(j).tail(nw), exact.head(nw), 3e-8, "A " + std::to_string(j));
    // A sensor at a time, since accelerations are far larger than positions; by symmetry some columns of one are zero.
    Eigen::Index first = 0;
    for (const Sensor& sensor : outputs) {
      const auto count = static_cast<Eigen::Index>(sensor.columns().size());
      const double size = s.C.middleRows(first, count).norm();
      EXPECT_LT((s.C.col(j).segment(first, count) - exact.segment(nw + first, count)).norm(), 3e-8 * size + 1e-12)
          << sensor.name() << " by " << j;
      first += count;
    }
  }
}

/// The two forms are two ways to the same transfer functions.
TEST(StateSpace, has_the_same_response_in_both_forms) {
  for (const bool controlled : {false, true}) {
    Arm arm(controlled);
    const System system = assemble(arm.graph);
    const State rest = controlled ? system.initial_state() : find_equilibrium(system, system.initial_state()).state;
    const std::vector<const Input*> inputs{&arm.torque, &arm.push, controlled ? &arm.target : &arm.length};
    const auto s = linearize(system, rest, inputs,
                             {coordinate(arm.pin->angle(), "angle"), position(arm.tip, "tip"), velocity(arm.tip, "v"),
                              acceleration(arm.tip, "a"), joint_reaction(*arm.pin)});
    EXPECT_EQ(s.B_rate.col(2).isZero(0), !controlled);
    EXPECT_TRUE(s.B_rate.leftCols(2).isZero(0));
    for (const Complex p : {Complex(0, 1), Complex(0, 40), Complex(0.5, 7)}) {
      const Eigen::MatrixXcd a = s.response(p), b = s.descriptor_response(p);
      // A sensor at a time. The descriptor's columns are those of single coordinates, stiff as the clamped rod is,
      // whose round-off is some 1e-10 of 1e7 N/m.
      for (const auto& [first, count] : {std::pair(0, 1), {1, 3}, {4, 3}, {7, 3}, {10, 3}, {13, 3}}) {
        const double size = a.middleRows(first, count).norm();
        EXPECT_LT((a - b).middleRows(first, count).norm(), 1e-3 * size) << s.outputs[static_cast<std::size_t>(first)];
      }
    }
    // And as poles and zeros.
    for (const auto& [input, output] : {std::pair(0, 0), {0, 3}, {1, 3}, {1, 9}, {2, 0}}) {
      const TransferFunction h = s.transfer_function(input, output);
      for (const Complex p : {Complex(0, 2), Complex(0, 50), Complex(1, 10)})
        EXPECT_LT(relative_error(h(p), s.response(p)(output, input)), 1e-5) << h.input << " to " << h.output;
    }
  }
}

// ---- a flexible arm against its analytic transfer functions ----

/// Euler and Bernoulli's beam, driven by a torque T at the hinge: EI w⁗ = ρA ω² w, w(0) = 0, EI w″(0) = -T, its end
/// free. The angle at the hinge and the deflection of the end, by T.
std::array<double, 2> analytic(double EI, double mass, double length, double omega) {
  const double b = std::pow(mass * omega * omega / EI, 0.25), x = b * length;
  const double s = std::sin(x), c = std::cos(x), sh = std::sinh(x), ch = std::cosh(x);
  // w = a (cos - cosh) + p sin + q sinh
  const double a = 1 / (2 * EI * b * b), det = sh * c - s * ch;
  const double p = a * ((c + ch) * ch - sh * (sh - s)) / det, q = a * (c * (c + ch) - s * (sh - s)) / det;
  return {b * (p + q), a * (c - ch) + p * s + q * sh};
}

TEST(StateSpace, gives_the_bode_chart_of_a_flexible_arm) {
  // So slender that shear and rotary inertia, which Euler and Bernoulli leave out, lower the third mode by 2e-5: a
  // hundredth of it away from the mode that is 2e-3 of the response.
  const double length = 2, edge = 0.002, E = 7e10, density = 2700;
  const double EI = E * std::pow(edge, 4) / 12, mass = density * edge * edge;
  // Rigid limit, as a check of the formula itself: T / (-J ω²).
  EXPECT_NEAR(analytic(EI, mass, length, 1e-3)[0] * -1e-6 * mass * std::pow(length, 3) / 3, 1, 1e-6);
  const auto bode = [&](int elements, const std::vector<double>& frequencies) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& torque = graph.add<Input>("torque", {.unit = "N m", .lower = -1, .upper = 1});
    auto& arm = graph.add<Beam>("arm", {.axis = BeamAxis::straight({0, 0, 0}, {length, 0, 0}),
                                        .sections = {{0, BeamSection::rectangle(edge, edge, {E, 0.3, density})}},
                                        .elements = elements});
    auto& hinge =
        graph.add<RevoluteJoint>("hinge", {graph.ground().marker(), arm.marker(0, {}, arm.axes(0).transpose())});
    graph.add<CoordinateMotor>("motor", {hinge.angle()}, {.effort = torque});
    const System system = assemble(graph);
    const auto s = linearize(system, system.initial_state(), {&torque},
                             {coordinate(hinge.angle(), "angle"), position(arm.marker(length), "end")});
    std::vector<std::array<double, 2>> values;
    for (const double f : frequencies) {
      const auto H = s.response({0, 2 * M_PI * f});
      EXPECT_LT(std::abs(H(0, 0).imag()), 1e-6 * std::abs(H(0, 0)));
      values.push_back({H(0, 0).real(), H(2, 0).real()});
    }
    return values;
  };
  // From well below the first bending mode (1.80 Hz, pinned and free) to above the third (12.2 Hz).
  std::vector<double> frequencies;
  for (int k = 0; k <= 20; ++k) frequencies.push_back(0.1 * std::pow(160.0, k / 20.0));
  // Three meshes: without the errors of second and fourth order in their elements.
  const auto coarse = bode(12, frequencies), middle = bode(24, frequencies), fine = bode(48, frequencies);
  int compared = 0;
  for (std::size_t k = 0; k < frequencies.size(); ++k) {
    const auto exact = analytic(EI, mass, length, 2 * M_PI * frequencies[k]);
    for (std::size_t o : {0u, 1u}) {
      // Near a pole or a zero, where meshes differ by their frequencies, nothing is relative.
      const double first = (4 * middle[k][o] - coarse[k][o]) / 3, second = (4 * fine[k][o] - middle[k][o]) / 3;
      if (std::abs(fine[k][o] - middle[k][o]) > 0.02 * std::abs(fine[k][o])) continue;
      EXPECT_LT(std::abs((16 * second - first) / 15 / exact[o] - 1), 3e-3) << frequencies[k] << " Hz, output " << o;
      ++compared;
    }
  }
  EXPECT_GT(compared, 30);
}

// ---- charts and files ----

TEST(StateSpace, is_drawn_and_written) {
  HangingRod scene;
  auto& torque = scene.graph.add<Input>("torque", {.unit = "N m"});
  scene.graph.add<CoordinateMotor>("motor", {scene.pin.angle()}, {.effort = torque});
  const System system = assemble(scene.graph);
  const auto s = linearize(system, system.initial_state(), {&torque}, {coordinate(scene.pin.angle(), "angle")});
  const ScratchFolder folder;
  write_csv(s, folder.path("pendulum"));
  write_hdf5(s, folder.path("pendulum.h5"));
  write_matrix_market(s, folder.path("pendulum"));
  const Table A = read_csv(folder.path("pendulum_A.csv"));
  EXPECT_EQ(A.at(1, 0), s.A(1, 0));
  EXPECT_EQ(read_csv(folder.path("pendulum_B.csv")).columns, std::vector<std::string>{"torque"});
  const Hdf5Reader file(folder.path("pendulum.h5"));
  EXPECT_EQ(file.matrix("/A"), s.A);
  EXPECT_EQ(file.matrix("/descriptor/E"), s.descriptor.E);
  EXPECT_EQ(file.texts("/output_units"), s.output_units);
  std::ifstream market(folder.path("pendulum_descriptor_E.mtx"));
  std::string line;
  std::getline(market, line);
  EXPECT_EQ(line, "%%MatrixMarket matrix coordinate real general");
  MatrixX E = MatrixX::Zero(s.descriptor.E.rows(), s.descriptor.E.cols());
  int rows = 0, columns = 0, count = 0, i = 0, j = 0;
  double value = 0;
  market >> rows >> columns >> count;
  for (int k = 0; k < count && market >> i >> j >> value; ++k) E(i - 1, j - 1) = value;
  EXPECT_EQ(E, s.descriptor.E);
  const FrequencyResponse r = frequency_response(s, 0, 0, 0.1, 10, 50);
  EXPECT_GE(r.frequency.size(), 50u);
  const double k = HangingRod::m * kGravity * HangingRod::l;
  EXPECT_NEAR(r.decibels().front(), -20 * std::log10(k - HangingRod::J * std::pow(0.2 * M_PI, 2)), 1e-6);
  EXPECT_NEAR(std::abs(r.phase().back()), 180, 1e-6);
  write_bode({r}, folder.path("bode"));
  write_nyquist({r}, folder.path("nyquist"));
  for (const char* name : {"bode_amplitude.svg", "bode_phase.png", "nyquist.svg"})
    EXPECT_TRUE(std::filesystem::exists(folder.path(name))) << name;
}

TEST(StateSpace, refuses_inputs_of_other_scenes) {
  HangingRod scene, other;
  auto& torque = other.graph.add<Input>("torque");
  const System system = assemble(scene.graph);
  const Sensor angle = coordinate(scene.pin.angle(), "angle");
  const auto refused = [&](const std::vector<const Input*>& inputs, const std::vector<Sensor>& outputs) {
    try {
      linearize(system, system.initial_state(), inputs, outputs);
    } catch (const SceneError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused({&torque}, {angle}).find("'torque' is of another graph"), std::string::npos);
  EXPECT_NE(refused({}, {angle}).find("no input"), std::string::npos);
  auto& own = scene.graph.add<Input>("own");
  EXPECT_NE(refused({&own}, {}).find("no output"), std::string::npos);
}

}  // namespace
}  // namespace lithe::test::state_space_test
