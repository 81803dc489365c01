#include <gtest/gtest.h>

#include <functional>

#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "engine/base/error.h"
#include "engine/motion/projection.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "joints/cylindrical_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/spring_damper.h"
#include "joints/planar_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/bodies/flexible_models.h"
#include "tests/reference/mechanism.h"

// Accelerations by joint-wise recursion and in the plane, against the same scene as bodies with constraints.
namespace lithe::test::forward_dynamics_test {
namespace {

using test::axes_with_z;
using test::Part;

Part body(SystemGraph& graph, const std::string& name, const Vector3& at, const Vector3& turn) {
  return Part(graph, name, 1 + 0.3 * at.norm(), {0.11, 0.23, 0.31}, at, rotation_exp(turn), {0.3, -0.2, 0.5},
              {0.4, -0.7, 0.9});
}

/// Ground - revolute - a - spherical - b, a - cylindrical - c - prismatic - d, ground - planar - e - fixed - f, and g
/// and h free with a hinge between; some joints are given from the outer body to the inner one.
void draw_tree(SystemGraph& graph) {
  const Matrix3 skew_axes = axes_with_z({0.3, 0.5, 1});
  const Part a = body(graph, "a", {0.5, 0, 0}, {0.3, 0.2, -0.1}), b = body(graph, "b", {1.2, 0.3, 0}, {0, 0.4, 1}),
             c = body(graph, "c", {0.4, 0.9, 0.2}, {1, 0, 0.3}), d = body(graph, "d", {0.3, 1.5, 0.1}, {0.2, 1, 0}),
             e = body(graph, "e", {-1, 0, 0.2}, {0.1, 0.2, 0.3}), f = body(graph, "f", {-1.5, 0.3, 0}, {0.6, 0, 0}),
             g = body(graph, "g", {0, -2, 0}, {0, 0, 0.5}), h = body(graph, "h", {0.6, -2.2, 0.3}, {0.7, 0.1, 0});
  const auto tie = [&](auto* type, const char* name, const Part& inner, const Part& outer, const Vector3& at,
                       bool reversed = false) {
    using J = std::remove_pointer_t<decltype(type)>;
    const Marker A = inner.at(at, skew_axes), B = outer.at(at, skew_axes);
    graph.add<J>(name, {reversed ? B : A, reversed ? A : B});
  };
  graph.add<RevoluteJoint>("ground-a", {graph.ground().marker({0, 0.1, 0}, skew_axes), a.at({0, 0.1, 0}, skew_axes)});
  tie(static_cast<SphericalJoint*>(nullptr), "a-b", a, b, {0.9, 0.1, 0}, true);
  tie(static_cast<CylindricalJoint*>(nullptr), "a-c", a, c, {0.5, 0.5, 0.1}, true);
  tie(static_cast<PrismaticJoint*>(nullptr), "c-d", c, d, {0.4, 1.2, 0.2});
  graph.add<PlanarJoint>("ground-e", {graph.ground().marker({-0.7, 0, 0}, skew_axes), e.at({-0.7, 0, 0}, skew_axes)});
  tie(static_cast<FixedJoint*>(nullptr), "e-f", e, f, {-1.2, 0.1, 0.1}, true);
  tie(static_cast<RevoluteJoint*>(nullptr), "g-h", g, h, {0.3, -2.1, 0.1});
  graph.add<SpringDamper>("spring", {b.at({1.4, 0.3, 0.1}), d.at({0.2, 1.7, 0})},
                          {.stiffness = 40, .damping = 3, .natural_length = 0.5});
  graph.add<SpringDamper>("tie", {f.at({-1.6, 0.5, 0}), h.at({0.8, -2.3, 0.3})},
                          {.stiffness = 10, .damping = 1, .natural_length = 1.5});
}

/// Balls alone: ground - a, and on a: b, c and d; on c: e; and a free body f with g and h on it; springs across.
void draw_balls(SystemGraph& graph) {
  const Part a = body(graph, "a", {0.5, 0, 0}, {0.3, 0.2, -0.1}), b = body(graph, "b", {1.2, 0.3, 0}, {0, 0.4, 1}),
             c = body(graph, "c", {0.4, 0.9, 0.2}, {1, 0, 0.3}), d = body(graph, "d", {0.3, -0.8, 0.1}, {0.2, 1, 0}),
             e = body(graph, "e", {0.1, 1.6, 0.4}, {0.1, 0.2, 0.3}), f = body(graph, "f", {-1.5, 0.3, 0}, {0.6, 0, 0}),
             g = body(graph, "g", {-2, 0.5, 0.1}, {0, 0, 0.5}), h = body(graph, "h", {-1.4, 1, 0.3}, {0.7, 0.1, 0});
  const auto tie = [&](const char* name, const Part& A, const Part& B, const Vector3& at) {
    graph.add<SphericalJoint>(name, {A.at(at), B.at(at)});
  };
  graph.add<SphericalJoint>("ground-a", {graph.ground().marker({0, 0.1, 0}), a.at({0, 0.1, 0})});
  tie("b-a", b, a, {0.9, 0.1, 0}), tie("a-c", a, c, {0.5, 0.5, 0.1}), tie("d-a", d, a, {0.4, -0.4, 0});
  tie("c-e", c, e, {0.2, 1.3, 0.3}), tie("g-f", g, f, {-1.8, 0.4, 0}), tie("f-h", f, h, {-1.4, 0.6, 0.2});
  graph.add<SpringDamper>("spring", {b.at({1.4, 0.3, 0.1}), e.at({0.2, 1.7, 0})},
                          {.stiffness = 40, .damping = 3, .natural_length = 0.5});
  graph.add<SpringDamper>("tie", {d.at({0.3, -1, 0.2}), h.at({-1.4, 1.2, 0.4})},
                          {.stiffness = 10, .damping = 1, .natural_length = 1.5});
}

/// Slider-crank and a four-bar loop on it, in the plane normal to world axis `normal`, with a spring.
void draw_linkage(SystemGraph& graph, int normal) {
  const auto in = [&](double x, double y) {
    Vector3 p = Vector3::Zero();
    p[(normal + 1) % 3] = x, p[(normal + 2) % 3] = y;
    return p;
  };
  const Vector3 up = Vector3::Unit(normal);
  const Matrix3 hinge = axes_with_z(normal == 0 ? -up : up, Vector3(0.3, 0.4, 0.5)),
                slide = axes_with_z(in(1, 0.2), Vector3(0.3, 0.4, 0.5));
  const auto part = [&](const char* name, const Vector3& at, double turn) {
    return Part(graph, name, 0.7 + at.norm(), {0.05, 0.06, 0.09}, at, rotation_exp(turn * up + 0.3 * in(1, 0)),
                in(0, 0), 0.0 * up);
  };
  const Part crank = part("crank", in(0.15, 0.1), 0.3), rod = part("rod", in(0.6, 0.15), -0.2),
             piston = part("piston", in(0.9, 0.1), 0), link = part("link", in(0.45, 0.5), 1),
             rocker = part("rocker", in(0.8, 0.7), 0.4);
  graph.add<RevoluteJoint>("pin", {graph.ground().marker(in(0, 0), hinge), crank.at(in(0, 0), hinge)});
  graph.add<RevoluteJoint>("big end", {rod.at(in(0.3, 0.2), hinge), crank.at(in(0.3, 0.2), hinge)});
  graph.add<RevoluteJoint>("small end", {rod.at(in(0.9, 0.1), hinge), piston.at(in(0.9, 0.1), hinge)});
  graph.add<PrismaticJoint>("guide", {piston.at(in(0.95, 0.1), slide), graph.ground().marker(in(0.95, 0.1), slide)});
  graph.add<SphericalJoint>("ball", {rod.at(in(0.5, 0.3)), link.at(in(0.5, 0.3))});
  graph.add<RevoluteJoint>("knee", {link.at(in(0.4, 0.7), hinge), rocker.at(in(0.4, 0.7), hinge)});
  graph.add<CylindricalJoint>("post", {rocker.at(in(1.1, 0.8), hinge), graph.ground().marker(in(1.1, 0.8), hinge)});
  graph.add<PlanarJoint>("plate", {graph.ground().marker(in(0.4, 0.5), hinge), link.at(in(0.4, 0.5), hinge)});
  graph.add<SpringDamper>("spring", {crank.at(in(0.2, 0.1)), graph.ground().marker(in(-0.5, 0.6))},
                          {.stiffness = 60, .damping = 2, .natural_length = 0.2});
}

struct Scene {
  SystemGraph graph;
  System system;
  Scene(const std::function<void(SystemGraph&)>& draw, bool forward, const Vector3& gravity = {1.5, -3, -9.81})
      : graph({.gravity = gravity}), system((draw(graph), assemble(graph, {.forward_dynamics = forward}))) {}
};

State moved(const Scene& scene, double time, double tolerance = 1e-10) {
  ExplicitRungeKutta integrator({.method = ExplicitRungeKutta::Method::dormand_prince8,
                                 .tolerance = {.relative = tolerance, .absolute = tolerance}});
  Simulation simulation(scene.system, integrator);
  State state = scene.system.initial_state();
  simulation.run(state, time);
  return state;
}

void expect_same_accelerations(const std::function<void(SystemGraph&)>& draw, ForwardMethod method) {
  const Scene general(draw, false), forward(draw, true);
  ASSERT_EQ(forward.system.forward_method(), method);
  for (double time : {0.0, 0.11, 0.37}) {
    const State state = moved(general, time);
    Evaluator by_rows(general.system), by_forward(forward.system);
    VectorX expected(state.v.size()), lambda(general.system.layout().row_count()), v_dot(state.v.size());
    Projector(by_rows).accelerations(state.time, state.q, state.v, expected, lambda);
    by_forward.parts().forward_dynamics->accelerations(state.time, state.q, state.v, v_dot);
    EXPECT_GT(expected.norm(), 5);
    EXPECT_LT((v_dot - expected).norm(), 1e-9 * expected.norm()) << "t = " << time;
  }
}

TEST(ForwardDynamics, recursion_over_a_tree_of_every_lower_pair_gives_the_accelerations_of_bodies_with_constraints) {
  expect_same_accelerations(draw_tree, ForwardMethod::tree);
}

TEST(ForwardDynamics, recursion_over_balls_gives_the_accelerations_of_bodies_with_constraints) {
  expect_same_accelerations(draw_balls, ForwardMethod::tree);
}

/// Wires a hundred million times easier to turn about their axes than across: no digit is lost across.
TEST(ForwardDynamics, recursion_over_balls_bears_slender_links) {
  const auto draw = [](SystemGraph& graph) {
    Marker last = graph.ground().marker({0, 0, 0});
    Vector3 at = Vector3::Zero();
    for (int i = 0; i < 5; ++i) {
      const Matrix3 A = rotation_exp(Vector3(0.3 * i, 0.7 - i, 0.2 + 0.4 * i));
      const Vector3 along = A * Vector3(0.5, 0, 0);
      auto& wire = graph.add<RigidBody>("wire " + std::to_string(i), {.mass = 1,
                                                                      .inertia = {1e-9, 0.1, 0.1},
                                                                      .position = at + along,
                                                                      .orientation = A,
                                                                      .angular_velocity = {0, 1.0 + i, 0.5}});
      graph.add<SphericalJoint>("at " + wire.name(), {last, wire.marker({-0.5, 0, 0})});
      last = wire.marker({0.5, 0, 0}), at += 2 * along;
    }
  };
  const Scene general(draw, false), forward(draw, true);
  const State state = general.system.initial_state();
  Evaluator by_rows(general.system), by_forward(forward.system);
  VectorX expected(state.v.size()), lambda(general.system.layout().row_count()), v_dot(state.v.size());
  Projector(by_rows).accelerations(0, state.q, state.v, expected, lambda);
  by_forward.parts().forward_dynamics->accelerations(0, state.q, state.v, v_dot);
  for (int i = 0; i < v_dot.size(); i += 6)
    EXPECT_LT((v_dot - expected).segment<3>(i).norm(), 1e-11 * expected.norm()) << "wire " << i / 6;
}

TEST(ForwardDynamics, a_linkage_with_loops_moves_in_its_plane_as_it_does_in_space) {
  for (int normal = 0; normal < 3; ++normal)
    expect_same_accelerations([&](SystemGraph& g) { draw_linkage(g, normal); }, ForwardMethod::planar);
}

TEST(ForwardDynamics, motions_agree_to_the_tolerance_and_multipliers_come_out_the_same) {
  const std::pair<std::function<void(SystemGraph&)>, ForwardMethod> scenes[] = {
      {draw_tree, ForwardMethod::tree}, {[](SystemGraph& g) { draw_linkage(g, 2); }, ForwardMethod::planar}};
  for (const auto& [draw, method] : scenes) {
    const Scene general(draw, false), forward(draw, true);
    const State a = moved(general, 0.6, 1e-11), b = moved(forward, 0.6, 1e-11);
    ASSERT_EQ(b.lambda.size(), a.lambda.size());
    EXPECT_LT((a.q - b.q).cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_LT((a.v - b.v).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LT((a.lambda - b.lambda).norm(), 1e-6 * a.lambda.norm());
    Evaluator check(forward.system);
    VectorX g(forward.system.layout().row_count());
    check.evaluate(b.time, b.q, b.v, Level::velocity);
    check.constraint(Level::position, g);
    EXPECT_LT(g.cwiseAbs().maxCoeff(), 1e-13);
    check.constraint(Level::velocity, g);
    EXPECT_LT(g.cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(ForwardDynamics, a_state_off_the_constraints_is_moved_onto_them_by_about_as_much) {
  const std::function<void(SystemGraph&)> scenes[] = {draw_tree, [](SystemGraph& g) { draw_linkage(g, 1); }};
  for (const auto& draw : scenes) {
    const Scene scene(draw, true);
    const State on = moved(scene, 0.2);
    VectorX away(on.v.size()), q = on.q, v = on.v;
    for (int i = 0; i < away.size(); ++i) away[i] = 1e-4 * std::sin(1 + 2.4 * i);
    scene.system.layout().retract(on.q, away, q);
    v += away;
    Evaluator equations(scene.system);
    ASSERT_TRUE(equations.parts().forward_dynamics->project(on.time, q, v, 1e-14));
    VectorX g(scene.system.layout().row_count());
    equations.evaluate(on.time, q, v, Level::velocity);
    equations.constraint(Level::position, g);
    EXPECT_LT(g.cwiseAbs().maxCoeff(), 1e-14);
    equations.constraint(Level::velocity, g);
    EXPECT_LT(g.cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((q - on.q).cwiseAbs().maxCoeff(), 2e-3);
    EXPECT_LT((v - on.v).cwiseAbs().maxCoeff(), 2e-2);
  }
}

/// A trunk of `trunk` links with a branch of `length` links at each; and `islands` chains of their own.
void draw_wide(SystemGraph& graph, int trunk, int length, int islands) {
  const auto chain = [&](const std::string& name, const RigidBody* root, Vector3 at, const Vector3& step, int count) {
    Marker last = root ? const_cast<RigidBody*>(root)->marker({0.1, 0.2, 0}) : graph.ground().marker(at);
    std::vector<RigidBody*> links;
    for (int i = 0; i < count; ++i, at += step) {
      auto& link = graph.add<RigidBody>(name + std::to_string(i), {.mass = 1 + 0.1 * i,
                                                                   .inertia = {0.1, 0.2, 0.25},
                                                                   .position = at + 0.5 * step,
                                                                   .angular_velocity = {0.3, 0.1 * i, -0.2}});
      graph.add<SphericalJoint>("at " + link.name(), {last, link.marker(-0.5 * step)});
      last = link.marker(0.5 * step);
      links.push_back(&link);
    }
    return links;
  };
  const auto stem = chain("stem", nullptr, {0, 0, 0}, {1, 0, 0.1}, trunk);
  for (int i = 0; i < trunk; ++i)
    chain("branch" + std::to_string(i) + "-", stem[i], {i + 0.6, 0.2, 0.1 * i + 0.05}, {0, 1, 0.3}, length);
  for (int i = 0; i < islands; ++i)
    chain("island" + std::to_string(i) + "-", nullptr, {0, -i - 1.0, 0}, {-1, 0, 0}, 50);
}

TEST(ForwardDynamics, any_number_of_threads_gives_the_same_bits) {
  std::vector<VectorX> found;
  for (int threads : {1, 2, 3, 8}) {
    SystemGraph graph({.gravity = {0, 0, -9.81}});
    draw_wide(graph, 80, 7, 3);
    const System system = assemble(graph, {.threads = threads});
    ASSERT_EQ(system.forward_method(), ForwardMethod::tree);
    ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-5, .absolute = 1e-5}});
    Simulation simulation(system, integrator);
    State state = system.initial_state();
    simulation.run(state, 0.2);
    VectorX all(state.q.size() + state.v.size() + state.lambda.size());
    all << state.q, state.v, state.lambda;
    found.push_back(all);
    EXPECT_GT(integrator.statistics().steps, 5);
  }
  for (const VectorX& other : found) EXPECT_EQ(found[0], other);
}

TEST(ForwardDynamics, what_branches_hand_to_their_trunk_is_what_they_weigh) {
  const auto draw = [](SystemGraph& graph) { draw_wide(graph, 70, 3, 1); };
  const Scene general(draw, false), forward(draw, true);
  const State state = moved(general, 0.1, 1e-8);
  Evaluator by_rows(general.system), by_forward(forward.system);
  VectorX expected(state.v.size()), lambda(general.system.layout().row_count()), v_dot(state.v.size());
  Projector(by_rows).accelerations(state.time, state.q, state.v, expected, lambda);
  by_forward.parts().forward_dynamics->accelerations(state.time, state.q, state.v, v_dot);
  EXPECT_LT((v_dot - expected).norm(), 1e-9 * expected.norm());
}

TEST(ForwardDynamics, no_threads_at_all_are_refused) {
  SystemGraph graph;
  graph.add<RigidBody>("a", {});
  EXPECT_THROW(assemble(graph, {.threads = 0}), SceneError);
}

TEST(ForwardDynamics, what_a_joint_says_it_leaves_free_is_what_its_rows_leave) {
  int met = 0;
  const auto check = [&](auto* type) {
    using J = std::remove_pointer_t<decltype(type)>;
    SystemGraph graph;
    const Matrix3 axes = axes_with_z({0.3, 0.5, 1});
    const Part a = body(graph, "a", {0.5, 0, 0}, {0.3, 0.2, -0.1}), b = body(graph, "b", {1.2, 0.3, 0}, {0, 0.4, 1});
    const Marker A = a.at({0.8, 0.1, 0}, axes), B = b.at({0.8, 0.1, 0}, axes);
    const auto& joint = graph.add<J>("joint", {A, B});
    const auto freedom = joint.freedom();
    ASSERT_TRUE(freedom);
    const System system = assemble(graph);
    Evaluator equations(system);
    const State& state = system.initial_state();
    // Velocities of b alone, about the joint's point.
    const Matrix3 A_b = rotation_matrix(state.q.segment<4>(10));
    const Vector3 arm = Vector3(0.8, 0.1, 0) - state.q.segment<3>(7);
    VectorX v = VectorX::Zero(12), rates(system.layout().row_count());
    const auto allowed = [&](const Vector3& shift, const Vector3& turn) {
      v.segment<3>(6) = shift - turn.cross(arm);
      v.segment<3>(9) = A_b.transpose() * turn;
      equations.evaluate(0, state.q, v, Level::velocity);
      equations.constraint(Level::velocity, rates);
      return rates.norm() < 1e-12;
    };
    const Vector3 none = Vector3::Zero();
    const bool shifts[] = {freedom->x, freedom->y, freedom->z};
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(allowed(axes.col(i), none), shifts[i]);
      const bool turns = freedom->rotation == JointFreedom::Rotation::any ||
                         (freedom->rotation == JointFreedom::Rotation::about_z && i == 2);
      EXPECT_EQ(allowed(none, axes.col(i)), turns);
    }
    ++met;
  };
  check(static_cast<RevoluteJoint*>(nullptr));
  check(static_cast<SphericalJoint*>(nullptr));
  check(static_cast<PrismaticJoint*>(nullptr));
  check(static_cast<CylindricalJoint*>(nullptr));
  check(static_cast<FixedJoint*>(nullptr));
  check(static_cast<PlanarJoint*>(nullptr));
  EXPECT_EQ(met, 6);
}

TEST(ForwardDynamics, scenes_that_are_neither_tree_nor_plane_stay_bodies_with_constraints) {
  const auto method = [](const std::function<void(SystemGraph&)>& draw) {
    return Scene(draw, true, {0, 0, -9.81}).system.forward_method();
  };
  const auto pair = [](SystemGraph& graph) {
    return std::pair(body(graph, "a", {0.5, 0, 0}, {0, 0, 0}), body(graph, "b", {1.5, 0, 0}, {0, 0, 0}));
  };
  // A loop in space.
  EXPECT_EQ(method([&](SystemGraph& g) {
              const auto [a, b] = pair(g);
              g.add<SphericalJoint>("1", {g.ground().marker(), a.at({0, 0, 0})});
              g.add<SphericalJoint>("2", {a.at({1, 0, 0}), b.at({1, 0, 0})});
              g.add<SphericalJoint>("3", {b.at({2, 0, 0}), g.ground().marker({2, 0, 0})});
            }),
            ForwardMethod::constraints);
  // A joint that is no lower pair.
  EXPECT_EQ(method([&](SystemGraph& g) {
              const auto [a, b] = pair(g);
              g.add<UniversalJoint>("1", {g.ground().marker(), a.at({0, 0, 0})});
            }),
            ForwardMethod::constraints);
  // Hinges whose axes cross: a tree, not a plane.
  EXPECT_EQ(method([&](SystemGraph& g) {
              const auto [a, b] = pair(g);
              g.add<RevoluteJoint>("1", {g.ground().marker(), a.at({0, 0, 0})});
              const Matrix3 level = axes_with_z({0, 1, 0});
              g.add<RevoluteJoint>("2", {a.at({1, 0, 0}, level), b.at({1, 0, 0}, level)});
            }),
            ForwardMethod::tree);
  // Rows that repeat each other in the plane.
  EXPECT_EQ(method([&](SystemGraph& g) {
              const auto [a, b] = pair(g);
              g.add<RevoluteJoint>("1", {g.ground().marker(), a.at({0, 0, 0})});
              g.add<RevoluteJoint>("2", {g.ground().marker({1, 0, 0}), a.at({1, 0, 0})});
              g.add<RevoluteJoint>("3", {a.at({1, 0, 0}), b.at({1, 0, 0})});
            }),
            ForwardMethod::constraints);
}

}  // namespace
}  // namespace lithe::test::forward_dynamics_test
