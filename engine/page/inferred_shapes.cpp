#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "engine/model/rigid_frame_body.h"
#include "engine/page/run_record_internal.h"

namespace lithe {
namespace {

/// The box of even density that has this mass and inertia, in body axes.
DrawnShape inertia_box(const RigidInertia& body) {
  const Eigen::SelfAdjointEigenSolver<MatrixX> principal{MatrixX(body.inertia)};
  const Vector3 moments = principal.eigenvalues();
  Vector3 edges;  // m/12 (b² + c²) = I_a
  for (int i = 0; i < 3; ++i) edges[i] = std::sqrt(std::max(0.0, 6 / body.mass * (moments.sum() - 2 * moments[i])));
  edges = edges.cwiseMax(0.02 * edges.maxCoeff());
  Matrix3 axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) *= -1;
  return visual::box(edges).at(Vector3(0, 0, 0), axes);
}

}  // namespace

std::vector<DrawnShape> inferred_shapes(const Body& body, const std::vector<Vector3>& markers, double extent) {
  double reach = 0;
  for (const Vector3& marker : markers) reach = std::max(reach, marker.norm());
  std::vector<DrawnShape> shapes;
  if (reach > 1e-9 * extent && reach > 0) {  // sticks from the origin of its frame
    const double radius = 0.03 * reach;
    for (auto marker = markers.begin(); marker != markers.end(); ++marker) {
      const bool again =
          std::any_of(markers.begin(), marker, [&](const Vector3& m) { return (m - *marker).norm() < radius; });
      if (!again && marker->norm() > 0.05 * reach) shapes.push_back(visual::rod(Vector3(0, 0, 0), *marker, radius));
    }
    shapes.push_back(visual::sphere(2 * radius));
    return shapes;
  }
  // An inertia of no matter (1, 1, 1) may be larger than the scene: then its likeness.
  if (const auto* rigid = rigid_inertia_of(body); rigid && rigid->mass > 0) {
    DrawnShape box = inertia_box(*rigid);
    const double largest = *std::max_element(box.size.begin(), box.size.end());
    const double allowed = extent > 0 ? std::min(largest, 0.3 * extent) : largest;
    if (!(largest > 0)) return {visual::sphere(extent > 0 ? 0.05 * extent : 0.1)};
    for (double& edge : box.size) edge *= allowed / largest;
    return {box};
  }
  return {visual::sphere(extent > 0 ? 0.03 * extent : 0.1)};
}

}  // namespace lithe
