#include "bodies/flexible/surface_mesh.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "bodies/flexible/elements/meshes.h"
#include "engine/base/error.h"
#include "engine/model/system_graph.h"
#include "tests/bodies/flexible_models.h"

namespace lithe::test::surface_mesh_test {
namespace {

struct Measure {
  double area = 0, volume = 0;
  Vector3 closure = Vector3::Zero();  // ∮ n dA
  bool closed = true;                 // every edge once each way
};

Measure measure(const std::vector<std::array<int, 3>>& triangles, const std::vector<Vector3>& points) {
  Measure m;
  std::map<std::pair<int, int>, int> ways;
  for (const auto& t : triangles) {
    const Vector3 &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
    const Vector3 normal = 0.5 * (b - a).cross(c - a);
    m.area += normal.norm();
    m.volume += normal.dot(a) / 3;  // divergence theorem
    m.closure += normal;
    for (int i = 0; i < 3; ++i) ++ways[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : ways)
    m.closed = m.closed && count == 1 && ways.count({edge.second, edge.first}) == 1;
  return m;
}

TEST(SurfaceMesh, encloses_the_volume_of_a_block_of_any_solid) {
  for (const char* type : {"C3D4", "C3D8", "C3D8I", "C3D10", "C3D20", "C3D20R"}) {
    const FiniteElementModel model = brick_mesh(
        {.size = {0.3, 0.1, 0.2}, .divisions = {3, 2, 2}, .type = type, .material = {2e11, 0.3, 7800}, .name = type});
    const auto triangles = boundary_triangles(model.elements, model.nodes);
    std::vector<Vector3> points;
    for (Eigen::Index i = 0; i < model.nodes.cols(); ++i) points.emplace_back(model.nodes.col(i));
    const Measure m = measure(triangles, points);
    EXPECT_NEAR(m.volume, 0.3 * 0.1 * 0.2, 1e-15) << type;
    EXPECT_NEAR(m.area, 2 * (0.3 * 0.1 + 0.3 * 0.2 + 0.1 * 0.2), 1e-14) << type;
    EXPECT_LT(m.closure.norm(), 1e-15) << type;
    EXPECT_TRUE(m.closed) << type;
    // Every node of the boundary, those in the middles of edges too, and no other.
    std::set<int> used, outside;
    for (const auto& t : triangles) used.insert(t.begin(), t.end());
    for (int i = 0; i < static_cast<int>(points.size()); ++i)
      for (int axis = 0; axis < 3; ++axis)
        if (points[i][axis] < 1e-12 || points[i][axis] > model.nodes.row(axis).maxCoeff() - 1e-12) outside.insert(i);
    EXPECT_EQ(used, outside) << type;
  }
}

TEST(SurfaceMesh, knows_wedges_and_collapsed_bricks) {
  Matrix3X nodes(3, 8);
  nodes << 0, 1, 1, 0, 0, 1, 1, 0,  //
      0, 0, 1, 1, 0, 0, 1, 1,       //
      0, 0, 0, 0, 1, 1, 1, 1;
  std::vector<Vector3> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(nodes.col(i));
  // A cube of two wedges: one as such, turned inside out, one as a brick with two collapsed edges.
  const std::vector<ElementBlock> elements{{"C3D6", {{4, 5, 6, 0, 1, 2}}}, {"C3D8", {{0, 2, 3, 3, 4, 6, 7, 7}}}};
  const Measure m = measure(boundary_triangles(elements, nodes), points);
  EXPECT_NEAR(m.volume, 1, 1e-15);
  EXPECT_NEAR(m.area, 6, 1e-15);
  EXPECT_TRUE(m.closed);

  // A wedge of the second order: its middles lie on its edges.
  Matrix3X quadratic(3, 15);
  const int corners[6] = {0, 1, 2, 4, 5, 6};
  for (int i = 0; i < 6; ++i) quadratic.col(i) = nodes.col(corners[i]);
  const int ends[9][2] = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
  for (int i = 0; i < 9; ++i) quadratic.col(6 + i) = 0.5 * (quadratic.col(ends[i][0]) + quadratic.col(ends[i][1]));
  points.clear();
  for (int i = 0; i < 15; ++i) points.emplace_back(quadratic.col(i));
  const Measure wedge =
      measure(boundary_triangles({{"C3D15", {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14}}}}, quadratic), points);
  EXPECT_NEAR(wedge.volume, 0.5, 1e-15);
  EXPECT_NEAR(wedge.area, 3 + std::sqrt(2.0), 1e-14);
  EXPECT_TRUE(wedge.closed);
}

/// Where the nodes of a surface are, by the frame's marker, and by their own.
void expect_on_nodes(const SurfaceMesh& mesh, const FlexibleBody& body, const VectorX& q) {
  const auto cache = body.make_cache();
  const VectorX v = VectorX::Zero(body.coordinates().v_count());
  const BodyState state{q.data(), v.data(), cache.get()};
  body.evaluate(state, Level::position);
  MarkerKinematics frame, node;
  body.marker_kinematics(state, mesh.frame.index, Level::position, frame);
  double moved = 0;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    body.marker_kinematics(state, mesh.nodes[i].index, Level::position, node);
    moved = std::max(moved, (node.p - frame.p - frame.R * mesh.points[i]).norm());
  }
  double bound = 1e-14;
  const bool each = mesh.reach.size() == body.mode_count();
  for (int k = 0; k < body.mode_count(); ++k)
    bound += std::abs(q[7 + k]) * (each ? mesh.reach[k] : mesh.reach.maxCoeff());
  EXPECT_LE(moved, bound);
  if (body.mode_count() > 0) {
    EXPECT_GT(moved, 1e-2 * bound);
  }
}

TEST(SurfaceMesh, lies_on_the_nodes_of_the_body_and_follows_every_fidelity) {
  const FiniteElementModel model = pendulum_model("hex8i");
  const auto basis = make_basis(model, HingeFrame{model.node_set("hinge")}, 9);
  SystemGraph graph;
  const Matrix3 turn = rotation_about({1, 2, 3}, 0.6);
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = basis, .position = {0.1, 0.2, 0.3}, .orientation = turn});
  const SurfaceMesh mesh = surface(rod);
  const Measure m = measure(mesh.triangles, mesh.points);
  EXPECT_NEAR(m.volume, 0.1 * 0.01 * 0.015, 1e-18);
  EXPECT_TRUE(m.closed);
  EXPECT_EQ(mesh.nodes.size(), mesh.points.size());
  std::set<int> markers;
  for (const Marker& node : mesh.nodes) EXPECT_TRUE(node.body == &rod && markers.insert(node.index).second);

  const auto try_state = [&] {
    VectorX q(rod.coordinates().q_count()), v(rod.coordinates().v_count());
    rod.initial_state(q, v);
    for (int k = 0; k < rod.mode_count(); ++k) q[7 + k] = k % 2 ? 1e-4 : -2e-4;
    expect_on_nodes(mesh, rod, q);
  };
  try_state();
  rod.set_fidelity({.modes = {1, 4}});
  try_state();
  rod.set_fidelity({});
  try_state();

  auto& rigid = graph.add<FlexibleBody>("rigid", {.basis = basis, .mode_count = 0});
  EXPECT_EQ(surface(rigid).points, mesh.points);
  EXPECT_EQ(surface(rigid).frame, rigid.body_frame());
}

TEST(SurfaceMesh, takes_a_part_and_says_what_it_misses) {
  auto model = brick_mesh({.size = {0.3, 0.1, 0.2}, .divisions = {3, 2, 2}, .material = {2e11, 0.3, 7800}});
  SystemGraph graph;
  auto& body = graph.add<FlexibleBody>("block", {.basis = make_basis(model, MeanAxisFrame{}, 4)});
  const SurfaceMesh top = surface(body, "z_max");
  const Measure m = measure(top.triangles, top.points);
  EXPECT_NEAR(m.area, 0.3 * 0.1, 1e-15);
  EXPECT_NEAR(m.closure[2], 0.3 * 0.1, 1e-15);  // upwards
  EXPECT_EQ(top.nodes.size(), model.node_set("z_max").size());
  EXPECT_EQ(top.reach.size(), 4);
  EXPECT_THROW(surface(body, "nowhere"), SceneError);
  EXPECT_THROW(surface(body, std::vector<int>{1, 2}), SceneError);  // no face

  model.elements.clear();
  auto& bare = graph.add<FlexibleBody>("bare", {.basis = make_basis(model, MeanAxisFrame{}, 4)});
  EXPECT_THROW(surface(bare), SceneError);
  const auto& ids = model.node_set("z_max");
  const std::vector<std::array<int, 3>> one{{ids[0], ids[1], ids[2]}};
  EXPECT_EQ(surface(bare, one).nodes.size(), 3u);
}

}  // namespace
}  // namespace lithe::test::surface_mesh_test
