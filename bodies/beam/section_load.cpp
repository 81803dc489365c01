#include "bodies/beam/section_load.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bodies/beam/beam_cache_internal.h"
#include "bodies/beam/se3_internal.h"
#include "bodies/resultant_sensor.h"
#include "engine/observe/snapshot.h"

namespace lithe {
namespace {

double middle(const Beam& beam, int element) { return 0.5 * (beam.arc(element) + beam.arc(element + 1)); }

/// Whether loads may jump between the elements before and behind a node.
bool is_station(const Beam& beam, int node) {
  const auto& stations = beam.parameters().stations;
  return std::any_of(stations.begin(), stations.end(),
                     [&](double arc) { return std::abs(arc - beam.arc(node)) < 1e-9 * beam.length(); });
}

void check_arc(const Beam& beam, double arc) {
  if (!(arc >= 0 && arc <= beam.length() * (1 + 1e-9)))
    throw SceneError("beam '" + beam.name() + "' has no section at " + std::to_string(arc) + " m", beam.where(),
                     "give an arc length from 0 to " + std::to_string(beam.length()));
}

/// By `resultants(element)` and `twist(element)`, which is d of BeamSpan.
template <class Resultants, class Twist>
Vector6 between_middles(const Beam& beam, double arc, const Resultants& resultants, const Twist& twist) {
  check_arc(beam, arc);
  const int e = beam.element_at(std::min(arc, beam.length()));
  const bool before = e > 0 && !is_station(beam, e), behind = e + 1 < beam.element_count() && !is_station(beam, e + 1);
  const double from_middle = arc - middle(beam, e);
  const Vector6 here = resultants(e);
  const int other = (from_middle < 0 && before) || !behind ? e - 1 : e + 1;
  if (before || behind) {
    const double share = from_middle / (middle(beam, other) - middle(beam, e));
    return (1 - share) * here + share * resultants(other);
  }
  // The same wrench about another point of the element's helix, in the axes there.
  const se3::Pose there = se3::exp(from_middle / beam.element(e).length() * twist(e));
  Vector6 moved;
  moved.head<3>() = there.R.transpose() * here.head<3>();
  moved.tail<3>() = there.R.transpose() * (here.tail<3>() - there.p.cross(Vector3(here.head<3>())));
  return moved;
}

/// A slender body of modes: elements of the mesh by the small motions of their nodes.
class ReducedSections {
 public:
  ReducedSections(const Beam& mesh, const FlexibleBody& body, const BodyState& state)
      : mesh_(mesh),
        basis_(body.basis()),
        eta_(state.q + 7, basis_.mode_count()),
        eta_dot_(state.v + 6, basis_.mode_count()) {}

  /// As drawn, and what the motions add, linear in them.
  Vector6 twist(int e) const {
    const FramePose &a = mesh_.pose(e), &b = mesh_.pose(e + 1);
    const Vector6 drawn = se3::log_between(a.position, a.axes, b.position, b.axes);
    const se3::Blocks T = se3::blocks(se3::right_inverse_at(drawn), drawn);
    return drawn + T * motion(e + 1, eta_) - T.turned_back() * motion(e, eta_);
  }
  Vector6 resultants(int e) const {
    return mesh_.element(e).resultants(twist(e), motion(e, eta_dot_), motion(e + 1, eta_dot_));
  }

 private:
  using Coordinates = Eigen::Map<const VectorX>;
  /// Of a node beside the body's frame, in the axes of its section as drawn.
  Vector6 motion(int node, const Coordinates& eta) const {
    const Matrix3 to_section = mesh_.pose(node).axes.transpose() * basis_.rotation;
    Vector6 motion;
    motion << to_section * (basis_.node_modes(node) * eta), to_section * (basis_.node_rotation_modes(node) * eta);
    return motion;
  }

  const Beam& mesh_;
  const ModalBasis& basis_;
  const Coordinates eta_, eta_dot_;
};

/// The mesh of a slender body's present model.
Beam::Parameters mesh_of(const SlenderBody& body) {
  Beam::Parameters mesh = body.parameters().beam;
  if (body.fidelity().elements > 0) mesh.elements = body.fidelity().elements;
  return mesh;
}

Vector6 section_load(const SlenderBody& body, const Beam* mesh, const BodyState& state, double arc) {
  const BodyState inner{state.q, state.v, static_cast<const SlenderBody::Cache&>(*state.cache).inner.get()};
  if (body.beam()) return lithe::section_load(*body.beam(), inner, arc);
  const ReducedSections reduced(*mesh, *body.flexible(), inner);
  return between_middles(
      *mesh, arc, [&](int e) { return reduced.resultants(e); }, [&](int e) { return reduced.twist(e); });
}

}  // namespace

Vector6 section_load(const Beam& beam, const BodyState& state, double arc) {
  return between_middles(
      beam, arc, [&](int e) { return beam.resultants(state, e); },
      [&](int e) -> Vector6 { return static_cast<const Beam::Cache&>(*state.cache).d[e]; });
}

Sensor section_load(const Beam& beam, double arc, Located name) {
  check_arc(beam, arc);
  if (name.text.empty()) name.text = beam.name() + "_s" + std::to_string(arc);
  return resultant_sensor(std::move(name),
                          [&beam, arc](Snapshot& now) { return section_load(beam, now.body_state(beam), arc); });
}

Vector6 section_load(const SlenderBody& body, const BodyState& state, double arc) {
  if (body.beam()) return section_load(body, nullptr, state, arc);
  const Beam mesh(mesh_of(body));
  return section_load(body, &mesh, state, arc);
}

Sensor section_load(const SlenderBody& body, double arc, Located name) {
  if (!(arc >= 0 && arc <= body.length() * (1 + 1e-9)))
    throw SceneError("'" + body.name() + "' has no section at " + std::to_string(arc) + " m", body.where(),
                     "give an arc length from 0 to " + std::to_string(body.length()));
  if (name.text.empty()) name.text = body.name() + "_s" + std::to_string(arc);
  struct Drawn {
    int elements = -1;
    std::unique_ptr<Beam> mesh;
  };
  return resultant_sensor(std::move(name), [&body, arc, drawn = std::make_shared<Drawn>()](Snapshot& now) {
    if (body.flexible() && drawn->elements != body.fidelity().elements)
      *drawn = {body.fidelity().elements, std::make_unique<Beam>(mesh_of(body))};
    return section_load(body, drawn->mesh.get(), now.body_state(body), arc);
  });
}

}  // namespace lithe
