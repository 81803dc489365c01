#include "bodies/flexible/elements/stress_recovery.h"

#include <algorithm>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/readers/calculix_deck.h"
#include "bodies/flexible/reduction.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::stress_recovery_test {
namespace {

std::string stress_data(const std::string& file) { return std::string(LITHE_TEST_DATA) + "/stress/" + file; }

/// K u = force with the degrees of freedom held.
VectorX solved(const FiniteElementModel& model, const VectorX& force, const std::vector<int>& held) {
  SparseMatrix K = model.stiffness;
  for (int dof : held) K.coeffRef(dof, dof) += 1e12 * test::largest(model.stiffness);
  return test::solve_sparse(K, force);
}

/// Largest difference of two tables, by the largest entry of the second.
double relative(const MatrixX& found, const MatrixX& wanted) {
  return (found - wanted).cwiseAbs().maxCoeff() / wanted.cwiseAbs().maxCoeff();
}

TEST(StressRecovery, NodalStressesAreThoseOfCalculiX) {
  for (const auto& [type, bound] :
       {std::pair{"C3D4", 5e-6}, {"C3D8", 3e-5}, {"C3D8I", 3e-5}, {"C3D10", 1e-5}, {"C3D20", 3e-5}, {"C3D20R", 3e-5}}) {
    const FiniteElementModel model = read_calculix_mesh(stress_data(std::string(type) + ".inp"));
    const auto table = test::csv_columns(stress_data(std::string(type) + ".csv"));
    const auto columns = [&](const std::vector<const char*>& names) {
      MatrixX rows(names.size(), model.node_count());
      for (size_t k = 0; k < names.size(); ++k)
        for (int i = 0; i < model.node_count(); ++i)
          rows(static_cast<Eigen::Index>(k),
               model.node_index(static_cast<int>(table.at("node")[static_cast<size_t>(i)]))) =
              table.at(names[k])[static_cast<size_t>(i)];
      return rows;
    };
    VectorX force = VectorX::Zero(model.dof_count());
    for (int id : model.node_set("tip")) force.segment<3>(3 * model.node_index(id)) << 30, -10, 20;
    std::vector<int> held;
    for (int id : model.node_set("root"))
      for (int axis = 0; axis < 3; ++axis) held.push_back(3 * model.node_index(id) + axis);
    const VectorX u = solved(model, force, held);
    const StressRecovery recovery(model, u);
    const Matrix6X stress = recovery.stress(VectorX::Ones(1));
    Matrix6X strain = recovery.strain(VectorX::Ones(1));
    strain.bottomRows<3>() /= 2;  // CalculiX prints tensor shear
    // Six digits are printed; CalculiX rounds the coefficients of its extrapolation, of bricks to the fourth digit.
    const double of_u = relative(u.reshaped(3, model.node_count()), columns({"ux", "uy", "uz"}));
    const double of_stress = relative(stress, columns({"sxx", "syy", "szz", "sxy", "szx", "syz"}));
    const double of_strain = relative(strain, columns({"exx", "eyy", "ezz", "exy", "ezx", "eyz"}));
    std::printf("%s: displacements %.1e, stresses %.1e, strains %.1e\n", type, of_u, of_stress, of_strain);
    EXPECT_LT(of_u, 5e-6) << type;
    EXPECT_LT(of_stress, bound) << type;
    EXPECT_LT(of_strain, bound) << type;
  }
}

/// Nonlinear CalculiX of the swinging rod: its displacements, turned back to the best-fitting body axes, give its true
/// stresses at the integration points. (In the linear measure the largest one at the hinge is 2 to 4 % off.)
TEST(StressRecovery, TrueStressesOfTheSwingingPendulumAreThoseOfCalculiX) {
  FiniteElementModel model = test::pendulum("hex8i");
  model.elements.at(0).type = "C3D8I";
  model.elements.at(0).material = {1e7, 0.49, 0.26 / 1.5e-5};
  const std::vector<SolidElement> elements = make_solid_elements(model);
  auto moved = test::csv_columns(stress_data("pendulum_displacements.csv"));
  auto printed = test::csv_columns(stress_data("pendulum_stress.csv"));
  for (double t : {0.1, 0.15, 0.2}) {
    Matrix3X x = model.nodes;
    for (size_t k = 0; k < moved["t"].size(); ++k)
      if (moved["t"][k] == t)
        x.col(model.node_index(static_cast<int>(moved["node"][k]))) +=
            Vector3(moved["ux"][k], moved["uy"][k], moved["uz"][k]);
    const double sine = (model.nodes.row(2).cwiseProduct(x.row(0)) - model.nodes.row(0).cwiseProduct(x.row(2))).sum();
    const double cosine = (model.nodes.row(0).cwiseProduct(x.row(0)) + model.nodes.row(2).cwiseProduct(x.row(2))).sum();
    const Matrix3 turn = rotation_exp(Vector3(0, std::atan2(sine, cosine), 0));
    const VectorX u = (turn.transpose() * x - model.nodes).reshaped();

    double worst = 0, scale = 0, root = 0, root_calculix = 0, root_small = 0;
    for (size_t e = 0; e < elements.size(); ++e) {
      Matrix6X wanted = Matrix6X::Zero(6, 8);
      for (size_t k = 0; k < printed["t"].size(); ++k)
        if (printed["t"][k] == t && printed["element"][k] == static_cast<double>(e + 1))
          wanted.col(static_cast<Eigen::Index>(printed["point"][k]) - 1) << printed["sxx"][k], printed["syy"][k],
              printed["szz"][k], printed["sxy"][k], printed["sxz"][k], printed["syz"][k];
      wanted = turned_stress(wanted, turn.transpose());
      const Matrix6X found = point_stress(elements[e], u, StrainMeasure::green_lagrange).stress;
      worst = std::max(worst, (found - wanted).cwiseAbs().maxCoeff());
      scale = std::max(scale, wanted.cwiseAbs().maxCoeff());
      if (e >= 2) continue;  // the elements at the hinge, 0 <= x <= 12.5 mm
      root = std::max(root, von_mises(found).maxCoeff());
      root_calculix = std::max(root_calculix, von_mises(wanted).maxCoeff());
      root_small = std::max(root_small, von_mises(point_stress(elements[e], u).stress).maxCoeff());
    }
    std::printf("t = %.2f s: largest von Mises stress at the hinge %.0f Pa, CalculiX %.0f Pa, small strain %.0f Pa\n",
                t, root, root_calculix, root_small);
    EXPECT_NEAR(root / root_calculix, 1, 1e-5) << t;
    EXPECT_LT(worst, 1e-2 * scale) << t;  // the mean stress (ν = 0.49) feels CalculiX's tolerance of the force
    EXPECT_GT(std::abs(root_small / root_calculix - 1), 0.015) << t;
  }
}

TEST(StressRecovery, ABasisGivesTheStressesOfItsDisplacementsInBodyAxes) {
  FiniteElementModel model = test::pendulum("hex20");
  model.elements.at(0).material = {1e7, 0.49, 0.26 / 1.5e-5};
  const ThreeNodeFrame frame{1, 155, 153};  // x axis slanted: body axes are not those of the mesh
  const auto basis = make_basis(model, frame, 5);
  ASSERT_GT((basis->rotation - Matrix3::Identity()).norm(), 0.01);
  const VectorX eta = 1e-4 * VectorX::LinSpaced(5, 1, -2);
  const StressRecovery recovery(*basis);
  const Matrix6X stress = recovery.stress(eta);

  // The same displacements in mesh axes.
  const VectorX u = (basis->rotation * (basis->modes * eta).reshaped(3, model.node_count())).reshaped();
  const Matrix6X in_mesh_axes = StressRecovery(model, u).stress(VectorX::Ones(1));
  EXPECT_LT(relative(turned_stress(stress, basis->rotation), in_mesh_axes), 1e-9);
  EXPECT_LT(relative(von_mises(stress), von_mises(in_mesh_axes)), 1e-9);

  // Stress modes from elsewhere, and the elements gone through at every call: the same.
  MatrixX modes(6 * model.node_count(), 5);
  for (int k = 0; k < 5; ++k) modes.col(k) = recovery.stress(VectorX::Unit(5, k)).reshaped();
  EXPECT_LT(relative(StressRecovery(modes).stress(eta), stress), 1e-13);
  const StressRecovery finite(*basis, StrainMeasure::green_lagrange);
  const double tiny = 1e-7;  // small displacements: the measures agree
  EXPECT_LT(relative(finite.stress(tiny * eta), tiny * stress), 1e-6);
  EXPECT_LT(relative(finite.strain(tiny * eta), tiny * recovery.strain(eta)), 1e-6);

  // All nodal coordinates: stress of a free node's unit displacement.
  const auto nodal = make_basis(model, frame, kAllNodal);
  const StressRecovery through_elements(*nodal);
  VectorX q(nodal->mode_count());
  VectorX full = basis->modes * eta;
  for (int k = 0; k < q.size(); ++k) q[k] = full[nodal->free_dofs[static_cast<size_t>(k)]];
  EXPECT_LT(relative(through_elements.stress(q), stress), 1e-9);
  EXPECT_LT(relative(through_elements.strain(q), recovery.strain(eta)), 1e-9);
}

TEST(StressRecovery, AQuadraticDeflectionBringsItsFields) {
  FiniteElementModel model = test::pendulum("hex20");
  model.elements.at(0).material = {1e7, 0.49, 0.26 / 1.5e-5};
  ModalBasis basis = *make_basis(model, HingeFrame{model.node_set("hinge")}, 4);
  auto deflection = std::make_shared<QuadraticDeflection>();
  deflection->fields = basis.modes.rightCols(2);
  basis.modes = basis.modes.leftCols(2).eval();
  basis.deflection = deflection;
  const StressRecovery recovery(basis);
  EXPECT_EQ(recovery.coordinate_count(), 4);
  EXPECT_LT(
      relative(recovery.stress(VectorX::Unit(4, 3)),
               StressRecovery(*make_basis(model, HingeFrame{model.node_set("hinge")}, 4)).stress(VectorX::Unit(4, 3))),
      1e-9);
}

TEST(StressRecovery, PulledBarsAreUnderUniaxialStressAndSofterOnesStretchMore) {
  // Two materials in series, pulled by 1 MPa: the same stress, strain by modulus; no lateral hold.
  FiniteElementModel model =
      brick_mesh({.size = {0.2, 0.05, 0.05}, .divisions = {4, 2, 2}, .type = "C3D20", .material = {2e11, 0, 1}});
  ElementBlock soft = model.elements[0];
  soft.material.young = 1e11;
  model.elements[0].nodes.resize(8);
  soft.nodes.erase(soft.nodes.begin(), soft.nodes.begin() + 8);
  model.elements.push_back(soft);
  Matrix3X u = Matrix3X::Zero(3, model.node_count());
  for (int i = 0; i < model.node_count(); ++i) {
    const double x = model.nodes(0, i);
    u(0, i) = x < 0.1 ? x * 5e-6 : 0.5e-6 + (x - 0.1) * 1e-5;
  }
  const StressRecovery recovery(model, u.reshaped());
  const Matrix6X stress = recovery.stress(VectorX::Ones(1)), strain = recovery.strain(VectorX::Ones(1));
  Matrix6X wanted = Matrix6X::Zero(6, model.node_count());
  wanted.row(0).setConstant(1e6);
  EXPECT_LT(relative(stress, wanted), 1e-10);
  for (int i = 0; i < model.node_count(); ++i)  // at the interface: the stiffer one's
    EXPECT_NEAR(strain(0, i), model.nodes(0, i) < 0.1 + 1e-9 ? 5e-6 : 1e-5, 1e-14);
  EXPECT_LT(relative(von_mises(stress), VectorX::Constant(model.node_count(), 1e6)), 1e-10);
}

TEST(StressRecovery, InvariantsOfPullAndShear) {
  Matrix6X stress(6, 3);
  stress.col(0) << 5, 0, 0, 0, 0, 0;
  stress.col(1) << 0, 0, 0, 0, 3, 0;
  stress.col(2) << 7, 7, 7, 0, 0, 0;
  EXPECT_LT((von_mises(stress) - Vector3(5, 3 * std::sqrt(3.0), 0)).norm(), 1e-14);
  Matrix3 wanted;  // columns: largest first
  wanted << 5, 3, 7, 0, 0, 7, 0, -3, 7;
  EXPECT_LT((principal(stress) - wanted).norm(), 1e-13);
  // A quarter turn about z: pull along x becomes pull along y, shear xz becomes yz.
  const Matrix6X turned = turned_stress(stress, rotation_exp(Vector3(0, 0, std::numbers::pi / 2)));
  EXPECT_NEAR(turned(1, 0), 5, 1e-14);
  EXPECT_NEAR(turned(5, 1), 3, 1e-14);
}

TEST(StressRecovery, ExtremaRememberWhenAndWhere) {
  StressExtrema extrema;
  Matrix6X stress = Matrix6X::Zero(6, 3);
  stress(0, 1) = 4;
  extrema.add(0.1, stress);
  stress(0, 1) = -6;  // compression counts like tension
  stress(0, 2) = 5;
  extrema.add(0.2, stress);
  stress.setZero();
  stress(0, 2) = 5.5;
  extrema.add(0.3, stress);
  EXPECT_EQ(extrema.value, 6);
  EXPECT_EQ(extrema.time, 0.2);
  EXPECT_EQ(extrema.node, 1);
  EXPECT_EQ(extrema.largest, VectorX(Vector3(0, 6, 5.5)));
  EXPECT_EQ(extrema.times, VectorX(Vector3(0.1, 0.2, 0.3)));
  test::expect_error<SceneError>([&] { extrema.add(0.4, Matrix6X::Zero(6, 2)); }, {"2 nodes after 3"});
  stress(0, 0) = std::nan("");
  test::expect_error<SceneError>([&] { extrema.add(0.4, stress); }, {"not a number"});
}

TEST(StressRecovery, WhatCannotBeRecoveredIsRefused) {
  const FiniteElementModel pendulum = test::pendulum("hex20");  // Matrix Market knows no material
  const auto basis = make_basis(pendulum, MeanAxisFrame{}, 2);
  test::expect_error<SceneError>([&] { StressRecovery recovery(*basis); }, {"Young", "C3D20", "material"});
  FiniteElementModel bare = pendulum;
  bare.elements.clear();
  const MatrixX field = MatrixX::Zero(bare.dof_count(), 1);
  test::expect_error<SceneError>([&] { StressRecovery(bare, field); }, {"without elements", "stress modes"});
  test::expect_error<SceneError>([&] { StressRecovery(pendulum, MatrixX::Zero(6, 1)); }, {"6 rows"});
  test::expect_error<SceneError>([] { StressRecovery(MatrixX::Zero(7, 1)); }, {"7 rows"});
  const StressRecovery from_file(MatrixX::Ones(12, 2));
  test::expect_error<SceneError>([&] { from_file.stress(VectorX::Ones(3)); }, {"3 coordinates", "2 fields"});
  test::expect_error<SceneError>([&] { from_file.strain(VectorX::Ones(2)); }, {"strain"});
}

}  // namespace
}  // namespace lithe::test::stress_recovery_test
