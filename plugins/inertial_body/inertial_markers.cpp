#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <set>

#include "plugins/inertial_body/inertial_body.h"

namespace lithe {
namespace {

// Weight of the elements around where the marker's own nodes leave the rotation open.
constexpr double kNeighbourWeight = 1e-3;

bool span_a_plane(const BrickMesh& mesh, const std::vector<int>& nodes) {
  if (nodes.size() < 3) return false;
  Vector3 center = Vector3::Zero();
  for (int i : nodes) center += mesh.nodes.col(i) / static_cast<double>(nodes.size());
  Matrix3 spread = Matrix3::Zero();
  for (int i : nodes) spread += (mesh.nodes.col(i) - center) * (mesh.nodes.col(i) - center).transpose();
  const Vector3 size = Eigen::SelfAdjointEigenSolver<Matrix3>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  return size[1] > 1e-9 * size[2];
}

/// The rotation nearest to H = Σ w x ρᵀ (Kabsch 1976); proper even where H is flat or turned inside out.
Matrix3 best_rotation(const Matrix3& H) {
  const Eigen::JacobiSVD<Matrix3> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3 U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

}  // namespace

/// The nodes of all elements that touch `nodes`.
std::vector<int> InertialBody::neighbours(const std::vector<int>& nodes) const {
  std::set<int> around;
  for (const auto& element : mesh().elements)
    if (std::any_of(element.begin(), element.end(),
                    [&](int i) { return std::find(nodes.begin(), nodes.end(), i) != nodes.end(); }))
      around.insert(element.begin(), element.end());
  return {around.begin(), around.end()};
}

Marker InertialBody::add_marker(std::vector<int> points, const std::vector<std::pair<int, double>>& fitted,
                                const Matrix3& orientation) {
  MarkerShape shape{std::move(points), {}, orientation};
  double total = 0;
  Vector3 center = Vector3::Zero();
  for (const auto& [node, weight] : fitted) {
    total += weight;
    center += weight * mesh().nodes.col(node);
  }
  center /= total;
  for (const auto& [node, weight] : fitted)
    shape.arms.push_back({node, weight / total, mesh().nodes.col(node) - center});
  markers_.push_back(std::move(shape));
  return new_marker();
}

Marker InertialBody::node(int id, const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of a node marker"); });
  const int i = mesh().node_index(id);
  std::vector<std::pair<int, double>> fitted;
  for (int around : neighbours({i})) fitted.emplace_back(around, 1.0);
  return add_marker({i}, fitted, orientation);
}

Marker InertialBody::average(const std::vector<int>& ids, const Matrix3& orientation) {
  if (ids.empty())
    throw SceneError("an average marker on '" + name() + "' has no nodes", where(), "name at least one node");
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of an average marker"); });
  std::vector<int> points;
  std::vector<std::pair<int, double>> fitted;
  for (int id : ids) {
    points.push_back(mesh().node_index(id));
    fitted.emplace_back(points.back(), 1.0);
  }
  if (!span_a_plane(mesh(), points))
    for (int around : neighbours(points)) fitted.emplace_back(around, kNeighbourWeight);
  return add_marker(std::move(points), fitted, orientation);
}

/// With arms ρ from the weighted centre of the undeformed nodes and H = Σ w x ρᵀ, R fits best where H Rᵀ is symmetric;
/// differentiated in time, with T = tr(H Rᵀ) 1 - H Rᵀ:
///   T ω = Σ w (R ρ) × v,   T ω̇ = Σ w ((R ρ) × a + (ω × R ρ) × v) - Ṫ ω
void InertialBody::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  const MarkerShape& m = markers_[marker];
  if (static_cast<int>(cache.elastic.size()) < marker_count())  // markers made since
    cache.elastic.resize(static_cast<size_t>(marker_count()));
  const auto position = [&](int node) { return Eigen::Map<const Vector3>(state.q + 3 * node); };
  const auto velocity = [&](int node) { return Eigen::Map<const Vector3>(state.v + 3 * node); };

  const double share = 1.0 / static_cast<double>(m.points.size());
  k.p.setZero();
  for (int node : m.points) k.p += share * position(node);
  const Vector3 origin = position(m.arms.front().node);  // Σ w ρ = 0: x may be taken from anywhere
  Matrix3 H = Matrix3::Zero();
  for (const auto& arm : m.arms) H += (arm.weight * (position(arm.node) - origin)) * arm.rho.transpose();
  const Matrix3 R = best_rotation(H);
  const Matrix3 stretch = H * R.transpose();
  const Matrix3 T_inverse = (stretch.trace() * Matrix3::Identity() - stretch).inverse();
  k.R = R * m.orientation;
  k.r = k.p;
  k.A = &cache.A;

  Matrix6X& J = cache.elastic[marker];  // columns of other nodes stay zero
  if (J.cols() == 0) J = Matrix6X::Zero(6, 3 * node_count());
  for (int node : m.points) J.middleCols<3>(3 * node).setZero();
  for (const auto& arm : m.arms) J.middleCols<3>(3 * arm.node).setZero();
  for (int node : m.points)
    for (int i = 0; i < 3; ++i) J(i, 3 * node + i) += share;
  for (const auto& arm : m.arms)
    J.middleCols<3>(3 * arm.node).bottomRows<3>() += T_inverse * skew(arm.weight * (R * arm.rho));
  k.elastic = J.data();
  if (level == Level::position) return;

  k.v.setZero();
  for (int node : m.points) k.v += share * velocity(node);
  const Vector3 drift = velocity(m.arms.front().node);
  Vector3 spin = Vector3::Zero();
  for (const auto& arm : m.arms) spin += (arm.weight * (R * arm.rho)).cross(Vector3(velocity(arm.node) - drift));
  k.w = T_inverse * spin;
  if (level == Level::velocity) return;

  k.bias_v.setZero();
  Matrix3 stretch_rate = Matrix3::Zero();
  Vector3 turning = Vector3::Zero();
  for (const auto& arm : m.arms) {
    const Vector3 rho = arm.weight * (R * arm.rho), rho_rate = k.w.cross(rho), v = velocity(arm.node) - drift;
    stretch_rate += v * rho.transpose() + Vector3(position(arm.node) - origin) * rho_rate.transpose();
    turning += rho_rate.cross(v);
  }
  k.bias_w = T_inverse * (turning - stretch_rate.trace() * k.w + stretch_rate * k.w);
}

}  // namespace lithe
