// Geometric stiffening and quadratic deflection of reduced bodies (docs/equations.md 4.5).
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/elements/solid_element.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/readers/calculix.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/base/error.h"
#include "engine/study/certificate.h"
#include "integrators/explicit_runge_kutta.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/body_checks.h"
#include "tests/support/json_file.h"

namespace lithe::test::deflection_test {
namespace {

MatrixX matrix(const nlohmann::json& rows) {
  MatrixX A(rows.size(), rows.at(0).size());
  for (size_t i = 0; i < rows.size(); ++i)
    for (size_t j = 0; j < rows[i].size(); ++j) A(i, j) = rows[i][j].get<double>();
  return A;
}

SparseMatrix isotropic(const MatrixX& scalar) {
  MatrixX S = MatrixX::Zero(3 * scalar.rows(), 3 * scalar.cols());
  for (Eigen::Index i = 0; i < scalar.rows(); ++i)
    for (Eigen::Index j = 0; j < scalar.cols(); ++j)
      for (int axis = 0; axis < 3; ++axis) S(3 * i + axis, 3 * j + axis) = scalar(i, j);
  return S.sparseView();
}

/// Geometric stiffness of a nodal load (body axes), -θ_klᵀ F, among all modes of a basis.
MatrixX geometric_stiffness(const ModalBasis& basis, const VectorX& load) {
  const auto nm = basis.mode_count();
  MatrixX fields(basis.modes.rows(), nm + basis.deflection->field_count());
  fields << basis.modes, basis.deflection->fields;
  const VectorX pairs = -(load.transpose() * fields * basis.deflection->curvature).transpose();
  MatrixX K(nm, nm);
  for (int l = 0, p = 0; l < nm; ++l)
    for (int k = 0; k <= l; ++k, ++p) K(k, l) = K(l, k) = pairs[p];
  return K;
}

/// Oracle case g01: two bricks clamped at one end, geometric stiffness of unit loads by an independent program.
class Oracle {
 public:
  Oracle() {
    data = read_json(LITHE_TEST_DATA "/oracle/g01_geo_stiffness.json");
    model.name = "g01";
    model.nodes = matrix(data["nodes"]).transpose();
    for (int i = 0; i < model.node_count(); ++i) model.node_ids.push_back(i + 1);
    model.stiffness = matrix(data["K"]).sparseView();
    model.mass = isotropic(matrix(data["mass_scalar"]));
    ElementBlock block{.type = "C3D8", .nodes = {}, .material = {data["E"], data["nu"], data["rho"]}};
    for (const auto& e : data["elements"])  // counted like a lattice; CalculiX goes round each face
      block.nodes.push_back({e[0], e[1], e[3], e[2], e[4], e[5], e[7], e[6]});
    model.elements.push_back(block);
    std::vector<int> clamped;
    for (int node : data["frame"]["fixed_nodes"]) clamped.push_back(node + 1);
    basis = make_basis(model, TangentFrame{clamped}, 24,
                       {.deflection = Deflection::stiffened, .deflection_tolerance = 1e-12});
    oracle_modes = basis->modes.transpose() * (model.mass * matrix(data["B"]));  // the oracle's shapes in ours
  }
  /// In the oracle's modes; `load` about the oracle's origin, which the mesh has.
  MatrixX stiffness(const VectorX& load) const {
    return oracle_modes.transpose() * geometric_stiffness(*basis, load) * oracle_modes;
  }

  nlohmann::json data;
  FiniteElementModel model;
  std::shared_ptr<const ModalBasis> basis;
  MatrixX oracle_modes;
};

TEST(Deflection, geometric_stiffness_of_gravity_spin_and_end_forces_is_that_of_the_oracle) {
  const Oracle oracle;
  const Matrix3X& r = oracle.model.nodes;
  const auto n = oracle.model.node_count();
  const auto load = [&](auto&& at) {
    VectorX field(3 * n);
    for (int i = 0; i < n; ++i) field.segment<3>(3 * i) = at(Vector3(r.col(i)));
    return VectorX(-(oracle.model.mass * field));
  };
  const auto expect_near = [&](const MatrixX& K, const nlohmann::json& expected, const std::string& what) {
    const MatrixX E = matrix(expected);
    EXPECT_LT((K - E).cwiseAbs().maxCoeff(), 1e-6 * E.cwiseAbs().maxCoeff()) << what;  // fields above 1e-7
  };
  const auto& K = oracle.data["Kgeo"];
  for (int a = 0; a < 3; ++a) {
    const Vector3 e = Vector3::Unit(a);
    expect_near(oracle.stiffness(load([&](const Vector3&) -> Vector3 { return e; })), K["Kt"][a], "acceleration");
    expect_near(oracle.stiffness(load([&](const Vector3& p) -> Vector3 { return e.cross(p); })), K["Kr"][a], "turning");
    for (int b = 0; b < 3; ++b) {
      const Vector3 f = Vector3::Unit(b);
      expect_near(oracle.stiffness(load(
                      [&](const Vector3& p) -> Vector3 { return 0.5 * (e.cross(f.cross(p)) + f.cross(e.cross(p))); })),
                  K["Kw"][a][b], "spin");
    }
  }
  const auto& end = oracle.data["end_force"];
  VectorX force = VectorX::Zero(3 * n);
  for (int node : end["nodes"])
    for (int axis = 0; axis < 3; ++axis)
      force[3 * node + axis] = end["total_force_body"][axis].get<double>() / static_cast<double>(end["nodes"].size());
  expect_near(oracle.stiffness(force), K["Kforce"], "end force");
}

TEST(Deflection, imported_stress_stiffness_gives_what_the_elements_give) {
  // The stress stiffness of unit loads as a finite-element code exports it, here from the quadratic fields themselves.
  Oracle oracle;
  const VectorX pull = [&] {
    VectorX f = VectorX::Zero(oracle.model.dof_count());
    for (int node : oracle.data["end_force"]["nodes"]) f[3 * node] = 1;
    return f;
  }();
  const MatrixX& B = oracle.basis->modes;
  const MatrixX dual = oracle.model.mass * B;  // Bᵀ dual = E
  FiniteElementModel imported = oracle.model;
  imported.elements.clear();
  imported.stress_stiffness.push_back(
      {pull, SparseMatrix((dual * geometric_stiffness(*oracle.basis, pull) * dual.transpose()).sparseView())});
  std::vector<int> clamped;
  for (int node : oracle.data["frame"]["fixed_nodes"]) clamped.push_back(node + 1);
  const auto basis = make_basis(imported, TangentFrame{clamped}, 6,
                                {.deflection = Deflection::stiffened, .deflection_tolerance = 1e-12});
  const MatrixX expected = geometric_stiffness(*oracle.basis, pull).topLeftCorner(6, 6);
  EXPECT_LT((geometric_stiffness(*basis, pull) - expected).cwiseAbs().maxCoeff(),
            1e-9 * expected.cwiseAbs().maxCoeff());
}

std::shared_ptr<const ModalBasis> rod(Deflection deflection, const std::string& frame = "frameA") {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  const auto& n = model.node_set("frameA");
  const BodyFrame three = ThreeNodeFrame{n.at(0), n.at(1), n.at(2)};
  return make_basis(model, frame == "mean" ? BodyFrame{MeanAxisFrame{}} : three, 5, {.deflection = deflection});
}

class DeflectedBody : public testing::TestWithParam<std::pair<Deflection, std::string>> {};

TEST_P(DeflectedBody, owes_what_every_body_owes) {
  SystemGraph graph{{.gravity = {1, -2, -9.81}}};
  auto& body =
      graph.add<FlexibleBody>("rod", {.basis = rod(GetParam().first, GetParam().second), .velocity = {0.1, 0.2, -0.3}});
  const auto& tip = body.basis().node_set("tip");
  const auto& face = body.basis().node_set("root_face");
  check_body(graph, body, {body.node(tip.front()), body.average(face), body.frame()},
             {.mass = 0.26, .speed = 3, .deformation = 2e-3});
}

TEST_P(DeflectedBody, has_the_frames_part_of_its_position_tangent) {
  SystemGraph graph{{.gravity = {1, -2, -9.81}}};
  auto& body = graph.add<FlexibleBody>(
      "rod", FlexibleBody::Parameters{.basis = rod(GetParam().first, GetParam().second), .velocity = {0.1, 0.2, -0.3}});
  check_position_tangent(graph, body, 3, 2e-3);
}

TEST_P(DeflectedBody, in_free_flight_keeps_energy_and_momenta) {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  FlexibleBody::Parameters parameters{.basis = rod(GetParam().first, GetParam().second)};
  parameters.velocity = {0.3, -0.2, 0.1};
  parameters.angular_velocity = {8, 5, -6};
  parameters.modal_coordinates = VectorX::Zero(5);
  parameters.modal_coordinates << 2e-3, -1e-3, 5e-4, 2e-4, 0;
  auto& body = graph.add<FlexibleBody>("rod", parameters);
  const System system = assemble(graph);
  Evaluator equations(system);
  State state = system.initial_state();
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-10, .absolute = 1e-12}});
  integrator.start(equations, state);
  const auto observed = [&] {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    const BodyState s = body_state(equations, body);
    return std::tuple(equations.energy().total(), body.linear_momentum(s), body.angular_momentum(s));
  };
  const auto [e0, p0, l0] = observed();
  while (state.time < 0.5) ASSERT_TRUE(integrator.step(equations, state, 0.5).ok());
  const auto [e, p, l] = observed();
  EXPECT_LT(std::abs(e / e0 - 1), 1e-8);
  EXPECT_LT((p - p0).norm(), 1e-8 * p0.norm());
  EXPECT_LT((l - l0).norm(), 1e-8 * l0.norm());
}

INSTANTIATE_TEST_SUITE_P(Kinds, DeflectedBody,
                         testing::Values(std::pair(Deflection::stiffened, std::string("frameA")),
                                         std::pair(Deflection::quadratic, std::string("frameA")),
                                         std::pair(Deflection::quadratic, std::string("mean"))),
                         [](const auto& test) { return to_string(test.param.first) + "_" + test.param.second; });

TEST(Deflection, energy_of_fourth_order_is_that_of_the_nonlinear_elements) {
  // A cantilever bent along its first mode by 6 % of its length: the strain energy of the whole field [B, Ψ] ξ(η),
  // integrated from the Green-Lagrange strain, against V(η). The section is no square, and modes count as positive
  // where they lift the end: which combination of them is bent does not depend on rounding.
  const FiniteElementModel model =
      brick_mesh({.size = {1, 0.05, 0.04}, .divisions = {10, 1, 1}, .type = "C3D20", .material = {1e7, 0.3, 1000}});
  const auto basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 4,
                                {.deflection = Deflection::quadratic, .deflection_tolerance = 1e-6});
  const DeflectionMap map(*basis->deflection, 4);
  DeflectionTerms terms(map.field_count(), 4);
  const double scale = 0.06 / basis->modes.col(0).cwiseAbs().maxCoeff();
  VectorX eta(4), still = VectorX::Zero(4);
  eta << scale, -0.4 * scale, 0.05 * scale, 0.1 * scale;
  const int end = model.node_index(model.node_set("x_max").front());
  for (int i = 0; i < 4; ++i)
    if (basis->modes.col(i).segment<3>(3 * end).sum() < 0) eta[i] = -eta[i];
  const auto elastic = [&](double part, double& quartic) {
    const VectorX x = part * eta;
    map.evaluate(x.data(), still.data(), Level::position, terms);
    quartic = terms.energy;
    const VectorX u =
        basis->modes * terms.xi.head(4) + basis->deflection->fields * terms.xi.tail(map.field_count() - 4);
    double energy = 0;
    for (const SolidElement& element : make_solid_elements(model)) {
      const VectorX c = element.coordinates_of(u);
      for (const SolidPoint& point : element.points) {
        const Matrix3 H = Eigen::Map<const Matrix3X>(c.data(), 3, c.size() / 3) * point.gradients;
        const Matrix3 E = 0.5 * (H + H.transpose() + H.transpose() * H);
        const Vector6 e = (Vector6() << E(0, 0), E(1, 1), E(2, 2), 2 * E(0, 1), 2 * E(1, 2), 2 * E(0, 2)).finished();
        energy += 0.5 * point.volume * e.dot(elasticity(element.material) * e);
      }
    }
    return energy - 0.5 * x.dot(basis->stiffness * x);
  };
  // What is left is of sixth order: beside the fourth it falls by four where the deflection is halved.
  double quartic = 0, half_quartic = 0;
  const double beyond = elastic(0.125, quartic) / quartic - 1,
               half_beyond = elastic(0.0625, half_quartic) / half_quartic - 1;
  EXPECT_LT(std::abs(beyond), 0.08);
  EXPECT_NEAR(beyond / half_beyond, 4, 0.4);
}

TEST(Deflection, says_what_it_needs) {
  FiniteElementModel model = pendulum_from_calculix("hex8i");
  const BodyFrame hinge = HingeFrame{model.node_set("hinge")};
  const auto make = [&] { make_basis(model, hinge, 3, {.deflection = Deflection::stiffened}); };
  model.elements[0].material.young = 2e7;
  expect_error<SceneError>(make, {"do not give the stiffness matrix"});
  model.elements[0].material.young = 0;
  expect_error<SceneError>(make, {"Young's modulus"});
  model.elements.clear();
  expect_error<SceneError>(make, {"stress stiffness"});
}

}  // namespace
}  // namespace lithe::test::deflection_test
