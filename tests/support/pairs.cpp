#include "tests/support/pairs.h"

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
  };
  return all;
}

}  // namespace lithe::test
