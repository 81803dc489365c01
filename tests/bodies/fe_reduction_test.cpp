#include "bodies/flexible/reduction.h"

#include <numbers>

#include "bodies/flexible/eigen_modes.h"
#include "bodies/flexible/inertia_integrals.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::fe_reduction_test {
namespace {

using test::expect_error;
using test::pendulum;

const FiniteElementModel& model_of(const std::string& body) {
  static std::map<std::string, FiniteElementModel> models;
  if (!models.count(body)) models[body] = pendulum(body);
  return models[body];
}

ThreeNodeFrame three_node(const FiniteElementModel& model, const std::string& set) {
  const auto& ids = model.node_set(set);
  return {ids.at(0), ids.at(1), ids.at(2)};
}

BodyFrame frame_of_column(const FiniteElementModel& model, const std::string& column) {
  if (column == "free") return MeanAxisFrame{};
  if (column == "hinged") return HingeFrame{model.node_set("hinge")};
  if (column == "clamped") return TangentFrame{model.node_set("root_face")};
  return three_node(model, "frame" + std::string(1, static_cast<char>(std::tolower(column.back()))));
}

/// |Bᵀ S B - E|, S from the scalar mass.
double orthonormality(const ModalBasis& basis) {
  MatrixX Mff = MatrixX::Zero(basis.mode_count(), basis.mode_count());
  for (int axis = 0; axis < 3; ++axis) {
    const MatrixX B = basis.modes(Eigen::seqN(axis, basis.nodes.cols(), 3), Eigen::all);
    Mff += test::congruence(B, basis.nodal_mass);
  }
  return (Mff - MatrixX(basis.modal_mass)).cwiseAbs().maxCoeff();
}

TEST(Reduction, FrequenciesAgreeWithTheReferenceForEverySupport) {
  for (const char* body : {"hex8i", "hex20", "paper", "stiff"}) {
    const FiniteElementModel& model = model_of(body);
    const auto reference = test::csv_columns(test::pendulum_path(body, "frequencies.csv"));
    double worst = 0, worst_calculix = 0;
    for (const char* column : {"free", "hinged", "clamped", "frameA", "frameB", "frameC"}) {
      const auto& hz = reference.at(column);
      const auto& calculix = reference.at(std::string(column) + "_calculix");
      const size_t zero = std::string(column) == "free" ? 6 : std::string(column) == "hinged" ? 1 : 0;
      const auto basis = make_basis(model, frame_of_column(model, column), static_cast<int>(hz.size() - zero));
      for (size_t k = zero; k < hz.size(); ++k) {
        const double f = basis->frequencies[static_cast<Eigen::Index>(k - zero)];
        worst = std::max(worst, std::abs(f / hz[k] - 1));
        if (k < calculix.size()) worst_calculix = std::max(worst_calculix, std::abs(f / calculix[k] - 1));
      }
      EXPECT_LT(orthonormality(*basis), 1e-13) << body << " " << column;
      EXPECT_EQ(basis->free_swing_dropped, std::string(column) == "hinged");
      EXPECT_TRUE(basis->diagonal);
    }
    EXPECT_LT(worst, 1e-9) << body;
    EXPECT_LT(worst_calculix, 1e-6) << body;
    RecordProperty(std::string(body) + "_worst", std::to_string(worst * 1e12) + "e-12");
    std::printf("%s: worst relative deviation %.1e, from CalculiX %.1e\n", body, worst, worst_calculix);
  }
}

TEST(Reduction, FrequenciesWithoutABasisCountRigidMotionsAsZero) {
  const FiniteElementModel& model = model_of("hex8i");
  const auto reference = test::csv_columns(test::pendulum_path("hex8i", "frequencies.csv"));
  const VectorX free = frequencies(model, {}, 12);
  const VectorX hinged = frequencies(model, {0, 1, 2, 3, 4, 5, 6, 7, 8}, 12);
  const VectorX pinned = frequencies(model, {0, 1, 2}, 5);
  for (int k = 0; k < 12; ++k) {
    EXPECT_NEAR(free[k], reference.at("free")[static_cast<size_t>(k)], 1e-9 * free[11]) << k;
    EXPECT_NEAR(hinged[k], reference.at("hinged")[static_cast<size_t>(k)], 1e-9 * hinged[11]) << k;
  }
  EXPECT_EQ(free.head(6).norm(), 0.0);
  EXPECT_EQ(hinged[0], 0.0);
  EXPECT_EQ(pinned.head(3).norm(), 0.0);
  EXPECT_GT(pinned[3], 1.0);
}

TEST(Reduction, AThreeNodeFrameHoldsItsSixConditions) {
  const FiniteElementModel& model = model_of("hex8i");
  // Tilted against the mesh axes: origin, a far corner, a node of the top.
  const auto basis = make_basis(model, ThreeNodeFrame{1, 54, 52}, 9);
  EXPECT_LT((basis->rotation.transpose() * basis->rotation - Matrix3::Identity()).norm(), 1e-15);
  EXPECT_NEAR(basis->rotation.determinant(), 1.0, 1e-15);
  EXPECT_EQ(basis->nodes.col(0).norm(), 0.0);
  EXPECT_EQ(basis->nodes.col(53).tail<2>().norm(), 0.0);
  EXPECT_EQ(basis->nodes(2, 51), 0.0);
  EXPECT_GT(basis->nodes(0, 53), 0.0);
  EXPECT_EQ(basis->node_modes(0).norm(), 0.0);
  EXPECT_EQ(basis->node_modes(53).bottomRows<2>().norm(), 0.0);
  EXPECT_EQ(basis->node_modes(51).row(2).norm(), 0.0);
  EXPECT_GT(basis->node_modes(53).row(0).norm(), 0.0);
  // Back in mesh axes every node is where it was.
  EXPECT_LT(((basis->rotation * basis->nodes).colwise() + basis->origin - model.nodes).norm(), 1e-15);
}

TEST(Reduction, StiffnessTurnsWithTheBodyFrame) {
  // Bᵀ K B in body axes is the energy of the same displacement in mesh axes (18).
  const FiniteElementModel& model = model_of("hex8i");
  const auto basis = make_basis(model, ThreeNodeFrame{1, 54, 52}, 12);
  MatrixX mesh_modes(162, 12);
  for (int i = 0; i < 54; ++i) mesh_modes.middleRows<3>(3 * i) = basis->rotation * basis->node_modes(i);
  const MatrixX K = test::congruence(mesh_modes, model.stiffness);
  EXPECT_LT((K - MatrixX(basis->stiffness)).norm() / K.norm(), 1e-12);
}

TEST(Reduction, MeanAxisModesCarryNoMomentum) {
  const FiniteElementModel& model = model_of("hex8i");
  const auto basis = make_basis(model, MeanAxisFrame{}, 20);
  EXPECT_LT((basis->origin - Vector3(0.05, 0.005, 0.0075)).norm(), 1e-15);
  EXPECT_EQ(basis->rotation, Matrix3::Identity());
  const InertiaIntegrals inertia = inertia_integrals(*basis);
  // Natural scales: sqrt(m Mff) and sqrt(J Mff), Mff = 1.
  EXPECT_LT(inertia.Ct.cwiseAbs().maxCoeff() / std::sqrt(0.26), 1e-15 * 10);
  EXPECT_LT(inertia.C0.cwiseAbs().maxCoeff() / std::sqrt(inertia.J0[1]), 1e-15 * 10);
  EXPECT_LT(inertia.s0.norm() / (0.26 * 0.1), 1e-14);
}

TEST(Reduction, HingeModesAreOrthogonalToTheSwingThatWasDropped) {
  const FiniteElementModel& model = model_of("hex8i");
  const auto basis = make_basis(model, HingeFrame{model.node_set("hinge")}, 9);
  EXPECT_TRUE(basis->free_swing_dropped);
  EXPECT_LT((basis->origin - Vector3(0, 0.005, 0)).norm(), 1e-17);
  const InertiaIntegrals inertia = inertia_integrals(*basis);
  EXPECT_LT(inertia.C0.row(1).cwiseAbs().maxCoeff() / std::sqrt(inertia.J0[1]), 1e-14);  // swing about y
  for (int id : model.node_set("hinge")) EXPECT_EQ(basis->node_modes(basis->node_index(id)).norm(), 0.0);
}

TEST(Reduction, OnePinnedNodeLeavesThreeTurnsAndAFaceLeavesNone) {
  const FiniteElementModel& model = model_of("hex8i");
  const auto ball = make_basis(model, HingeFrame{{1}}, 3);
  EXPECT_TRUE(ball->free_swing_dropped);
  const VectorX pinned = frequencies(model, {0, 1, 2}, 6);
  EXPECT_LT((ball->frequencies - pinned.tail(3)).norm(), 1e-9);
  const auto face = make_basis(model, HingeFrame{model.node_set("root_face")}, 3);
  EXPECT_FALSE(face->free_swing_dropped);
  EXPECT_NEAR(face->frequencies[0], 4.191127617185, 1e-8);
}

TEST(Reduction, ASingleTangentNodeClampsItsElements) {
  const FiniteElementModel& model = model_of("hex8i");
  const auto basis = make_basis(model, TangentFrame{{2}}, 4);  // middle of the edge: two elements, twelve nodes
  for (int node = 0; node < 12; ++node) EXPECT_EQ(basis->node_modes(node).norm(), 0.0) << node;
  EXPECT_GT(basis->node_modes(12).norm(), 0.0);
  EXPECT_LT((basis->origin - model.nodes.col(1)).norm(), 1e-17);
  FiniteElementModel bare = model;
  bare.elements.clear();
  expect_error<SceneError>([&] { make_basis(bare, TangentFrame{{2}}, 4); }, {"elements around it", "three or more"});
}

TEST(Reduction, ModesAreTheSameInSignEveryTime) {
  const FiniteElementModel& model = model_of("hex8i");
  const auto few = make_basis(model, three_node(model, "framea"), 3);
  const auto many = make_basis(model, three_node(model, "framea"), 80);  // by the dense solver
  EXPECT_LT((few->modes - many->modes.leftCols(3)).cwiseAbs().maxCoeff() / few->modes.cwiseAbs().maxCoeff(), 1e-8);
  for (int k = 0; k < 80; ++k) {
    const double top = many->modes.col(k).maxCoeff(), bottom = -many->modes.col(k).minCoeff();
    EXPECT_GE(top, bottom * (1 - 2e-6)) << k;
  }
}

TEST(Reduction, AllModesOfAFrameSpanAllItsNodalCoordinates) {
  const FiniteElementModel& model = model_of("hex8i");
  const auto modal = make_basis(model, three_node(model, "framea"), 156);
  const auto nodal = make_basis(model, three_node(model, "framea"), kAllNodal);
  EXPECT_LT(orthonormality(*modal), 1e-12);
  ASSERT_EQ(nodal->mode_count(), 156);
  EXPECT_TRUE(nodal->nodal);
  EXPECT_EQ(nodal->modes.size(), 0);
  const VectorX exact = test::symmetric_eigenvalues(nodal->stiffness, nodal->modal_mass);
  const double two_pi = 2 * std::numbers::pi;
  const VectorX eigenvalues = (two_pi * modal->frequencies).array().square();
  EXPECT_LT(((exact - eigenvalues).array() / exact.array()).abs().maxCoeff(), 1e-8);
}

TEST(Reduction, NodalCoordinatesOfAFrameAreThoseItLeavesFree) {
  const FiniteElementModel& model = model_of("hex8i");
  EXPECT_EQ(make_basis(model, three_node(model, "framea"), kAllNodal)->mode_count(), 162 - 6);
  EXPECT_EQ(make_basis(model, TangentFrame{model.node_set("root_face")}, kAllNodal)->mode_count(), 162 - 18);
  // The hinge: nine rows of the edge and one that holds the swing, z or x of a node of the far top edge.
  const auto hinge = make_basis(model, HingeFrame{model.node_set("hinge")}, kAllNodal);
  EXPECT_EQ(hinge->mode_count(), 162 - 10);
  std::vector<int> held;
  for (int dof = 9; dof < 162; ++dof)
    if (!std::binary_search(hinge->free_dofs.begin(), hinge->free_dofs.end(), dof)) held.push_back(dof);
  ASSERT_EQ(held.size(), 1u);
  EXPECT_GE(held[0] / 3, 48);
  EXPECT_EQ(held[0] % 3, 2);
  EXPECT_EQ(make_basis(model, HingeFrame{{1}}, kAllNodal)->mode_count(), 162 - 6);

  const auto basis = make_basis(model, three_node(model, "framea"), kAllNodal);
  const Matrix3X B = basis->node_modes(12);  // node 13, on the x axis: free in x only
  EXPECT_EQ(B.cwiseAbs().sum(), 1.0);
  EXPECT_EQ(B.row(0).sum(), 1.0);
  expect_error<SceneError>([&] { make_basis(model, MeanAxisFrame{}, kAllNodal); }, {"mean axes", "ThreeNodeFrame"});
}

TEST(Reduction, NoModesMakeARigidBody) {
  const auto basis = make_basis(model_of("hex8i"), MeanAxisFrame{}, 0);
  EXPECT_EQ(basis->mode_count(), 0);
  EXPECT_EQ(basis->modes.rows(), 162);
  EXPECT_EQ(basis->node_modes(3).cols(), 0);
  EXPECT_EQ(basis->nodes.cols(), 54);
  EXPECT_NEAR(inertia_integrals(*basis).mass, 0.26, 1e-14);
}

TEST(Reduction, CalculixFilesGiveTheFrequenciesOfTheMatrices) {
  const auto model = test::pendulum_from_calculix("hex8i");
  const auto reference = test::csv_columns(test::pendulum_path("hex8i", "frequencies.csv"));
  const auto basis = make_basis(model, three_node(model, "framea"), 20);
  for (int k = 0; k < 20; ++k)
    EXPECT_NEAR(basis->frequencies[k] / reference.at("frameA")[static_cast<size_t>(k)], 1, 1e-9) << k;
}

TEST(Reduction, LanczosMissesNoMultipleEigenvalue) {
  // Two equal bodies in one problem: every eigenvalue is double, and one start vector would see each once.
  const FiniteElementModel& model = model_of("hex8i");
  const auto single = make_basis(model, TangentFrame{model.node_set("root_face")}, 6);
  const int n = 162 - 18;
  std::vector<Eigen::Triplet<double>> k_entries, m_entries;
  const auto twice = [&](const SparseMatrix& A, auto& entries) {
    for (int j = 0; j < A.outerSize(); ++j)
      for (SparseMatrix::InnerIterator e(A, j); e; ++e)
        for (int copy = 0; copy < 2; ++copy)
          if (e.row() >= 18 && j >= 18)
            entries.emplace_back(static_cast<int>(e.row()) - 18 + copy * n, j - 18 + copy * n, e.value());
  };
  twice(model.stiffness, k_entries);
  twice(model.mass, m_entries);
  SparseMatrix K(2 * n, 2 * n), M(2 * n, 2 * n);
  K.setFromTriplets(k_entries.begin(), k_entries.end());
  M.setFromTriplets(m_entries.begin(), m_entries.end());
  for (int count : {1, 2, 3, 4, 7, 12}) {
    const EigenModes modes = lowest_modes(K, M, MatrixX(2 * n, 0), count, "two bars", EigenMethod::lanczos);
    for (int k = 0; k < count; ++k) {
      const double hz = std::sqrt(modes.eigenvalues[k]) / (2 * std::numbers::pi);
      EXPECT_NEAR(hz / single->frequencies[k / 2], 1, 1e-10) << count << " " << k;
    }
  }
}

TEST(Reduction, FrameNodesOnOneLineAreRefused) {
  expect_error<SceneError>(
      [] {
        make_basis(model_of("hex8i"), ThreeNodeFrame{1, 2, 3}, 4);
      },
      {"on one line", "three-node frame (1, 2, 3)", "third node"});
  expect_error<SceneError>([] { make_basis(model_of("hex8i"), ThreeNodeFrame{1, 1, 3}, 4); }, {"on one line"});
}

TEST(Reduction, AFrameNodeThatIsMissingIsRefused) {
  expect_error<SceneError>([] { make_basis(model_of("hex8i"), ThreeNodeFrame{1, 13, 99}, 4); }, {"no node 99"});
  expect_error<SceneError>([] { make_basis(model_of("hex8i"), HingeFrame{}, 4); }, {"names no node"});
}

TEST(Reduction, MoreModesThanCoordinatesAreRefused) {
  const FiniteElementModel& model = model_of("hex8i");
  expect_error<SceneError>([&] { make_basis(model, three_node(model, "framea"), 157); }, {"157 modes", "at most 156"});
  expect_error<SceneError>([&] { make_basis(model, HingeFrame{model.node_set("hinge")}, 153); }, {"at most 152"});
  expect_error<SceneError>([&] { make_basis(model, MeanAxisFrame{}, 157); }, {"at most 156"});
  expect_error<SceneError>([&] { make_basis(model, MeanAxisFrame{}, -2); }, {"mode count is -2"});
}

TEST(Reduction, APinThatLeavesAMechanismIsRefused) {
  const FiniteElementModel& model = model_of("hex8i");
  expect_error<SceneError>([&] { make_basis(model, TangentFrame{model.node_set("hinge")}, 4); },
                           {"mechanism", "HingeFrame"});
  // Two rods that do not touch, only one of them held.
  FiniteElementModel two = model;
  two.nodes.conservativeResize(3, 108);
  two.nodes.rightCols(54) = model.nodes.colwise() + Vector3(0, 0.05, 0);
  for (int i = 0; i < 54; ++i) two.node_ids.push_back(55 + i);
  const auto doubled = [](const SparseMatrix& A) {
    MatrixX both = MatrixX::Zero(324, 324);
    both.topLeftCorner(162, 162) = MatrixX(A);
    both.bottomRightCorner(162, 162) = MatrixX(A);
    return SparseMatrix(both.sparseView());
  };
  two.stiffness = doubled(model.stiffness);
  two.mass = doubled(model.mass);
  for (int count : {4, 200, kAllNodal})
    expect_error<SceneError>([&] { make_basis(two, TangentFrame{model.node_set("root_face")}, count); },
                             {"mechanism", "unconnected pieces"});
}

TEST(Reduction, ABasisFromModesKeepsWhatItIsGiven) {
  const FiniteElementModel& model = model_of("hex8i");
  const auto source = make_basis(model, three_node(model, "framea"), 5);
  MatrixX modes = source->modes;
  modes.col(1) += 0.5 * modes.col(0);  // no longer orthogonal
  const auto basis = basis_from_modes("given", source->nodes, source->nodal_mass, model.stiffness, modes);
  EXPECT_EQ(basis->modes, modes);
  EXPECT_FALSE(basis->diagonal);
  EXPECT_NEAR(basis->modal_mass.coeff(0, 1), 0.5, 1e-12);
  EXPECT_NEAR(basis->modal_mass.coeff(1, 1), 1.25, 1e-12);
  EXPECT_LT((basis->frequencies - source->frequencies).norm() / source->frequencies.norm(), 1e-9);
  EXPECT_EQ(basis->node_index(7), 6);
  const auto again = basis_from_modes("given", source->nodes, source->nodal_mass, basis->stiffness, modes);
  EXPECT_EQ(MatrixX(again->stiffness), MatrixX(basis->stiffness));
  const auto same = basis_from_modes("same", source->nodes, source->nodal_mass, source->stiffness, source->modes);
  EXPECT_TRUE(same->diagonal);

  modes.col(2) = modes.col(0);
  expect_error<SceneError>(
      [&] { basis_from_modes("given", source->nodes, source->nodal_mass, model.stiffness, modes); },
      {"not positive definite", "independent"});
  expect_error<SceneError>(
      [&] { basis_from_modes("given", source->nodes, source->nodal_mass, SparseMatrix(4, 4), modes); }, {"4 x 4"});
}

}  // namespace
}  // namespace lithe::test::fe_reduction_test
