// solve(): the answer, its model and its stated error, against what is known of the scene.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/output/csv.h"
#include "engine/study/model_run.h"
#include "integrators/generalized_alpha.h"
#include "integrators/solve.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/methods.h"

namespace lithe::test::solve_test {
namespace {

const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

/// What every certificate owes, whatever the scene: numbers that sum and agree with the samples, and a chosen trial.
void check_sheet(const Solution& solution, const std::vector<Want>& wants) {
  const Certificate& c = solution.certificate;
  ASSERT_EQ(c.quantities.size(), wants.size());
  std::vector<Sensor> sensors;
  for (const Want& w : wants) sensors.push_back(w.sensor);
  double worst = 0;
  const auto column_count = [&] {
    size_t count = 1;
    for (const Sensor& s : sensors) count += s.columns().size();
    return count;
  }();
  ASSERT_EQ(solution.samples.columns.size(), column_count);
  int column = 1;
  for (size_t w = 0; w < wants.size(); ++w) {
    const CertifiedQuantity& q = c.quantities[w];
    SCOPED_TRACE(q.name);
    double change = 0;
    for (int row = 0; row < solution.samples.row_count(); ++row) {
      double squares = 0;
      for (int i = 0; i < static_cast<int>(sensors[w].columns().size()); ++i)
        squares += std::pow(solution.samples.at(row, column + i) - solution.samples.at(0, column + i), 2);
      change = std::max(change, std::sqrt(squares));
    }
    column += static_cast<int>(sensors[w].columns().size());
    // Of rigid answers the change is the one that was predicted; it is looked for at a hundred samples or more.
    EXPECT_GE(q.change, 0.9 * change);
    if (solution.samples.row_count() > 100) {
      EXPECT_LE(q.change, 1.1 * change);
    }
    EXPECT_NEAR(q.bound, wants[w].precision.value * (wants[w].precision.relative ? q.change : 1),
                1e-12 * q.bound + 1e-8 * wants[w].precision.value);  // what changes by round-off has a floor
    for (double part : {q.error.truncation, q.error.deflection, q.error.time, q.error.solver, q.error.mesh}) {
      EXPECT_TRUE(std::isfinite(part));
      EXPECT_GE(part, 0);
    }
    EXPECT_EQ(q.error.total(), q.error.truncation + q.error.deflection + q.error.time + q.error.solver + q.error.mesh);
    worst = std::max(worst, q.error.total() / q.bound);
  }
  EXPECT_EQ(c.met(), worst <= 1);
  ASSERT_GE(c.chosen, 0);
  ASSERT_LT(c.chosen, static_cast<int>(c.trials.size()));
  const CertificateTrial& chosen = c.trials[static_cast<size_t>(c.chosen)];
  EXPECT_TRUE(chosen.run);
  EXPECT_NEAR(chosen.error, worst, 1e-9 * worst);
  EXPECT_GT(c.steps, 0);
  EXPECT_GT(c.cost, 0);
  EXPECT_LE(c.answer_cost, c.cost);
  double spent = 0;
  for (const CertificateCost& cost : c.costs) spent += cost.cost;
  EXPECT_GE(spent, c.answer_cost);
  EXPECT_LE(spent, c.cost);
  EXPECT_EQ(c.met(), c.text().find("NOT MET") == std::string::npos);
}

double apart(const Sensor& sensor, const Table& a, const Table& b) {
  EXPECT_EQ(a.row_count(), b.row_count());
  double most = 0;
  for (int row = 0; row < a.row_count(); ++row) {
    double squares = 0;
    for (int i = 1; i <= static_cast<int>(sensor.columns().size()); ++i)
      squares += std::pow(a.at(row, i) - b.at(row, i), 2);
    most = std::max(most, std::sqrt(squares));
  }
  return most;
}

/// The soft rod of examples/02 on its hinge, as CalculiX has solved it with large deflections.
struct Pendulum {
  explicit Pendulum(Deflection finest = Deflection::quadratic) {
    static const FiniteElementModel model = pendulum_from_calculix("hex8i");
    static const auto& hinge = model.node_set("hinge");
    static const auto quadratic = make_basis(model, HingeFrame{hinge}, 12, {.deflection = Deflection::quadratic});
    auto basis = std::make_shared<ModalBasis>(*quadratic);
    if (finest == Deflection::linear) basis->deflection = nullptr;
    body = &graph.add<FlexibleBody>("rod", {.basis = basis});
    Vector3 middle = Vector3::Zero();
    for (int id : hinge) middle += model.nodes.col(model.node_index(id)) / static_cast<double>(hinge.size());
    pin = &graph.add<RevoluteJoint>("hinge", {graph.ground().marker(middle, kAlongY), body->average(hinge, kAlongY)});
    tip = body->node(model.node_set("tip").front());
  }
  static Table reference() {
    const Table all = read_csv(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/trajectory.csv");  // every ms
    Table table{{"t", "tip_x", "tip_y", "tip_z"}, {}};
    for (int row = 0; row <= 1000; row += 10)
      table.add_row({all.at(row, 0), all.at(row, 1), all.at(row, 2), all.at(row, 3)});
    return table;
  }
  SystemGraph graph;
  FlexibleBody* body;
  RevoluteJoint* pin;
  Marker tip;
};

TEST(Solve, a_pendulum_misses_its_nonlinear_solution_by_less_than_is_stated_and_gets_finer_as_more_is_wanted) {
  std::size_t modes = 0;
  Deflection order = Deflection::linear;
  for (double wanted : {40.0, 10.0, 3.0, 1.0, 0.1}) {
    SCOPED_TRACE(wanted);
    Pendulum scene;
    const std::vector<Want> wants = {want(position(scene.tip, "tip"), percent(wanted))};
    const Solution solution = solve(scene.graph, 1, wants, {.scene = "pendulum"});
    check_sheet(solution, wants);
    const Certificate& c = solution.certificate;
    EXPECT_TRUE(c.met()) << c.text();
    const double truth = apart(wants[0].sensor, solution.samples, Pendulum::reference()),
                 stated = c.quantities[0].error.total();
    EXPECT_LE(truth, stated) << c.text();
    EXPECT_LT(stated, 100 * truth);
    ASSERT_EQ(c.bodies.size(), 1u);
    const Fidelity& fidelity = c.bodies[0].fidelity;
    EXPECT_EQ(fidelity, scene.body->fidelity());
    EXPECT_EQ(c.bodies[0].modes.size(), 12u);
    EXPECT_GE(fidelity.deflection, order);
    modes = fidelity.modes.size(), order = fidelity.deflection;
    if (wanted == 40) {
      EXPECT_EQ(modes, 0u);  // rigid, it misses by 7 mm of 200 mm
    }
  }
  EXPECT_GE(modes, 3u);
  EXPECT_GE(order, Deflection::stiffened);  // without it 0.8 mm of the 0.2 mm asked for
}

TEST(Solve, the_sheet_says_what_no_number_of_linear_modes_does_for_the_pendulum) {
  for (double wanted : {3.0, 0.1}) {
    SCOPED_TRACE(wanted);
    Pendulum scene;
    const Solution solution = solve(scene.graph, 1, {want(position(scene.tip, "tip"), percent(wanted))});
    const ChosenBody& rod = solution.certificate.bodies.at(0);
    ASSERT_EQ(rod.deflection_effect.size(), 1u);
    EXPECT_GT(rod.deflection_effect[0], 4e-4) << solution.certificate.text();  // 0.95 mm are known
    EXPECT_LT(rod.deflection_effect[0], 2e-3);
  }
}

TEST(Solve, answers_the_same_twice_and_leaves_the_graph_with_its_model) {
  Pendulum scene;
  const std::vector<Want> wants = {want(position(scene.tip, "tip"), percent(1))};
  const Solution first = solve(scene.graph, 1, wants), second = solve(scene.graph, 1, wants);
  EXPECT_EQ(first.samples.values, second.samples.values);
  EXPECT_EQ(first.certificate.quantities[0].error.total(), second.certificate.quantities[0].error.total());
  // What was left goes on: the graph's own run is the answer, but for the error of the integrator.
  BodyModels bodies(scene.graph);
  const ModelRun run = run_model(scene.graph, bodies, bodies.current(), {wants[0].sensor},
                                 [](const Tolerance&) { return runge_kutta8(1e-9); },
                                 {.duration = 1, .samples = 100, .dynamics = false});
  EXPECT_LE(apart(wants[0].sensor, run.samples, first.samples), first.certificate.quantities[0].error.total());
}

TEST(Solve, without_data_of_the_second_order_it_does_not_claim_what_no_number_of_linear_modes_gives) {
  Pendulum scene(Deflection::linear);
  const std::vector<Want> wants = {want(position(scene.tip, "tip"), percent(0.1))};
  const Solution solution = solve(scene.graph, 1, wants);
  const Certificate& c = solution.certificate;
  const double truth = apart(wants[0].sensor, solution.samples, Pendulum::reference());
  EXPECT_GT(truth, 5e-4);  // 0.8 mm are known
  EXPECT_FALSE(c.met()) << c.text();
  std::string remarks;
  for (const std::string& remark : c.remarks) remarks += remark;
  EXPECT_NE(remarks.find("Deflection::quadratic"), std::string::npos) << c.text();
  // Who knows that deflections stay small may say so.
  const Solution trusting = solve(scene.graph, 1, wants, {.small_deflection = true});
  check_sheet(trusting, wants);
  EXPECT_EQ(trusting.certificate.quantities[0].error.deflection, 0);
}

TEST(Solve, of_two_links_makes_the_soft_one_flexible_and_may_leave_the_stiff_one_rigid) {
  SystemGraph graph;
  const auto add = [&](const std::string& name, double x, double young) -> FlexibleBody& {
    const FiniteElementModel model = brick_mesh(
        {.size = {0.3, 0.02, 0.01}, .divisions = {6, 1, 2}, .type = "C3D8I", .material = {young, 0.3, 1150}});
    const auto& tip = model.node_set("x_max");
    return graph.add<FlexibleBody>(name, {.basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 6,
                                                              {.loaded = {{tip}}, .deflection = Deflection::quadratic}),
                                          .damping = {.stiffness_proportional = 5e-4},
                                          .position = {x, -0.01, -0.005}});
  };
  FlexibleBody &upper = add("upper", 0, 2e11), &lower = add("lower", 0.3, 2e7);
  const auto root = [](FlexibleBody& b) { return b.average(b.basis().node_set("x_min"), kAlongY); };
  const auto end = [](FlexibleBody& b) { return b.average(b.basis().node_set("x_max"), kAlongY); };
  graph.add<RevoluteJoint>("shoulder", {graph.ground().marker({}, kAlongY), root(upper)});
  graph.add<RevoluteJoint>("elbow", {end(upper), root(lower)});
  const std::vector<Want> wants = {want(position(end(lower), "tip"), percent(0.5))};
  const Solution solution = solve(graph, 0.6, wants, {.samples = 60});
  check_sheet(solution, wants);
  const Certificate& c = solution.certificate;
  EXPECT_TRUE(c.met()) << c.text();
  EXPECT_TRUE(upper.fidelity().modes.empty()) << c.text();
  EXPECT_FALSE(lower.fidelity().modes.empty()) << c.text();
  BodyModels bodies(graph);
  const ModelRun whole =
      run_model(graph, bodies, bodies.all(Deflection::quadratic), {wants[0].sensor},
                [](const Tolerance&) { return radau(1e-6); }, {.duration = 0.6, .samples = 60, .dynamics = false});
  ASSERT_TRUE(whole.reached()) << whole.why;
  const double truth = apart(wants[0].sensor, solution.samples, whole.samples);
  EXPECT_LE(truth, c.quantities[0].error.total());
}

TEST(Solve, a_cantilever_on_a_hub_gives_the_forces_of_the_spin_that_statics_knows) {
  // Brought to 30 rad/s in 0.2 s and turning on: the root pulls the beam in by m ω² r, with a stiff beam at once.
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  const FiniteElementModel model =
      brick_mesh({.size = {0.4, 0.02, 0.01}, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {7e10, 0.3, 2700}});
  auto& beam = graph.add<FlexibleBody>("beam", {.basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 8,
                                                                    {.deflection = Deflection::quadratic}),
                                                .damping = {.stiffness_proportional = 2e-4},
                                                .position = {0.1, -0.01, -0.005}});
  auto& hub = graph.add<RigidBody>("hub", {.mass = 1, .inertia = {0.01, 0.01, 0.01}});
  const Marker ground = graph.ground().marker();
  auto& bearing = graph.add<RevoluteJoint>("bearing", {ground, hub.marker()});
  const MotionLaw run_up = [](double t) -> Motion {
    constexpr double w = 30, T = 0.2;
    if (t >= T) return {w * (t - T / 2), w, 0};
    const double s = t / T;
    return {w * T * (s * s * s - 0.5 * s * s * s * s), w * (3 * s * s - 2 * s * s * s), w / T * (6 * s - 6 * s * s)};
  };
  graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = run_up});
  auto& root = graph.add<FixedJoint>("root", {hub.marker({0.1, 0, 0}), beam.average(model.node_set("x_min"))});
  const std::vector<Want> wants = {want(reaction(root, 1, hub.marker(), "root"), percent(5)),
                                   want(position(beam.average(model.node_set("x_max")), "tip"), percent(1))};
  const Solution solution = solve(graph, 0.4, wants);
  check_sheet(solution, wants);
  EXPECT_TRUE(solution.certificate.met()) << solution.certificate.text();
  const double mass = 2700 * 0.4 * 0.02 * 0.01, pull = mass * 30 * 30 * 0.3;
  const int last = solution.samples.row_count() - 1;
  EXPECT_NEAR(solution.samples.at(last, 1), -pull, 0.02 * pull);
  EXPECT_LT(std::abs(solution.samples.at(last, 3)), 1e-6 * pull);
  const double angle = run_up(0.4).value;
  EXPECT_NEAR(solution.samples.at(last, 7), 0.5 * std::cos(angle), solution.certificate.quantities[1].error.total());
  EXPECT_NEAR(solution.samples.at(last, 8), 0.5 * std::sin(angle), solution.certificate.quantities[1].error.total());
}

/// A soft cantilever whose foot is driven or whose end is pushed.
struct Cantilever {
  enum class Load { shaken_foot, push, blow };
  Cantilever(Load load, double frequency) {
    static const FiniteElementModel model =
        brick_mesh({.size = {0.5, 0.02, 0.01}, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {2e9, 0.3, 1200}});
    static const auto basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 6,
                                         {.loaded = {{model.node_set("x_max")}}, .deflection = Deflection::quadratic});
    auto& beam = graph.add<FlexibleBody>("beam", {.basis = basis, .damping = {.stiffness_proportional = 5e-4}});
    const Marker foot = beam.average(model.node_set("x_min")), ground = graph.ground().marker({0, 0.01, 0.005});
    tip = beam.average(model.node_set("x_max"));
    if (load == Load::shaken_foot) {
      auto& guide = graph.add<PrismaticJoint>("guide", {ground, foot});
      graph.add<CoordinateDrive>("drive", {guide.displacement()},
                                 {.motion = harmonic(2e-3, 2 * M_PI * frequency, M_PI / 2, -2e-3)});
      return;
    }
    graph.add<FixedJoint>("root", {ground, foot});
    graph.add<UserForce>("load", {tip}, {[=](double t, const MarkerView&) {
                           const double s = (t - 0.1) / 0.02;
                           const double blow = s > 0 && s < 1 ? 3 * std::pow(std::sin(M_PI * s), 2) : 0;
                           return force({0, 0, load == Load::blow ? blow : 0.05 * std::sin(2 * M_PI * frequency * t)});
                         }});
  }
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  Marker tip;
};

TEST(Solve, loads_that_come_and_go_between_the_samples_are_seen) {
  struct Case {
    Cantilever::Load load;
    double duration;
    int samples;
  };
  for (const Case& c : {Case{Cantilever::Load::shaken_foot, 0.5, 20}, Case{Cantilever::Load::push, 0.5, 20},
                        Case{Cantilever::Load::blow, 2, 5}}) {
    SCOPED_TRACE("load " + std::to_string(static_cast<int>(c.load)));
    Cantilever scene(c.load, c.samples / c.duration);  // periods as long as the samples are apart
    const std::vector<Want> wants = {want(position(scene.tip, "tip"), percent(10))};
    const Solution solution = solve(scene.graph, c.duration, wants, {.samples = c.samples});
    check_sheet(solution, wants);
    BodyModels bodies(scene.graph);
    const ModelRun whole = run_model(scene.graph, bodies, bodies.all(Deflection::quadratic), {wants[0].sensor},
                                     [](const Tolerance&) { return radau(1e-8); },
                                     {.duration = c.duration, .samples = c.samples, .dynamics = false});
    ASSERT_TRUE(whole.reached()) << whole.why;
    EXPECT_LE(apart(wants[0].sensor, solution.samples, whole.samples),
              solution.certificate.quantities[0].error.total());
  }
}

TEST(Solve, shapes_beyond_the_candidates_are_stated_by_what_the_highest_candidates_do) {
  // A slow push: the shapes of the loads at both ends are among the candidates, and forty more eigenmodes tell what
  // all of them leave out.
  const FiniteElementModel model =
      brick_mesh({.size = {0.5, 0.02, 0.01}, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {2e9, 0.3, 1200}});
  const auto draw = [&](SystemGraph& graph, int eigenmodes) {
    auto& beam = graph.add<FlexibleBody>(
        "beam", {.basis = make_basis(model, TangentFrame{model.node_set("x_min")}, eigenmodes,
                                     {.loaded = {{model.node_set("x_max")}}, .deflection = Deflection::quadratic}),
                 .damping = {.stiffness_proportional = 5e-4}});
    graph.add<FixedJoint>("root", {graph.ground().marker({0, 0.01, 0.005}), beam.average(model.node_set("x_min"))});
    const Marker tip = beam.average(model.node_set("x_max"));
    graph.add<UserForce>("load", {tip}, {[](double t, const MarkerView&) {
                           return force({0, 0, 0.02 * std::pow(std::sin(M_PI * t), 2)});
                         }});
    return position(tip, "tip");
  };
  SystemGraph few{{.gravity = {0, 0, 0}}}, many{{.gravity = {0, 0, 0}}};
  const std::vector<Want> wants = {want(draw(few, 6), percent(0.1))};
  const Solution solution = solve(few, 1, wants);
  check_sheet(solution, wants);
  const Certificate& c = solution.certificate;
  EXPECT_TRUE(c.met()) << c.text();
  const Sensor tip = draw(many, 46);
  BodyModels bodies(many);
  const ModelRun truth =
      run_model(many, bodies, bodies.all(Deflection::quadratic), {tip}, [](const Tolerance&) { return radau(1e-11); },
                {.duration = 1, .samples = 100, .dynamics = false});
  ASSERT_TRUE(truth.reached()) << truth.why;
  const CertifiedQuantity& q = c.quantities[0];
  EXPECT_LE(apart(tip, solution.samples, truth.samples), q.error.total()) << c.text();
  EXPECT_LT(q.error.truncation, 2e-4 * q.change) << c.text();
}

/// A rigid bar that swings from level.
struct RigidPendulum {
  RigidPendulum() {
    auto& bar = graph.add<RigidBody>("bar", {.mass = 1, .inertia = {1e-3, 0.02, 0.02}, .position = {0.25, 0, 0}});
    pin = &graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAlongY), bar.marker({-0.25, 0, 0}, kAlongY)});
    tip = bar.marker({0.25, 0, 0});
    root = bar.marker({-0.25, 0, 0});
  }
  SystemGraph graph;
  RevoluteJoint* pin;
  Marker tip, root;
};

TEST(Solve, a_scene_without_deformable_bodies_gets_its_tolerance_alone) {
  double last = std::numeric_limits<double>::infinity();
  for (double wanted : {10.0, 0.1, 1e-3}) {
    RigidPendulum scene;
    const std::vector<Want> wants = {want(position(scene.tip, "tip"), percent(wanted)),
                                     want(velocity(scene.tip, "speed"), within(1))};
    const Solution solution = solve(scene.graph, 2, wants, {.samples = 50});
    check_sheet(solution, wants);
    const Certificate& c = solution.certificate;
    EXPECT_TRUE(c.met()) << c.text();
    EXPECT_TRUE(c.bodies.empty());
    EXPECT_EQ(c.quantities[0].error.truncation + c.quantities[0].error.deflection, 0);
    EXPECT_LT(c.quantities[0].error.total(), last);
    last = c.quantities[0].error.total();
    BodyModels none(scene.graph);
    const ModelRun exact =
        run_model(scene.graph, none, {}, {wants[0].sensor}, [](const Tolerance&) { return runge_kutta8(1e-12); },
                  {.duration = 2, .samples = 50, .dynamics = false});
    EXPECT_LE(apart(wants[0].sensor, solution.samples, exact.samples), c.quantities[0].error.total());
  }
}

TEST(Solve, what_stays_where_it_is_does_not_keep_the_rest_from_its_certificate) {
  RigidPendulum scene;
  const std::vector<Want> wants = {want(position(scene.tip, "tip"), percent(1)),
                                   want(position(scene.root, "root"), percent(1))};
  const Solution solution = solve(scene.graph, 0.5, wants);
  EXPECT_TRUE(solution.certificate.met()) << solution.certificate.text();

  // A coordinate out of the plane of motion changes by round-off.
  Pendulum rod;
  const Sensor aside{
      "aside", {"aside"}, [&](Snapshot& now, std::span<double> out) { out[0] = now.marker(rod.tip).p.y(); }};
  const Solution flexible =
      solve(rod.graph, 0.5, {want(position(rod.tip, "tip"), percent(10)), want(aside, percent(10))});
  EXPECT_TRUE(flexible.certificate.met()) << flexible.certificate.text();
}

TEST(Solve, coordinates_that_come_and_go_with_the_model_are_refused_or_read_as_they_are) {
  Pendulum scene;
  for (const char* name : {"other", "third"})
    scene.graph.add<RigidBody>(name, {.mass = 1, .inertia = {1, 1, 1}, .position = {5, 0, 0}});
  const Sensor eta = modal_coordinates(*scene.body, "eta");
  try {
    const Solution solution = solve(scene.graph, 0.3, {want(eta, percent(5))});
    BodyModels bodies(scene.graph);
    const ModelRun whole =
        run_model(scene.graph, bodies, bodies.all(Deflection::quadratic), {eta},
                  [](const Tolerance&) { return radau(1e-6); }, {.duration = 0.3, .samples = 100, .dynamics = false});
    EXPECT_TRUE(solution.certificate.met()) << solution.certificate.text();
    EXPECT_LE(apart(eta, solution.samples, whole.samples), solution.certificate.quantities[0].error.total())
        << solution.certificate.text();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("'eta'"), std::string::npos) << error.what();
  }
}

TEST(Solve, the_sheet_counts_every_run) {
  Pendulum scene;
  int by_tolerance = 0, by_step = 0;
  const SolveMethods counted{
      .by_tolerance =
          [&](const Tolerance& t) {
            ++by_tolerance;
            return automatic(t.relative);
          },
      .by_step =
          [&](double step) {
            ++by_step;
            return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = step});
          },
      .by_step_with_impacts = {}};
  const Certificate c = solve(scene.graph, 1, {want(position(scene.tip, "tip"), percent(1))}, counted).certificate;
  std::map<std::string, CertificateCost> costs;
  for (const CertificateCost& cost : c.costs) costs[cost.what] = cost;
  const int flexible = costs["modes, fixed steps"].runs + costs["modes, by tolerance"].runs;
  EXPECT_EQ(costs["rigid bodies"].runs + flexible, by_step + by_tolerance) << c.text();
  EXPECT_GT(flexible, 0);
  EXPECT_GT(costs["estimates along a run"].runs, 0);
  // Nothing there depends on time: the rigid run is judged by one in steps twice as long, 50 for 100 samples.
  EXPECT_EQ(costs["rigid bodies"].steps % 50, 0);
  EXPECT_LE(costs["rigid bodies"].steps, 200) << c.text();
}

/// Fails at once, below a tolerance.
class Stuck final : public Integrator {
 public:
  std::string name() const override { return "stuck"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  void prepare(EquationsOfMotion&, State&) override {}
  StepResult advance(EquationsOfMotion&, State&, double) override { return {StepResult::Outcome::failed, "stuck"}; }
  IntegratorStatistics statistics_;
};
SolveMethods stuck_below(double tolerance) {
  return {.by_tolerance = [tolerance](const Tolerance& t) -> std::unique_ptr<Integrator> {
            if (t.relative < tolerance) return std::make_unique<Stuck>();
            return automatic(t.relative);
          },
          .by_step = {},
          .by_step_with_impacts = {}};
}

TEST(Solve, integrators_that_fail_at_tight_tolerances_are_told_not_certified) {
  for (double limit : {2e-4, 2e-5, 2e-7}) {
    SCOPED_TRACE(limit);
    const auto run = [&](SystemGraph& graph, Marker tip, double duration) {
      try {
        const Solution s = solve(graph, duration, {want(position(tip, "tip"), within(1e-6))}, stuck_below(limit));
        EXPECT_EQ(s.samples.row_count(), 101);
        EXPECT_GE(s.certificate.tolerance, limit) << s.certificate.text();
      } catch (const SimulationError& error) {
        EXPECT_NE(std::string(error.what()).find("stuck"), std::string::npos) << error.what();
      }
    };
    RigidPendulum rigid;
    run(rigid.graph, rigid.tip, 2);
    Pendulum flexible;
    run(flexible.graph, flexible.tip, 0.5);
  }
}

TEST(Solve, a_method_that_fails_at_the_loosest_tolerance_is_tried_with_a_tighter_one) {
  RigidPendulum scene;
  int failed = 0;
  const SolveMethods methods{
      .by_tolerance = [&](const Tolerance& t) -> std::unique_ptr<Integrator> {
        if (t.relative < 0.05) return automatic(t.relative);
        ++failed;
        return std::make_unique<Stuck>();
      },
      .by_step =
          [](double step) { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = step}); },
      .by_step_with_impacts = {}};
  const std::vector<Want> wants = {want(position(scene.tip, "tip"), percent(1e-3))};
  const Solution solution = solve(scene.graph, 2, wants, methods);
  check_sheet(solution, wants);
  EXPECT_EQ(failed, 1);
  EXPECT_TRUE(solution.certificate.met()) << solution.certificate.text();
}

TEST(Solve, refuses_what_is_no_question) {
  RigidPendulum scene;
  const std::vector<Want> wants = {want(position(scene.tip, "tip"), percent(1))};
  expect_error<SceneError>([&] { solve(scene.graph, 1, {}); }, {"nothing is wanted", "want("});
  for (double duration : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")})
    expect_error<SceneError>([&] { solve(scene.graph, duration, wants); }, {"duration"});
  for (double value : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    expect_error<SceneError>([&] { percent(value); }, {"precision", "solve_test.cpp"});
    expect_error<SceneError>([&] { within(value); }, {"precision", "solve_test.cpp"});
  }
  expect_error<SceneError>([&] { solve(scene.graph, 1, wants, {.samples = 2}); }, {"samples"});
  expect_error<SceneError>([&] { solve(scene.graph, 1, wants, {.most_runs = 0}); }, {"run"});
}

}  // namespace
}  // namespace lithe::test::solve_test
