// What observers read of accelerations and reactions obeys Newton's law, whatever the method leaves in the state.
#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/automatic.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/support/methods.h"

namespace lithe::test::observed_reactions_test {
namespace {

const Vector3 kGravity(0.3, -0.2, -9.81);

/// Newton's and Euler's laws of every rigid body, each force and moment as its sensor tells it; the generalised
/// equation of every body, rigid or not.
class Laws final : public Observer {
 public:
  void observe(Snapshot& now) override {
    ++states;
    const Layout& layout = now.system().layout();
    const SystemGraph& graph = now.system().graph();
    double largest_force = 0, largest_moment = 0, force = 0, moment = 0;
    for (const auto& slice : layout.bodies()) {
      const auto* body = dynamic_cast<const RigidBody*>(slice.body);
      if (!body) continue;
      const Vector3 p = now.state().q.segment<3>(slice.q), omega = now.state().v.segment<3>(slice.v + 3);
      const Matrix3 A = rotation_matrix(now.state().q.segment<4>(slice.q + 3)), J = body->parameters().inertia.matrix;
      Vector3 forces = body->parameters().mass * (now.accelerations().segment<3>(slice.v) - kGravity);
      Vector3 moments = A * (J * now.accelerations().segment<3>(slice.v + 3) + omega.cross(J * omega));
      const auto feel = [&](const Marker& marker, const Sensor& load) {
        Vector6 wrench;
        load.evaluate(now, {wrench.data(), 6});
        const Vector3 F = wrench.head<3>(), M = wrench.tail<3>() + (now.marker(marker).p - p).cross(F);
        largest_force = std::max(largest_force, F.norm());
        largest_moment = std::max(largest_moment, M.norm());
        forces -= F;
        moments -= M;
      };
      for (const auto& entry : graph.constraints())
        for (int m = 0; m < entry.constraint->marker_count(); ++m)
          if (entry.markers[static_cast<size_t>(m)].body == body)
            feel(entry.markers[static_cast<size_t>(m)], reaction(*entry.constraint, m));
      for (const auto& entry : graph.forces())
        for (int m = 0; m < entry.force->marker_count(); ++m)
          if (entry.markers[static_cast<size_t>(m)].body == body)
            feel(entry.markers[static_cast<size_t>(m)], applied_force(*entry.force, m));
      force = std::max(force, forces.norm());
      moment = std::max(moment, moments.norm());
    }
    if (largest_force > 0) newton = std::max(newton, force / largest_force);
    if (largest_moment > 0) euler = std::max(euler, moment / largest_moment);

    VectorX r(layout.v_count()), weight(layout.v_count());
    const VectorX still = VectorX::Zero(layout.v_count()), none = VectorX::Zero(layout.row_count());
    const VectorX v_dot = now.accelerations(), lambda = now.multipliers();
    now.evaluator().residual(still, lambda, weight);
    now.evaluator().residual(v_dot, lambda, r);
    generalised = std::max(generalised, r.norm() / weight.norm());
  }
  int states = 0;
  double newton = 0, euler = 0, generalised = 0;  // largest, relative
};

/// The same of the states as the method left them.
class LawsAsLeft final : public Observer {
 public:
  void observe(Snapshot& now) override {
    if (!snapshot_) snapshot_.emplace(now.system());
    snapshot_->evaluate(now.state());
    laws.observe(*snapshot_);
  }
  Laws laws;

 private:
  std::optional<Snapshot> snapshot_;
};

const Matrix3 kAcross = rotation_about(Vector3::UnitX(), -M_PI / 2);  // z along y

/// A four-bar in space: as it is flat, three of its rows repeat others.
void draw_loop(SystemGraph& graph) {
  const auto bar = [&](const char* name, const Vector3& from, const Vector3& to) -> RigidBody& {
    return graph.add<RigidBody>(name, {.mass = 1.5,
                                       .inertia = {0.02, 0.05, 0.06},
                                       .position = 0.5 * (from + to),
                                       .orientation = rotation_about(Vector3::UnitY(), 0.4)});
  };
  const Vector3 a(0, 0, 0), b(0, 0, 0.4), c(1, 0, 0.7), d(1.1, 0, 0);
  RigidBody &crank = bar("crank", a, b), &rod = bar("rod", b, c), &rocker = bar("rocker", c, d);
  const auto at = [](RigidBody& body, const Vector3& p) {
    const Matrix3 A = body.parameters().orientation;
    return body.marker(A.transpose() * (p - body.parameters().position), A.transpose() * kAcross);
  };
  graph.add<RevoluteJoint>("a", {graph.ground().marker(a, kAcross), at(crank, a)});
  graph.add<RevoluteJoint>("b", {at(crank, b), at(rod, b)});
  graph.add<RevoluteJoint>("c", {at(rod, c), at(rocker, c)});
  graph.add<RevoluteJoint>("d", {graph.ground().marker(d, kAcross), at(rocker, d)});
  graph.add<SpringDamper>("spring", {graph.ground().marker({0.5, 0, -1}), at(rod, {0.5, 0, 0.55})},
                          {.stiffness = 40, .damping = 0.3});
}

/// Two links in space; the second hangs on a ball.
void draw_chain(SystemGraph& graph) {
  auto& upper = graph.add<RigidBody>("upper", {.mass = 2, .inertia = {0.05, 0.1, 0.12}, .position = {0.5, 0, 0}});
  auto& lower = graph.add<RigidBody>(
      "lower", {.mass = 1, .inertia = {0.01, 0.04, 0.05}, .position = {1.4, 0, 0}, .angular_velocity = {3, 1, -2}});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAcross), upper.marker({-0.5, 0, 0}, kAcross)});
  graph.add<SphericalJoint>("ball", {upper.marker({0.5, 0, 0}), lower.marker({-0.4, 0, 0})});
}

/// A bearing that rubs by its reaction.
void draw_rubbing(SystemGraph& graph) {
  auto& arm = graph.add<RigidBody>("arm", {.mass = 2, .inertia = {0.05, 0.1, 0.12}, .position = {0.5, 0, 0}});
  auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAcross), arm.marker({-0.5, 0, 0}, kAcross)});
  graph.add<JointFriction>("rubs", {pin.angle()}, {.joint = &pin, .coefficient = 0.2, .radius = 0.02});
}

/// A flexible link on a pin, a rigid bob at its end.
void draw_flexible(SystemGraph& graph) {
  static const FiniteElementModel model = brick_mesh({.size = {1, 0.02, 0.02},
                                                      .divisions = {6, 1, 1},
                                                      .type = "C3D20",
                                                      .material = {.young = 7e9, .poisson = 0.3, .density = 2700}});
  static const auto basis = make_basis(model, MeanAxisFrame{}, 6);
  auto& link = graph.add<FlexibleBody>("link", {.basis = basis});
  auto& bob = graph.add<RigidBody>("bob", {.mass = 0.4, .inertia = {4e-4, 4e-4, 4e-4}, .position = {1.05, 0.01, 0.01}});
  graph.add<RevoluteJoint>(
      "pin", {graph.ground().marker({0, 0.01, 0.01}, kAcross), link.average(model.node_set("x_min"), kAcross)});
  graph.add<SphericalJoint>("ball", {link.average(model.node_set("x_max")), bob.marker({-0.05, 0, 0})});
}

struct Named {
  const char* name;
  void (*draw)(SystemGraph&);
};
constexpr Named kScenes[] = {
    {"chain", draw_chain}, {"loop", draw_loop}, {"rubbing", draw_rubbing}, {"flexible", draw_flexible}};

struct MethodOf {
  const char* name;
  Method (*make)();
  bool approximates;  // what it leaves in the state breaks the laws by more than 1e-8
  double bound;       // of what observers see
};
const MethodOf kMethods[] = {
    {"bdf", [] { return bdf(1e-6); }, true, 1e-10},
    {"bdf_fixed", [] { return bdf_fixed(1e-3, 2); }, false, 1e-10},
    {"ida", [] { return ida(1e-6); }, true, 1e-10},
    {"adams", [] { return adams(1e-6); }, true, 1e-10},
    {"automatic", [] { return automatic(1e-6); }, false, 1e-10},
    {"radau", [] { return radau(1e-6); }, false, 1e-10},
    {"runge_kutta8", [] { return runge_kutta8(1e-6); }, false, 1e-10},
    {"index3", [] { return index3(1e-3); }, true, 1e-10},
    {"index2", [] { return index2(1e-3); }, false, 1e-10},
    {"hht", [] { return hht(1e-3); }, true, 1e-10},
};

TEST(ObservedReactions, obey_newton_and_euler_after_every_method) {
  for (const MethodOf& of : kMethods) {
    double left = 0;
    for (const Named& scene : kScenes) {
      SystemGraph graph{{.gravity = kGravity}};
      scene.draw(graph);
      const System system = assemble(graph);
      const Method method = of.make();
      Laws laws;
      LawsAsLeft as_left;
      Simulation simulation(system, *method);
      simulation.observe(laws, every(0.01));
      simulation.observe(as_left, every(0.01));
      State state = system.initial_state();
      simulation.run(state, 0.4);
      EXPECT_EQ(laws.states, 41);
      const std::string what = std::string(of.name) + ", " + scene.name;
      expect_below(what + ", Newton's law (of the largest force)", laws.newton, of.bound);
      expect_below(what + ", Euler's law (of the largest moment)", laws.euler, of.bound);
      expect_below(what + ", generalised (of the forces)", laws.generalised, of.bound);
      left = std::max({left, as_left.laws.newton, as_left.laws.euler, as_left.laws.generalised});
    }
    if (of.approximates) {
      EXPECT_GT(left, 1e-8) << of.name;
    }
  }
}

/// The chain with a damper that makes it stiff: for BDF.
void draw_stiff(SystemGraph& graph) {
  draw_chain(graph);
  for (const auto& entry : graph.bodies())
    if (auto* body = dynamic_cast<RigidBody*>(entry.body); body && body->name() == "lower")
      graph.add<SpringDamper>("damper", {graph.ground().marker({1, 2, 1}), body->marker({0.2, 0.1, 0})},
                              {.damping = 1e6});
}

TEST(ObservedReactions, obey_newton_where_automatic_has_chosen_bdf) {
  SystemGraph graph{{.gravity = kGravity}};
  draw_stiff(graph);
  const System system = assemble(graph);
  Automatic automatic({.tolerance = {.relative = 1e-6, .absolute = 1e-6}});
  Laws laws;
  Simulation simulation(system, automatic);
  State state = system.initial_state();
  simulation.run(state, 1);
  ASSERT_EQ(automatic.method(), Automatic::Method::lie_bdf);
  simulation.observe(laws, every(0.02));
  simulation.run(state, 2);
  ASSERT_EQ(automatic.method(), Automatic::Method::lie_bdf);
  expect_below("automatic, BDF at work, Newton's law", laws.newton, 1e-10);
  expect_below("automatic, BDF at work, Euler's law", laws.euler, 1e-10);
  // The state itself is the method's: a snapshot shows it as it is, or solved.
  Snapshot as_left(system, state), solved(system);
  solved.evaluate(state, Accelerations::solved);
  Laws of_left, of_solved;
  of_left.observe(as_left);
  of_solved.observe(solved);
  EXPECT_GT(of_left.newton, 1e-9);
  EXPECT_LT(of_solved.newton, 1e-11);  // N: round-off of the damper's 1e6 N s/m at speeds of 1 m/s is 1e-10
  EXPECT_EQ(solved.state().v_dot, state.v_dot);
  EXPECT_EQ(solved.found_multipliers(), state.lambda);
}

TEST(ObservedReactions, do_not_touch_the_run) {
  for (const Named& scene : kScenes)
    for (const MethodOf& of : kMethods) {
      const auto run = [&](Observer& observer) {
        SystemGraph graph{{.gravity = kGravity}};
        scene.draw(graph);
        const System system = assemble(graph);
        const Method method = of.make();
        Simulation simulation(system, *method);
        simulation.observe(observer, every(0.01));
        State state = system.initial_state();
        simulation.run(state, 0.2);
        simulation.run(state, 0.3);
        return state;
      };
      class Blind final : public Observer {
        void observe(Snapshot&) override {}
      } blind;
      Laws laws;
      EXPECT_TRUE(same(run(blind), run(laws))) << of.name << ", " << scene.name;
    }
}

TEST(ObservedReactions, obey_newton_in_scenes_that_run_as_islands) {
  SystemGraph graph{{.gravity = kGravity}};
  draw_loop(graph);
  draw_chain(graph);
  Simulation simulation(graph, [] { return bdf(1e-6); });
  ASSERT_EQ(simulation.islands().size(), 2U);
  Laws laws;
  simulation.observe(laws, every(0.01));
  State state = simulation.system().initial_state();
  simulation.run(state, 0.3);
  EXPECT_EQ(laws.states, 31);
  expect_below("two islands by BDF, Newton's law", laws.newton, 1e-10);
  expect_below("two islands by BDF, Euler's law", laws.euler, 1e-10);
  expect_below("two islands by BDF, generalised", laws.generalised, 1e-10);
}

}  // namespace
}  // namespace lithe::test::observed_reactions_test
