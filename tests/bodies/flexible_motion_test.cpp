// Motion of one flexible body: what energy and momentum can see, and what they cannot (docs/equations.md 3.5).
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "bodies/flexible/flexible_body.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "integrators/explicit_runge_kutta.h"
#include "tests/bodies/flexible_models.h"
#include "tests/support/json_file.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/oracle.h"

namespace lithe::test::flexible_motion_test {
namespace {

TEST(FlexibleBody, in_free_flight_keeps_energy_and_momenta_for_five_seconds) {
  const FiniteElementModel model = pendulum_model("hex8i");
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  // A three-node frame: Ct and C0 do not vanish, so every term of f_v is at work.
  FlexibleBody::Parameters parameters{.basis = make_basis(model, frame_of(model, "frameA"), 5)};
  parameters.velocity = {0.3, -0.2, 0.1};
  parameters.angular_velocity = {8, 5, -6};
  parameters.modal_coordinates = VectorX::Zero(5);
  parameters.modal_coordinates << 3e-4, -2e-4, 1e-4, 5e-5, 0;
  auto& body = graph.add<FlexibleBody>("rod", parameters);
  const System system = assemble(graph);
  Evaluator equations(system);
  State state = system.initial_state();

  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-10, .absolute = 1e-12}});
  integrator.start(equations, state);
  const auto observe = [&](double& energy, Vector3& linear, Vector3& angular) {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    const BodyState s = body_state(equations, body);
    energy = equations.energy().total();
    linear = body.linear_momentum(s);
    angular = body.angular_momentum(s);
  };
  double e0, e;
  Vector3 p0, p, l0, l;
  observe(e0, p0, l0);
  double worst_e = 0, worst_p = 0, worst_l = 0;
  for (int second = 1; second <= 5; ++second) {
    while (state.time < second) ASSERT_TRUE(integrator.step(equations, state, second).ok());
    observe(e, p, l);
    worst_e = std::max(worst_e, std::abs(e / e0 - 1));
    worst_p = std::max(worst_p, (p - p0).norm() / p0.norm());
    worst_l = std::max(worst_l, (l - l0).norm() / l0.norm());
  }
  EXPECT_LT(worst_e, 1e-8);
  EXPECT_LT(worst_p, 1e-8);
  EXPECT_LT(worst_l, 1e-8);
}

/// All nodes in the inertial frame: S q̈ = f, S constant, no quadratic velocity force anywhere. f are the nodal forces
/// that do the work of (0, 0, -K η) on the motions x0, rotation, η; frame and η are read off the nodes, eqs. (65)-(68).
class InertialModel {
 public:
  explicit InertialModel(const nlohmann::json& data)
      : r0_(oracle::matrix(data.at("nodes")).transpose()),
        K_(oracle::matrix(data.at("K"))),
        frame_(data.at("frame").at("frame_nodes").get<std::vector<int>>()) {
    const MatrixX m = oracle::matrix(data.at("mass_scalar"));
    mass_inverse_ = solve(m, MatrixX::Identity(m.rows(), m.rows()));
    const auto eliminated = data.at("frame").at("eliminated_dofs").get<std::vector<int>>();
    for (int i = 0; i < r0_.size(); ++i)
      if (std::find(eliminated.begin(), eliminated.end(), i) == eliminated.end()) free_.push_back(i);
  }

  Matrix3X acceleration(const Matrix3X& q) const {
    const int n = static_cast<int>(q.cols()), nm = static_cast<int>(free_.size());
    const Vector3 a = q.col(frame_[0]), x = (q.col(frame_[1]) - a).normalized();
    const Vector3 z = x.cross(q.col(frame_[2]) - a).normalized();
    Matrix3 A;
    A << x, z.cross(x), z;
    const Matrix3X r = A.transpose() * (q.colwise() - a), u = r - r0_;
    MatrixX L = MatrixX::Zero(3 * n, 6 + nm);  // body axes: [Phi, Y, B]
    VectorX eta(nm);
    for (int k = 0; k < nm; ++k) eta[k] = u.data()[free_[k]], L(free_[k], 6 + k) = 1;
    for (int i = 0; i < n; ++i) {
      L.block<3, 3>(3 * i, 0).setIdentity();
      L.block<3, 3>(3 * i, 3) = -skew(r.col(i));
    }
    VectorX load = VectorX::Zero(6 + nm);
    for (int k = 0; k < nm; ++k)
      for (int l = 0; l < nm; ++l) load[6 + k] -= K_(free_[k], free_[l]) * eta[l];
    const VectorX f = solve(L.transpose(), load);
    const Matrix3X forces = A * Eigen::Map<const Matrix3X>(f.data(), 3, n);
    return forces * mass_inverse_;
  }

 private:
  Matrix3X r0_;
  MatrixX K_, mass_inverse_;
  std::vector<int> frame_, free_;
};

TEST(FlexibleBody, with_all_nodal_coordinates_follows_the_inertial_frame_model) {
  const auto data = read_json(LITHE_TEST_DATA "/oracle/b01_hex_nodal.json");
  auto basis = std::make_shared<ModalBasis>(*basis_from_modes(
      "hex", oracle::matrix(data.at("nodes")).transpose(), oracle::matrix(data.at("mass_scalar")).sparseView(),
      oracle::matrix(data.at("K_modal")).sparseView(), oracle::matrix(data.at("B"))));
  basis->nodal = true;  // B selects coordinates
  for (int k = 0; k < basis->modes.cols(); ++k) {
    int dof = 0;
    basis->modes.col(k).maxCoeff(&dof);
    basis->free_dofs.push_back(dof);
  }
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  FlexibleBody::Parameters parameters{.basis = basis};
  parameters.velocity = {1, -0.5, 0.3};
  parameters.angular_velocity = {3, -2, 4};
  parameters.modal_coordinates = 2e-3 * VectorX::LinSpaced(basis->modes.cols(), -1, 1);
  auto& body = graph.add<FlexibleBody>("hex", parameters);
  const System system = assemble(graph);
  Evaluator equations(system);
  State state = system.initial_state();
  const auto nodes = [&] {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    return body.nodal_motion(body_state(equations, body), state.v_dot.data());
  };
  const auto start = nodes();
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-12, .absolute = 1e-13}});
  integrator.start(equations, state);
  const double end = 0.05;
  while (state.time < end) ASSERT_TRUE(integrator.step(equations, state, end).ok());

  // The inertial model by classical Runge-Kutta, small fixed steps.
  const InertialModel inertial(data);
  Matrix3X q = start.position, v = start.velocity;
  const int steps = 5000;
  const double h = end / steps;
  for (int i = 0; i < steps; ++i) {
    const Matrix3X a1 = inertial.acceleration(q), v2 = v + h / 2 * a1;
    const Matrix3X a2 = inertial.acceleration(q + h / 2 * v), v3 = v + h / 2 * a2;
    const Matrix3X a3 = inertial.acceleration(q + h / 2 * v2), v4 = v + h * a3;
    const Matrix3X a4 = inertial.acceleration(q + h * v3);
    q += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  const auto reached = nodes();
  EXPECT_LT((reached.position - q).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((reached.velocity - v).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT((reached.acceleration - inertial.acceleration(q)).cwiseAbs().maxCoeff(),
            1e-8 * start.acceleration.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace lithe::test::flexible_motion_test
