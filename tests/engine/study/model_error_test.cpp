// What solve() is made of: runs of a model, oscillators driven by what it leaves out, and the error that follows.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "engine/study/model_error.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

namespace lithe::test::model_error_test {
namespace {

double largest(const MatrixX& A) { return A.cwiseAbs().maxCoeff(); }

// ---- oscillators ----

/// δη̈ + A (D δη̇ + K δη) = a by classical Runge-Kutta in many steps a sample, a linear between the samples.
DrivenOscillators::Response integrated(const MatrixX& A, const VectorX& D, const VectorX& K, const MatrixX& a,
                                       double interval, const VectorX& start, const VectorX& start_rate) {
  constexpr int kSteps = 400;
  const double h = interval / kSteps;
  VectorX x = start, v = start_rate;
  DrivenOscillators::Response out{a, a, a};
  const auto pull = [&](const VectorX& place, const VectorX& rate) -> VectorX {
    return A * (D.cwiseProduct(rate) + K.cwiseProduct(place));
  };
  for (Eigen::Index k = 0; k < a.cols(); ++k) {
    out.displacement.col(k) = x, out.rate.col(k) = v, out.acceleration.col(k) = a.col(k) - pull(x, v);
    for (int i = 0; i < kSteps && k + 1 < a.cols(); ++i) {
      const auto load = [&](double s) -> VectorX { return a.col(k) + (i + s) / kSteps * (a.col(k + 1) - a.col(k)); };
      const VectorX v1 = load(0) - pull(x, v), x2 = x + h / 2 * v, w2 = v + h / 2 * v1, v2 = load(0.5) - pull(x2, w2),
                    x3 = x + h / 2 * w2, w3 = v + h / 2 * v2, v3 = load(0.5) - pull(x3, w3), x4 = x + h * w3,
                    w4 = v + h * v3, v4 = load(1) - pull(x4, w4);
      x += h / 6 * (v + 2 * w2 + 2 * w3 + w4);
      v += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    }
  }
  return out;
}

void expect_same(const DrivenOscillators::Response& found, const DrivenOscillators::Response& expected,
                 double tolerance) {
  EXPECT_LT(largest(found.displacement - expected.displacement), tolerance * largest(expected.displacement));
  EXPECT_LT(largest(found.rate - expected.rate), tolerance * largest(expected.rate));
  EXPECT_LT(largest(found.acceleration - expected.acceleration), tolerance * largest(expected.acceleration));
}

VectorX one(double value) { return VectorX::Constant(1, value); }

TEST(DrivenOscillators, a_step_and_a_ramp_of_load_swing_about_the_static_deflection_however_coarse_the_samples) {
  const double mobility = 2.5, stiffness = 40, w = std::sqrt(mobility * stiffness), h = 0.37;
  const DrivenOscillators oscillators(MatrixX::Constant(1, 1, mobility), one(0), one(stiffness));
  EXPECT_NEAR(oscillators.frequencies()[0], w, 1e-13);
  MatrixX step = MatrixX::Constant(1, 30, 3.0), ramp(1, 30);
  for (int k = 0; k < 30; ++k) ramp(0, k) = 3.0 * k * h;
  const auto a = oscillators.respond(step, h, one(0), one(0)), b = oscillators.respond(ramp, h, one(0), one(0));
  for (int k = 0; k < 30; ++k) {
    const double t = k * h;
    EXPECT_NEAR(a.displacement(0, k), 3 / (w * w) * (1 - std::cos(w * t)), 1e-12);
    EXPECT_NEAR(a.rate(0, k), 3 / w * std::sin(w * t), 1e-12);
    EXPECT_NEAR(a.acceleration(0, k), 3 * std::cos(w * t), 1e-11);
    EXPECT_NEAR(b.displacement(0, k), 3 / (w * w) * (t - std::sin(w * t) / w), 1e-12);
    EXPECT_NEAR(b.rate(0, k), 3 / (w * w) * (1 - std::cos(w * t)), 1e-12);
  }
}

TEST(DrivenOscillators, a_harmonic_load_near_resonance_beats) {
  const double w = 20, drive = 19, h = 2e-3;
  const DrivenOscillators oscillators(MatrixX::Identity(1, 1), one(0), one(w * w));
  MatrixX load(1, 2000);
  for (int k = 0; k < 2000; ++k) load(0, k) = std::sin(drive * k * h);
  const auto found = oscillators.respond(load, h, one(0), one(0));
  const double static_part = 1 / (w * w - drive * drive);
  for (int k = 0; k < 2000; ++k) {
    const double t = k * h, x = static_part * (std::sin(drive * t) - drive / w * std::sin(w * t));
    EXPECT_NEAR(found.displacement(0, k), x, 3e-4 * static_part);
  }
  EXPECT_GT(largest(found.displacement), 1.9 * static_part);
}

TEST(DrivenOscillators, are_what_a_fine_integration_gives_with_light_critical_and_strong_damping) {
  const double w = 7, h = 0.1;
  RandomNumbers random(2);
  const MatrixX load = random.vector(40, 5).transpose();
  for (double zeta : {0.0, 0.02, 0.999999, 1.0, 1.0000001, 1.3, 8.0}) {
    const VectorX D = one(2 * zeta * w), K = one(w * w), start = one(0.1), rate = one(-0.7);
    const MatrixX A = MatrixX::Identity(1, 1);
    SCOPED_TRACE(zeta);
    expect_same(DrivenOscillators(A, D, K).respond(load, h, start, rate), integrated(A, D, K, load, h, start, rate),
                2e-8);
  }
}

TEST(DrivenOscillators, coupled_by_recoil_and_held_by_joints_they_are_what_a_fine_integration_gives) {
  RandomNumbers random(4);
  const VectorX K = (VectorX(3) << 30, 80, 400).finished();
  MatrixX root(3, 3);
  for (int k = 0; k < 3; ++k) root.col(k) = random.vector(3);
  for (int free : {3, 2, 1}) {  // directions that joints leave
    SCOPED_TRACE(free);
    const MatrixX B = root.leftCols(free), A = B * B.transpose();
    const MatrixX load = B * MatrixX(random.matrix3x(30, 3).topRows(free));
    const VectorX start = B * random.vector(free, 0.2), rate = B * random.vector(free, 1), D = 0.01 * K;
    const DrivenOscillators oscillators(A, D, K);
    expect_same(oscillators.respond(load, 0.05, start, rate), integrated(A, D, K, load, 0.05, start, rate), 1e-7);
    EXPECT_EQ((oscillators.frequencies().array() == 0).count(), 3 - free);
    EXPECT_LT(largest(A * oscillators.inertia() * A - A), 1e-12 * largest(A));
    EXPECT_LT(largest(oscillators.mobility() - A), 1e-15);
  }
}

TEST(DrivenOscillators, a_slow_load_gives_the_static_deflection) {
  const VectorX K = (VectorX(2) << 100, 1e6).finished(), D = 0.5 * K.cwiseSqrt();
  MatrixX load(2, 400);
  for (int k = 0; k < 400; ++k) load.col(k) = std::min(1.0, k / 200.0) * Eigen::Vector2d(2, 3);
  const DrivenOscillators oscillators(MatrixX::Identity(2, 2), D, K);
  const auto all = oscillators.respond(load, 0.1, VectorX::Zero(2), VectorX::Zero(2));
  EXPECT_NEAR(all.displacement(0, 399), 2 / 1e2, 1e-12);
  EXPECT_NEAR(all.displacement(1, 399), 3 / 1e6, 1e-14);
  EXPECT_NEAR(all.displacement(1, 100), 1.5 / 1e6 - D[1] * 0.15 / 1e12, 1e-14);  // half way up, lagging
}

// ---- runs ----

constexpr double kLength = 0.5;
MakeIntegratorBy<Tolerance> explicit_method() {
  return [](const Tolerance& tolerance) { return runge_kutta8(tolerance.relative); };
}
RunRequest request(double duration, int samples, double tolerance = 1e-8) {
  return {.duration = duration, .samples = samples, .tolerance = {tolerance, tolerance}};
}

/// A rigid bar on a hinge along y, released level; it turns over when `spin` is large.
struct RigidPendulum {
  explicit RigidPendulum(double spin = 0) {
    auto& bar = graph.add<RigidBody>("bar", {.mass = 1,
                                             .inertia = {1e-3, 0.02, 0.02},
                                             .position = {kLength / 2, 0, 0},
                                             .velocity = {0, 0, -spin * kLength / 2},
                                             .angular_velocity = {0, spin, 0}});
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    pin = &graph.add<RevoluteJoint>("pin",
                                    {graph.ground().marker({}, along_y), bar.marker({-kLength / 2, 0, 0}, along_y)});
    tip = bar.marker({kLength / 2, 0, 0});
  }
  SystemGraph graph;
  RevoluteJoint* pin;
  Marker tip;
};

TEST(ModelRun, samples_between_steps_are_what_stopping_there_gives_whole_turns_included) {
  RigidPendulum scene(20);
  const std::vector<Sensor> sensors = {position(scene.tip, "tip"), velocity(scene.tip, "speed"),
                                       coordinate(scene.pin->angle(), "angle"), reaction(*scene.pin, 1)};
  BodyModels none(scene.graph);
  EXPECT_EQ(none.count(), 0);
  const ModelRun run = run_model(scene.graph, none, {}, sensors, explicit_method(), request(2, 50, 1e-10));
  ASSERT_TRUE(run.reached()) << run.why;
  ASSERT_EQ(run.samples.row_count(), 51);
  ASSERT_EQ(run.states.size(), 51u);
  EXPECT_LT(run.residual, 1e-9);
  const System system = assemble(scene.graph);
  const Method method = runge_kutta8(1e-10);
  Simulation simulation(system, *method);
  Recorder recorder(sensors);
  simulation.observe(recorder, every(0.04));
  State state = system.initial_state();
  simulation.run(state, 2);
  ASSERT_EQ(run.samples.columns, recorder.table().columns);
  const auto changes = sample_changes(sensors, recorder.table());
  const auto apart = sample_differences(sensors, run.samples, recorder.table());
  for (size_t s = 0; s < sensors.size(); ++s) EXPECT_LT(apart[s], 1e-6 * changes[s]) << sensors[s].name();
  EXPECT_GT(std::abs(run.samples.at(50, 7)), 4 * M_PI);  // turned over, turn upon turn

  RunRequest kinematics = request(2, 50, 1e-10);
  kinematics.dynamics = false;
  const ModelRun same = run_model(scene.graph, none, {}, sensors, explicit_method(), kinematics);
  EXPECT_TRUE(same.states.empty());
  EXPECT_LT(sample_differences(sensors, run.samples, same.samples)[0], 1e-14);
}

TEST(ModelRun, a_run_that_fails_tells_why) {
  RigidPendulum scene;
  BodyModels none(scene.graph);
  const Sensor broken{"broken", {"broken"}, [](Snapshot& now, std::span<double> out) {
                        out[0] = now.time() < 0.5 ? 0 : std::numeric_limits<double>::quiet_NaN();
                      }};
  const ModelRun run = run_model(scene.graph, none, {}, {broken}, explicit_method(), request(1, 10));
  EXPECT_FALSE(run.reached());
  EXPECT_NE(run.why.find("'broken'"), std::string::npos) << run.why;
  scene.graph.add<UserForce>("burst", {scene.tip}, {[](double t, const MarkerView&) {
                               return force(Vector3(0, 0, 1 / std::max(0.0, 0.3 - t)));
                             }});
  const ModelRun burst = run_model(scene.graph, none, {}, {position(scene.tip)}, explicit_method(), request(1, 10));
  EXPECT_FALSE(burst.reached());
  EXPECT_LT(burst.samples.row_count(), 5);
}

TEST(RecordedWrench, is_the_force_of_the_same_law_in_world_axes_and_torque_in_those_of_the_body) {
  RandomNumbers random(8);
  const double interval = 0.1;
  RecordedWrench::Parameters recorded{interval, random.matrix3x(6, 4), random.matrix3x(6, 0.05)};
  const auto law = [recorded, interval](double t, const MarkerView& m) -> Wrench {
    const auto at = [&](const Matrix3X& table) -> Vector3 {
      if (t >= 5 * interval) return table.col(5);  // the last holds on
      const int k = static_cast<int>(t / interval);
      return table.col(k) + (t / interval - k) * (table.col(k + 1) - table.col(k));
    };
    return {at(recorded.force), m.R * at(recorded.torque)};
  };
  Table tables[2];
  for (int by_law : {0, 1}) {
    SystemGraph graph;
    auto& body =
        graph.add<RigidBody>("body", {.mass = 2, .inertia = {0.01, 0.02, 0.015}, .angular_velocity = {3, 4, 5}});
    const Marker marker = body.marker({0.1, 0, -0.05}, rotation_about({1, 1, 0}, 0.5));
    if (by_law)
      graph.add<UserForce>("load", {marker}, {law});
    else
      graph.add<RecordedWrench>("load", {marker}, recorded);
    BodyModels none(graph);
    const auto fixed = [](const Tolerance&) { return runge_kutta_fixed(2e-3); };
    tables[by_law] =
        run_model(graph, none, {}, {position(marker, "place"), orientation(marker, "axes")}, fixed, request(0.8, 16))
            .samples;
  }
  ASSERT_EQ(tables[0].row_count(), 17);
  for (size_t i = 0; i < tables[0].values.size(); ++i) EXPECT_NEAR(tables[0].values[i], tables[1].values[i], 1e-12);
}

// ---- errors of models ----

/// Largest difference over that of what is expected from a base.
double misses(const std::vector<Sensor>& sensors, const Table& predicted, const Table& exact, const Table& base,
              size_t sensor = 0) {
  return sample_differences(sensors, predicted, exact)[sensor] / sample_differences(sensors, base, exact)[sensor];
}

/// A cantilever whose foot is moved up and down by a drive, without weight; its end swings already.
struct ShakenCantilever {
  explicit ShakenCantilever(double frequency, double mean_damping = 0) {
    const FiniteElementModel model = brick_mesh(
        {.size = {kLength, 0.02, 0.01}, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {2e9, 0.3, 1200}});
    FlexibleBody::Parameters beam{.basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 4),
                                  .damping = {.mass_proportional = mean_damping}};
    beam.modal_coordinates = (VectorX(4) << 4e-4, -2e-4, 0, 0).finished();  // it starts bent, and on its way
    beam.modal_velocities = (VectorX(4) << 0.03, 0.02, 0.05, 0).finished();
    body = &graph.add<FlexibleBody>("beam", beam);
    const Marker foot = body->average(model.node_set("x_min")), ground = graph.ground().marker({0, 0.01, 0.005});
    auto& guide = graph.add<PrismaticJoint>("guide", {ground, foot});
    drive = &graph.add<CoordinateDrive>(
        "drive", {guide.displacement()},
        {.motion = smooth_step(0, 0.02, 0, 0.05) + harmonic(1e-3, frequency, M_PI / 2, -1e-3)});
    tip = body->node(model.node_set("x_max").back());
  }
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  FlexibleBody* body;
  CoordinateDrive* drive;
  Marker tip;
};

/// What shows at once, and what a run under the feedback adds.
Table superposed(const ModelError& error, const ModelRun& corrected, const ModelRun& rigid) {
  Table sum = error.samples;
  const size_t width = sum.columns.size();
  for (size_t i = 0; i < sum.values.size(); ++i)
    if (i % width > 0) sum.values[i] += corrected.samples.values[i] - rigid.samples.values[i];
  return sum;
}

TEST(ModelError, of_a_shaken_cantilever_is_what_the_run_of_the_whole_model_shows) {
  ShakenCantilever scene(100, 3);
  const std::vector<Sensor> sensors = {position(scene.tip, "tip"), velocity(scene.tip, "speed"),
                                       reaction(*scene.drive, 1)};
  BodyModels bodies(scene.graph);
  ASSERT_EQ(bodies.count(), 1);
  const auto go = [&](const std::vector<Fidelity>& models) {
    return run_model(scene.graph, bodies, models, sensors, explicit_method(), request(0.3, 600, 1e-9));
  };
  const ModelRun whole = go(bodies.all());
  ASSERT_TRUE(whole.reached());
  // No turning, and nothing but the first order: the prediction is exact but for the drive between samples.
  for (const std::vector<int>& modes : {std::vector<int>{}, std::vector<int>{0}, std::vector<int>{1, 2}}) {
    const ModelRun poorer = go({{modes, Deflection::linear}});
    ASSERT_TRUE(poorer.reached());
    const ModelError error = model_error(scene.graph, bodies, poorer, bodies.all(), sensors);
    EXPECT_EQ(bodies.current(), bodies.all());
    ASSERT_EQ(error.coordinates.size(), 4 - modes.size());
    ASSERT_EQ(error.states.size(), 601u);
    for (size_t s = 0; s < sensors.size(); ++s) {
      SCOPED_TRACE(sensors[s].name() + " without " + std::to_string(error.coordinates.size()) + " modes");
      EXPECT_LT(misses(sensors, error.samples, whole.samples, poorer.samples, s), 0.02);
      EXPECT_NEAR(error.effect[s] / sample_differences(sensors, whole.samples, poorer.samples)[s], 1, 0.02);
    }
  }
  // One by one: the effect of the first mode is that of leaving it out.
  const ModelRun rigid = go(bodies.rigid()), first = go({{{0}, Deflection::linear}});
  const ModelError error = model_error(scene.graph, bodies, rigid, bodies.all(), sensors);
  EXPECT_NEAR(error.coordinates[0].effect[0] / sample_differences(sensors, first.samples, rigid.samples)[0], 1, 0.02);
  EXPECT_NEAR(error.coordinates[0].frequency, scene.body->basis().frequencies[0], 1e-9);
  double amplitude = 0;
  for (const State& state : first.states) amplitude = std::max(amplitude, std::abs(state.q[7]));
  EXPECT_NEAR(error.coordinates[0].amplitude / amplitude, 1, 0.02);
}

TEST(ModelError, of_modes_that_are_all_there_is_nothing) {
  ShakenCantilever scene(100);
  const std::vector<Sensor> sensors = {position(scene.tip, "tip")};
  BodyModels bodies(scene.graph);
  const ModelRun run =
      run_model(scene.graph, bodies, bodies.all(), sensors, explicit_method(), request(0.2, 200, 1e-9));
  const ModelError modes = model_error(scene.graph, bodies, run, bodies.all(), sensors);
  EXPECT_TRUE(modes.coordinates.empty());
  EXPECT_LT(modes.effect[0], 1e-12);
}

/// The soft rod of examples/02 on its hinge.
struct Pendulum {
  Pendulum() {
    const FiniteElementModel model = pendulum_from_calculix("hex8i");
    const auto& hinge = model.node_set("hinge");
    body = &graph.add<FlexibleBody>(
        "rod", {.basis = make_basis(model, HingeFrame{hinge}, 8, {.deflection = Deflection::quadratic})});
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    Vector3 middle = Vector3::Zero();
    for (int id : hinge) middle += model.nodes.col(model.node_index(id)) / static_cast<double>(hinge.size());
    pin = &graph.add<RevoluteJoint>("hinge", {graph.ground().marker(middle, along_y), body->average(hinge, along_y)});
    tip = body->node(model.node_set("tip").front());
  }
  SystemGraph graph;
  FlexibleBody* body;
  RevoluteJoint* pin;
  Marker tip;
};

TEST(ModelError, of_the_rigid_pendulum_needs_what_bending_does_to_the_swing) {
  Pendulum scene;
  const std::vector<Sensor> sensors = {position(scene.tip, "tip")};
  BodyModels bodies(scene.graph);
  const auto go = [&](const std::vector<Fidelity>& models,
                      const std::vector<RecordedWrench::Parameters>& wrenches = {}) {
    return run_model(scene.graph, bodies, models, sensors, explicit_method(), request(1, 100, 1e-6), wrenches);
  };
  const ModelRun rigid = go(bodies.rigid()), linear = go(bodies.all());
  ASSERT_TRUE(rigid.reached() && linear.reached());
  const ModelError error = model_error(scene.graph, bodies, rigid, bodies.all(), sensors);
  const ModelRun corrected = go(bodies.rigid(), error.feedback);
  const Table predicted = superposed(error, corrected, rigid);
  EXPECT_GT(sample_differences(sensors, rigid.samples, linear.samples)[0], 5e-3);
  EXPECT_LT(misses(sensors, predicted, linear.samples, rigid.samples), 0.15);
  // Feedback is most of it: without, the prediction is poorer, and against its sense it would be far off.
  EXPECT_LT(misses(sensors, predicted, linear.samples, rigid.samples),
            misses(sensors, error.samples, linear.samples, rigid.samples));

  // Looked at more rarely, the same is seen.
  const ModelError rare = model_error(scene.graph, bodies, rigid, bodies.all(), sensors, 5);
  ASSERT_EQ(rare.samples.row_count(), 21);
  ASSERT_EQ(rare.states.size(), 21u);
  EXPECT_LT(sample_differences(sensors, rare.samples, error.samples)[0], 1e-14);
  EXPECT_EQ(rare.feedback[0].interval, 0.05);
  EXPECT_LT(largest(rare.feedback[0].force.col(7) - error.feedback[0].force.col(35)), 1e-12);
  EXPECT_LT(largest(rare.feedback[0].torque.col(20) - error.feedback[0].torque.col(100)), 1e-12);
  EXPECT_EQ(rare.coordinates[0].amplitude, error.coordinates[0].amplitude);
}

TEST(ModelError, of_a_rod_on_a_swinging_arm_feeds_back_to_the_arm_too) {
  // The rod's frame is far from the pin: it moves as it recoils, and what bending does to the swing is a force on it
  // and on the arm. The arm is a rigid body, or one that might deform and does not.
  const FiniteElementModel model =
      brick_mesh({.size = {0.15, 0.02, 0.01}, .divisions = {6, 1, 2}, .type = "C3D8I", .material = {5e7, 0.3, 1200}});
  const FiniteElementModel arm_model =
      brick_mesh({.size = {0.3, 0.006, 0.006}, .divisions = {2, 1, 1}, .type = "C3D8I", .material = {2e11, 0.3, 1200}});
  const auto& face = model.node_set("x_min");
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  for (bool rigid_arm : {false, true}) {
    SCOPED_TRACE(rigid_arm);
    SystemGraph graph;
    std::vector<Fidelity> some = {{}, {{0, 1, 2, 3}}};
    Marker root, elbow;
    if (rigid_arm) {
      auto& arm = graph.add<RigidBody>("arm", {.mass = 0.02, .inertia = {1e-5, 1e-4, 1e-4}, .position = {0.15, 0, 0}});
      root = arm.marker({-0.15, 0, 0}, along_y), elbow = arm.marker({0.15, 0, 0});
      some.erase(some.begin());
    } else {
      auto& arm = graph.add<FlexibleBody>(
          "arm", {.basis = make_basis(arm_model, MeanAxisFrame{}, 2), .position = {0, -0.003, -0.003}});
      root = arm.average(arm_model.node_set("x_min"), along_y), elbow = arm.average(arm_model.node_set("x_max"));
    }
    auto& rod = graph.add<FlexibleBody>(
        "rod", {.basis = make_basis(model, TangentFrame{face}, 4), .position = {0.3, -0.01, -0.005}});
    graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, along_y), root});
    graph.add<FixedJoint>("clamp", {elbow, rod.average(face)});
    const std::vector<Sensor> sensors = {position(elbow, "elbow"),
                                         position(rod.average(model.node_set("x_max")), "tip")};
    BodyModels bodies(graph);
    const auto go = [&](const std::vector<Fidelity>& models,
                        const std::vector<RecordedWrench::Parameters>& wrenches = {}) {
      return run_model(graph, bodies, models, sensors, explicit_method(), request(0.6, 200, 1e-7), wrenches);
    };
    const ModelRun rigid = go(bodies.rigid()), whole = go(some);
    ASSERT_TRUE(rigid.reached() && whole.reached());
    const ModelError error = model_error(graph, bodies, rigid, some, sensors);
    const ModelRun corrected = go(bodies.rigid(), error.feedback);
    const Table predicted = superposed(error, corrected, rigid);
    for (size_t s : {0, 1}) {
      EXPECT_LT(misses(sensors, error.samples, whole.samples, rigid.samples, s), 0.15) << sensors[s].name();
      EXPECT_LT(misses(sensors, predicted, whole.samples, rigid.samples, s), 0.15) << sensors[s].name();
    }
  }
}

TEST(ModelError, of_a_bar_held_at_both_ends_is_its_bounce_under_its_weight) {
  const FiniteElementModel model = brick_mesh(
      {.size = {kLength, 0.02, 0.01}, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {2e9, 0.3, 1200}});
  const auto &start = model.node_set("x_min"), &end = model.node_set("x_max");
  SystemGraph graph;
  auto& body =
      graph.add<FlexibleBody>("bar", {.basis = make_basis(model, MeanAxisFrame{}, 8, {.loaded = {{start}, {end}}}),
                                      .damping = {.stiffness_proportional = 1e-4}});
  graph.add<FixedJoint>("left", {graph.ground().marker({0, 0.01, 0.005}), body.average(start)});
  graph.add<FixedJoint>("right", {graph.ground().marker({kLength, 0.01, 0.005}), body.average(end)});
  std::vector<int> middle;
  for (int i = 0; i < model.node_count(); ++i)
    if (std::abs(model.nodes(0, i) - kLength / 2) < 1e-9) middle.push_back(model.node_ids[static_cast<size_t>(i)]);
  const std::vector<Sensor> sensors = {position(body.average(middle), "middle")};
  BodyModels bodies(graph);
  const auto implicit = [](const Tolerance& tolerance) { return radau(tolerance.relative); };
  const auto go = [&](const std::vector<Fidelity>& models) {
    return run_model(graph, bodies, models, sensors, implicit, request(0.1, 100, 1e-6));
  };
  const ModelRun rigid = go(bodies.rigid()), whole = go(bodies.all());
  ASSERT_TRUE(rigid.reached()) << rigid.why;
  ASSERT_TRUE(whole.reached()) << whole.why;
  EXPECT_LT(sample_changes(sensors, rigid.samples)[0], 1e-9);
  const ModelError error = model_error(graph, bodies, rigid, bodies.all(), sensors);
  // Clamped beam under its own weight, w L⁴ / (384 E I): it bounces to about twice that.
  const double sag = 1200 * 0.01 * 0.02 * 9.81 * std::pow(kLength, 4) / (384 * 2e9 * 0.02 * std::pow(0.01, 3) / 12);
  EXPECT_GT(sample_changes(sensors, whole.samples)[0], 1.5 * sag);
  EXPECT_LT(sample_changes(sensors, whole.samples)[0], 2.3 * sag);
  EXPECT_LT(misses(sensors, error.samples, whole.samples, rigid.samples), 0.15);
  for (const auto& c : error.coordinates) {
    EXPECT_TRUE(std::isfinite(c.amplitude) && std::isfinite(c.effect[0]));
    EXPECT_LT(c.effect[0], 3 * sag) << c.mode;
  }
}

TEST(ModelError, of_two_runs_is_the_largest_norm_over_a_sensor_s_columns) {
  SystemGraph graph;
  const Marker ground = graph.ground().marker();
  const std::vector<Sensor> sensors = {height(ground, "h"), position(ground, "p")};
  const Table a{{"t", "h", "p_x", "p_y", "p_z"}, {0, 1, 0, 0, 0, 1, 3, 3, 4, 0}},
      b{{"t", "h", "p_x", "p_y", "p_z"}, {0, 1, 0, 0, 0, 1, 2.5, 0, 0, 0}};
  EXPECT_EQ(sample_differences(sensors, a, b), (std::vector<double>{0.5, 5}));
  EXPECT_EQ(sample_changes(sensors, a), (std::vector<double>{2, 5}));
}

}  // namespace
}  // namespace lithe::test::model_error_test
