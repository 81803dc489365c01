#pragma once

#include <optional>
#include <vector>

#include "engine/assembly/batch.h"
#include "engine/base/lanes.h"
#include "engine/model/appearance.h"
#include "engine/model/point_body.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// A cable, rope or wire: mass, axial and bending stiffness, no torsion. A chain of n straight elements between n + 1
/// nodes; q: positions of the nodes in world axes, v: their velocities;
///   M v̇ + ∂U/∂q + D v = M g,   U = Σ ½ EA ε² L + Σ ½ EI κ² L_i,   ε = l/L - 1,   κ = |t₂ - t₁| / L_i
/// with ε in each element and κ at each inner node, t the directions of the elements beside it, L_i half the sum of
/// their lengths L. M is constant and consistent with linear shape functions; D resists the rate of ε alone. U and D do
/// not see rigid motion. Errors fall with the square of the element's length.
/// The ends are hinged and the unloaded cable is straight. A compressed element pushes: without bending stiffness it
/// buckles at once, with it by the load of its length. Limits: ends have no moment, sections do not turn, no shear; its
/// highest frequency is that of its shortest element, √(12 EA/μ)/L: implicit integrators.
/// Markers have a place and no axes of their own: what would turn them is refused (engine/model/point_body.h).
/// Source: Bergou, Wardetzky, Robinson, Audoly & Grinspun, Discrete Elastic Rods, 2008 (curvature at nodes; here with
/// 2 sin(θ/2), which stays finite where a cable folds); Irvine, Cable Structures, 1981.
class Cable final : public PointBody, public DrawableBody {
 public:
  struct Parameters {
    Vector3 from{0, 0, 0};           // first end as drawn, world axes, m
    Vector3 to{0, 0, 0};             // last end, likewise
    std::vector<Vector3> points{};   // instead of both: a curve of straight pieces to be drawn along, m
    std::optional<double> length{};  // L₀, unstretched, m; none: as drawn
    Vector3 sag{0, 0, -1};           // where a cable hangs that is longer than from its first end to its last
    int elements = 20;               // n; with stations about so many, at least one between two
    std::vector<double> stations{};  // unstretched lengths from the first end at which there is to be a node, rising, m
    double mass_per_length = 0;      // μ, kg/m
    double axial_stiffness = 0;      // EA, N
    double bending_stiffness = 0;    // EI, N m²
    double axial_damping = 0;        // c, N s: tension EA ε + c ε̇ (Kelvin-Voigt)
    Vector3 velocity{0, 0, 0};       // of all nodes, world axes, m/s
    double radius = 0;               // of the tube that is drawn on pages, m; 0: 1/500 of the length
  };
  struct Cache : BodyCache {
    explicit Cache(const Cable&);
    std::vector<Lanes> directions;  // t of each element
    VectorX lengths, tensions;      // l (m) and EA ε + c ε̇ (N)
    VectorX force;                  // ∂U/∂q + D v, N
    double strain_energy = 0;       // J
    /// Of the tangent: a node's three columns in its own rows, and in those of the two nodes behind it.
    struct Blocks {
      Lanes own[3], next[3], second[3];
    };
    std::vector<Blocks> blocks;
  };

  /// Throws SceneError for a cable without length, mass or axial stiffness, negative stiffness or damping, stations
  /// that do not rise within the cable, too few elements to be drawn slack, NaN.
  explicit Cable(Parameters parameters);

  const Parameters& parameters() const { return parameters_; }
  int element_count() const { return static_cast<int>(rest_lengths_.size()); }
  int node_count() const { return element_count() + 1; }
  double length() const { return arc_[element_count()]; }  // unstretched, m
  double mass() const { return parameters_.mass_per_length * length(); }
  /// Unstretched length from the first end to a node (0 … n), m.
  double arc(int node) const { return arc_[node]; }
  /// The element that holds the point at an unstretched length from the first end; of two the later one.
  int element_at(double arc_length) const;

  /// The point at an unstretched length from the first end (m): a node, or between two of them. Its axes keep
  /// `orientation` (marker axes to world axes). A load between nodes bends the cable at nodes only: where one acts, a
  /// station makes a node. SceneError outside the cable.
  Marker marker(double arc_length, const Matrix3& orientation = Matrix3::Identity());
  Marker start(const Matrix3& orientation = Matrix3::Identity()) { return marker(0, orientation); }
  Marker end(const Matrix3& orientation = Matrix3::Identity()) { return marker(length(), orientation); }

  Matrix3X positions(const BodyState& state) const { return Eigen::Map<const Matrix3X>(state.q, 3, node_count()); }
  /// Of each element, damping included; negative where it is compressed, N.
  const VectorX& tensions(const BodyState& state) const { return static_cast<const Cache&>(*state.cache).tensions; }

  Coordinates coordinates() const override { return {.frames = 0, .linear = 3 * node_count(), .pattern = &pattern_}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override;
  void evaluate(const BodyState&, Level) const override;
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  /// Exact but for the softening by compressed elements, which would make it indefinite, and ∂(D)/∂q v.
  void add_tangent(const BodyState&, const double* v_dot, const Vector3& gravity, const TangentWeights&,
                   BodyTangent&) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3& gravity) const override;

  /// A tube of six sides; points on its axis first.
  DrawnMesh drawn_mesh(bool with_stress) const override;
  void drawn_points(const BodyState&, const DrawnMesh& mesh, Matrix3X& points) const override;
  std::vector<std::pair<int, double>> nodes_of_marker(int marker) const override;

 private:
  struct Place {
    int element;
    double share;      // of the element's later node
    Matrix3 axes;      // marker axes to world axes
    Matrix6X columns;  // constant
  };
  void set_lengths(double length);
  void set_constants();
  void set_pattern();
  void add_bending(Cache& cache) const;
  void add_bending_stiffness(Cache& cache, double weight) const;
  Matrix3X surface(const Matrix3X& axis) const;

  const Parameters parameters_;
  VectorX rest_lengths_, arc_;  // L of each element, unstretched length up to each node
  Matrix3X drawn_;              // nodes at t = 0
  VectorX mass_diagonal_, mass_beside_, nodal_mass_;
  VectorX bend_stiffness_;  // EI/L_i of the inner nodes, N m
  LinearPattern pattern_;
  int reach_ = 1;             // nodes to each side that a node is coupled with
  std::vector<int> columns_;  // first entry of each column in the pattern
  std::vector<Place> places_;
};

/// Tension of an element (0 … n - 1), N; negative: compressed. Throws SceneError for one that the cable does not have.
Sensor tension(const Cable& cable, int element, Located name = "");

extern template std::unique_ptr<BodyBatch> make_body_batch<Cable>();

}  // namespace lithe
