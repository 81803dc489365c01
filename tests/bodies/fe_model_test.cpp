#include "bodies/flexible/finite_element_model.h"

#include "bodies/flexible/reduction.h"
#include "tests/bodies/fe_models.h"

namespace lithe::test::fe_model_test {
namespace {

using test::expect_error;
using test::pendulum;

FiniteElementModel hex8i() {
  static const FiniteElementModel model = pendulum("hex8i");
  return model;
}

TEST(FiniteElementModel, TheCheckFindsMassCentreAndInertiaOfTheRod) {
  for (const char* body : {"hex8i", "hex20", "paper", "stiff"}) {
    const ModelCheck found = check(pendulum(body));
    // 0.1 x 0.01 x 0.015 m, 0.26 kg.
    EXPECT_NEAR(found.mass, 0.26, 1e-14) << body;
    EXPECT_LT((found.center - Vector3(0.05, 0.005, 0.0075)).norm(), 1e-15) << body;
    const double m12 = 0.26 / 12;
    const Vector3 inertia(m12 * (1e-4 + 2.25e-4), m12 * (1e-2 + 2.25e-4), m12 * (1e-2 + 1e-4));
    EXPECT_LT((found.inertia - Matrix3(inertia.asDiagonal())).cwiseAbs().maxCoeff(), 1e-17) << body;
    for (double residual : found.rigid_residual) EXPECT_LT(residual, 1e-13) << body;
    EXPECT_LT(found.mass_isotropy, 1e-15) << body;
    EXPECT_LT(found.row_sum_deviation, 1e-13) << body;
    EXPECT_TRUE(found.mass_positive) << body;
    EXPECT_EQ(found.stiffness_negative, 0) << body;
  }
}

TEST(FiniteElementModel, FourteenPrintedDigitsAreSoundEnough) {
  for (const char* body : {"hex8i", "hex20", "paper", "stiff"})
    EXPECT_NO_THROW(require_sound(test::pendulum_from_calculix(body))) << body;
}

TEST(FiniteElementModel, TheReportReadsAsASheet) {
  const std::string report = check(hex8i()).report();
  for (const char* text : {"54 nodes", "0.26 kg", "centre of mass", "0.05 0.005 0.0075 m", "K asymmetry", "ok"})
    EXPECT_NE(report.find(text), std::string::npos) << report;
  EXPECT_EQ(report.find("REFUSED"), std::string::npos) << report;
}

TEST(FiniteElementModel, ANodeIsFoundByItsLabelInAnyOrder) {
  FiniteElementModel model = hex8i();
  EXPECT_EQ(model.node_index(50), 49);
  std::swap(model.node_ids[3], model.node_ids[40]);
  EXPECT_EQ(model.node_index(4), 40);
  EXPECT_EQ(model.node_index(41), 3);
  model.node_ids[53] = 900;
  EXPECT_EQ(model.node_index(900), 53);
}

TEST(FiniteElementModel, AMissingNodeNamesTheNearestLabels) {
  expect_error<SceneError>([] { hex8i().node_index(60); }, {"no node 60", "hex8i", "54, 53, 52"});
}

TEST(FiniteElementModel, AnUnknownNodeSetListsTheKnownOnes) {
  expect_error<SceneError>([] { hex8i().node_set("hinges"); }, {"no node set 'hinges'", "hinge", "tip_top", "framea"});
}

TEST(FiniteElementModel, NothingIsLostInANodeSet) {
  EXPECT_EQ(hex8i().node_set("framea"), (std::vector<int>{1, 13, 2}));  // order matters: origin, on x, in xy
  EXPECT_EQ(hex8i().node_set("root_face").size(), 6u);
}

TEST(FiniteElementModel, ZeroMassIsRefused) {
  FiniteElementModel model = hex8i();
  model.mass *= 0;
  expect_error<SceneError>([&] { require_sound(model); }, {"the mass is 0 kg", "density"});
}

TEST(FiniteElementModel, ANodeWithoutMassIsRefused) {
  FiniteElementModel model = hex8i();
  model.mass.prune([](int row, int column, double) { return row / 3 != 7 && column / 3 != 7; });
  expect_error<SceneError>([&] { require_sound(model); }, {"mass matrix is not positive definite", "every node"});
}

TEST(FiniteElementModel, IndefiniteStiffnessIsRefusedAndItsNegativeEigenvaluesCounted) {
  // Two stretching motions turned soft, x and y of node 8 against its neighbours: rigid motions still meet no force.
  FiniteElementModel model = hex8i();
  const VectorX u = VectorX::Random(162);
  const VectorX f = model.stiffness * u;
  const double energy = u.dot(f);
  const MatrixX K = MatrixX(model.stiffness) - 2 / energy * f * f.transpose();
  model.stiffness = K.sparseView();
  EXPECT_EQ(check(model).stiffness_negative, 1);
  expect_error<SceneError>([&] { require_sound(model); },
                           {"K is indefinite", "1 negative eigenvalue", "the bound is 0"});
  EXPECT_NE(check(model).report().find("REFUSED"), std::string::npos);

  model.stiffness = -hex8i().stiffness;
  EXPECT_GE(check(model).stiffness_negative, 156 - 1);
}

TEST(FiniteElementModel, AsymmetricStiffnessIsRefused) {
  FiniteElementModel model = hex8i();
  model.stiffness.coeffRef(3, 0) *= 1.001;
  expect_error<SceneError>([&] { require_sound(model); }, {"K is not symmetric", "the bound is 1e-10"});
}

TEST(FiniteElementModel, ASpringToGroundIsRefused) {
  FiniteElementModel model = hex8i();
  model.stiffness.coeffRef(149, 149) += 1000.0;
  expect_error<SceneError>([&] { require_sound(model); }, {"rigid translation along z", "1e-08", "free body"});
}

TEST(FiniteElementModel, AMassThatIsNoScalarInterpolationIsAcceptedWithANote) {
  FiniteElementModel model = hex8i();
  EXPECT_EQ(check(model).report().find("note:"), std::string::npos);
  model.mass.coeffRef(0, 0) *= 1 + 1e-6;
  EXPECT_NE(require_sound(model).report().find("note: M is no scalar interpolation"), std::string::npos);
  expect_error<SceneError>([&] { make_basis(model, ThreeNodeFrame{1, 13, 2}, kAllNodal); }, {"scalar interpolation"});
}

TEST(FiniteElementModel, MatricesOfTheWrongSizeAreRefused) {
  FiniteElementModel model = hex8i();
  model.mass.conservativeResize(159, 159);
  expect_error<SceneError>([&] { check(model); }, {"mass matrix is 159 x 159", "54 nodes", "162 degrees"});
  model = hex8i();
  model.nodes.conservativeResize(3, 53);
  model.node_ids.pop_back();
  model.node_sets.clear();
  expect_error<SceneError>([&] { check(model); }, {"element", "node index 53"});
}

TEST(FiniteElementModel, ANaNIsRefusedWhereverItHides) {
  FiniteElementModel model = hex8i();
  model.stiffness.coeffRef(0, 0) = std::nan("");
  expect_error<SceneError>([&] { check(model); }, {"stiffness matrix has a NaN", "row 1, column 1"});
  model = hex8i();
  model.nodes(2, 5) = std::nan("");
  expect_error<SceneError>([&] { check(model); }, {"node coordinate is NaN"});
}

TEST(FiniteElementModel, TwoNodesOfOneLabelAreRefused) {
  FiniteElementModel model = hex8i();
  model.node_ids[5] = 1;
  expect_error<SceneError>([&] { check(model); }, {"two nodes have the label 1"});
}

}  // namespace
}  // namespace lithe::test::fe_model_test
