#include "plugins/inertial_body/inertial_body.h"

#include <limits>

namespace lithe {
namespace {

using ConstVector3 = Eigen::Map<const Vector3>;
using ConstVector = Eigen::Map<const VectorX>;
using Points = Eigen::Map<const Matrix3X>;

InertialBody::Parameters with_mesh(InertialBody::Parameters p) {
  if (!p.mesh && p.mesh_file.empty())
    throw SceneError("has no mesh", "", "give .mesh_file, a CalculiX deck, or .mesh, read or made by brick_block()");
  try {
    if (!p.mesh) p.mesh = std::make_shared<const BrickMesh>(read_brick_mesh(p.mesh_file.string()));
  } catch (const FileError& error) {  // a plug-in's border lets the problem through, not the place
    throw FileError(error.where() + ": " + error.problem(), error.where(), error.fix());
  }
  require_sound(*p.mesh);
  return p;
}

}  // namespace

InertialBody::Cache::Cache(const InertialBody& body)
    : modes(body.bricks_.batch_count()), force(VectorX::Zero(3 * body.node_count())) {
  for (auto& batch : modes) brick::clear(batch.alpha, 3 * brick::kModes);
  elastic.resize(static_cast<size_t>(body.marker_count()));
}

InertialBody::InertialBody(Parameters parameters)
    : parameters_(with_mesh(std::move(parameters))), bricks_(*parameters_.mesh) {
  const auto& p = parameters_;
  require::finite(p.position, "position");
  require::rotation(p.orientation, "orientation");
  require::finite(p.velocity, "velocity");
  require::finite(p.angular_velocity, "angular_velocity");
  require::not_negative(p.mass_damping, "mass_damping");
  require::not_negative(p.stiffness_damping, "stiffness_damping");
  mass_ = bricks_.nodal_mass().sum();
  // The scalar blocks of M once, from the entries of the x axis.
  mass_diagonal_.setZero(node_count());
  const LinearPattern& pattern = bricks_.pattern();
  for (int k = 0; k < pattern.rows.size(); ++k) {
    const int i = pattern.rows[k], j = pattern.columns[k];
    if (i % 3 != 0 || j % 3 != 0) continue;
    if (i == j)
      mass_diagonal_[i / 3] = bricks_.mass()[k];
    else
      mass_entries_.push_back({i / 3, j / 3, bricks_.mass()[k]});
  }
}

void InertialBody::add_mass_product(double weight, const double* x, double* out) const {
  for (int i = 0; i < node_count(); ++i)
    Eigen::Map<Vector3>(out + 3 * i) += weight * mass_diagonal_[i] * ConstVector3(x + 3 * i);
  for (const MassEntry& entry : mass_entries_) {
    const double m = weight * entry.m;
    Eigen::Map<Vector3>(out + 3 * entry.i) += m * ConstVector3(x + 3 * entry.j);
    Eigen::Map<Vector3>(out + 3 * entry.j) += m * ConstVector3(x + 3 * entry.i);
  }
}

void InertialBody::initial_state(VectorRef q, VectorRef v) const {
  const auto& p = parameters_;
  for (int i = 0; i < node_count(); ++i) {
    const Vector3 X = mesh().nodes.col(i);
    q.segment<3>(3 * i) = p.position + p.orientation * X;
    v.segment<3>(3 * i) = p.velocity + p.orientation * p.angular_velocity.cross(X);
  }
}

void InertialBody::evaluate(const BodyState& state, Level level) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  if (!bricks_.find_modes(state.q, cache.modes)) {
    cache.force.setConstant(std::numeric_limits<double>::quiet_NaN());
    cache.strain_energy = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  cache.force.setZero();
  cache.strain_energy = bricks_.add_elastic_force(state.q, cache.modes, cache.force.data());
  const double beta = parameters_.stiffness_damping;
  if (beta > 0 && level != Level::position)
    bricks_.add_viscous_force(state.q, cache.modes, state.v, beta, cache.force.data());
}

void InertialBody::add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  Eigen::Map<VectorX>(r, cache.force.size()) += cache.force;
  add_mass_product(1, v_dot, r);
  if (parameters_.mass_damping > 0) add_mass_product(parameters_.mass_damping, state.v, r);
  for (int i = 0; i < node_count(); ++i) Eigen::Map<Vector3>(r + 3 * i) -= bricks_.nodal_mass()[i] * gravity;
}

void InertialBody::add_tangent(const BodyState& state, const double*, const Vector3&, const TangentWeights& weights,
                               BodyTangent& S) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  S.linear += (weights.acceleration + weights.velocity * parameters_.mass_damping) * bricks_.mass();
  using Stiffness = brick::Bricks::Stiffness;
  if (weights.position != 0)
    bricks_.add_stiffness(state.q, cache.modes, Stiffness::tangent, weights.position, S.linear.data());
  const double viscous = weights.velocity * parameters_.stiffness_damping;
  if (viscous != 0) bricks_.add_stiffness(state.q, cache.modes, Stiffness::material, viscous, S.linear.data());
}

BodyEnergy InertialBody::energy(const BodyState& state, const Vector3& gravity) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  BodyEnergy e;
  e.elastic = cache.strain_energy;
  for (int i = 0; i < node_count(); ++i) {
    e.gravity -= bricks_.nodal_mass()[i] * gravity.dot(ConstVector3(state.q + 3 * i));
    e.kinetic += 0.5 * mass_diagonal_[i] * ConstVector3(state.v + 3 * i).squaredNorm();
  }
  for (const MassEntry& entry : mass_entries_)
    e.kinetic += entry.m * ConstVector3(state.v + 3 * entry.i).dot(ConstVector3(state.v + 3 * entry.j));
  return e;
}

LITHE_EXPORT_BODY(InertialBody, "inertial_body")  // empty unless built by lithe_add_plugin()

}  // namespace lithe
