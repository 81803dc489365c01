// Where a body is tied: rigid sets (RBE2), averages (RBE3), static modes.
#include <gtest/gtest.h>

#include <numbers>

#include "bodies/flexible/flexible_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/observe/sensors.h"
#include "engine/observe/snapshot.h"
#include "joints/fixed_joint.h"
#include "tests/bodies/bar_model.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/body_checks.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::interfaces_test {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

struct Rod {
  explicit Rod(double poisson = 0.3) : bar{.size = {0.3, 0.03, 0.02}, .bricks = {6, 2, 2}, .poisson = poisson} {}
  Bar bar;
  FiniteElementModel model = bar_model(bar);
  const std::vector<int>& start = model.node_set("start");
  const std::vector<int>& end = model.node_set("end");
};

/// u = T z, written out by hand: loose nodes as they are, six motions about the first node of each set.
MatrixX tied(const FiniteElementModel& model, const std::vector<std::vector<int>>& sets) {
  std::vector<int> owner(model.node_count(), -1);
  for (size_t s = 0; s < sets.size(); ++s)
    for (int id : sets[s]) owner[model.node_index(id)] = static_cast<int>(s);
  const auto loose = std::count(owner.begin(), owner.end(), -1);
  MatrixX T = MatrixX::Zero(3 * model.node_count(), 3 * loose + 6 * static_cast<int>(sets.size()));
  int column = 0;
  for (int i = 0; i < model.node_count(); ++i) {
    if (owner[i] < 0) {
      T.block<3, 3>(3 * i, column).setIdentity();
      column += 3;
      continue;
    }
    const auto place = 3 * loose + 6 * owner[i];
    const Vector3 arm = model.nodes.col(i) - model.nodes.col(model.node_index(sets[owner[i]][0]));
    T.block<3, 3>(3 * i, place).setIdentity();
    T.block<3, 3>(3 * i, place + 3) = -skew(arm);
  }
  return T;
}

TEST(RigidSet, FrequenciesAreThoseOfTheTiedModelBothEndsFree) {
  const Rod rod;
  const auto basis = make_basis(rod.model, MeanAxisFrame{}, 9, {.rigid = {rod.start, rod.end}});
  const MatrixX T = tied(rod.model, {rod.start, rod.end});
  const VectorX exact = symmetric_eigenvalues(congruence(T, rod.model.stiffness), congruence(T, rod.model.mass));
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(basis->frequencies[k] / (std::sqrt(exact[6 + k]) / kTwoPi), 1, 1e-8) << k;
  // Stiffer than the model whose ends may deform: modes with few waves a little, others much.
  const auto loose = make_basis(rod.model, MeanAxisFrame{}, 9);
  for (int k = 0; k < 9; ++k) EXPECT_GT(basis->frequencies[k], loose->frequencies[k]) << k;
}

TEST(RigidSet, FrequenciesAreThoseOfTheTiedModelOneEndClamped) {
  const Rod rod;
  const auto basis = make_basis(rod.model, TangentFrame{rod.start}, 6, {.rigid = {rod.start, rod.end}});
  MatrixX T = tied(rod.model, {rod.start, rod.end});
  T = MatrixX(T(Eigen::all, Eigen::seq(0, Eigen::last - 12))).eval();  // loose nodes
  MatrixX with_end(T.rows(), T.cols() + 6);
  with_end << T, tied(rod.model, {rod.start, rod.end}).rightCols(6);
  const VectorX exact =
      symmetric_eigenvalues(congruence(with_end, rod.model.stiffness), congruence(with_end, rod.model.mass));
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(basis->frequencies[k] / (std::sqrt(exact[k]) / kTwoPi), 1, 1e-8) << k;
}

TEST(RigidSet, MayHoldNodesOfTheFrame) {
  // A three-node frame within the set, the swing of a hinge within the set: the free body's frequencies do not change
  // with the frame, and a hinged one still swings.
  const Rod rod;
  const auto& s = rod.start;
  const auto hinged = make_basis(rod.model, HingeFrame{{s[0], s[1], s[2]}}, 4, {.rigid = {s}});
  EXPECT_TRUE(hinged->free_swing_dropped);
  for (int id : {s[0], s[1], s[2]}) EXPECT_EQ(hinged->node_modes(hinged->node_index(id)).norm(), 0);
  EXPECT_GT(hinged->node_modes(hinged->node_index(s.back())).norm(), 1e-3);
  const auto framed = make_basis(rod.model, ThreeNodeFrame{s[0], s[2], s[6]}, 4, {.rigid = {s}});
  const auto clamped = make_basis(rod.model, TangentFrame{s}, 4);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(framed->frequencies[k] / clamped->frequencies[k], 1, 1e-8);
}

TEST(RigidSet, KeepsItsDistancesInEveryModeAndUnderLoad) {
  const Rod rod;
  const auto basis =
      make_basis(rod.model, MeanAxisFrame{}, 5, {.rigid = {rod.end}, .loaded = {{rod.start}, {rod.end}}});
  EXPECT_EQ(basis->mode_count(), 17);
  double worst = 0, other = 0;
  const auto stretch = [&](const std::vector<int>& set, int mode) {
    double largest = 0;
    for (int a : set)
      for (int b : set) {
        const int i = basis->node_index(a), j = basis->node_index(b);
        const Vector3 u = basis->node_modes(j).col(mode) - basis->node_modes(i).col(mode);
        largest = std::max(largest, std::abs(u.dot(basis->nodes.col(j) - basis->nodes.col(i))));
      }
    return largest / (0.03 * basis->modes.col(mode).cwiseAbs().maxCoeff());
  };
  for (int mode = 0; mode < basis->mode_count(); ++mode) {
    worst = std::max(worst, stretch(rod.end, mode));
    other = std::max(other, stretch(rod.start, mode));
  }
  EXPECT_LT(worst, 1e-13);
  EXPECT_GT(other, 1e-3);
}

TEST(RigidMarker, TurnsAndMovesWithItsNodesAndOwesWhatEveryBodyOwes) {
  const Rod rod;
  SystemGraph graph{{.gravity = {1, 2, -9.81}}};
  auto& body = graph.add<FlexibleBody>(
      "rod",
      {.basis = make_basis(rod.model, MeanAxisFrame{}, 4, {.rigid = {rod.start, rod.end}, .loaded = {{rod.end}}})});
  const Matrix3 turn = rotation_about({1, 2, 3}, 0.7);
  check_body(graph, body, {body.rigid(rod.start), body.rigid(rod.end, turn)},
             {.mass = 7800 * 0.3 * 0.03 * 0.02, .speed = 3, .deformation = 1e-3, .tolerance = 1e-7});
}

TEST(RigidMarker, IsRefusedWhereTheBasisDeformsItsNodes) {
  const Rod rod;
  SystemGraph graph;
  auto& loose = graph.add<FlexibleBody>("loose", {.basis = make_basis(rod.model, MeanAxisFrame{}, 5)});
  expect_error<SceneError>([&] { loose.rigid(rod.end); }, {"deforms the 9 nodes", ".rigid"});
  auto& nodal = graph.add<FlexibleBody>("nodal", {.basis = make_basis(rod.model, TangentFrame{rod.start}, kAllNodal)});
  expect_error<SceneError>([&] { nodal.rigid(rod.end); }, {"deforms"});
  nodal.rigid(rod.start);  // all held: rigid
  auto& stiff = graph.add<FlexibleBody>("stiff", {.basis = loose.parameters().basis, .mode_count = 0});
  stiff.rigid(rod.end);
  expect_error<SceneError>([&] { stiff.rigid({rod.end[0], rod.end[1], rod.end[2]}); }, {"line", "average"});
  expect_error<SceneError>([&] { make_basis(rod.model, TangentFrame{rod.start}, kAllNodal, {.rigid = {rod.end}}); },
                           {"keeps no set of nodes rigid"});
  expect_error<SceneError>(
      [&] {
        make_basis(rod.model, MeanAxisFrame{}, 3, {.rigid = {rod.end, {rod.end[0]}}});
      },
      {"two rigid sets"});
}

TEST(RigidMarker, FixedAtBothEndsTakesTwelveRowsAndBendsAsTheTiedModelDoes) {
  const Rod rod;
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  const auto basis =
      make_basis(rod.model, MeanAxisFrame{}, 2, {.rigid = {rod.start, rod.end}, .loaded = {{rod.start}, {rod.end}}});
  auto& body = graph.add<FlexibleBody>("rod", {.basis = basis});
  const double aside = 1e-6;  // m, of the end
  graph.add<FixedJoint>("start", {graph.ground().marker(), body.rigid(rod.start)});
  auto& end = graph.add<FixedJoint>("end", {graph.ground().marker({0.3, 0, aside}), body.rigid(rod.end)});
  const System system = assemble(graph);
  EXPECT_EQ(system.rank(), 12);
  const Equilibrium rest = find_equilibrium(system, system.initial_state());
  Snapshot now(system, rest.state);

  // The end's force by the tied model: the loose nodes eliminated from its stiffness.
  const MatrixX K = congruence(tied(rod.model, {rod.start, rod.end}), rod.model.stiffness);
  const auto loose = K.rows() - 12;
  const MatrixX C = K.topRightCorner(loose, 12);
  const MatrixX ends =
      K.bottomRightCorner(12, 12) - product(C.transpose(), solve_positive(K.topLeftCorner(loose, loose), C));
  const double stiffness = reaction(end, 1).value(now, 2) / aside;
  EXPECT_NEAR(stiffness / ends(8, 8), 1, 1e-6);
}

/// Static deflection of the marker under a unit load by the basis, and by the mesh: K u = F with the start clamped.
TEST(StaticModes, LetALoadedFaceYieldAsTheMeshDoes) {
  const Rod rod(0);  // its clamped face hinders no contraction: a beam to the end
  const std::vector<double> weights = face_weights(rod.bar);
  const auto basis = make_basis(rod.model, TangentFrame{rod.start}, 0, {.loaded = {{rod.end, weights}}});
  EXPECT_EQ(basis->mode_count(), 6);
  SystemGraph graph;
  auto& body = graph.add<FlexibleBody>("rod", {.basis = basis});
  const Marker tip = body.average(rod.end, Matrix3::Identity(), weights);
  const System system = assemble(graph);
  Evaluator equations(system);
  const State state = system.initial_state();
  equations.evaluate(0, state.q, state.v, Level::acceleration);
  const MarkerKinematics k = marker_kinematics(equations, tip, Level::position);
  const Eigen::Map<const Matrix6X> J(k.elastic, 6, 6);
  const Matrix6 compliance = J * VectorX(basis->stiffness.diagonal()).cwiseInverse().asDiagonal() * J.transpose();

  // The mesh by a dense solution.
  const int held = 27, n = 3 * rod.model.node_count();
  const MatrixX K = MatrixX(rod.model.stiffness).bottomRightCorner(n - held, n - held);
  MatrixX F = MatrixX::Zero(n, 6);
  Vector3 center(0.3, 0, 0);
  Matrix3 D = Matrix3::Zero();
  for (size_t i = 0; i < weights.size(); ++i) {
    const Vector3 arm = rod.model.nodes.col(rod.end[i] - 1) - center;
    D += weights[i] / 4 * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
  }
  for (size_t i = 0; i < weights.size(); ++i) {
    const Vector3 arm = rod.model.nodes.col(rod.end[i] - 1) - center;
    for (int a = 0; a < 3; ++a) {
      F.block<3, 1>(3 * (rod.end[i] - 1), a) = weights[i] / 4 * Vector3::Unit(a);
      F.block<3, 1>(3 * (rod.end[i] - 1), 3 + a) = weights[i] / 4 * Vector3(D.inverse().col(a)).cross(arm);
    }
  }
  const MatrixX loads = F.bottomRows(n - held), exact = product(loads.transpose(), solve_positive(K, loads));
  EXPECT_LT((compliance - exact).norm() / exact.norm(), 1e-9);
  // Timoshenko's beam: bending and shear.
  const double I = 0.03 * std::pow(0.02, 3) / 12, shear = 2.07e11 / 2 * 0.03 * 0.02 * 5 / 6;
  EXPECT_NEAR(compliance(2, 2) / (std::pow(0.3, 3) / (3 * 2.07e11 * I) + 0.3 / shear), 1, 0.01);
}

TEST(StaticModes, OfAFreeBodyLeaveEigenmodesAlone) {
  // With eigenmodes the Ritz vectors keep the lowest frequencies, and every mode stays rid of momentum.
  const Rod rod;
  const auto eigen = make_basis(rod.model, MeanAxisFrame{}, 4);
  const auto both = make_basis(rod.model, MeanAxisFrame{}, 4, {.loaded = {{rod.start}, {rod.end}}});
  EXPECT_EQ(both->mode_count(), 16);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(both->frequencies[k] / eigen->frequencies[k], 1, 1e-9);
  const MatrixX R = rigid_motions(both->nodes, Vector3::Zero());
  const MatrixX& B = both->modes;
  const MatrixX momenta = product(R.transpose(), product(rod.model.mass, B));
  EXPECT_LT(momenta.cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT((congruence(B, rod.model.mass) - MatrixX::Identity(16, 16)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((congruence(B, rod.model.stiffness) - MatrixX(both->stiffness)).cwiseAbs().maxCoeff() /
                both->stiffness.diagonal().maxCoeff(),
            1e-10);
}

/// A basis whose one mode moves the nodes as one rigid piece.
TEST(AverageMarker, OnALineFollowsItsNodesButForTheTurnAboutTheLine) {
  Matrix3X nodes(3, 4);
  nodes << 0, 1, 2, 4, 0, 0.5, 1, 2, 0, 0, 0, 0;  // along (2, 1, 0)
  const Vector3 turn(0.3, -0.2, 0.5), along = Vector3(2, 1, 0).normalized();
  MatrixX B(12, 1);
  for (int i = 0; i < 4; ++i) B.block<3, 1>(3 * i, 0) = turn.cross(Vector3(nodes.col(i))) + Vector3(0.1, 0.2, 0.3);
  SparseMatrix m(4, 4), K(1, 1);
  m.setIdentity();
  K.insert(0, 0) = 1;
  SystemGraph graph;
  auto& body = graph.add<FlexibleBody>("line", {.basis = basis_from_modes("line", nodes, m, K, B)});
  const std::vector<double> weights{1, 5, 2, 4};
  const Marker plain = body.average({1, 2, 3, 4}), weighted = body.average({1, 2, 3, 4}, Matrix3::Identity(), weights);
  const Marker one = body.average({3});
  // As drawn: a line has no inertia about itself, and a mode that is a rigid motion none of its own, so that there are
  // no accelerations.
  const System system = assemble(graph, {.start = AssembleOptions::Start::as_drawn});
  Evaluator equations(system);
  const State state = system.initial_state();
  equations.evaluate(0, state.q, state.v, Level::acceleration);
  const Vector3 seen = turn - turn.dot(along) * along;
  for (Marker marker : {plain, weighted}) {
    const MarkerKinematics k = marker_kinematics(equations, marker, Level::position);
    const Eigen::Map<const Vector6> column(k.elastic);
    EXPECT_LT((column.tail<3>() - seen).norm(), 1e-14);
    EXPECT_LT((column.head<3>() - (turn.cross(k.r) + Vector3(0.1, 0.2, 0.3))).norm(), 1e-14);
  }
  const Vector3 expected = (nodes * Eigen::Map<const VectorX>(weights.data(), 4)) / 12;
  EXPECT_LT((marker_kinematics(equations, weighted, Level::position).r - expected).norm(), 1e-15);
  EXPECT_EQ((marker_kinematics(equations, one, Level::position).r - nodes.col(2)).norm(), 0);
  expect_error<SceneError>([&] { body.average({1, 2}, Matrix3::Identity(), {1}); }, {"2 nodes has 1 weights"});
  expect_error<SceneError>([&] { body.average({1, 2}, Matrix3::Identity(), {1, -1}); }, {"negative"});
}

}  // namespace
}  // namespace lithe::test::interfaces_test
