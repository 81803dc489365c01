#include "engine/run/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/archive/archive.h"
#include "engine/assembly/batch_of.h"
#include "engine/model/islands.h"
#include "engine/observe/recorder.h"
#include "engine/simplify/simplification.h"
#include "integrators/automatic.h"
#include "integrators/explicit_runge_kutta.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/bar_model.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::simulation_islands_test {

using lithe::test::message_of;
using testing::ElementsAre;
using testing::HasSubstr;

namespace {

const Matrix3 kAxisY = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y

/// A spring that counts how often it is asked.
class CountingSpring final : public Force</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    double stiffness = 0, length = 0;
    long* asked = nullptr;
  };
  explicit CountingSpring(Parameters parameters) : parameters_(parameters) {}
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    ++*parameters_.asked;
    const Vector3 d = markers[1].p - markers[0].p, n = d.normalized();
    const double k = parameters_.stiffness, stretch = d.norm() - parameters_.length;
    rows.add({force(-n), force(n)}, k * stretch, k, 0, 0.5 * k * stretch * stretch);
  }

 private:
  const Parameters parameters_;
};

RigidBody& add_rod(SystemGraph& graph, const std::string& name, const Vector3& pivot) {
  auto& rod = graph.add<RigidBody>(
      name, {.mass = 2, .inertia = {1e-3, 2.0 / 12, 2.0 / 12}, .position = pivot + Vector3(0.5, 0, 0)});
  graph.add<RevoluteJoint>(name + " pin", {graph.ground().marker(pivot, kAxisY), rod.marker({-0.5, 0, 0}, kAxisY)});
  return rod;
}

/// A mass of 1 kg on a vertical slider and a spring of stiffness k, drawn with the spring relaxed.
RigidBody& add_bouncer(SystemGraph& graph, const std::string& name, const Vector3& place, double k,
                       double damping = 0) {
  auto& mass = graph.add<RigidBody>(name, {.mass = 1, .inertia = {1, 1, 1}, .position = place});
  graph.add<PrismaticJoint>(name + " slide", {graph.ground().marker(place), mass.marker()});
  graph.add<SpringDamper>(name + " spring", {graph.ground().marker(place - Vector3(0, 0, 1)), mass.marker()},
                          {.stiffness = k, .damping = damping});
  return mass;
}

auto automatic(double tolerance) {
  return [=] {
    return std::make_unique<Automatic>(
        Automatic::Parameters{.tolerance = {.relative = tolerance, .absolute = 1e-2 * tolerance}});
  };
}
auto runge_kutta(double tolerance) {
  return [=] {
    return std::make_unique<ExplicitRungeKutta>(
        ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8,
                                       .tolerance = {.relative = tolerance, .absolute = 1e-2 * tolerance}});
  };
}

double largest_difference(const Table& a, const Table& b) {
  EXPECT_EQ(a.values.size(), b.values.size());
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.values.size(), b.values.size()); ++i)
    largest = std::max(largest, std::abs(a.values[i] - b.values[i]));
  return largest;
}

/// Five islands of many kinds, their elements drawn in turn so that no island lies in one piece.
struct Archipelago {
  Archipelago() {
    auto& first = add_rod(graph, "upper", {0, 0, 0});
    auto& rotor = graph.add<RigidBody>(
        "rotor", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {0, 5, 0}, .angular_velocity = {0, 20, 0}});
    auto& second = graph.add<RigidBody>("lower", {.mass = 1, .inertia = {1e-3, 0.08, 0.08}, .position = {1.5, 0, 0}});
    auto& block = graph.add<RigidBody>("block", {.mass = 1, .inertia = {1, 1, 1}, .position = {0, 10, 0}});
    graph.add<RevoluteJoint>("knee", {first.marker({0.5, 0, 0}, kAxisY), second.marker({-0.5, 0, 0}, kAxisY)});
    auto& slide = graph.add<PrismaticJoint>("slide", {graph.ground().marker({0, 10, 0}), block.marker()});
    auto& shaft =
        graph.add<RevoluteJoint>("shaft", {graph.ground().marker({0, 5, 0}, kAxisY), rotor.marker({0, 0, 0}, kAxisY)});
    graph.add<CoordinateStop>("floor", {slide.displacement()},
                              {.lower = -0.3, .stiffness = 1e4, .exponent = 1.5, .dissipation = 0.5});
    graph.add<CoordinateSpring>("clock spring", {shaft.angle()}, {.stiffness = 0.15});
    auto& rubbing = add_rod(graph, "rubbing", {0, 20, 0});
    auto& pin = static_cast<RevoluteJoint&>(*graph.constraints().back().constraint);
    graph.add<JointFriction>("rub", {pin.angle()}, {.joint = &pin, .coefficient = 0.1, .radius = 0.05});
    auto& stone = graph.add<RigidBody>("stone", {.velocity = {1, 2, 3}, .angular_velocity = {1, 2, 3}});
    for (RigidBody* body : {&first, &rotor, &second, &block, &rubbing, &stone}) {
      sensors.push_back(position(body->marker({0.1, 0.2, 0.3}), body->name()));
      energies.push_back(total_energy(*body, body->name() + " energy"));
    }
    sensors.push_back(coordinate(shaft.angle(), "turns"));
    sensors.push_back(total_energy("energy"));
    sensors.push_back(reaction(pin, 1, kWorldAxes, "bearing"));
    sensors.push_back(
        potential_energy(static_cast<const ForceElement&>(*graph.forces()[0].force), "energy of the floor"));
    sensors.push_back(
        potential_energy(static_cast<const ForceElement&>(*graph.forces()[1].force), "energy of the clock spring"));
  }
  SystemGraph graph;
  std::vector<Sensor> sensors, energies;
};

std::vector<std::string> names_of(const SystemGraph& graph) {
  std::vector<std::string> names;
  for (const auto& b : graph.bodies()) names.push_back(b.body->name());
  for (const auto& c : graph.constraints()) names.push_back(c.constraint->name());
  for (const auto& f : graph.forces()) names.push_back(f.force->name());
  return names;
}

TEST(islands, joints_and_forces_tie_and_ground_does_not) {
  Archipelago scene;
  const auto parts = split(scene.graph);
  ASSERT_EQ(parts.size(), 5u);
  EXPECT_THAT(names_of(*parts[0]), ElementsAre("ground", "upper", "lower", "upper pin", "knee"));
  EXPECT_THAT(names_of(*parts[1]), ElementsAre("ground", "rotor", "shaft", "clock spring"));
  EXPECT_THAT(names_of(*parts[2]), ElementsAre("ground", "block", "slide", "floor"));
  EXPECT_THAT(names_of(*parts[3]), ElementsAre("ground", "rubbing", "rubbing pin", "rub"));
  EXPECT_THAT(names_of(*parts[4]), ElementsAre("ground", "stone"));
  // A spring between two of them makes them one.
  scene.graph.add<SpringDamper>("band", {static_cast<RigidBody&>(*scene.graph.bodies()[1].body).marker(),
                                         static_cast<RigidBody&>(*scene.graph.bodies()[6].body).marker()});
  EXPECT_EQ(split(scene.graph).size(), 4u);
}

TEST(islands, friction_belongs_to_the_joint_that_presses_wherever_it_rubs) {
  SystemGraph graph;
  add_rod(graph, "pressed", {0, 0, 0});
  auto& pin = static_cast<RevoluteJoint&>(*graph.constraints().back().constraint);
  add_rod(graph, "rubbed", {0, 5, 0});
  auto& other = static_cast<RevoluteJoint&>(*graph.constraints().back().constraint);
  EXPECT_EQ(split(graph).size(), 2u);
  graph.add<JointFriction>("rub", {other.angle()}, {.joint = &pin, .coefficient = 0.1, .radius = 0.05});
  EXPECT_EQ(split(graph).size(), 1u);
}

TEST(simulation_islands, islands_with_steps_of_their_own_move_as_the_whole_does) {
  Archipelago together, apart;
  Recorder as_one(together.sensors), as_many(apart.sensors), shares(apart.energies);
  const System system = assemble(together.graph);
  const auto integrator = runge_kutta(1e-12)();
  Simulation simulation{system, *integrator};
  State state = system.initial_state();
  simulation.observe(as_one, every(0.05));
  simulation.run(state, 2);

  Simulation islands{apart.graph, runge_kutta(1e-12)};
  State islands_state = islands.system().initial_state();
  islands.observe(as_many, every(0.05));
  islands.observe(shares, every(0.05));
  islands.run(islands_state, 2);
  EXPECT_EQ(islands_state.time, 2);
  const double difference = largest_difference(as_one.table(), as_many.table());
  EXPECT_LT(difference, 1e-8);
  EXPECT_LT((state.q - islands_state.q).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((state.v - islands_state.v).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT((state.lambda - islands_state.lambda).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((state.quarter_turns - islands_state.quarter_turns).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_GT(as_many.table().column("turns").back(), 2 * M_PI);  // turns are counted in islands too
  // The energy of the whole is the sum of the shares, observer by observer.
  const auto total = as_many.table().column("energy");
  for (int i = 0; i < shares.table().row_count(); ++i) {
    double sum =
        as_many.table().column("energy of the floor")[i] + as_many.table().column("energy of the clock spring")[i];
    for (std::size_t c = 1; c < shares.table().columns.size(); ++c) sum += shares.table().at(i, static_cast<int>(c));
    EXPECT_NEAR(total[i], sum, 1e-10);
  }
  std::printf("apart and together: %.1e; together %ld steps\n%s", difference, simulation.statistics().steps,
              islands.report().c_str());
  // Given another spin, the rotor keeps count of its turns.
  for (State* s : {&state, &islands_state}) s->v[10] += 5;
  simulation.run(state, 2.5);
  islands.run(islands_state, 2.5);
  EXPECT_LT((state.q - islands_state.q).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((state.quarter_turns - islands_state.quarter_turns).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(simulation_islands, an_island_takes_the_steps_that_it_would_take_alone) {
  const auto alone = [](const std::function<RigidBody&(SystemGraph&)>& draw) {
    SystemGraph graph;
    RigidBody& body = draw(graph);
    Recorder path{{position(body.marker(), "path")}};
    const System system = assemble(graph);
    const auto integrator = automatic(1e-6)();
    Simulation simulation{system, *integrator};
    simulation.observe(path, every(0.1));
    State state = system.initial_state();
    simulation.run(state, 1);
    return std::pair(simulation.statistics(), path.table());
  };
  const auto slow = [](SystemGraph& graph) -> RigidBody& { return add_rod(graph, "slow", {0, 0, 0}); };
  const auto stiff = [](SystemGraph& graph) -> RigidBody& { return add_bouncer(graph, "stiff", {0, 5, 0}, 1e6); };
  const auto [slow_steps, slow_path] = alone(slow);
  const auto [stiff_steps, stiff_path] = alone(stiff);

  SystemGraph graph;
  RigidBody &rod = slow(graph), &mass = stiff(graph);
  Recorder rod_path{{position(rod.marker(), "path")}}, mass_path{{position(mass.marker(), "path")}};
  Simulation simulation{graph, automatic(1e-6)};
  simulation.observe(rod_path, every(0.1));
  simulation.observe(mass_path, every(0.1));
  State state = simulation.system().initial_state();
  simulation.run(state, 1);
  const auto islands = simulation.islands();
  ASSERT_EQ(islands.size(), 2u);
  EXPECT_THAT(islands[0].bodies, ElementsAre("slow"));
  EXPECT_EQ(islands[0].statistics.steps, slow_steps.steps);
  EXPECT_EQ(islands[1].statistics.steps, stiff_steps.steps);
  EXPECT_EQ(islands[1].statistics.evaluations, stiff_steps.evaluations);
  EXPECT_EQ(largest_difference(rod_path.table(), slow_path), 0);
  EXPECT_EQ(largest_difference(mass_path.table(), stiff_path), 0);
  EXPECT_GT(stiff_steps.steps, 10 * slow_steps.steps);
}

TEST(simulation_islands, a_stiff_island_does_not_make_its_neighbours_pay) {
  constexpr int kSlow = 19;  // beside one stiff body
  const auto draw = [](SystemGraph& graph) {
    for (int i = 0; i < kSlow; ++i) add_rod(graph, "rod " + std::to_string(i), {0, 0, 0});
    add_bouncer(graph, "stiff", {0, -5, 0}, 1e6);
  };
  SystemGraph together, apart;
  draw(together), draw(apart);
  const auto evaluations_of_bodies = [](const Simulation& simulation) {
    long sum = 0;
    for (const auto& island : simulation.islands())
      sum += island.statistics.evaluations * static_cast<long>(island.bodies.size());
    return sum;
  };
  Simulation one{together, runge_kutta(1e-6), {.split = false}}, many{apart, runge_kutta(1e-6)};
  State a = one.system().initial_state(), b = many.system().initial_state();
  one.run(a, 1);
  many.run(b, 1);
  const long whole = evaluations_of_bodies(one), parts = evaluations_of_bodies(many);
  const long stiff = many.islands().back().statistics.evaluations, slow = many.islands().front().statistics.evaluations;
  std::printf("evaluations of bodies: %ld together, %ld apart: %.1f times fewer\n", whole, parts,
              static_cast<double>(whole) / static_cast<double>(parts));
  EXPECT_EQ(parts, kSlow * slow + stiff);
  // Together all take the steps of the stiff one (a norm over more bodies lets it take somewhat longer ones).
  EXPECT_GT(whole, 0.7 * (kSlow + 1) * stiff);
  EXPECT_GT(whole, 8 * parts);
  EXPECT_LT((a.q - b.q).cwiseAbs().maxCoeff(), 1e-5);
}

/// A swinging rod beside a mass that hangs still from a counting spring.
struct Sleepers {
  explicit Sleepers(double length = 1) {
    add_rod(graph, "rod", {0, 0, 0});
    mass = &graph.add<RigidBody>("mass", {.mass = 2, .inertia = {1, 1, 1}, .position = {3, 0, -1}});
    graph.add<PrismaticJoint>("slide", {graph.ground().marker({3, 0, -1}), mass->marker()});
    graph.add<CountingSpring>("spring", {graph.ground().marker({3, 0, 0}), mass->marker()},
                              {.stiffness = 1e4, .length = length - 2 * 9.81 / 1e4, .asked = &asked});
  }
  long asked = 0;
  SystemGraph graph;
  RigidBody* mass;
};

TEST(simulation_islands, an_island_at_rest_costs_nothing_and_keeps_every_bit) {
  Sleepers scene;
  Simulation simulation{scene.graph, automatic(1e-8)};
  State state = simulation.system().initial_state();
  simulation.run(state, 0);
  const State start = state;
  const long asked = scene.asked;
  simulation.run(state, 2);
  simulation.run(state, 5);
  EXPECT_EQ(scene.asked, asked);
  const auto islands = simulation.islands();
  EXPECT_FALSE(islands[0].asleep);
  EXPECT_GT(islands[0].statistics.steps, 100);
  EXPECT_TRUE(islands[1].asleep);
  EXPECT_EQ(islands[1].statistics.steps, 0);
  EXPECT_EQ(islands[1].statistics.evaluations, 0);
  EXPECT_EQ(state.q.tail(7), start.q.tail(7));
  EXPECT_EQ(state.v.tail(6), VectorX::Zero(6));
  EXPECT_EQ(state.v_dot.tail(6), VectorX::Zero(6));
  EXPECT_NE(state.q.head(7), start.q.head(7));
  EXPECT_THAT(simulation.report(), HasSubstr("'mass': 1 degrees of freedom, automatic, asleep"));

  // A sleep of a thousand seconds is looked into some times, not at every observed time.
  simulation.run(state, 5);
  const long before = scene.asked;
  SystemGraph quiet;
  long questions = 0;
  auto& mass = quiet.add<RigidBody>("mass", {.mass = 2, .inertia = {1, 1, 1}, .position = {0, 0, -1}});
  quiet.add<PrismaticJoint>("slide", {quiet.ground().marker({0, 0, -1}), mass.marker()});
  quiet.add<CountingSpring>("spring", {quiet.ground().marker(), mass.marker()},
                            {.stiffness = 1e4, .length = 1 - 2 * 9.81 / 1e4, .asked = &questions});
  Simulation night{quiet, automatic(1e-8)};
  State still = night.system().initial_state();
  night.run(still, 0);
  questions = 0;
  for (int i = 1; i <= 1000; ++i) night.run(still, i);
  EXPECT_TRUE(night.islands()[0].asleep);
  EXPECT_LT(questions, 200);
  EXPECT_EQ(scene.asked, before);
  EXPECT_EQ(still.q, night.system().initial_state().q);
}

TEST(simulation_islands, a_sleeping_island_wakes_when_its_state_is_changed_and_others_do_not_notice) {
  Sleepers scene, undisturbed;
  Simulation simulation{scene.graph, automatic(1e-10)}, other{undisturbed.graph, automatic(1e-10)};
  State state = simulation.system().initial_state(), calm = state;
  simulation.run(state, 1);
  other.run(calm, 1);
  EXPECT_TRUE(simulation.islands()[1].asleep);
  state.v[8] = 0.01;  // a push on the mass, along the slider
  simulation.run(state, 2);
  other.run(calm, 2);
  EXPECT_FALSE(simulation.islands()[1].asleep);
  EXPECT_EQ(state.q.head(7), calm.q.head(7));
  EXPECT_EQ(simulation.islands()[0].statistics.steps, other.islands()[0].statistics.steps);
  const double omega = std::sqrt(1e4 / 2);
  EXPECT_NEAR(state.q[9], -1 + 0.01 / omega * std::sin(omega), 1e-8);
  EXPECT_EQ(calm.q[9], -1);
}

TEST(simulation_islands, what_is_not_quite_at_rest_does_not_sleep) {
  for (const double off : {1e-6, 1e-8}) {
    Sleepers scene(1 + off);
    Simulation simulation{scene.graph, automatic(1e-10)};
    State state = simulation.system().initial_state();
    simulation.run(state, 0.01);
    EXPECT_FALSE(simulation.islands()[1].asleep) << off;
  }
  // A push of 1e-14 m/s² is noise for half a minute, and half a nanometre at the end of five.
  for (const double piece : {1.0, 7.0, 316.0}) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& mass = graph.add<RigidBody>("mass");
    graph.add<PrismaticJoint>("rail", {graph.ground().marker({0, 0, 0}, kAxisY), mass.marker({0, 0, 0}, kAxisY)});
    graph.add<PointForce>("push", {mass.marker()}, {.force = {0, 1e-14, 0}});
    Simulation simulation{graph, automatic(1e-10)};
    State state = simulation.system().initial_state();
    for (double t = piece; t <= 316; t += piece) simulation.run(state, t);
    EXPECT_FALSE(simulation.islands()[0].asleep);
    const double late = piece < 30 ? 33 : 0.01;  // s; looked at once, it is awake at once
    EXPECT_GT(state.q[1], 0.5e-14 * std::pow(state.time - late, 2));
    EXPECT_LT(state.q[1], 0.5e-14 * std::pow(state.time + 0.01, 2));
  }
  // A thrown stone at the top of its flight: no speed, but gravity.
  SystemGraph graph;
  graph.add<RigidBody>("stone");
  Simulation simulation{graph, automatic(1e-10)};
  State state = simulation.system().initial_state();
  simulation.run(state, 1);
  EXPECT_FALSE(simulation.islands()[0].asleep);
  EXPECT_NEAR(state.q[2], -9.81 / 2, 1e-9);
}

TEST(simulation_islands, an_island_driven_later_does_not_sleep_through_it) {
  SystemGraph graph;
  add_rod(graph, "rod", {0, 0, 0});
  auto& mass = graph.add<RigidBody>("mass", {.mass = 2, .inertia = {1, 1, 1}, .position = {3, 0, 0}});
  auto& slide = graph.add<PrismaticJoint>("slide", {graph.ground().marker({3, 0, 0}), mass.marker()});
  graph.add<CoordinateDrive>("lift", {slide.displacement()}, {.motion = smooth_step(0, 0.2, 0.5, 0.7)});
  auto& pushed = graph.add<RigidBody>("pushed", {.mass = 1, .inertia = {1, 1, 1}, .position = {6, 0, 0}});
  graph.add<PrismaticJoint>("rail", {graph.ground().marker({6, 0, 0}, kAxisY), pushed.marker({0, 0, 0}, kAxisY)});
  graph.add<UserForce>("push", {pushed.marker()}, {[](double t, const MarkerView&) {
                         return force({0, t > 0.5 ? 1.0 : 0.0, 0});
                       }});
  Simulation simulation{graph, automatic(1e-8)};
  State state = simulation.system().initial_state();
  simulation.run(state, 1);
  EXPECT_NEAR(state.q[9], 0.2, 1e-9);
  EXPECT_NEAR(state.q[15], 0.5 * 0.25, 1e-4);
  for (const auto& island : simulation.islands()) EXPECT_FALSE(island.asleep);
}

TEST(simulation_islands, a_run_in_pieces_is_the_run_in_one) {
  Archipelago one, pieces;
  Recorder all(one.sensors), bits(pieces.sensors);
  Simulation whole{one.graph, automatic(1e-8)}, parts{pieces.graph, automatic(1e-8)};
  whole.observe(all, every(0.125));
  parts.observe(bits, every(0.125));
  State a = whole.system().initial_state(), b = a;
  whole.run(a, 1);
  for (double end : {0.0, 0.25, 0.25, 0.875, 1.0}) parts.run(b, end);
  EXPECT_EQ(largest_difference(all.table(), bits.table()), 0);
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.lambda, b.lambda);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_EQ(whole.islands()[i].statistics.steps, parts.islands()[i].statistics.steps);
}

TEST(simulation_islands, an_island_that_fails_is_named_and_what_was_observed_is_kept) {
  SystemGraph graph;
  auto& before = add_rod(graph, "before", {0, 0, 0});
  auto& wild = add_bouncer(graph, "wild", {0, 5, 0}, 100);
  add_rod(graph, "after", {0, 10, 0});
  graph.add<UserForce>("curse", {wild.marker()}, {[](double t, const MarkerView&) {
                         return force({0, 0, t > 0.55 ? std::numeric_limits<double>::quiet_NaN() : 0});
                       }});
  Recorder path{{position(before.marker(), "before"), position(wild.marker(), "wild")}};
  Simulation simulation{graph, automatic(1e-8)};
  simulation.observe(path, every(0.1));
  State state = simulation.system().initial_state();
  std::string message;
  try {
    simulation.run(state, 1);
    FAIL() << "it went on";
  } catch (const SimulationError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("in the island of 'wild'"));
  EXPECT_THAT(message, HasSubstr("t = 0.5"));
  EXPECT_GT(state.time, 0.5);
  EXPECT_LT(state.time, 0.551);
  EXPECT_TRUE(state.q.allFinite());
  // Seven states: those of the schedule and the last good one, at one time for all.
  ASSERT_EQ(path.table().row_count(), 7);
  EXPECT_EQ(path.table().at(6, 0), state.time);
  EXPECT_EQ(path.table().at(6, 1), state.q[0]);
  // The others stand where they would without the failure.
  SystemGraph sound;
  auto& rod = add_rod(sound, "before", {0, 0, 0});
  Simulation reference{sound, automatic(1e-8)};
  State there = reference.system().initial_state();
  reference.run(there, state.time);
  EXPECT_EQ(rod.name(), "before");
  EXPECT_NEAR(there.q[0], state.q[0], 1e-7);
  EXPECT_NEAR(there.q[0], state.q[14], 1e-7);
}

TEST(simulation_islands, a_flexible_body_is_an_island_that_swings_sags_and_sleeps) {
  const FiniteElementModel model =
      test::bar_model({.size = {0.3, 0.04, 0.03}, .bricks = {4, 1, 1}, .young = 3e6, .density = 1000});
  const auto basis = make_basis(model, MeanAxisFrame{}, 2, {.loaded = {{model.node_set("start")}}});
  const auto draw = [&](SystemGraph& graph, bool with_rod) -> FlexibleBody& {
    if (with_rod) add_rod(graph, "rod", {0, 5, 0});
    auto& bar = graph.add<FlexibleBody>("bar", {.basis = basis, .damping = {.stiffness_proportional = 1e-3}});
    const auto& ids = model.node_set("start");
    graph.add<FixedJoint>("clamp", {graph.ground().marker(), bar.average(ids)});
    return bar;
  };
  SystemGraph alone, beside;
  auto &free = draw(alone, false), &other = draw(beside, true);
  Recorder free_tip{{modal_coordinates(free, "eta")}}, other_tip{{modal_coordinates(other, "eta")}};
  Simulation one{alone, automatic(1e-8)}, two{beside, automatic(1e-8)};
  one.observe(free_tip, every(0.05));
  two.observe(other_tip, every(0.05));
  State a = one.system().initial_state(), b = two.system().initial_state();
  one.run(a, 0.3);
  two.run(b, 0.3);
  EXPECT_EQ(largest_difference(free_tip.table(), other_tip.table()), 0);
  EXPECT_GT(free_tip.table().values.back() * free_tip.table().values.back(), 0);

  // Hung in its equilibrium, found together with a rod that hangs down, it sleeps.
  const Equilibrium still = find_equilibrium(two.system(), b);
  State rest = still.state;
  two.run(rest, rest.time + 10);
  EXPECT_TRUE(two.islands()[1].asleep);
  EXPECT_EQ(rest.q.tail(other.mode_count()), still.state.q.tail(other.mode_count()));
  std::printf("found to %.1e N; %s", still.out_of_balance, two.report().c_str());
}

TEST(simulation_islands, one_island_is_a_simulation_with_events_and_every_step) {
  class Steps : public Observer {
   public:
    int count = 0;
    void observe(Snapshot&) override { ++count; }
  };
  SystemGraph graph;
  auto& rod = add_rod(graph, "rod", {0, 0, 0});
  Simulation simulation{graph, automatic(1e-8)};
  Steps steps;
  simulation.observe(steps, every_step());
  simulation.on({.name = "below", .function = watch(position(rod.marker(), "p"), 0), .action = Event::Action::stop});
  State state = simulation.system().initial_state();
  simulation.run(state, 5);
  EXPECT_EQ(simulation.stopped_by(), "below");
  EXPECT_LT(state.time, 1);
  EXPECT_GT(steps.count, 5);

  // Asleep, it still comes to an event that the clock makes.
  Sleepers quiet;
  const auto parts = split(quiet.graph);
  Simulation sleeper{*parts[1], automatic(1e-8)};
  sleeper.on(
      {.name = "alarm", .function = [](Snapshot& now) { return now.time() - 0.7; }, .action = Event::Action::stop});
  State still = sleeper.system().initial_state();
  sleeper.run(still, 2);
  EXPECT_TRUE(sleeper.islands()[0].asleep);
  EXPECT_EQ(sleeper.stopped_by(), "alarm");
  EXPECT_NEAR(still.time, 0.7, 1e-12);

  add_rod(graph, "second", {0, 5, 0});
  Simulation two{graph, automatic(1e-8)};
  EXPECT_THAT(message_of<SceneError>([&] { two.observe(steps, every_step()); }), HasSubstr("2 islands"));
  EXPECT_THAT(message_of<SceneError>([&] { two.on({.name = "e", .function = watch(height(rod.marker()))}); }),
              HasSubstr(".split = false"));
  EXPECT_THAT(message_of<SceneError>([&] { two.run(state, 6); }), HasSubstr("7 coordinates"));
}

TEST(simulation_islands, observers_see_the_whole_of_which_a_simpler_scene_runs) {
  SystemGraph graph;
  auto& rod = add_rod(graph, "rod", {0, 0, 0});
  auto& base = graph.add<RigidBody>("base", {.mass = 7, .inertia = {1, 1, 1}, .position = {0, 0, 2}});
  auto& weld = graph.add<FixedJoint>("weld", {graph.ground().marker({0, 0, 2}), base.marker()});
  Simulation drawn{graph, automatic(1e-10)}, simple{graph, automatic(1e-10), {.simplify = true}};
  EXPECT_EQ(drawn.simplification(), nullptr);
  ASSERT_NE(simple.simplification(), nullptr);
  EXPECT_TRUE(simple.simplification()->smaller());
  EXPECT_EQ(&simple.observed(), &simple.simplification()->whole());
  Recorder seen{{position(rod.marker(), "rod"), reaction(weld, 1, kWorldAxes, "weld"), total_energy("energy")}};
  simple.observe(seen, every(0.1));
  State whole = drawn.start(), small = simple.start(), expanded;
  EXPECT_LT(small.q.size(), whole.q.size());
  drawn.run(whole, 1);
  simple.run(small, 1);
  simple.simplification()->expand(small, expanded);
  EXPECT_LT((expanded.q - whole.q).lpNorm<Eigen::Infinity>(), 1e-6);
  EXPECT_EQ(seen.table().row_count(), 11);
  for (int i = 0; i < 11; ++i) {
    EXPECT_NEAR(seen.table().at(i, 6), 7 * 9.81, 1e-9);       // the weight of the base
    EXPECT_NEAR(seen.table().at(i, 10), 7 * 9.81 * 2, 1e-6);  // its energy: the rod swings from height 0
  }
  EXPECT_EQ(seen.table().at(10, 1), expanded.q[0]);
}

/// A simulation of a graph that is one island, and one of its system with an integrator lent to it, are one.
TEST(simulation_islands, a_graph_that_is_one_island_runs_as_its_system_does) {
  SystemGraph graph;
  auto& rod = add_rod(graph, "rod", {0, 0, 0});
  const System system = assemble(graph);
  const auto integrator = automatic(1e-8)();
  Simulation lent{system, *integrator}, own{graph, automatic(1e-8), {.sleep = false}};
  Recorder seen_lent{{position(rod.marker(), "rod")}}, seen_own{{position(rod.marker(), "rod")}};
  lent.observe(seen_lent, every_step());
  own.observe(seen_own, every_step());
  EXPECT_EQ(&lent.system(), &system);
  EXPECT_EQ(&lent.observed(), &system);
  EXPECT_EQ(lent.simplification(), nullptr);
  State a = lent.start(), b = own.start();
  lent.run(a, 1);
  own.run(b, 1);
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(seen_lent.table().values, seen_own.table().values);
  EXPECT_EQ(lent.statistics().steps, own.statistics().steps);
  EXPECT_EQ(lent.report(), own.report());
  Archive saved_lent, saved_own;
  lent.save(a, saved_lent);
  own.save(b, saved_own);
  EXPECT_EQ(saved_lent.bytes(), saved_own.bytes());
}

TEST(simulation_islands, multipliers_that_nobody_asks_for_change_no_motion) {
  SystemGraph graph;
  add_rod(graph, "one", {0, 0, 0}), add_rod(graph, "two", {0, 5, 0});
  Simulation asked{graph, runge_kutta(1e-8)}, unasked{graph, runge_kutta(1e-8)};
  State found = asked.start(), later = found;
  asked.run(found, 0.3);
  unasked.run(later, 0.3, Multipliers::later);
  EXPECT_EQ(found.lambda.size(), asked.system().layout().row_count());
  EXPECT_EQ(found.q, later.q);
  EXPECT_EQ(found.v, later.v);
  long steps = 0;
  for (const auto& island : asked.islands()) steps += island.statistics.steps;
  EXPECT_EQ(asked.statistics().steps, steps);
}

}  // namespace

}  // namespace lithe::test::simulation_islands_test
