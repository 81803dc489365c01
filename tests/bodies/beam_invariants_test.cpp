#include <gtest/gtest.h>

#include "bodies/beam/beam.h"
#include "engine/run/simulation.h"
#include "joints/forces/user_force.h"
#include "tests/support/dense.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// What a free beam keeps, and the derivatives of its forces.
namespace lithe::test::beam_invariants_test {
namespace {

/// Energy, linear momentum, and angular momentum about the world's origin: p · d = u_dᵀ M v with the rigid velocity u_d
/// = (d, 0), L · d likewise, by kinetic energies alone.
struct Invariants {
  double energy;
  Vector3 linear, angular;

  Invariants(Evaluator& equations, const System& system, const State& state) {
    const auto kinetic = [&](const VectorX& v) {
      equations.evaluate(state.time, state.q, v, Level::velocity);
      return equations.energy().kinetic;
    };
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    energy = equations.energy().total();
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 d = Vector3::Unit(axis);
      VectorX moved = VectorX::Zero(state.v.size()), turned = moved;
      for (const auto& body : system.layout().bodies()) {
        if (!body.frame) continue;
        const Vector3 place = state.q.segment<3>(body.q);
        const Matrix3 R = rotation_matrix(state.q.segment<4>(body.q + 3));
        moved.segment<3>(body.v) = d;
        turned.segment<3>(body.v) = d.cross(place);
        turned.segment<3>(body.v + 3) = R.transpose() * d;
      }
      linear[axis] = (kinetic(state.v + moved) - kinetic(state.v - moved)) / 2;
      angular[axis] = (kinetic(state.v + turned) - kinetic(state.v - turned)) / 2;
    }
  }
};

/// The rod of D04, thrown by a force and moments that end at 5 s, at tight tolerance.
TEST(BeamInvariants, AFlyingRodKeepsItsEnergyAndMomenta) {
  for (const auto mass : {Beam::Mass::lumped, Beam::Mass::consistent}) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& rod = graph.add<Beam>(
        "rod", {.axis = BeamAxis::straight({6, 0, 0}, {0, 0, 8}, {0, 1, 0}),
                .sections = {{0, BeamSection::diagonal({1e4, 1e4, 1e4, 500, 500, 500}, 1, {20, 10, 10})}},
                .elements = 8,
                .mass = mass});
    graph.add<UserForce>("throw", {rod.marker(0)}, {[](double t, const MarkerView&) {
                           const double M = t < 2.5 ? 80 * t : t < 5 ? 200 * (2 - t / 2.5) : 0;
                           return Wrench{{M / 10, 0, 0}, {0, M, M / 2}};
                         }});
    const System system = assemble(graph);
    State state = system.initial_state();
    Evaluator equations(system);
    const Method method = runge_kutta8(1e-10);
    Simulation simulation(system, *method);
    simulation.run(state, 5);
    const Invariants before(equations, system, state);
    EXPECT_GT(before.linear.norm(), 10);
    EXPECT_GT(before.angular.norm(), 100);
    double energy = 0, linear = 0, angular = 0;
    for (int i = 1; i <= 6; ++i) {
      simulation.run(state, 5 + 0.5 * i);
      const Invariants now(equations, system, state);
      energy = std::max(energy, std::abs(now.energy / before.energy - 1));
      linear = std::max(linear, (now.linear - before.linear).norm() / before.linear.norm());
      angular = std::max(angular, (now.angular - before.angular).norm() / before.angular.norm());
    }
    const std::string what = mass == Beam::Mass::lumped ? ", lumped mass" : ", consistent mass";
    expect_below("flying rod, energy" + what, energy, 1e-8);
    expect_below("flying rod, momentum" + what, linear, 1e-8);
    expect_below("flying rod, angular momentum" + what, angular, 1e-8);
  }
}

/// Every strain tied to every other, drawn curved and twisted, bent far from that.
TEST(BeamInvariants, TheTangentIsThatOfTheForces) {
  RandomNumbers random(11);
  BeamSection section = BeamSection::diagonal({40, 30, 20, 3, 5, 4}, 2, {0.3, 0.2, 0.15});
  Matrix6 B;
  for (int i = 0; i < 6; ++i) B.col(i) = random.vector(6, 0.3);
  const Vector6 root = section.stiffness.diagonal().cwiseSqrt();
  section.stiffness += root.asDiagonal() * (B * B.transpose()) * root.asDiagonal();
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  graph.add<Beam>("beam", {.axis = BeamAxis::curved({{1, 2, 3}, rotation_exp({0.3, 0.2, -0.5})}, {0.4, 0.1, 0.6}, 3),
                           .sections = {{0, section}},
                           .elements = 4});
  const System system = assemble(graph);
  const Layout& layout = system.layout();
  Evaluator equations(system);
  const VectorX still = VectorX::Zero(layout.v_count()), none = VectorX::Zero(0);
  for (const double bent : {0.0, 0.1, 0.3}) {
    VectorX q(layout.q_count());
    layout.retract(system.initial_state().q, random.vector(layout.v_count(), bent), q);
    const auto force = [&](const VectorX& at) {
      equations.evaluate(0, at, still, Level::velocity);
      VectorX r(layout.v_count());
      equations.residual(still, none, r);
      return r;
    };
    const MatrixX differences = jacobian(layout, q, force);
    equations.evaluate(0, q, still, Level::velocity);
    equations.factorize({1, 0, 0}, still, none, nullptr);
    const MatrixX tangent = dense(equations).S();
    expect_below("tangent of a beam against differences, bent by " + std::to_string(bent),
                 (tangent - differences).cwiseAbs().maxCoeff() / differences.cwiseAbs().maxCoeff(), 1e-9);
  }
}

}  // namespace
}  // namespace lithe::test::beam_invariants_test
