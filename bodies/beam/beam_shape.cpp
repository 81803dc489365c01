#include "bodies/beam/beam.h"
#include "bodies/beam/beam_model.h"
#include "bodies/beam/se3_internal.h"
#include "bodies/surface_writer.h"

namespace lithe {
namespace {

constexpr int kRings = 3;  // an element
constexpr int kCorners = 4;

}  // namespace

/// The nodes, then rings of corners from the first node to the last.
Matrix3X Beam::surface(std::span<const FramePose> nodes) const {
  Matrix3X points(3, node_count() + kCorners * (kRings * element_count() + 1));
  int at = 0;
  for (const FramePose& node : nodes) points.col(at++) = node.position;
  for (int e = 0; e < element_count(); ++e) {
    const BeamSpan& span = spans_[static_cast<std::size_t>(e)];
    const FramePose &a = nodes[static_cast<std::size_t>(e)], &b = nodes[static_cast<std::size_t>(e) + 1];
    const Vector6 d = se3::log_between(a.position, a.axes, b.position, b.axes);
    const auto [b2, b3] = span.section().edges(0.01 * span.length());
    const Vector3 center = span.section().mass_center();
    for (int ring = 0; ring < kRings + (e + 1 == element_count() ? 1 : 0); ++ring) {
      const auto h = se3::exp(static_cast<double>(ring) / kRings * d);
      for (const auto& [s2, s3] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
        const Vector3 corner(0, center[1] + 0.5 * s2 * b2, center[2] + 0.5 * s3 * b3);
        points.col(at++) = a.position + a.axes * (h.p + h.R * corner);
      }
    }
  }
  return points;
}

DrawnMesh Beam::drawn_mesh(bool) const {
  DrawnMesh drawn;
  drawn.nodal = true;
  drawn.points = surface(poses_);
  const int nodes = node_count(), rings = kRings * element_count() + 1;
  for (int i = 0; i < nodes; ++i) drawn.nodes.push_back(i);
  for (int ring = 0; ring < rings; ++ring) drawn.nodes.insert(drawn.nodes.end(), kCorners, (ring + 1) / kRings);
  const auto rim = [&](int ring, int corner) { return nodes + kCorners * ring + corner % kCorners; };
  for (int ring = 0; ring + 1 < rings; ++ring)
    for (int k = 0; k < kCorners; ++k) {
      drawn.triangles.push_back({rim(ring, k), rim(ring, k + 1), rim(ring + 1, k + 1)});
      drawn.triangles.push_back({rim(ring, k), rim(ring + 1, k + 1), rim(ring + 1, k)});
      if (ring % kRings == 0) drawn.edges.push_back({rim(ring, k), rim(ring, k + 1)});
      drawn.edges.push_back({rim(ring, k), rim(ring + 1, k)});
    }
  for (int k = 0; k < kCorners; ++k) drawn.edges.push_back({rim(rings - 1, k), rim(rings - 1, k + 1)});
  for (int k = 2; k < kCorners; ++k) {  // its ends
    drawn.triangles.push_back({rim(0, 0), rim(0, k), rim(0, k - 1)});
    drawn.triangles.push_back({rim(rings - 1, 0), rim(rings - 1, k - 1), rim(rings - 1, k)});
  }
  return drawn;
}

DrawnSkin drawn_skin(const Beam& beam) {
  DrawnMesh drawn = beam.drawn_mesh(false);
  DrawnSkin skin{std::move(drawn.points), {}, {}, std::move(drawn.triangles), std::move(drawn.edges)};
  const int nodes = beam.node_count(), last = beam.element_count() - 1;
  for (int point = 0; point < skin.points.cols(); ++point) {
    const int ring = point < nodes ? kRings * point : (point - nodes) / kCorners, e = std::min(ring / kRings, last);
    skin.nodes.push_back({e, e + 1});
    skin.shares.push_back(static_cast<double>(ring - kRings * e) / kRings);
  }
  return skin;
}

void Beam::drawn_points(const BodyState& state, const DrawnMesh&, Matrix3X& points) const {
  std::vector<FramePose> nodes(poses_.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    nodes[i] = {Eigen::Map<const Vector3>(state.q + 7 * i),
                rotation_matrix(Eigen::Map<const Vector4>(state.q + 7 * i + 3))};
  points = surface(nodes);
}

SurfaceWriter::Fields section_fields(const Beam& beam) {
  return [&beam](const BodyState& state, const DrawnMesh& mesh) {
    const int nodes = beam.node_count(), elements = beam.element_count();
    MatrixX elemental(12, elements);
    for (int e = 0; e < elements; ++e) elemental.col(e) << beam.strain(state, e), beam.resultants(state, e);
    MatrixX values(12, mesh.points.cols());
    for (Eigen::Index point = 0; point < values.cols(); ++point) {
      const int ring = point < nodes ? kRings * static_cast<int>(point) : static_cast<int>(point - nodes) / kCorners;
      const int after = ring / kRings, before = ring % kRings == 0 ? after - 1 : after;
      values.col(point) = 0.5 * (elemental.col(std::max(before, 0)) + elemental.col(std::min(after, elements - 1)));
    }
    return std::vector<VtuField>{{"strain", values.topRows<3>()},
                                 {"curvature", values.middleRows<3>(3)},
                                 {"force", values.middleRows<3>(6)},
                                 {"moment", values.bottomRows<3>()}};
  };
}

std::vector<std::pair<int, double>> Beam::nodes_of_marker(int marker) const {
  const Place& place = places_[static_cast<std::size_t>(marker)];
  if (const int node = node_of(place); node >= 0) return {{node, 1.0}};
  return {{place.element, 1 - place.share}, {place.element + 1, place.share}};
}

}  // namespace lithe
