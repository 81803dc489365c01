#include "bodies/beam/beam_model.h"

#include <gtest/gtest.h>

#include "bodies/flexible/flexible_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "engine/base/error.h"
#include "engine/base/rotations.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "tests/support/body_checks.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// Beams as finite-element models and reduced to modes, against the beams themselves.
namespace lithe::test::beam_model_test {
namespace {

/// Every strain tied to every other, mass off the axis.
BeamSection coupled_section() {
  RandomNumbers random(7);
  BeamSection s = BeamSection::diagonal({40, 30, 20, 3, 5, 4}, 2, {0.3, 0.2, 0.15}).moved(0.04, -0.03);
  Matrix6 B;
  for (int i = 0; i < 6; ++i) B.col(i) = random.vector(6, 0.3);
  const Vector6 root = s.stiffness.diagonal().cwiseSqrt();
  s.stiffness += root.asDiagonal() * (B * B.transpose()) * root.asDiagonal();
  return s;
}

Beam::Parameters twisted(Beam::Mass mass) {
  return {.axis = BeamAxis::curved({{0.3, -0.2, 0.5}, rotation_exp(Vector3(0.4, -0.7, 0.2))}, {0.5, 0.3, -0.6}, 1.5),
          .sections = {{0, coupled_section()}},
          .elements = 4,
          .mass = mass};
}

BeamSection rod() { return BeamSection::rectangle(0.02, 0.01, {2.1e11, 0.3, 7850}); }

/// Energy of the beam moved from its drawing by x, as the degrees of freedom of its model.
BodyEnergy energy(const Beam& beam, const VectorX& x, const VectorX& rate) {
  const int n = beam.node_count();
  const auto cache = beam.make_cache();
  VectorX q(7 * n), v(6 * n);
  for (int i = 0; i < n; ++i) {
    const Matrix3 axes = rotation_exp(Vector3(x.segment<3>(3 * (n + i)))) * beam.pose(i).axes;
    q.segment<7>(7 * i) << beam.pose(i).position + x.segment<3>(3 * i), quaternion_of(axes);
    v.segment<6>(6 * i) << rate.segment<3>(3 * i), axes.transpose() * rate.segment<3>(3 * (n + i));
  }
  const BodyState state{q.data(), v.data(), cache.get()};
  beam.evaluate(state, Level::velocity);
  return beam.energy(state, Vector3::Zero());
}

TEST(BeamModel, HasTheEnergiesOfItsBeam) {
  for (const Beam::Mass mass : {Beam::Mass::lumped, Beam::Mass::consistent}) {
    const Beam beam(twisted(mass));
    const FiniteElementModel model = finite_element_model(beam);
    const ModelCheck sheet = check(model);
    for (const double residual : sheet.rigid_residual) expect_below("K r", residual, 1e-12);
    EXPECT_TRUE(sheet.mass_positive);
    expect_below("mass", std::abs(sheet.mass / beam.mass() - 1), 1e-13);

    RandomNumbers random(3);
    const VectorX x = random.vector(model.dof_count(), 1), rate = random.vector(model.dof_count(), 1);
    const double kinetic = 0.5 * rate.dot(model.mass * rate);
    expect_below("kinetic energy", std::abs(energy(beam, 0 * x, rate).kinetic / kinetic - 1), 1e-13);

    // V(h x) = ½ h² x K x + h³/6 V''' + …; V''' = 3 Σ a_k a_l s_kl x with x = Σ a_k φ_k.
    MatrixX modes(x.size(), 3);
    for (int k = 0; k < 3; ++k) modes.col(k) = random.vector(model.dof_count(), 1);
    const Vector3 a(0.7, -1.1, 0.4);
    const VectorX along = modes * a;
    const auto V = [&](double h) { return energy(beam, h * along, 0 * x).elastic; };
    const auto odd = [&](double h) { return (V(h) - V(-h)) / 2; };
    const double h = 1e-3, second = (V(h) + V(-h)) / (h * h),
                 third = (8 * odd(h) - odd(2 * h) / 4) * 2 / (2 * h * h * h);
    expect_below("V''", std::abs(along.dot(model.stiffness * along) / second - 1), 1e-4);
    const MatrixX s = model.second_order_forces(modes);
    double expected = 0;
    for (int l = 0; l < 3; ++l)
      for (int k = 0; k < 3; ++k)
        expected += 3 * a[k] * a[l] * s.col(k <= l ? l * (l + 1) / 2 + k : k * (k + 1) / 2 + l).dot(along);
    EXPECT_GT(std::abs(expected), 1);
    expect_below("V'''", std::abs(third / expected - 1), 1e-4);
  }
}

/// Clamped, all modes against those of the exact beam's small motions.
TEST(BeamModel, HasTheFrequenciesOfTheClampedBeam) {
  for (const Beam::Mass mass : {Beam::Mass::lumped, Beam::Mass::consistent}) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    Beam& beam = graph.add<Beam>("beam", twisted(mass));
    graph.add<FixedJoint>("clamp", {graph.ground().marker(beam.pose(0).position, beam.axes(0)), beam.marker(0)});
    const System system = assemble(graph);
    const VectorX exact = linearize(system, system.initial_state()).undamped_frequencies();
    const auto basis = make_basis(beam, TangentFrame{{1}}, 24);
    ASSERT_EQ(exact.size(), 24);
    for (int k = 0; k < 24; ++k)
      expect_below("mode " + std::to_string(k), std::abs(basis->frequencies[k] / exact[k] - 1), 1e-12);
  }
}

/// A cantilever along x under a force at its tip, as the exact beam or reduced.
struct Cantilever {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  Marker tip;

  Cantilever(const Beam::Parameters& drawing, std::optional<Deflection> reduced, const Vector3& load, int modes = 12) {
    if (!reduced) {
      Beam& beam = graph.add<Beam>("beam", drawing);
      graph.add<FixedJoint>("clamp", {graph.ground().marker(), beam.marker(0)});
      tip = beam.marker(beam.length());
    } else {
      const Beam beam(drawing);
      auto& body = graph.add<FlexibleBody>(
          "beam", {.basis = make_basis(beam, TangentFrame{{1}}, modes, {.deflection = *reduced})});
      graph.add<FixedJoint>("clamp", {graph.ground().marker(), body.node(1)});
      tip = body.node(beam.node_count());
    }
    graph.add<UserForce>("load", {tip}, {[load](double, const MarkerView&) { return force(load); }});
  }
  Vector3 deflection(const Vector3& drawn) {
    const System system = assemble(graph);
    Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
    return now.marker(tip).p - drawn;
  }
  /// rad/s, lowest.
  double frequency() {
    const System system = assemble(graph);
    return std::sqrt(linearize(system, find_equilibrium(system, system.initial_state()).state).undamped[0]);
  }
};

Beam::Parameters cantilever() {
  return {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), .sections = {{0, rod()}}, .elements = 10};
}

TEST(BeamModel, DeflectsAsTheBeamUnderSmallLoads) {
  const Vector3 load(0, 0.1, 0.2), tip(1, 0, 0);
  const Vector3 exact = Cantilever(cantilever(), {}, load).deflection(tip);
  // All 60 coordinates: nothing but the second order is left out.
  const Vector3 found = Cantilever(cantilever(), Deflection::linear, load, 60).deflection(tip);
  expect_below("across", (found - exact).tail<2>().norm() / exact.tail<2>().norm(), 1e-6);
  // The bent beam gets shorter; linear displacements do not.
  const Vector3 second = Cantilever(cantilever(), Deflection::stiffened, load, 6).deflection(tip);
  EXPECT_LT(exact[0], -1e-8);
  expect_below("shortening", std::abs(second[0] / exact[0] - 1), 0.005);
  expect_below("no shortening", std::abs(found[0]), 0.02 * std::abs(exact[0]));
}

/// Tension raises the lowest frequency, compression lowers it to zero at Euler's load.
TEST(BeamModel, StiffensUnderTension) {
  const double EI = 2.1e11 * 0.02 * 1e-6 / 12, euler = M_PI * M_PI * EI / 4;
  for (const double share : {-0.6, 1.0, 3.0}) {
    const Vector3 load(share * euler, 0, 0);
    const double exact = Cantilever(cantilever(), {}, load).frequency();
    const double stiffened = Cantilever(cantilever(), Deflection::stiffened, load).frequency();
    const double linear = Cantilever(cantilever(), Deflection::linear, load).frequency();
    const std::string what = std::to_string(share) + " of Euler's load";
    expect_below(what + ", stiffened", std::abs(stiffened / exact - 1), 2e-4);
    EXPECT_GT(std::abs(linear / exact - 1), 0.2) << what;
  }
}

TEST(BeamModel, OwesWhatEveryBodyOwes) {
  const Beam beam(twisted(Beam::Mass::consistent));
  for (const Deflection deflection : {Deflection::linear, Deflection::stiffened}) {
    SystemGraph graph{{.gravity = {1, 2, -9.81}}};
    auto& body =
        graph.add<FlexibleBody>("beam", {.basis = make_basis(beam, MeanAxisFrame{}, 5, {.deflection = deflection})});
    check_body(graph, body, {body.node(1), body.node(3), body.frame()}, {.mass = 3, .deformation = 0.05});
  }
}

/// Modes show it as thick as it is, its surface where the beam itself has it: at nodes up to the square of the motion,
/// between them up to the bend of an element.
TEST(BeamModel, IsDrawnAsTheBeamIs) {
  SystemGraph graph;
  const auto& beam = graph.add<Beam>("beam", twisted(Beam::Mass::lumped));
  const auto basis = make_basis(beam, TangentFrame{{1}}, 6);
  auto& body = graph.add<FlexibleBody>("modal", {.basis = basis});
  const DrawnMesh exact = beam.drawn_mesh(false), mesh = body.drawn_mesh(false);
  const auto in_mesh = [&](const Matrix3X& points) -> Matrix3X {
    return (basis->rotation * points).colwise() + basis->origin;
  };
  EXPECT_LT((in_mesh(mesh.points) - exact.points).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(mesh.triangles, exact.triangles);
  EXPECT_EQ(mesh.nodes[3], 3);
  const int n = beam.node_count();
  const auto cache = beam.make_cache();
  for (int k = 0; k < 6; ++k) {
    const double size = 1e-4 / basis->modes.col(k).cwiseAbs().maxCoeff();
    VectorX q(7 * n);
    const VectorX v = VectorX::Zero(6 * n);
    for (int i = 0; i < n; ++i) {
      const Vector3 u = basis->rotation * size * basis->node_modes(i).col(k),
                    turn = basis->rotation * size * basis->node_rotation_modes(i).col(k);
      q.segment<7>(7 * i) << beam.pose(i).position + u, quaternion_of(rotation_exp(turn) * beam.pose(i).axes);
    }
    Matrix3X moved = exact.points;
    beam.drawn_points({q.data(), v.data(), cache.get()}, exact, moved);
    const VectorX shown = size * mesh.modes.col(k);
    const Matrix3X off = moved - in_mesh(mesh.points + Eigen::Map<const Matrix3X>(shown.data(), 3, shown.size() / 3));
    for (int point = 0; point < off.cols(); ++point) {
      const bool at_node = point < n || (point - n) / 4 % 3 == 0;
      EXPECT_LT(off.col(point).norm(), at_node ? 3e-8 : 1e-5) << "mode " << k << ", point " << point;
    }
  }
}

TEST(BeamModel, RefusesTheFourthOrder) {
  const Beam beam(cantilever());
  EXPECT_THROW(make_basis(beam, TangentFrame{{1}}, 4, {.deflection = Deflection::quadratic}), SceneError);
}

}  // namespace
}  // namespace lithe::test::beam_model_test
