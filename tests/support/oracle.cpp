#include "tests/support/oracle.h"

#include <stdexcept>

#include "bodies/flexible/flexible_body.h"
#include "tests/support/oracle_body.h"

namespace lithe::oracle {

void Findings::compare(const std::string& quantity, const MatrixX& got, const MatrixX& want, double scale) {
  if (got.rows() != want.rows() || got.cols() != want.cols())
    throw std::runtime_error(quantity + ": size " + std::to_string(got.rows()) + "x" + std::to_string(got.cols()) +
                             ", expected " + std::to_string(want.rows()) + "x" + std::to_string(want.cols()));
  double& error = worst[quantity];
  if (want.size() == 0) return;
  double unit = std::max(want.cwiseAbs().maxCoeff(), scale);
  if (unit == 0) unit = 1;
  const double e = (got - want).cwiseAbs().maxCoeff() / unit;
  if (!(e <= error)) error = e;  // NaN stays
}

double Findings::largest() const {
  double all = 0;
  for (const auto& [name, e] : worst)
    if (!(e <= all)) all = e;
  return all;
}

MatrixX matrix(const nlohmann::json& rows) {
  if (rows.is_number()) return MatrixX::Constant(1, 1, rows.get<double>());
  const int n = static_cast<int>(rows.size());
  if (n == 0) return MatrixX(0, 1);
  if (rows[0].is_number()) {
    MatrixX column(n, 1);
    for (int i = 0; i < n; ++i) column(i, 0) = rows[i].get<double>();
    return column;
  }
  MatrixX out(n, static_cast<int>(rows[0].size()));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < out.cols(); ++j) out(i, j) = rows[i][j].get<double>();
  return out;
}

Findings check_case(const nlohmann::json& data) {
  const std::string kind = data.at("kind");
  if (kind == "joints") return check_joints(data);
  if (kind == "geo") return check_stiffness(data);
  if (kind == "trajectory") return check_trajectory(data);
  if (data.contains("states") && (data.contains("invariants") || data.contains("B"))) return check_body(data);
  throw std::runtime_error("unknown kind of case '" + kind + "'");
}

double bound(const nlohmann::json& data) { return data.at("kind") == "trajectory" ? 1e-8 : 1e-10; }

namespace {

void compare_invariants(const InertiaIntegrals& I, const nlohmann::json& want, Findings& f) {
  const auto largest = [&](const char* key) { return matrix3(want.at(key)).cwiseAbs().maxCoeff(); };
  const int nm = I.mode_count();
  const auto full = [](const Vector6& s) {
    Matrix3 J;
    J << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
    return J;
  };
  MatrixX J1(3 * nm, 3), J2(9 * nm * nm / 3, 3), C1(3 * nm, nm);
  for (int k = 0; k < nm; ++k) {
    J1.middleRows<3>(3 * k) = full(I.J1.col(k));
    C1.middleRows<3>(3 * k) = I.C1.middleRows<3>(3 * k);
    for (int l = 0; l < nm; ++l) J2.middleRows<3>(3 * (k * nm + l)) = full(I.J2.block<6, 1>(6 * k, l));
  }
  f.compare("invariant m", MatrixX::Constant(1, 1, I.mass), matrix(want.at("m")));
  f.compare("invariant s0", I.s0, matrix(want.at("s0")), std::sqrt(largest("m") * largest("J0")));
  f.compare("invariant Ct", I.Ct, matrix3(want.at("Ct")), std::sqrt(largest("m") * largest("Mff")));
  f.compare("invariant J0", full(I.J0), matrix(want.at("J0")));
  f.compare("invariant J1", J1, matrix3(want.at("J1")), std::sqrt(largest("J0") * largest("J2")));
  f.compare("invariant J2", J2, matrix3(want.at("J2")));
  f.compare("invariant C0", I.C0, matrix3(want.at("C0")), std::sqrt(largest("J0") * largest("Mff")));
  f.compare("invariant C1", C1, matrix3(want.at("C1")), largest("Mff"));
  f.compare("invariant Mff", I.Mff, matrix(want.at("Mff")));
}

/// Everything a body owes at one state of the file.
void compare_state(const nlohmann::json& data, const nlohmann::json& entry, Evaluated& body, Findings& f) {
  const auto& want = entry.at("expected");
  const BodyState s = body.state();
  const FlexibleBody& flexible = body.body();
  const Vector3 gravity = matrix(data.at("gravity"));
  const BodyEnergy energy = flexible.energy(s, gravity);
  f.compare("A", s.cache->A, matrix(entry.at("A")));
  f.compare("M", flexible.mass_matrix(s), matrix(want.at("M")));
  f.compare("f_v", flexible.quadratic_velocity_force(s), matrix(want.at("f_v")));
  f.compare("f_gravity", flexible.gravity_force(s, gravity), matrix(want.at("f_gravity")));
  f.compare("kinetic_energy", MatrixX::Constant(1, 1, energy.kinetic), matrix(want.at("kinetic_energy")));
  f.compare("linear_momentum", flexible.linear_momentum(s), matrix(want.at("linear_momentum")));
  const Vector3 about_origin = flexible.angular_momentum(s), p = flexible.linear_momentum(s);
  const Eigen::Map<const Vector3> x(s.q);
  f.compare("angular_momentum_origin", about_origin, matrix(want.at("angular_momentum_origin")));
  f.compare("angular_momentum_x0_body", s.cache->A.transpose() * (about_origin - x.cross(p)),
            matrix(want.at("angular_momentum_x0_body")));
  if (!want.contains("inertia_force")) return;

  const VectorX internal = flexible.elastic_force(s) + flexible.damping_force(s);
  VectorX residual = VectorX::Zero(internal.size());
  flexible.add_residual(s, body.v_dot(), Vector3::Zero(), residual.data());
  f.compare("inertia_force", residual + internal, matrix(want.at("inertia_force")));
  f.compare("f_elastic", flexible.elastic_force(s), matrix(want.at("f_elastic")));
  f.compare("f_damping", flexible.damping_force(s), matrix(want.at("f_damping")));
  f.compare("elastic_energy", MatrixX::Constant(1, 1, energy.elastic), matrix(want.at("elastic_energy")));
  f.compare("gravity_energy", MatrixX::Constant(1, 1, energy.gravity), matrix(want.at("gravity_energy")));
  const Vector3 force = matrix(entry.at("point_force").at("force")), torque = matrix(entry.at("marker_torque"));
  const int node = entry.at("point_force").at("node");
  f.compare("f_point", body.generalized(body.node_marker(node), force, Vector3::Zero()), matrix(want.at("f_point")));
  f.compare("f_marker_force", body.generalized(body.marker(), force, Vector3::Zero()),
            matrix(want.at("f_marker_force")));
  f.compare("f_marker_torque", body.generalized(body.marker(), Vector3::Zero(), torque),
            matrix(want.at("f_marker_torque")));
  const auto k = body.kinematics(body.marker());
  const Vector6 acceleration = body.acceleration(body.marker());
  const auto& m = want.at("marker");
  f.compare("marker p", k.p, matrix(m.at("p")));
  f.compare("marker R", k.R, matrix(m.at("R")));
  f.compare("marker v", k.v, matrix(m.at("v")));
  f.compare("marker Omega", k.w, matrix(m.at("Omega")));
  f.compare("marker vdot", acceleration.head<3>(), matrix(m.at("vdot")));
  f.compare("marker Omegadot", acceleration.tail<3>(), matrix(m.at("Omegadot")));
  const auto motion = flexible.nodal_motion(s, body.v_dot());
  for (const auto& n : want.at("nodes")) {
    const int i = n.at("node");
    f.compare("node position", motion.position.col(i), matrix(n.at("position")));
    f.compare("node velocity", motion.velocity.col(i), matrix(n.at("velocity")));
    f.compare("node acceleration", motion.acceleration.col(i), matrix(n.at("acceleration")));
  }
}

}  // namespace

Findings check_body(const nlohmann::json& data) {
  Findings f;
  if (data.contains("invariants")) compare_invariants(integrals_of(data), data.at("invariants"), f);
  Evaluated body(data);
  for (const auto& entry : data.at("states")) {
    body.set(entry.at("state"));
    compare_state(data, entry, body, f);
    if (!data.contains("mass_scalar")) continue;
    // The nodal form, all 3n coordinates, seen through B: the same M and f_v.
    const NodalForm nodal(data, entry.at("state"));
    f.compare("M, nodal form", nodal.M, matrix(entry.at("expected").at("M")));
    f.compare("f_v, nodal form", nodal.f_v, matrix(entry.at("expected").at("f_v")));
    f.compare("f_gravity, nodal form", nodal.f_gravity, matrix(entry.at("expected").at("f_gravity")));
  }
  return f;
}

Findings check_stiffness(const nlohmann::json& data) {
  // Kw given: with it in J2, M and f_v hold the stiffening by spin in conserving form (docs/equations.md 4.5).
  Findings f;
  InertiaIntegrals I = integrals_of(data);
  const auto& Kw = data.at("Kgeo").at("Kw");
  static constexpr int kPair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  for (int c = 0; c < 6; ++c) {
    const MatrixX K = matrix(Kw[kPair[c][0]][kPair[c][1]]);
    for (int k = 0; k < I.mode_count(); ++k)
      for (int l = 0; l < I.mode_count(); ++l) I.J2(6 * k + c, l) -= K(k, l);
  }
  Evaluated body(data, std::move(I));
  for (const auto& entry : data.at("states")) {
    body.set(entry.at("state"));
    f.compare("M_with_Kw", body.body().mass_matrix(body.state()), matrix(entry.at("expected").at("M_with_Kw")));
    f.compare("f_v_with_Kw", body.body().quadratic_velocity_force(body.state()),
              matrix(entry.at("expected").at("f_v_with_Kw")));
  }
  f.note = "K_geo itself is not computed yet: Kw taken from the file";
  return f;
}

}  // namespace lithe::oracle
