#include "bodies/flexible/flexible_inertia.h"
#include "bodies/flexible/inertia_integrals.h"
#include "bodies/flexible/reduction.h"

#include <nlohmann/json.hpp>

#include "tests/bodies/fe_models.h"
#include "tests/support/json_file.h"

namespace lithe::test::inertia_integrals_test {
namespace {

using nlohmann::json;

json oracle(const std::string& name) { return read_json(std::string(LITHE_TEST_DATA) + "/oracle/" + name + ".json"); }

MatrixX matrix(const json& rows) {
  MatrixX A(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.at(0).size()));
  for (Eigen::Index i = 0; i < A.rows(); ++i)
    for (Eigen::Index j = 0; j < A.cols(); ++j)
      A(i, j) = rows.at(static_cast<size_t>(i)).at(static_cast<size_t>(j)).get<double>();
  return A;
}

Matrix3 full(const Vector6& s) {
  return (Matrix3() << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2]).finished();
}

double largest(const MatrixX& A) { return A.cwiseAbs().maxCoeff(); }

/// As reference/oracle/check.py: relative to the largest entry of the expected value, or to the natural scale.
void expect_close(const MatrixX& found, const MatrixX& expected, double scale, const std::string& what) {
  EXPECT_LT(largest(found - expected) / std::max(largest(expected), scale), 1e-11) << what;
}

void expect_invariants(const InertiaIntegrals& found, const json& expected, const std::string& name) {
  const auto vector = [](const json& v) { return MatrixX(matrix(json::array({v}))).transpose().eval(); };
  const double m = expected.at("m"), J = largest(matrix(expected.at("J0"))), Mff = largest(matrix(expected.at("Mff")));
  EXPECT_LT(std::abs(found.mass - m) / m, 1e-11) << name;
  expect_close(found.s0, vector(expected.at("s0")), std::sqrt(m * J), name + " s0");
  expect_close(found.Ct, matrix(expected.at("Ct")), std::sqrt(m * Mff), name + " Ct");
  expect_close(full(found.J0), matrix(expected.at("J0")), 0, name + " J0");
  expect_close(found.C0, matrix(expected.at("C0")), std::sqrt(J * Mff), name + " C0");
  expect_close(found.Mff, matrix(expected.at("Mff")), 0, name + " Mff");
  double J2 = 0, C1 = 0;
  for (const json& row : expected.at("J2"))
    for (const json& block : row) J2 = std::max(J2, largest(matrix(block)));
  for (const json& block : expected.at("C1")) C1 = std::max(C1, largest(matrix(block)));
  const int nm = found.mode_count();
  ASSERT_EQ(static_cast<size_t>(nm), expected.at("C1").size());
  for (int k = 0; k < nm; ++k) {
    const auto index = static_cast<size_t>(k);
    expect_close(full(found.J1.col(k)), matrix(expected.at("J1").at(index)), std::sqrt(J * J2), name + " J1");
    expect_close(found.C1.middleRows<3>(3 * k), matrix(expected.at("C1").at(index)), C1, name + " C1");
    for (int l = 0; l < nm; ++l)
      expect_close(full(found.J2.block<6, 1>(6 * k, l)), matrix(expected.at("J2").at(index).at(static_cast<size_t>(l))),
                   J2, name + " J2");
  }
}

TEST(InertiaIntegrals, TheyAgreeWithTheOracle) {
  for (const char* name : {"b01_hex_nodal", "b02_bar_three_node", "b03_bar_clamped", "b04_plate_mean_axis",
                           "b05_bar_craig_bampton", "b06_bar_lumped", "b07_particles", "b08_beam_particles"}) {
    const json body = oracle(name);
    const auto basis =
        basis_from_modes(name, matrix(body.at("nodes")).transpose(), matrix(body.at("mass_scalar")).sparseView(),
                         matrix(body.at("K_modal")).sparseView(), matrix(body.at("B")));
    expect_invariants(inertia_integrals(*basis), body.at("invariants"), name);
  }
}

/// The solid of an oracle file as an exported model: S = m E, nodal K.
FiniteElementModel model_of(const json& body) {
  FiniteElementModel model;
  model.name = body.at("name");
  model.nodes = matrix(body.at("nodes")).transpose();
  for (int i = 0; i < model.node_count(); ++i) model.node_ids.push_back(i);
  model.stiffness = matrix(body.at("K")).sparseView();
  const MatrixX m = matrix(body.at("mass_scalar"));
  MatrixX S = MatrixX::Zero(3 * m.rows(), 3 * m.cols());
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j < m.cols(); ++j) S.block<3, 3>(3 * i, 3 * j) = m(i, j) * Matrix3::Identity();
  model.mass = S.sparseView();
  return model;
}

TEST(InertiaIntegrals, NodalCoordinatesOfAThreeNodeFrameAreTheOraclesBasis) {
  const json body = oracle("b01_hex_nodal");
  const auto ids = body.at("frame").at("frame_nodes").get<std::vector<int>>();
  const auto basis = make_basis(model_of(body), ThreeNodeFrame{ids.at(0), ids.at(1), ids.at(2)}, kAllNodal);
  ASSERT_EQ(basis->mode_count(), 18);
  expect_invariants(inertia_integrals(*basis), body.at("invariants"), "b01 from the mesh");
}

TEST(InertiaIntegrals, RigidPartsAgreeWithTheTableOfTheRod) {
  for (const char* name : {"hex8i", "hex20", "paper", "stiff"}) {
    const FiniteElementModel model = test::pendulum(name);
    const auto basis = make_basis(model, HingeFrame{{1}}, 0);  // origin at the corner, mesh axes
    const InertiaIntegrals I = inertia_integrals(*basis);
    std::ifstream table(test::pendulum_path(name, "rigid_body.csv"));
    std::map<std::string, double> expected;
    for (std::string line; std::getline(table, line);) {
      const size_t first = line.find(','), second = line.rfind(',');
      if (line.rfind("quantity", 0) != 0) expected[line.substr(0, first)] = std::stod(line.substr(second + 1));
    }
    EXPECT_NEAR(I.mass, expected.at("mass"), 1e-14);
    const char* axes[] = {"xx", "yy", "zz", "xy", "xz", "yz"};
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(I.s0[k], expected.at("first moment " + std::string(1, axes[k][0])), 1e-15) << name;
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(I.J0[k], expected.at("inertia about origin " + std::string(axes[k])), 1e-16) << name << axes[k];
  }
}

TEST(InertiaIntegrals, SymmetriesHoldToTheLastBit) {
  const FiniteElementModel model = test::pendulum("hex8i");
  for (int count : {9, kAllNodal}) {
    const InertiaIntegrals I = inertia_integrals(*make_basis(model, ThreeNodeFrame{1, 13, 2}, count));
    EXPECT_TRUE(I.antisymmetric);
    for (int k = 0; k < std::min(I.mode_count(), 30); ++k)
      for (int l = 0; l < std::min(I.mode_count(), 30); ++l) {
        EXPECT_EQ((I.C1.block<3, 1>(3 * k, l)), (-I.C1.block<3, 1>(3 * l, k)));
        EXPECT_EQ((I.J2.block<6, 1>(6 * k, l)), (I.J2.block<6, 1>(6 * l, k)));
      }
  }
}

TEST(InertiaIntegrals, AModalBasisSeesTheNodalOneThroughItsModes) {
  // C0, Ct, J1 of modes = those of nodal coordinates times B: linear in the basis.
  const FiniteElementModel model = test::pendulum("hex8i");
  const auto modal = make_basis(model, ThreeNodeFrame{1, 13, 2}, 7);
  const auto nodal = make_basis(model, ThreeNodeFrame{1, 13, 2}, kAllNodal);
  const InertiaIntegrals a = inertia_integrals(*modal), b = inertia_integrals(*nodal);
  MatrixX B(nodal->mode_count(), 7);
  for (size_t k = 0; k < nodal->free_dofs.size(); ++k)
    B.row(static_cast<Eigen::Index>(k)) = modal->modes.row(nodal->free_dofs[k]);
  const double mode = std::sqrt(0.26);
  EXPECT_LT(largest(a.Ct - b.Ct * B) / mode, 1e-13);
  EXPECT_LT(largest(a.C0 - b.C0 * B) / (mode * 0.1), 1e-13);
  EXPECT_LT(largest(a.J1 - b.J1 * B) / (mode * 0.1), 1e-13);
  EXPECT_LT(largest(MatrixX(B.transpose() * b.Mff * B) - a.Mff), 1e-12);
}

TEST(InertiaIntegrals, TheRateOfTheInertiaTensorIsItsDerivative) {
  // J is quadratic in η, so central differences are exact; with J2 counted once instead of twice they are off by J2 η.
  const FiniteElementModel model = test::pendulum("hex8i");
  const ModalInertia inertia(inertia_integrals(*make_basis(model, ThreeNodeFrame{1, 13, 2}, 6)));
  VectorX eta(6);
  for (int k = 0; k < 6; ++k) eta[k] = 2e-2 * std::cos(2.0 * k);
  InertiaTerms terms(6), more(6), less(6);
  for (int k = 0; k < 6; ++k) {
    const VectorX along = VectorX::Unit(6, k), up = eta + along, down = eta - along;
    inertia.evaluate(eta.data(), along.data(), Vector3::Zero(), Level::velocity, terms);
    inertia.evaluate(up.data(), along.data(), Vector3::Zero(), Level::position, more);
    inertia.evaluate(down.data(), along.data(), Vector3::Zero(), Level::position, less);
    expect_close(terms.J_rate, 0.5 * (more.J - less.J), largest(more.J), "mode " + std::to_string(k + 1));
    const VectorX two = eta + 2 * along;
    inertia.evaluate(two.data(), along.data(), Vector3::Zero(), Level::velocity, more);
    EXPECT_GT(largest(more.J_rate - terms.J_rate), 1e-3 * largest(terms.J_rate));  // there is a J2 to be wrong about
  }
}

}  // namespace
}  // namespace lithe::test::inertia_integrals_test
