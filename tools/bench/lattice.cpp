#include "tools/bench/lattice.h"

#include <map>
#include <string>
#include <utility>

#include "bodies/rigid_body.h"
#include "joints/point_on_line_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"

namespace lithe::bench {
namespace {

const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

struct Ends {
  Marker start, end;
};

/// A rod along `axis`, which its body axes follow; its markers' z axes point along world y.
Ends rod(SystemGraph& graph, const std::string& name, const Vector3& start, const Vector3& axis) {
  // x along the rod; turned about the axis that keeps a hinge along y simple.
  Matrix3 R = Matrix3::Identity();
  if (axis.z() != 0) R = rotation_about({0, 1, 0}, axis.z() > 0 ? -M_PI / 2 : M_PI / 2);
  if (axis.y() != 0) R = rotation_about({0, 0, 1}, axis.y() > 0 ? M_PI / 2 : -M_PI / 2);
  auto& body = graph.add<RigidBody>(
      name, {.mass = 1, .inertia = {1.25e-3, 1.0 / 12, 1.0 / 12}, .position = start + 0.5 * axis, .orientation = R});
  const Matrix3 axes = R.transpose() * kAlongY;
  return {body.marker({-0.5, 0, 0}, axes), body.marker({0.5, 0, 0}, axes)};
}

}  // namespace

void draw_ladder(SystemGraph& graph, int cells, RungFoot foot) {
  Marker upper = graph.ground().marker({0, 0, 0}, kAlongY), lower = graph.ground().marker({0, 0, -1}, kAlongY);
  for (int i = 0; i < cells; ++i) {
    const std::string number = std::to_string(i + 1);
    const double x = 2 * i;
    const Ends over[] = {rod(graph, "upper a " + number, {x, 0, 0}, {1, 0, 0}),
                         rod(graph, "upper b " + number, {x + 1, 0, 0}, {1, 0, 0})};
    const Ends under[] = {rod(graph, "lower a " + number, {x, 0, -1}, {1, 0, 0}),
                          rod(graph, "lower b " + number, {x + 1, 0, -1}, {1, 0, 0})};
    const Ends rung = rod(graph, "rung " + number, {x + 2, 0, 0}, {0, 0, -1});
    graph.add<RevoluteJoint>("upper hinge " + number, {upper, over[0].start});
    graph.add<RevoluteJoint>("lower hinge " + number, {lower, under[0].start});
    graph.add<RevoluteJoint>("upper knee " + number, {over[0].end, over[1].start});
    graph.add<RevoluteJoint>("lower knee " + number, {under[0].end, under[1].start});
    upper = over[1].end, lower = under[1].end;
    graph.add<RevoluteJoint>("rung's top " + number, {upper, rung.start});
    if (foot == RungFoot::hinge)
      graph.add<RevoluteJoint>("rung's foot " + number, {lower, rung.end});
    else
      graph.add<PointOnLineJoint>("rung's foot " + number, {lower, rung.end});
  }
}

void draw_grid(SystemGraph& graph, int cells, int width) {
  std::map<std::pair<int, int>, Marker> nodes;  // the first rod's end at each
  for (int j = 0; j <= width; ++j) nodes[{0, j}] = graph.ground().marker({0, 1.0 * j, 0});
  const auto meet = [&](int i, int j, const Marker& end) {
    const auto [place, first] = nodes.try_emplace({i, j}, end);
    if (!first)
      graph.add<SphericalJoint>("joint " + std::to_string(graph.constraints().size() + 1), {place->second, end});
  };
  for (int i = 1; i <= cells; ++i) {
    for (int j = 0; j <= width; ++j) {
      const std::string place = std::to_string(i) + ", " + std::to_string(j);
      const Ends along = rod(graph, "along " + place, {i - 1.0, 1.0 * j, 0}, {1, 0, 0});
      meet(i - 1, j, along.start);
      meet(i, j, along.end);
      if (j == 0) continue;
      const Ends across = rod(graph, "across " + place, {1.0 * i, j - 1.0, 0}, {0, 1, 0});
      meet(i, j - 1, across.start);
      meet(i, j, across.end);
    }
  }
}

}  // namespace lithe::bench
