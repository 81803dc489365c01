#include "bodies/flexible/nodal_loads.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cstdio>

#include "bodies/flexible/node_sets.h"
#include "engine/base/error.h"
#include "engine/observe/sensors.h"
#include "engine/output/partial_file.h"

namespace lithe {
namespace {

/// How the nodes move with the body's velocities, body axes: 3n x (6 + nm), at the deformation η or undeformed.
MatrixX node_motions(const FlexibleBody& body, const VectorX& eta) {
  const int count = 6 + body.mode_count();
  VectorX q = VectorX::Zero(count + 1), v = VectorX::Zero(count);
  q[3] = 1;
  q.tail(body.mode_count()) = eta;
  const auto cache = body.make_cache();
  const BodyState still{q.data(), v.data(), cache.get()};
  body.evaluate(still, Level::acceleration);
  MatrixX L(body.basis().nodes.size(), count);
  for (int k = 0; k < count; ++k)
    L.col(k) = body.nodal_motion(still, VectorX::Unit(count, k).eval().data()).acceleration.reshaped();
  return L;
}

/// Of the nodes relative to the body frame, body axes; exactly zero where the frame holds them.
Matrix3X deformation_of(const FlexibleBody& body, const BodyState& state) {
  const ModalBasis& basis = body.basis();
  const VectorX xi = body.field_coordinates(state);
  VectorX u = VectorX::Zero(basis.nodes.size());
  if (basis.nodal) {
    for (Eigen::Index k = 0; k < xi.size(); ++k) u[basis.free_dofs[static_cast<size_t>(k)]] = xi[k];
  } else {
    const Eigen::Index linear = std::min(xi.size(), basis.modes.cols());
    u = basis.modes.leftCols(linear) * xi.head(linear);
    if (xi.size() > linear) u += basis.deflection->fields * xi.tail(xi.size() - linear);
  }
  return u.reshaped(3, basis.nodes.cols());
}

/// A wrench about the origin of the body frame as forces of least norm on the degrees of freedom that the frame holds,
/// body axes: they do no work on any mode. As far as these can bear it.
Matrix3X on_held_nodes(const ModalBasis& basis, const Vector6& wrench) {
  VectorX held = VectorX::Zero(basis.nodes.size());
  if (basis.nodal) {
    held.setOnes();
    for (int dof : basis.free_dofs) held[dof] = 0;
  } else {
    for (Eigen::Index i = 0; i < held.size(); ++i) held[i] = basis.modes.row(i).isZero(0);
  }
  const MatrixX rigid = held.asDiagonal() * rigid_motions(basis.nodes, Vector3::Zero());
  const Matrix6 resultants = rigid.transpose() * rigid;
  return (rigid * Eigen::CompleteOrthogonalDecomposition<MatrixX>(resultants).solve(VectorX(wrench)))
      .reshaped(3, basis.nodes.cols());
}

/// Adds a wrench at a marker, body axes, to the forces on its nodes.
void add_wrench(const FlexibleBody& body, const Marker& marker, const Vector3& force, const Vector3& torque,
                Matrix3X& forces) {
  const auto& [nodes, weights] = body.marker_nodes(marker.index);
  const NodeAverage mean(body.basis().nodes, nodes, weights, body.name());
  const Vector3 turn = mean.spread_inverse * torque;
  for (size_t k = 0; k < nodes.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    forces.col(nodes[k]) += mean.weights[column] * (force + turn.cross(mean.arms.col(column)));
  }
}

/// Adds what connectors do to the body; `sensor` reads the wrench of one at its marker number m, world axes.
template <class Entries, class ElementOf, class SensorOf>
void add_connectors(const FlexibleBody& body, const Entries& entries, ElementOf&& element_of, SensorOf&& sensor,
                    Snapshot& now, const BodyState& state, Matrix3X& forces) {
  const Matrix3 to_body = state.cache->A.transpose();
  for (const auto& entry : entries)
    for (size_t m = 0; m < entry.markers.size(); ++m) {
      if (entry.markers[m].body != &body) continue;
      Vector6 wrench;
      sensor(*element_of(entry), static_cast<int>(m)).evaluate(now, {wrench.data(), 6});
      const Vector3 force = to_body * wrench.head<3>(), torque = to_body * wrench.tail<3>();
      if (!body.marker_nodes(entry.markers[m].index).nodes.empty()) {
        add_wrench(body, entry.markers[m], force, torque, forces);
        continue;
      }
      Vector6 about_origin;
      about_origin << force, torque;
      about_origin.tail<3>() +=
          (to_body * (now.marker(entry.markers[m]).p - Vector3(state.q[0], state.q[1], state.q[2]))).cross(force);
      forces += on_held_nodes(body.basis(), about_origin);
    }
}

/// The shortest text of up to 17 digits that fits the 20 columns CalculiX reads.
std::string number(double value) {
  char text[40];
  for (int digits = 17; digits > 0; --digits)
    if (std::snprintf(text, sizeof text, "%.*g", digits, value) <= 20) break;
  return text;
}

/// Six degrees of freedom that hold the rigid motions, among those without displacement as far as these do.
std::vector<int> determinate_support(const FiniteElementModel& model, const Matrix3X& displacements) {
  const Vector3 center = model.nodes.rowwise().mean();
  MatrixX rigid = rigid_motions(model.nodes, center).transpose();
  const double size = (model.nodes.colwise() - center).colwise().norm().maxCoeff();
  rigid.bottomRows<3>() /= size > 0 ? size : 1;
  constexpr double kOthers = 1e-3;  // far below what any held one adds
  for (Eigen::Index i = 0; i < rigid.cols(); ++i)
    if (displacements.reshaped()[i] != 0) rigid.col(i) *= kOthers;
  const Eigen::ColPivHouseholderQR<MatrixX> qr(rigid);
  std::vector<int> dofs(6);
  for (int k = 0; k < 6; ++k) dofs[static_cast<size_t>(k)] = qr.colsPermutation().indices()[k];
  std::sort(dofs.begin(), dofs.end());
  return dofs;
}

}  // namespace

NodalLoads nodal_loads(const FlexibleBody& body, Snapshot& snapshot, LoadGeometry geometry) {
  const ModalBasis& basis = body.basis();
  if (!basis.rotations.empty())
    throw SceneError("nodal loads of '" + body.name() + "', whose nodes have rotations", body.where(),
                     "loads back are for solids: the moments that its nodes bear are not known to the basis");
  const BodyState state = snapshot.body_state(body);
  const Matrix3& A = state.cache->A;
  const auto motion =
      body.nodal_motion(state, snapshot.accelerations().data() + snapshot.system().layout().slice(body).v);

  for (const auto& entry : snapshot.system().graph().contacts())
    for (const Marker& m : entry.markers)
      if (m.body == &body)
        throw SceneError(
            "nodal loads of '" + body.name() + "', which the contact '" + entry.contact->name() + "' touches",
            entry.contact->where(), "take nodal loads of a body without colliders");

  // Gravity and inertia, then what joints and force elements do to the nodes of their markers; body axes.
  const Matrix3X falling = A.transpose() * ((-motion.acceleration).colwise() + snapshot.system().gravity());
  Matrix3X forces = falling * basis.nodal_mass;
  const SystemGraph& graph = snapshot.system().graph();
  add_connectors(
      body, graph.constraints(), [](const auto& entry) { return entry.constraint; },
      [](const Constraint& joint, int m) { return reaction(joint, m); }, snapshot, state, forces);
  add_connectors(
      body, graph.forces(), [](const auto& entry) { return entry.force; },
      [](const ForceElement& element, int m) { return applied_force(element, m); }, snapshot, state, forces);

  // What is missing in the body's own equations, Lᵀ f = (0, 0, elastic force), as inertia forces.
  const VectorX eta = Eigen::Map<const VectorX>(state.q + 7, body.mode_count());
  const bool deformed = geometry == LoadGeometry::deformed;
  const MatrixX L = node_motions(body, deformed ? eta : VectorX(VectorX::Zero(eta.size())));
  VectorX missing = VectorX::Zero(L.cols());
  if (deformed)
    missing = -body.elastic_force(state);
  else
    missing.tail(eta.size()) = basis.stiffness.topLeftCorner(eta.size(), eta.size()) * eta;
  missing -= L.transpose() * forces.reshaped();
  MatrixX SL(L.rows(), L.cols());
  for (Eigen::Index k = 0; k < L.cols(); ++k)
    SL.col(k) = (L.col(k).reshaped(3, forces.cols()) * basis.nodal_mass).reshaped();
  const VectorX x = (L.transpose() * SL).ldlt().solve(missing);
  forces += (SL * x).reshaped(3, forces.cols());

  NodalLoads loads{.time = snapshot.time()};
  loads.forces = basis.rotation * forces;
  loads.displacements = basis.rotation * deformation_of(body, state);
  loads.spread_force = basis.rotation * missing.head<3>();
  loads.spread_moment = basis.rotation * missing.segment<3>(3);
  if (!loads.forces.allFinite())
    throw SceneError("nodal loads of '" + body.name() + "' that are not finite at " + std::to_string(loads.time) + " s",
                     body.where(), "look at the accelerations of the state: an integrator must have set them");
  return loads;
}

void write_calculix_loads(const std::string& path, const FiniteElementModel& model, const NodalLoads& loads) {
  if (loads.forces.cols() != model.node_count() || loads.displacements.cols() != model.node_count())
    throw SceneError("loads on " + std::to_string(loads.forces.cols()) + " nodes for a model of " +
                         std::to_string(model.node_count()),
                     "model '" + model.name + "'", "give the model that the body was reduced from");
  PartialFile file(path);
  std::ostream& out = file.stream();
  out << "** Loads of a flexible body at t = " << number(loads.time)
      << " s, in equilibrium: *INCLUDE in a *STATIC step\n"
      << "** of the body's own deck. They need no support; one that is statically determinate bears nothing:\n"
      << "** *BOUNDARY\n";
  for (int dof : determinate_support(model, loads.displacements)) {
    const std::string axis = std::to_string(dof % 3 + 1);
    out << "** " << model.node_ids[static_cast<size_t>(dof / 3)] << "," << axis << "," << axis << "\n";
  }
  out << "*CLOAD\n";
  for (int i = 0; i < model.node_count(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (const double force = loads.forces(axis, i); force != 0)
        out << model.node_ids[static_cast<size_t>(i)] << "," << axis + 1 << "," << number(force) << "\n";
  file.commit();
}

}  // namespace lithe
