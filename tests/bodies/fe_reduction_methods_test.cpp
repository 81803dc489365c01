// Ways to reduce a body: Craig-Bampton, Krylov, given modes; beams with nodal rotations, and condensed models.
#include <numbers>

#include "bodies/flexible/flexible_body.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "integrators/explicit_runge_kutta.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/bar_model.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/body_checks.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::fe_reduction_methods_test {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

struct Rod {
  Bar bar{.size = {0.3, 0.03, 0.02}, .bricks = {6, 2, 2}};
  FiniteElementModel model = bar_model(bar);
  const std::vector<int>& start = model.node_set("start");
  const std::vector<int>& end = model.node_set("end");
  MatrixX K = model.stiffness, M = model.mass;
};

/// λ of K a = λ M a in the span of X.
VectorX ritz_values(const MatrixX& K, const MatrixX& M, const MatrixX& X) {
  return test::symmetric_eigenvalues(test::congruence(X, K), test::congruence(X, M));
}

/// Mean motion of a set (its transpose: unit loads), with plain weights; rows of six, mesh axes.
MatrixX mean_motion(const FiniteElementModel& model, const std::vector<int>& ids) {
  MatrixX F = MatrixX::Zero(model.dof_count(), 6);
  Vector3 center = Vector3::Zero();
  for (int id : ids) center += model.nodes.col(model.node_index(id)) / static_cast<double>(ids.size());
  Matrix3 D = Matrix3::Zero();
  for (int id : ids) {
    const Matrix3 arm = skew(model.nodes.col(model.node_index(id)) - center);
    D -= arm * arm / static_cast<double>(ids.size());
  }
  for (int id : ids) {
    const int i = model.node_index(id);
    F.block<3, 3>(3 * i, 0) = Matrix3::Identity() / static_cast<double>(ids.size());
    F.block<3, 3>(3 * i, 3) = -skew(model.nodes.col(i) - center) * D.inverse() / static_cast<double>(ids.size());
  }
  return F;
}

MatrixX rigid(const ModalBasis& basis) { return rigid_motions(basis.nodes, Vector3::Zero()); }

MatrixX with_rigid(const ModalBasis& basis) {
  MatrixX X(basis.modes.rows(), 6 + basis.mode_count());
  X << rigid(basis), basis.modes;
  return X;
}

/// u = T z of two rigid sets: loose nodes, then six motions of each set.
MatrixX tied(const Rod& rod) {
  std::vector<int> loose;
  for (int i = 0; i < rod.model.node_count(); ++i)
    if (rod.model.nodes(0, i) > 1e-9 && rod.model.nodes(0, i) < 0.3 - 1e-9) loose.push_back(i);
  MatrixX T = MatrixX::Zero(rod.model.dof_count(), 3 * static_cast<int>(loose.size()) + 12);
  int column = 0;
  for (int i : loose) T.block<3, 3>(3 * i, 3 * column++).setIdentity();
  const MatrixX R = rigid_motions(rod.model.nodes, Vector3(0.1, 0, 0));
  for (int s = 0; s < 2; ++s)
    for (int id : s == 0 ? rod.start : rod.end)
      T.block(3 * (id - 1), 3 * column + 6 * s, 3, 6) = R.middleRows<3>(3 * (id - 1));
  return T;
}

void expect_orthonormal(const FiniteElementModel& model, const ModalBasis& basis) {
  const int nm = basis.mode_count();
  EXPECT_LT((basis.modes.transpose() * (model.mass * basis.modes) - MatrixX::Identity(nm, nm)).cwiseAbs().maxCoeff(),
            1e-10);
}

TEST(CraigBampton, FrequenciesLieAboveTheTiedModelsByNoMoreThanTheFirstModeLeftOutAllows) {
  const Rod rod;
  const MatrixX T = tied(rod);
  const int loose = static_cast<int>(T.cols()) - 12, kept = 10;
  const VectorX exact = ritz_values(rod.K, rod.M, T);
  const double cut_off = ritz_values(rod.K, rod.M, T.leftCols(loose))[kept];
  const auto basis = make_basis(rod.model, MeanAxisFrame{}, kept,
                                {.rigid = {rod.start, rod.end}, .interface_modes = InterfaceModes::craig_bampton});
  ASSERT_EQ(basis->mode_count(), kept + 6);  // twelve constraint modes, six of them rigid
  expect_orthonormal(rod.model, *basis);
  EXPECT_LT(test::product(rigid(*basis).transpose() * rod.M, basis->modes).cwiseAbs().maxCoeff(), 1e-10);
  double largest = 0;
  for (int k = 0; k < basis->mode_count(); ++k) {
    const double true_value = exact[6 + k], found = std::pow(kTwoPi * basis->frequencies[k], 2);
    const double excess = found / true_value - 1;
    EXPECT_GT(excess, -1e-9) << k;
    if (true_value < cut_off) {
      EXPECT_LT(excess, 1e-9 + true_value / (cut_off - true_value)) << k;
    }
    if (k < 2) largest = std::max(largest, excess);
  }
  EXPECT_LT(largest, 1e-3);
  EXPECT_GT(largest, 1e-9);  // an approximation after all
  // More modes, all of them better.
  const auto finer = make_basis(rod.model, MeanAxisFrame{}, 2 * kept,
                                {.rigid = {rod.start, rod.end}, .interface_modes = InterfaceModes::craig_bampton});
  for (int k = 0; k < kept; ++k) EXPECT_LE(finer->frequencies[k], basis->frequencies[k] * (1 + 1e-10));
}

TEST(CraigBampton, TheFrameChangesNothingButTheRigidPart) {
  const Rod rod;
  const Reduction ends{.rigid = {rod.start, rod.end}, .interface_modes = InterfaceModes::craig_bampton};
  const auto mean = make_basis(rod.model, MeanAxisFrame{}, 5, ends);
  const int a = 28, b = 55, c = 29;  // nodes between the ends: axes turned against the mesh
  const auto framed = make_basis(rod.model, ThreeNodeFrame{a, b + 4, c}, 5, ends);
  ASSERT_EQ(framed->mode_count(), mean->mode_count());
  EXPECT_EQ(framed->node_modes(framed->node_index(a)).norm(), 0);
  EXPECT_GT((framed->rotation - Matrix3::Identity()).norm(), 0.01);
  const SparseMatrix turn = [&] {
    MatrixX A = MatrixX::Zero(rod.K.rows(), rod.K.rows());
    for (int i = 0; i < rod.model.node_count(); ++i) A.block<3, 3>(3 * i, 3 * i) = framed->rotation;
    return SparseMatrix(A.sparseView());
  }();
  const VectorX first = ritz_values(rod.K, rod.M, with_rigid(*mean)),
                second = ritz_values(rod.K, rod.M, turn * with_rigid(*framed));
  for (int k = 6; k < first.size(); ++k) EXPECT_NEAR(second[k] / first[k], 1, 1e-8) << k;
  // Held by an interface (tangent) and hinged at one: the frequencies of the tied model with that support.
  const MatrixX T = tied(rod);
  const auto clamped = make_basis(rod.model, TangentFrame{rod.start}, 8, ends);
  MatrixX free(T.rows(), T.cols() - 6);
  free << T.leftCols(T.cols() - 12), T.rightCols(6);
  const VectorX exact = ritz_values(rod.K, rod.M, free);
  ASSERT_EQ(clamped->mode_count(), 14);
  for (int k = 0; k < 4; ++k) {
    const double ratio = std::pow(kTwoPi * clamped->frequencies[k], 2) / exact[k];
    EXPECT_GT(ratio, 1 - 1e-9);
    EXPECT_LT(ratio, 1.01) << k;
  }
  const auto hinged = make_basis(rod.model, HingeFrame{{rod.start[0], rod.start[1], rod.start[2]}}, 8, ends);
  EXPECT_TRUE(hinged->free_swing_dropped);
  EXPECT_EQ(hinged->mode_count(), 8 + 6);  // seven constraint modes, the swing one of their combinations
  expect_orthonormal(rod.model, *hinged);
}

TEST(CraigBampton, AveragedInterfacesAreFixedInTheirMeanMotion) {
  const Rod rod;
  MatrixX F(rod.K.rows(), 12);
  F << mean_motion(rod.model, rod.start), mean_motion(rod.model, rod.end);
  const int kept = 8;
  const auto basis = make_basis(rod.model, MeanAxisFrame{}, kept,
                                {.loaded = {{rod.start}, {rod.end}}, .interface_modes = InterfaceModes::craig_bampton});
  ASSERT_EQ(basis->mode_count(), kept + 6);
  expect_orthonormal(rod.model, *basis);
  const VectorX exact = ritz_values(rod.K, rod.M, MatrixX::Identity(rod.K.rows(), rod.K.rows()));
  const double cut_off = ritz_values(rod.K, rod.M, test::complement(F))[kept];
  for (int k = 0; k < basis->mode_count(); ++k) {
    const double found = std::pow(kTwoPi * basis->frequencies[k], 2);
    EXPECT_GT(found / exact[6 + k], 1 - 1e-9) << k;
    if (exact[6 + k] < cut_off) {
      EXPECT_LT(found / exact[6 + k] - 1, 1e-9 + exact[6 + k] / (cut_off - exact[6 + k])) << k;
    }
  }
  // Statics between the ends, loads in balance: exact.
  const MatrixX X = with_rigid(*basis);
  MatrixX load = F.rightCols(6);  // at the end, and what balances it at the start
  const MatrixX motions = rigid_motions(rod.model.nodes, Vector3::Zero());
  load -=
      F.leftCols(6) * test::solve(motions.transpose() * F.leftCols(6), MatrixX(motions.transpose() * F.rightCols(6)));
  // Balanced loads do not feel springs that act on rigid motions alone.
  const MatrixX held = rod.K + rod.K.diagonal().mean() * motions * motions.transpose();
  const MatrixX mesh = load.transpose() * test::solve_positive(held, load);
  const MatrixX body = load.transpose() * basis->modes *
                       VectorX(basis->stiffness.diagonal()).cwiseInverse().asDiagonal() * basis->modes.transpose() *
                       load;
  EXPECT_LT((mesh - body).norm() / mesh.norm(), 1e-9);
}

TEST(CraigBampton, TakesALineOfNodesAsAnInterfaceOfFiveMotions) {
  const Rod rod;
  std::vector<int> edge;  // of the start face, along y
  const double low = rod.model.nodes.row(2).minCoeff();
  for (int id : rod.start)
    if (rod.model.nodes(2, rod.model.node_index(id)) < low + 1e-9) edge.push_back(id);
  ASSERT_GE(edge.size(), 2u);
  const auto basis = make_basis(rod.model, MeanAxisFrame{}, 6,
                                {.loaded = {{edge}, {rod.end}}, .interface_modes = InterfaceModes::craig_bampton});
  EXPECT_EQ(basis->mode_count(), 6 + 5 + 6 - 6);
  expect_orthonormal(rod.model, *basis);
  const VectorX exact = frequencies(rod.model, {}, 9);
  for (int k = 0; k < 3; ++k) {
    EXPECT_GT(basis->frequencies[k], exact[6 + k] * (1 - 1e-9));
    EXPECT_LT(basis->frequencies[k], exact[6 + k] * 1.05);
  }
}

TEST(Attachment, AddsNothingWhereTheFrameHoldsTheInterface) {
  const Rod rod;
  EXPECT_EQ(make_basis(rod.model, TangentFrame{rod.start}, 0, {.loaded = {{rod.start}}})->mode_count(), 0);
}

/// Moments of the compliance about s = 0: Fᵀ (K⁻¹ M)^j K⁻¹ F, the mesh clamped at the start.
TEST(Krylov, TwiceAsManyMomentsOfTheComplianceAsBlocksAreTheMeshes) {
  const Rod rod;
  const int held = 27, n = static_cast<int>(rod.K.rows()) - held;
  const MatrixX K = rod.K.bottomRightCorner(n, n), M = rod.M.bottomRightCorner(n, n);
  const MatrixX F = mean_motion(rod.model, rod.end).bottomRows(n);
  for (int blocks : {1, 2, 3}) {
    const auto basis =
        make_basis(rod.model, TangentFrame{rod.start}, 0,
                   {.loaded = {{rod.end}}, .interface_modes = InterfaceModes::krylov, .krylov_blocks = blocks});
    ASSERT_EQ(basis->mode_count(), 6 * blocks);
    expect_orthonormal(rod.model, *basis);
    const MatrixX b = basis->modes.bottomRows(n).transpose() * F;
    const VectorX lambda = basis->stiffness.diagonal();
    MatrixX x = test::solve_positive(K, F);
    VectorX scale;
    for (int moment = 0; moment <= 2 * blocks; ++moment) {
      const MatrixX mesh = F.transpose() * x;
      const MatrixX body = test::congruence(b, lambda.array().pow(-moment - 1).matrix().asDiagonal());
      // Displacements and rotations in units of their static compliance.
      if (moment == 0) scale = mesh.diagonal().cwiseSqrt().cwiseInverse();
      const double error = (scale.asDiagonal() * (mesh - body) * scale.asDiagonal()).cwiseAbs().maxCoeff() /
                           (scale.asDiagonal() * mesh * scale.asDiagonal()).cwiseAbs().maxCoeff();
      if (moment < 2 * blocks)
        EXPECT_LT(error, 1e-9) << blocks << " blocks, moment " << moment;
      else
        EXPECT_GT(error, blocks == 1 ? 1e-6 : 0) << blocks;  // the first that is not matched
      x = test::solve_positive(K, M * x);
    }
    // The compliance below and near the first resonance, which is not among the modes.
    const double first = ritz_values(K, M, MatrixX::Identity(n, n))[0];
    const MatrixX dynamic = test::product(F.transpose(), test::solve(K - 0.5 * first * M, F));
    const MatrixX reduced = test::congruence(b, (lambda.array() - 0.5 * first).inverse().matrix().asDiagonal());
    EXPECT_LT((dynamic - reduced).norm() / dynamic.norm(), blocks == 1 ? 1e-2 : blocks == 2 ? 1e-6 : 1e-9) << blocks;
  }
}

TEST(Krylov, AFreeBodysVectorsAreWithoutMomentumAndJoinEigenmodes) {
  const Rod rod;
  const auto basis = make_basis(rod.model, MeanAxisFrame{}, 3,
                                {.loaded = {{rod.start}, {rod.end}}, .interface_modes = InterfaceModes::krylov});
  EXPECT_GE(basis->mode_count(), 3 + 20);
  EXPECT_LE(basis->mode_count(), 3 + 24);
  expect_orthonormal(rod.model, *basis);
  const MatrixX by_rigid = rigid(*basis).transpose() * rod.M;
  const double momentum = (by_rigid * basis->modes).cwiseAbs().maxCoeff();
  EXPECT_LT(momentum / (by_rigid.cwiseAbs() * basis->modes.cwiseAbs()).maxCoeff(), 1e-10);  // of what cancels in it
  const auto eigen = make_basis(rod.model, MeanAxisFrame{}, 3);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(basis->frequencies[k] / eigen->frequencies[k], 1, 1e-9);
}

TEST(GivenModes, AreTakenInWithoutTheirRigidPartAndOnlyOnce) {
  const Rod rod;
  const auto eigen = make_basis(rod.model, MeanAxisFrame{}, 4);
  MatrixX given(rod.K.rows(), 9);
  given << eigen->modes, 3 * eigen->modes, rigid_motions(rod.model.nodes, Vector3::Zero()).col(4);
  given.leftCols(4) += 5 * rigid_motions(rod.model.nodes, Vector3(1, 2, 3)).leftCols(4);
  const auto mean = make_basis(rod.model, MeanAxisFrame{}, 0, {.given_modes = given});
  ASSERT_EQ(mean->mode_count(), 4);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(mean->frequencies[k] / eigen->frequencies[k], 1, 1e-9);
  EXPECT_LT(test::product(rigid(*mean).transpose() * rod.M, mean->modes).cwiseAbs().maxCoeff(), 1e-10);
  // In a frame that is turned: the same shapes but for rigid motion.
  const auto framed = make_basis(rod.model, ThreeNodeFrame{1, 59, 2}, 0, {.given_modes = given});
  ASSERT_EQ(framed->mode_count(), 4);
  EXPECT_EQ(framed->node_modes(0).norm(), 0);
  MatrixX turned = with_rigid(*framed);
  for (int i = 0; i < rod.model.node_count(); ++i)
    turned.middleRows<3>(3 * i) = (framed->rotation * turned.middleRows<3>(3 * i)).eval();
  const VectorX lambda = ritz_values(rod.K, rod.M, turned);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(std::sqrt(lambda[6 + k]) / kTwoPi / eigen->frequencies[k], 1, 1e-8);
  expect_error<SceneError>([&] { make_basis(rod.model, MeanAxisFrame{}, 0, {.given_modes = MatrixX::Zero(7, 1)}); },
                           {"7 rows for 189"});
}

// ---- beams: nodes that turn ----

struct Beam {
  double length = 0.6, width = 0.03, height = 0.02;  // m, along x, y, z
  int elements = 12;
  double young = 2.07e11, poisson = 0.3, density = 7800;
  bool rotary = false;  // with the rotary inertia of bending
  double area() const { return width * height; }
  double inertia_y() const { return width * std::pow(height, 3) / 12; }  // bending along z
  double inertia_z() const { return height * std::pow(width, 3) / 12; }
};

/// Two-node Euler-Bernoulli beams along x, consistent mass.
FiniteElementModel beam_model(const Beam& beam) {
  const int n = beam.elements + 1;
  const double l = beam.length / beam.elements, E = beam.young, G = E / 2 / (1 + beam.poisson);
  const double polar = beam.inertia_y() + beam.inertia_z();
  FiniteElementModel model;
  model.name = "beam";
  model.nodes = Matrix3X::Zero(3, n);
  for (int i = 0; i < n; ++i) {
    model.node_ids.push_back(i + 1);
    model.nodes(0, i) = i * l;
    for (int axis = 0; axis < 3; ++axis) model.rotations.push_back({i, axis});
  }
  // Of one element: coordinates (node, translation or rotation, axis).
  const auto place = [&](int element, int node, bool turn, int axis) {
    return (turn ? 3 * n : 0) + 3 * (element + node) + axis;
  };
  std::vector<Eigen::Triplet<double>> stiffness, mass;
  for (int e = 0; e < beam.elements; ++e) {
    const auto rod = [&](bool turn, double k, double m) {
      for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) {
          stiffness.emplace_back(place(e, i, turn, 0), place(e, j, turn, 0), i == j ? k : -k);
          mass.emplace_back(place(e, i, turn, 0), place(e, j, turn, 0), i == j ? m / 3 : m / 6);
        }
    };
    rod(false, E * beam.area() / l, beam.density * beam.area() * l);
    rod(true, 0.8 * G * polar / l, beam.density * polar * l);  // torsion: any stiffness will do
    for (int axis : {1, 2}) {  // deflection along it; the slope is a rotation about z, or minus one about y
      const double I = axis == 1 ? beam.inertia_z() : beam.inertia_y(), sign = axis == 1 ? 1 : -1;
      Eigen::Matrix4d k, m;
      k << 12, 6 * l, -12, 6 * l, 6 * l, 4 * l * l, -6 * l, 2 * l * l, -12, -6 * l, 12, -6 * l, 6 * l, 2 * l * l,
          -6 * l, 4 * l * l;
      m << 156, 22 * l, 54, -13 * l, 22 * l, 4 * l * l, 13 * l, -3 * l * l, 54, 13 * l, 156, -22 * l, -13 * l,
          -3 * l * l, -22 * l, 4 * l * l;
      k *= E * I / std::pow(l, 3);
      m *= beam.density * beam.area() * l / 420;
      if (beam.rotary) {
        Eigen::Matrix4d turn;
        turn << 36, 3 * l, -36, 3 * l, 3 * l, 4 * l * l, -3 * l, -l * l, -36, -3 * l, 36, -3 * l, 3 * l, -l * l, -3 * l,
            4 * l * l;
        m += beam.density * I / (30 * l) * turn;
      }
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
          const auto at = [&](int c) {
            return c % 2 == 0 ? place(e, c / 2, false, axis) : place(e, c / 2, true, 3 - axis);
          };
          const double s = (i % 2 ? sign : 1) * (j % 2 ? sign : 1);
          stiffness.emplace_back(at(i), at(j), s * k(i, j));
          mass.emplace_back(at(i), at(j), s * m(i, j));
        }
    }
  }
  model.stiffness.resize(model.dof_count(), model.dof_count());
  model.mass.resize(model.dof_count(), model.dof_count());
  model.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
  model.mass.setFromTriplets(mass.begin(), mass.end());
  return model;
}

TEST(BeamModel, HasTheFrequenciesOfTheTheoryClampedAndFree) {
  const Beam beam;
  const FiniteElementModel model = beam_model(beam);
  const ModelCheck sheet = check(model);
  EXPECT_NEAR(sheet.mass, beam.density * beam.area() * beam.length, 1e-12);
  EXPECT_NEAR(sheet.center.x(), 0.3, 1e-14);
  EXPECT_NEAR(sheet.inertia(2, 2) / (sheet.mass * 0.36 / 12), 1, 1e-12);
  EXPECT_NE(sheet.report().find("39 nodal rotations"), std::string::npos);
  EXPECT_NE(sheet.report().find("no scalar interpolation"), std::string::npos);
  const auto bending = [&](double root, double I) {
    return root * root / kTwoPi * std::sqrt(beam.young * I / (beam.density * beam.area() * std::pow(beam.length, 4)));
  };
  const auto clamped = make_basis(model, TangentFrame{{1}}, 4);
  EXPECT_NEAR(clamped->frequencies[0] / bending(1.8751040687, beam.inertia_y()), 1, 1e-6);
  EXPECT_NEAR(clamped->frequencies[1] / bending(1.8751040687, beam.inertia_z()), 1, 1e-6);
  // Twelve elements: (root / 12)⁴ / 1440 too high.
  EXPECT_NEAR(clamped->frequencies[2] / bending(4.6940911330, beam.inertia_y()), 1, 1.8e-5);
  EXPECT_EQ(clamped->node_modes(0).norm() + clamped->node_rotation_modes(0).norm(), 0);
  const auto free = make_basis(model, MeanAxisFrame{}, 4);
  EXPECT_NEAR(free->frequencies[0] / bending(4.7300407449, beam.inertia_y()), 1, 1.8e-5);
  EXPECT_NEAR(free->frequencies[1] / bending(4.7300407449, beam.inertia_z()), 1, 1.8e-5);
  EXPECT_LT(free->integrals.Ct.cwiseAbs().maxCoeff() + free->integrals.C0.cwiseAbs().maxCoeff(), 1e-12);
  // Bending modes turn the nodes: the slope of neighbours' deflections.
  const Vector3 turn = clamped->node_rotation_modes(6).col(0);
  const double slope = (clamped->node_modes(7)(2, 0) - clamped->node_modes(5)(2, 0)) / 0.1;
  EXPECT_NEAR(-turn.y() / slope, 1, 5e-3);
  expect_error<SceneError>([&] { make_basis(model, TangentFrame{{1}}, kAllNodal); }, {"scalar interpolation"});
}

TEST(BeamModel, MayLieAskewToItsFrameIfItsNodesHaveAllRotations) {
  const Beam beam;
  FiniteElementModel model = beam_model(beam);
  // A bent rod: the second half turned up, so that three nodes make a frame.
  const auto straight = make_basis(model, MeanAxisFrame{}, 6);
  const Matrix3 turn = rotation_about({1, 2, -1}, 0.8);
  MatrixX A = MatrixX::Zero(model.dof_count(), model.dof_count());
  for (int i = 0; i < 2 * model.node_count(); ++i) A.block<3, 3>(3 * i, 3 * i) = turn;
  model.nodes = turn * model.nodes;
  model.stiffness = (A * model.stiffness * A.transpose()).sparseView(1, 1e-14);
  model.mass = (A * model.mass * A.transpose()).sparseView(1, 1e-14);
  model.stiffness = SparseMatrix(0.5 * (model.stiffness + SparseMatrix(model.stiffness.transpose())));
  model.mass = SparseMatrix(0.5 * (model.mass + SparseMatrix(model.mass.transpose())));
  const auto turned = make_basis(model, MeanAxisFrame{}, 6);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(turned->frequencies[k] / straight->frequencies[k], 1, 1e-8);
  const auto hinged = make_basis(model, HingeFrame{{1}}, 4, {.rigid = {{12, 13}}, .loaded = {{{12, 13}}}});
  EXPECT_EQ(hinged->node_modes(0).norm(), 0);
  EXPECT_GT(hinged->node_rotation_modes(0).norm(), 1e-3);  // a pin lets the node turn
  EXPECT_LT((hinged->node_rotation_modes(11) - hinged->node_rotation_modes(12)).norm(),
            1e-12 * hinged->node_rotation_modes(12).norm());
}

TEST(BeamModel, PartOfItsRotationsCannotBeTurned) {
  // A slab of bricks with one nodal rotation more, about x alone: fine in mesh axes, not in turned ones.
  const Rod rod;
  FiniteElementModel model = rod.model;
  model.rotations = {{4, 0}};
  const int n = static_cast<int>(rod.K.rows());
  model.stiffness.conservativeResize(n + 1, n + 1);
  model.mass.conservativeResize(n + 1, n + 1);
  // A light disc that turns with the z motion of its neighbour in y.
  const int a = 3 * 4 + 2, b = 3 * 5 + 2;
  const double gap = rod.model.nodes(1, 5) - rod.model.nodes(1, 4), k = 1e3;
  MatrixX row = MatrixX::Zero(n + 1, 1);
  row(n) = 1, row(b) = -1 / gap, row(a) = 1 / gap;
  model.stiffness = SparseMatrix(model.stiffness + SparseMatrix((k * row * row.transpose()).sparseView()));
  model.mass.coeffRef(n, n) = 1e-6;
  EXPECT_NO_THROW(make_basis(model, MeanAxisFrame{}, 3));
  expect_error<SceneError>([&] { make_basis(model, ThreeNodeFrame{1, 59, 2}, 3); }, {"node 5", "all three rotations"});
  model.rotations = {{4, 3}};
  expect_error<SceneError>([&] { check(model); }, {"axis 3"});
}

TEST(BeamModel, InFreeFlightKeepsEnergyAndMomentaAndOwesWhatEveryBodyOwes) {
  const Beam beam{.elements = 4, .young = 2e10};
  const auto basis = make_basis(beam_model(beam), MeanAxisFrame{}, 4);
  const double mass = beam.density * beam.area() * beam.length;
  {
    SystemGraph graph{{.gravity = {1, 2, -9.81}}};
    auto& body = graph.add<FlexibleBody>("beam", {.basis = basis});
    check_body(graph, body, {body.node(5)}, {.mass = mass, .speed = 3, .deformation = 1e-3, .tolerance = 1e-7});
  }
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  FlexibleBody::Parameters parameters{.basis = basis, .velocity = {0.3, -0.2, 0.1}, .angular_velocity = {8, 5, -6}};
  parameters.modal_coordinates = 3e-4 * VectorX::LinSpaced(4, -1, 1);
  auto& body = graph.add<FlexibleBody>("beam", parameters);
  const System system = assemble(graph);
  Evaluator equations(system);
  State state = system.initial_state();
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-11, .absolute = 1e-13}});
  integrator.start(equations, state);
  const auto observe = [&] {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    const BodyState s = body_state(equations, body);
    VectorX seen(7);
    seen << equations.energy().total(), body.linear_momentum(s), body.angular_momentum(s);
    return seen;
  };
  const VectorX before = observe();
  while (state.time < 0.2) ASSERT_TRUE(integrator.step(equations, state, 0.2).ok());
  const VectorX after = observe();
  EXPECT_NEAR(after[0] / before[0], 1, 1e-8);
  EXPECT_LT((after.segment<3>(1) - before.segment<3>(1)).norm(), 1e-8 * before.segment<3>(1).norm());
  EXPECT_LT((after.tail<3>() - before.tail<3>()).norm(), 1e-8 * before.tail<3>().norm());
}

/// Height of the free end of a rod that falls from the horizontal about a pin at the origin, y across.
double fallen_tip(const std::shared_ptr<const ModalBasis>& basis, const std::vector<int>& root,
                  const std::vector<int>& tip, double time) {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  auto& body = graph.add<FlexibleBody>("rod", {.basis = basis});
  const Matrix3 axis = rotation_about({1, 0, 0}, std::numbers::pi / 2);  // z to -y
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, axis),
                                   root.size() == 1 ? body.node(root[0], axis) : body.average(root, axis)});
  const Marker end = tip.size() == 1 ? body.node(tip[0]) : body.average(tip);
  const System system = assemble(graph);
  Evaluator equations(system);
  State state = system.initial_state();
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-8, .absolute = 1e-10}});
  integrator.start(equations, state);
  while (state.time < time) EXPECT_TRUE(integrator.step(equations, state, time).ok());
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  return marker_kinematics(equations, end, Level::position).p.z();
}

TEST(BeamModel, SwingsAsTheRodOfBricksDoes) {
  // Soft enough that the rod's bending shows: the rigid rod's tip is elsewhere.
  const Beam beam{.elements = 16, .young = 2e8, .rotary = true};
  const Bar bar{.size = {beam.length, beam.width, beam.height}, .bricks = {24, 2, 2}, .young = beam.young};
  const FiniteElementModel bricks = bar_model(bar), beams = beam_model(beam);
  const auto solid = make_basis(bricks, TangentFrame{bricks.node_set("start")}, 2);
  const auto slim = make_basis(beams, TangentFrame{{1}}, 2);
  const auto stiff = make_basis(beams, TangentFrame{{1}}, 0);
  for (double time : {0.1, 0.25}) {
    const double of_bricks = fallen_tip(solid, bricks.node_set("start"), bricks.node_set("end"), time);
    const double of_beams = fallen_tip(slim, {1}, {17}, time), of_rigid = fallen_tip(stiff, {1}, {17}, time);
    EXPECT_NEAR(of_beams, of_bricks, 0.03 * std::abs(of_rigid - of_bricks)) << time;
    EXPECT_GT(std::abs(of_rigid - of_bricks), 1e-3);
  }
}

TEST(CondensedModel, IsAcceptedWithANoteAndKeepsItsRigidInertia) {
  // Guyan: the nodes between the ends and the middle eliminated by statics.
  const Rod rod;
  std::vector<int> kept, gone;
  FiniteElementModel model;
  model.name = "superelement";
  for (int i = 0; i < rod.model.node_count(); ++i) {
    const bool keeps = std::fmod(rod.model.nodes(0, i) + 1e-9, 0.1) < 1e-3;
    if (keeps) model.node_ids.push_back(i + 1);
    for (int axis = 0; axis < 3; ++axis) (keeps ? kept : gone).push_back(3 * i + axis);
  }
  MatrixX G = MatrixX::Zero(rod.K.rows(), static_cast<Eigen::Index>(kept.size()));
  G(kept, Eigen::all).setIdentity();
  G(gone, Eigen::all) = -test::solve_positive(rod.K(gone, gone), rod.K(gone, kept));
  const auto symmetric = [](const MatrixX& A) { return SparseMatrix((0.5 * (A + A.transpose())).sparseView()); };
  model.stiffness = symmetric(test::congruence(G, rod.K));
  model.mass = symmetric(test::congruence(G, rod.M));
  model.damping = 1e-5 * model.stiffness;
  model.nodes.resize(3, static_cast<Eigen::Index>(model.node_ids.size()));
  for (size_t k = 0; k < model.node_ids.size(); ++k)
    model.nodes.col(static_cast<Eigen::Index>(k)) = rod.model.nodes.col(model.node_ids[k] - 1);

  const ModelCheck sheet = require_sound(model);
  EXPECT_GT(sheet.mass_isotropy, 1e-3);
  EXPECT_NE(sheet.report().find("note: M is no scalar interpolation"), std::string::npos);
  const auto whole = make_basis(rod.model, MeanAxisFrame{}, 3), part = make_basis(model, MeanAxisFrame{}, 3);
  EXPECT_NEAR(part->integrals.mass / whole->integrals.mass, 1, 1e-12);
  EXPECT_LT((part->integrals.J0 - whole->integrals.J0).norm() / whole->integrals.J0.norm(), 1e-9);
  EXPECT_LT((part->origin - whole->origin).norm(), 1e-12);
  EXPECT_LT(part->integrals.Ct.cwiseAbs().maxCoeff(), 1e-12);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(part->frequencies[k] / whole->frequencies[k], 1, 0.02) << k;
  // The damping comes along, proportional as it was given.
  EXPECT_LT((part->damping - 1e-5 * MatrixX(part->stiffness)).cwiseAbs().maxCoeff(),
            1e-9 * part->damping.cwiseAbs().maxCoeff());
  // How inertia changes with deformation: bending, free of momentum, does not change it at first order.
  EXPECT_LT((part->integrals.J1.cwiseAbs() - whole->integrals.J1.cwiseAbs()).norm(),
            0.02 * std::sqrt(whole->integrals.J0.maxCoeff()));
  SystemGraph graph{{.gravity = {1, 2, -9.81}}};
  auto& body = graph.add<FlexibleBody>("rod", {.basis = part});
  check_body(graph, body, {body.average({1, 3, 7, 9})},
             {.mass = sheet.mass, .speed = 3, .deformation = 1e-3, .dissipation = 1, .tolerance = 1e-7});
}

}  // namespace
}  // namespace lithe::test::fe_reduction_methods_test
