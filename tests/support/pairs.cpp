#include "tests/support/pairs.h"

#include "bodies/beam/beam.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "tests/support/marker_body.h"
#include "tests/support/motion.h"

namespace lithe::test {
namespace {

/// Other numbers for every body, the same in every run.
RandomNumbers numbers(const std::string& name) {
  unsigned seed = 1;
  for (char c : name) seed = 31 * seed + static_cast<unsigned char>(c);
  return RandomNumbers(seed);
}

/// A cube of 1.6 m: a mass in each corner, springs between all of them.
FiniteElementModel cube() {
  RandomNumbers random = numbers("cube");
  FiniteElementModel model;
  model.name = "cube";
  model.nodes.resize(3, 8);
  std::vector<Eigen::Triplet<double>> mass, stiffness;
  for (int i = 0; i < 8; ++i) {
    model.node_ids.push_back(i + 1);
    model.nodes.col(i) = 0.8 * Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    const double m = 0.2 + 0.05 * random.number();
    for (int axis = 0; axis < 3; ++axis) mass.emplace_back(3 * i + axis, 3 * i + axis, m);
  }
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < i; ++j) {
      const Vector3 n = (model.nodes.col(i) - model.nodes.col(j)).normalized();
      const Matrix3 k = (40 + 10 * random.number()) * n * n.transpose();
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          for (const auto& [row, column, sign] : {std::tuple(i, i, 1), {j, j, 1}, {i, j, -1}, {j, i, -1}})
            stiffness.emplace_back(3 * row + a, 3 * column + b, sign * k(a, b));
    }
  model.mass.resize(24, 24);
  model.mass.setFromTriplets(mass.begin(), mass.end());
  model.stiffness.resize(24, 24);
  model.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
  return model;
}

}  // namespace

Marker draw_rigid(SystemGraph& graph, const std::string& name, const Vector3& position, const Matrix3& orientation) {
  RandomNumbers random = numbers(name);
  const Vector3 offset = random.vector3();
  const Matrix3 turned = random.rotation(), A = orientation * turned.transpose();
  auto& body = graph.add<RigidBody>(name, {.mass = 1.5 + random.number(),
                                           .inertia = Vector3(Vector3(0.5, 0.6, 0.7) + 0.1 * random.vector3()),
                                           .position = position - A * offset,
                                           .orientation = A});
  return body.marker(offset, turned);
}

Marker draw_modal(SystemGraph& graph, const std::string& name, const Vector3& position, const Matrix3& orientation,
                  int modes) {
  RandomNumbers random = numbers(name);
  const ModalMarker m{random.vector3(), random.matrix3x(modes), random.matrix3x(modes), random.rotation()};
  const VectorX eta = random.vector(modes, 0.3);
  const Matrix3 A = orientation * m.orientation(eta).transpose();
  return graph
      .add<MarkerBody>(name, {.markers = {m}, .position = position - A * m.point(eta), .orientation = A, .eta = eta})
      .marker();
}

Marker draw_flexible(SystemGraph& graph, const std::string& name, const Vector3& position, const Matrix3& orientation,
                     int modes) {
  static const auto reduced = make_basis(cube(), MeanAxisFrame{}, 5);
  static const auto nodal = make_basis(cube(), ThreeNodeFrame{1, 2, 3}, kAllNodal);
  const std::vector<int> nodes = {5, 6, 7, 8};  // far from the frame's
  const Matrix3 turned = numbers(name).rotation(), A = orientation * turned.transpose();
  const Vector3 mean(0, 0, 0.8);
  auto& body = graph.add<FlexibleBody>(name, {.basis = modes == kAllNodal ? nodal : reduced,
                                              .mode_count = modes == kAllNodal ? FlexibleBody::kAll : modes,
                                              .position = position - A * mean,
                                              .orientation = A});
  return body.average(nodes, turned);
}

Marker draw_beam(SystemGraph& graph, const std::string& name, const Vector3& position, const Matrix3& orientation,
                 bool inside) {
  RandomNumbers random = numbers(name);
  const Vector3 offset = 0.3 * random.vector3();
  const Matrix3 turned = random.rotation(), A = orientation * turned.transpose();
  const double arc = inside ? 0.7 : 2;
  const Vector3 start = position - A * (offset + arc * Vector3::UnitX());
  const BeamSection section = BeamSection::diagonal({40, 30, 30, 3, 4, 5}, 0.8, {0.3, 0.2, 0.15});
  auto& beam = graph.add<Beam>(name, {.axis = {2,
                                               [=](double s) {
                                                 return FramePose{start + A * Vector3(s, 0, 0), A};
                                               }},
                                      .sections = {{0, section}},
                                      .elements = 2});
  return beam.marker(arc, offset, turned);
}

const std::vector<Pair>& pairs() {
  static const Vector3 place(0.3, -0.2, 0.5);
  static const Matrix3 axes = rotation_exp(Vector3(0.4, -0.7, 0.9));
  static const std::vector<Pair> all = {
      {"ground - rigid",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {graph.ground().marker(place, axes), draw_rigid(graph, "B", place + axes * gap, axes)};
       }},
      {"rigid - ground",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_rigid(graph, "A", place, axes), graph.ground().marker(place + axes * gap, axes)};
       }},
      {"rigid - rigid",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_rigid(graph, "A", place, axes), draw_rigid(graph, "B", place + axes * gap, axes)};
       }},
      {"rigid - modal",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_rigid(graph, "A", place, axes), draw_modal(graph, "B", place + axes * gap, axes)};
       }},
      {"modal - modal",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_modal(graph, "A", place, axes), draw_modal(graph, "B", place + axes * gap, axes, 2)};
       }},
      {"ground - reduced",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {graph.ground().marker(place, axes), draw_flexible(graph, "B", place + axes * gap, axes)};
       }},
      {"reduced - rigid",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_flexible(graph, "A", place, axes), draw_rigid(graph, "B", place + axes * gap, axes)};
       }},
      {"rigid - nodal",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_rigid(graph, "A", place, axes), draw_flexible(graph, "B", place + axes * gap, axes, kAllNodal)};
       }},
      {"nodal - reduced",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_flexible(graph, "A", place, axes, kAllNodal),
                 draw_flexible(graph, "B", place + axes * gap, axes)};
       }},
      {"rigid - end of a beam",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_rigid(graph, "A", place, axes), draw_beam(graph, "B", place + axes * gap, axes, false)};
       }},
      {"inside a beam - ground",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_beam(graph, "A", place, axes, true), graph.ground().marker(place + axes * gap, axes)};
       }},
      {"end of a beam - inside a beam",
       [](SystemGraph& graph, const Vector3& gap) -> std::vector<Marker> {
         return {draw_beam(graph, "A", place, axes, false), draw_beam(graph, "B", place + axes * gap, axes, true)};
       }},
  };
  return all;
}

}  // namespace lithe::test
