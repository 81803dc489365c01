#include "bodies/beam/slender_body.h"

#include <algorithm>
#include <cmath>

#include "bodies/beam/beam_model.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

/// The node of a mesh at an arc length; -1: none is there.
int node_at(const Beam& mesh, double arc) {
  for (int i = 0; i < mesh.node_count(); ++i)
    if (std::abs(mesh.arc(i) - arc) <= 1e-9 * mesh.length()) return i;
  return -1;
}

const BodyState inside(const BodyState& state) {
  return {state.q, state.v, static_cast<const SlenderBody::Cache&>(*state.cache).inner.get()};
}

}  // namespace

SlenderBody::SlenderBody(Parameters parameters) : parameters_(std::move(parameters)) {
  fidelity_ = {.deflection = Deflection::exact, .elements = parameters_.beam.elements};
  beam_ = std::make_unique<Beam>(parameters_.beam);
  if (node_at(*beam_, parameters_.held) < 0)
    throw SceneError("it is held at " + std::to_string(parameters_.held) + " m, where no node is", "",
                     "give an end (0 or " + std::to_string(length()) + ") or one of the beam's stations");
  if (parameters_.mode_count < 1 || parameters_.mode_count > 6 * beam_->element_count())
    throw SceneError("it has " + std::to_string(parameters_.mode_count) + " candidate modes", "",
                     "give 1 to " + std::to_string(6 * beam_->element_count()) + ", six for each element");
}

// ---- models ----

const Body& SlenderBody::model() const {
  if (beam_) return *beam_;
  return *flexible_;
}

const DrawableBody& SlenderBody::drawable() const {
  if (beam_) return *beam_;
  return *flexible_;
}

Beam::Parameters SlenderBody::mesh(int elements) const {
  Beam::Parameters mesh = parameters_.beam;
  if (elements > 0) mesh.elements = elements;
  return mesh;
}

std::shared_ptr<const ModalBasis> SlenderBody::basis_of(int elements) const {
  auto& basis = bases_[elements];
  if (!basis) {
    const Beam drawn(mesh(elements));
    basis =
        make_basis(drawn, TangentFrame{{node_at(drawn, parameters_.held) + 1}},
                   std::min(parameters_.mode_count, 6 * drawn.element_count()), {.deflection = Deflection::stiffened});
  }
  return basis;
}

/// The mesh is drawn in world axes about the world's origin.
std::unique_ptr<FlexibleBody> SlenderBody::reduced(int elements) const {
  const Beam::Parameters& p = parameters_.beam;
  return std::make_unique<FlexibleBody>(
      FlexibleBody::Parameters{.basis = basis_of(elements),
                               .velocity = p.velocity - p.angular_velocity.cross(p.axis.pose(0).position),
                               .angular_velocity = p.angular_velocity});
}

const FlexibleBody& SlenderBody::modal() const {
  if (!candidates_) candidates_ = reduced(0);
  return *candidates_;
}

int SlenderBody::element_count(int asked) const { return Beam(mesh(asked)).element_count(); }

void SlenderBody::set_fidelity(Fidelity fidelity) {
  const bool exact = fidelity.deflection == Deflection::exact;
  if (exact && !fidelity.modes.empty())
    throw SceneError("'" + name() + "' has modes and is to be exact", where(),
                     "leave out the modes, or give Deflection::linear or ::stiffened");
  if (fidelity.elements < 0)
    throw SceneError("'" + name() + "' has " + std::to_string(fidelity.elements) + " elements", where(),
                     "give a positive number, or 0 for as many as drawn");
  std::unique_ptr<Beam> beam;
  std::unique_ptr<FlexibleBody> flexible;
  if (exact) {
    beam = std::make_unique<Beam>(mesh(fidelity.elements));
  } else {
    flexible = reduced(fidelity.elements);
    flexible->set_fidelity({fidelity.modes, fidelity.deflection});
  }
  beam_ = std::move(beam), flexible_ = std::move(flexible), fidelity_ = std::move(fidelity);
  for (const Place& place : places_) put(place);
}

VectorX SlenderBody::candidate_forces(const BodyState& state, const double* v_dot, std::span<const MarkerLoad> loads,
                                      const Vector3& gravity) const {
  return flexible_ ? flexible_->candidate_forces(inside(state), v_dot, loads, gravity) : VectorX();
}

// ---- markers ----

/// Markers of the present model have the numbers of this body's.
void SlenderBody::put(const Place& place) {
  const FramePose pose = parameters_.beam.axis.pose(place.arc);
  if (beam_)
    beam_->marker(place.arc, {}, place.axes);
  else if (place.on_frame)
    flexible_->frame();
  else
    flexible_->node(node_at(Beam(mesh(fidelity_.elements)), place.arc) + 1, pose.axes * place.axes);
}

Marker SlenderBody::add(const Place& place) {
  put(place);
  places_.push_back(place);
  return new_marker();
}

Marker SlenderBody::marker(double arc, const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(), [&] { require::rotation(orientation, "orientation"); });
  const auto here = [&](double node) { return std::abs(node - arc) <= 1e-9 * length(); };
  const auto& stations = parameters_.beam.stations;
  if (!here(0) && !here(length()) && std::none_of(stations.begin(), stations.end(), here))
    throw SceneError("'" + name() + "' has no station at " + std::to_string(arc) + " m", where(),
                     "give an end, or add the arc length to .beam.stations: every mesh has a node there");
  return add({false, arc, orientation});
}

Marker SlenderBody::marker_at_world(const Point& point, const Matrix3& orientation) {
  std::vector<double> arcs = parameters_.beam.stations;
  arcs.insert(arcs.end(), {0, length()});
  for (const double arc : arcs) {
    const FramePose pose = parameters_.beam.axis.pose(arc);
    if ((pose.position - point.at).norm() <= 1e-6 * length()) return marker(arc, pose.axes.transpose() * orientation);
  }
  throw SceneError("'" + name() + "' has no end or station at the point given", where(),
                   "add its arc length to .beam.stations");
}

/// Of the exact beam: the section where it is held, with the axes of the frame.
Marker SlenderBody::body_frame() {
  if (!body_frame_.body)
    body_frame_ = add({true, parameters_.held, parameters_.beam.axis.pose(parameters_.held).axes.transpose()});
  return body_frame_;
}

// ---- one state ----

void SlenderBody::evaluate(const BodyState& state, Level level) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  model().evaluate(inside(state), level);
  cache.A = cache.inner->A;
}

void SlenderBody::add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const {
  model().add_residual(inside(state), v_dot, gravity, r);
}

void SlenderBody::add_tangent(const BodyState& state, const double* v_dot, const Vector3& gravity,
                              const TangentWeights& weights, BodyTangent& S) const {
  model().add_tangent(inside(state), v_dot, gravity, weights, S);
}

void SlenderBody::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  model().marker_kinematics(inside(state), marker, level, k);
}

BodyEnergy SlenderBody::energy(const BodyState& state, const Vector3& gravity) const {
  return model().energy(inside(state), gravity);
}

void SlenderBody::drawn_points(const BodyState& state, const DrawnMesh& mesh, Matrix3X& points) const {
  drawable().drawn_points(inside(state), mesh, points);
}

template std::unique_ptr<BodyBatch> make_body_batch<SlenderBody>();

}  // namespace lithe
