#pragma once

#include <functional>
#include <vector>

#include "bodies/beam/beam_span.h"
#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "engine/model/rigid_frame_body.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// Where a beam is drawn: points and section axes (columns: 1 along the beam, 2, 3) over the arc length.
struct BeamAxis {
  double length = 0;                            // m
  std::function<FramePose(double arc)> pose{};  // arc from 0 to length, m; world axes

  /// Axis 2 is the part of `axis_2` at right angles to the line; {}: from the world axis farthest from the line.
  static BeamAxis straight(const Vector3& from, const Vector3& to, const Vector3& axis_2 = Vector3::Zero());
  /// From `start` with constant curvature (torsion, about axis 2, about axis 3; 1/m): an arc, a helix, a twisted blade.
  static BeamAxis curved(const FramePose& start, const Vector3& curvature, double length);
};

/// A geometrically exact beam: one body with a frame at each node (the section's axes: 1 along the beam) and a BeamSpan
/// between each two. Strains are objective and without locking; errors are of second order in the length of the spans.
/// Mass, weight and rotary inertia are exact for rigid motions of the undeformed beam, offsets of the section included.
/// Lumped mass gives the higher frequencies better and costs less; consistent mass halves the error of a long flight
/// (docs/equations.md 4.6 has figures).
///   auto& blade = graph.add<Beam>("blade", {.axis = BeamAxis::straight({0, 0, 0}, {8, 0, 0}), .sections = {{0, s}}});
///   graph.add<FixedJoint>("root", {graph.ground().marker({0, 0, 0}, blade.axes(0)), blade.marker(0)});
/// Markers may be anywhere along the axis and off it. A load between nodes bends the beam as its shape functions allow:
/// where a large one acts, a station makes a node.
class Beam final : public Body, public DrawableBody {
 public:
  struct Station {
    double arc;  // m
    BeamSection section;
  };
  enum class Mass {
    lumped,      // each node carries the beam between the middles of its elements, as drawn, as a rigid piece
    consistent,  // kinetic energy of the motion between the nodes
  };
  struct Parameters {
    BeamAxis axis{};
    std::vector<Station> sections{};  // rising; linear between, constant beyond; each span has that of its middle
    int elements = 20;                // in all; each stretch between stations has one at least
    std::vector<double> stations{};   // m: where there are to be nodes, as at both ends
    Mass mass = Mass::lumped;
    Vector3 velocity{0, 0, 0};          // of the point at arc 0, world axes, m/s
    Vector3 angular_velocity{0, 0, 0};  // of the whole beam, world axes, rad/s
  };
  /// Terms of the spans, and what markers between nodes need.
  struct Cache;

  /// Throws SceneError for an axis without length, stations out of order or beyond the ends, no section, sections that
  /// BeamSection::check refuses, and too few elements for the curvature (BeamSpan).
  explicit Beam(Parameters parameters);

  /// On the axis at an arc length (m), with the section's axes.
  Marker marker(double arc) { return marker(arc, {}); }
  /// Fixed in the section there: `offset` in section axes (m), marker axes to section axes. SceneError beyond the ends.
  Marker marker(double arc, const Point& offset, const Matrix3& orientation = Matrix3::Identity());
  /// Fixed in the section of the node that is nearest to `point` (world axes, m, as drawn); marker axes to world axes.
  Marker marker_at_world(const Point& point, const Matrix3& orientation = Matrix3::Identity());

  double length() const { return arcs_.back(); }  // m
  double mass() const;                            // kg
  int node_count() const { return static_cast<int>(poses_.size()); }
  double arc(int node) const { return arcs_[checked_node(node)]; }              // m
  const Matrix3& axes(int node) const { return pose(node).axes; }               // as drawn
  const FramePose& pose(int node) const { return poses_[checked_node(node)]; }  // likewise
  /// Of the piece that a node carries with lumped mass, about the node, in its axes.
  Matrix6 lumped_mass(int node) const;
  const Parameters& parameters() const { return parameters_; }
  int element_count() const { return static_cast<int>(spans_.size()); }
  const BeamSpan& element(int i) const { return spans_[checked_element(i)]; }
  /// The element that holds the section at an arc length; of two the later one.
  int element_at(double arc) const;

  /// (Γ, K): axial strain, shears; torsion, curvatures (1/m), the drawn ones subtracted. Constant along an element,
  /// best in its middle. At the state that filled the cache.
  Vector6 strain(const BodyState& state, int element) const;
  /// (n, m): force (N) and moment (N m) of the part behind on the part before, axes of the middle section; damping
  /// included.
  Vector6 resultants(const BodyState& state, int element) const;
  /// The same as sensors: Gamma_1 …, K_1 … (1/m); n_1 … (N), m_1 … (N m).
  Sensor strain(int element, Located name = "") const;
  Sensor resultants(int element, Located name = "") const;

  Coordinates coordinates() const override { return {.frames = node_count(), .linear = 0, .pairs = pairs_}; }
  std::unique_ptr<BodyCache> make_cache() const override;
  void initial_state(VectorRef q, VectorRef v) const override;
  void evaluate(const BodyState&, Level) const override;
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  /// Exact in velocities and accelerations; in positions without the derivatives of inertia and weight.
  void add_tangent(const BodyState&, const double* v_dot, const Vector3& gravity, const TangentWeights&,
                   BodyTangent&) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3& gravity) const override;

  /// A tube of the bar that has the section's mass and inertia; points on its axis first.
  DrawnMesh drawn_mesh(bool with_stress) const override;
  void drawn_points(const BodyState&, const DrawnMesh& mesh, Matrix3X& points) const override;
  std::vector<std::pair<int, double>> nodes_of_marker(int marker) const override;

 private:
  struct Place {
    int element;
    double share;  // ξ in the element; 0 and 1: at its nodes
    Vector3 offset;
    Matrix3 axes;
  };
  std::size_t checked_node(int i) const;
  std::size_t checked_element(int i) const;
  Sensor make_sensor(int element, Located name, bool resultants) const;
  int node_of(const Place& place) const;  // -1: between two
  Matrix3X surface(std::span<const FramePose> nodes) const;

  const Parameters parameters_;
  std::vector<double> arcs_;  // of the nodes, m
  std::vector<FramePose> poses_;
  std::vector<BeamSpan> spans_;
  std::vector<FramePair> pairs_;
  std::vector<Matrix6> node_masses_;  // lumped, about the nodes, in their axes; empty: consistent
  std::vector<Place> places_;
};

extern template std::unique_ptr<BodyBatch> make_body_batch<Beam>();

}  // namespace lithe
