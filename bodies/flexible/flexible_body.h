#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "bodies/flexible/deflection_map.h"
#include "bodies/flexible/flexible_inertia.h"
#include "bodies/flexible/reduction.h"
#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "engine/model/deformable_body.h"

namespace lithe {

struct NodeAverage;

/// Damping of deformation alone; rigid motion is not damped.
///   D = mass_proportional Mff + stiffness_proportional K^ + diag(2 ζ_k ω_k)
struct FlexibleDamping {
  double mass_proportional = 0;        // 1/s, Rayleigh's alpha
  double stiffness_proportional = 0;   // s, Rayleigh's beta
  std::vector<double> modal_ratios{};  // ζ_k; one number serves all modes; eigenmode bases only
};

/// A field of nodal forces as at most six forces, one a marker, of the same virtual work: FlexibleBody::nodal_load().
struct NodalLoad {
  std::vector<Marker> markers;
  std::vector<Vector3> forces;  // N
};

/// Flexible body in the floating frame of reference: large motion of the frame, small deformation in it.
///   q_i = x0 + A (r0_i + B_i η),   M v̇ = f_v + f_gravity - K^ η - D η̇     (Vlasenko & Kasper eqs. 7-10, 23, 40;
///   M and f_v with every coupling as corrected in docs/equations.md 2.3, 3.2)
/// Three fidelities by one number, mode_count: all coordinates of a nodal basis, the first modes of a reduced one, or
/// 0: rigid. Stiffening by spin and load, and moderately large deflection, come with the basis (Reduction::deflection):
///   u = [B, Ψ] ξ(η), so that each B above becomes [B, Ψ] P, P = ∂ξ/∂η (deflection_map.h).
/// The modes of an eigenmode basis are candidates: set_fidelity(), or solve(), selects those that a scene needs.
/// The cost per step does not depend on the mesh.
class FlexibleBody final : public DeformableBody, public DrawableBody {
 public:
  static constexpr int kAll = std::numeric_limits<int>::max();
  struct Parameters {
    std::shared_ptr<const ModalBasis> basis{};
    int mode_count = kAll;  // modes used, lowest first; 0: rigid
    FlexibleDamping damping{};
    Vector3 position{0, 0, 0};                  // of the mesh origin at t = 0, world axes, m
    Matrix3 orientation = Matrix3::Identity();  // mesh axes to world axes
    Vector3 velocity{0, 0, 0};                  // of the mesh origin, world axes, m/s
    Vector3 angular_velocity{0, 0, 0};          // mesh axes, rad/s
    VectorX modal_coordinates{};                // η(0), empty: undeformed
    VectorX modal_velocities{};                 // η̇(0), empty: at rest
  };
  struct TurningMarker;  // the columns of a marker that depend on the deformation
  struct Cache : BodyCache {
    InertiaTerms terms;
    DeflectionTerms deflection;  // of a body with a quadratic deflection
    std::vector<std::unique_ptr<TurningMarker>> markers;
    explicit Cache(const FlexibleBody&);
    Cache(Cache&&) noexcept;
    ~Cache() override;
  };

  /// Throws SceneError for a missing basis, more modes than it has, wrong sizes, damping that does not fit, NaN.
  explicit FlexibleBody(Parameters parameters);
  /// With a mass matrix given by invariants alone (tests, imported integrals): K^ diagonal or full.
  FlexibleBody(Parameters parameters, InertiaIntegrals integrals);

  /// Of the modes in use, after set_fidelity(); as given before.
  const ModalBasis& basis() const { return *parameters_.basis; }
  const Parameters& parameters() const { return parameters_; }
  int mode_count() const { return modes_; }
  /// Coordinates ξ of the displacement fields [B, Ψ] of the basis; ξ = η for a linear deflection.
  VectorX field_coordinates(const BodyState&) const;
  double mass() const { return inertia_->mass; }

  // ---- markers; orientations are given in mesh axes ----
  /// A node by its label; translates with the deformation, turns with the body frame (solids have no nodal rotation).
  Marker node(int id, const Matrix3& orientation = Matrix3::Identity());
  /// The node at `point` of the world where the body is drawn (m), its axes `orientation` (marker axes to world axes).
  /// SceneError where no node is within 1e-6 of the body's size: only nodes follow the deformation.
  Marker marker_at_world(const Point& point, const Matrix3& orientation = Matrix3::Identity());
  /// The mean of nodes (RBE3): mean position and, for three or more nodes off a line, mean rotation. Nodes on a line
  /// turn with the body frame about it, with the nodes otherwise. Weights, one a node or none, count by their ratios;
  /// those of the areas that the nodes of a face stand for spread a load evenly over it.
  Marker average(const std::vector<int>& ids, const Matrix3& orientation = Matrix3::Identity(),
                 const std::vector<double>& weights = {});
  /// Nodes that move as one rigid piece (RBE2), at their mean. SceneError for a basis in which they deform, and for
  /// nodes on a line: make_basis(model, frame, modes, {.rigid = {ids}}) ties them.
  Marker rigid(const std::vector<int>& ids, const Matrix3& orientation = Matrix3::Identity());
  /// Forces on nodes, 3 x ids, N, in mesh axes (or world axes for a load that keeps its direction), as forces on
  /// weighted means of these nodes: of each component b the positive parts together and the negative ones,
  ///   F = Σ |f_b| e_b at Σ w_i r_i, w_i = |f_i,b| / Σ |f_b|.
  /// Markers have the mesh's axes and turn with the body frame. For joints/forces/distributed_load.h. SceneError for
  /// other than one force a node, for a value that is not finite, and for no force at all.
  NodalLoad nodal_load(const std::vector<int>& ids, const Matrix3X& forces);
  /// The body frame itself; does not follow the deformation.
  Marker frame(const Matrix3& orientation = Matrix3::Identity());
  /// Any point with given modal Jacobians, body axes: c, Bm, Theta (3 x nm each, or a column for each field of a basis
  /// with a quadratic deflection), R0 (docs/equations.md 7.1).
  Marker modal_marker(const Vector3& c, const Matrix3X& Bm, const Matrix3X& Theta, const Matrix3& R0);

  /// The nodes (indices) that a marker follows, and how much each counts (sum 1); none for the frame and modal markers.
  struct MarkerNodes {
    std::vector<int> nodes;
    std::vector<double> weights;
  };
  const MarkerNodes& marker_nodes(int marker) const { return markers_.at(static_cast<size_t>(marker)).nodes; }

  // ---- results: all nodes, world axes, 3 x n ----
  struct NodalMotion {
    Matrix3X position, velocity, acceleration;
  };
  NodalMotion nodal_motion(const BodyState&, const double* v_dot) const;
  /// Linear momentum, and angular momentum about the world origin, world axes.
  Vector3 linear_momentum(const BodyState&) const;
  Vector3 angular_momentum(const BodyState&) const;
  // The parts of the right-hand side, v_count long (docs/equations.md 3.2, 4.1, 4.4).
  VectorX quadratic_velocity_force(const BodyState&) const;
  VectorX gravity_force(const BodyState&, const Vector3& gravity) const;
  VectorX elastic_force(const BodyState&) const;
  VectorX damping_force(const BodyState&) const;
  MatrixX mass_matrix(const BodyState&) const;

  VectorX candidate_stiffness() const override;
  VectorX candidate_damping() const override;
  VectorX candidate_reach() const override;
  VectorX candidate_forces(const BodyState&, const double* v_dot, std::span<const MarkerLoad> loads,
                           const Vector3& gravity) const override;
  Deflection finest_deflection() const override;
  const Fidelity& fidelity() const override { return fidelity_; }
  void set_fidelity(Fidelity fidelity) override;
  Marker body_frame() override {
    if (!body_frame_.body) body_frame_ = frame();
    return body_frame_;
  }

  Coordinates coordinates() const override {
    return {.frames = 1, .linear = modes_, .pattern = diagonal_ ? nullptr : &pattern_};
  }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override;
  void evaluate(const BodyState&, Level) const override;
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  void add_tangent(const BodyState&, const double* v_dot, const Vector3& gravity, const TangentWeights&,
                   BodyTangent&) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3& gravity) const override;

  /// Of the modes in use; with full nodal coordinates of the points alone. Empty without elements.
  DrawnMesh drawn_mesh(bool with_stress) const override;
  void drawn_points(const BodyState&, const DrawnMesh& mesh, Matrix3X& points) const override;
  std::vector<std::pair<int, double>> nodes_of_marker(int marker) const override;

 private:
  struct MarkerShape {
    Vector3 c;
    Matrix3 R0;
    Matrix6X elastic;  // [Bm; Theta] of the modes; no columns if the deformation does not move it
    MatrixX pairs;     // 6 x pairs: what the squares of η add, for a quadratic deflection
    bool turns;        // the deformation turns it
    MarkerNodes nodes;
  };
  bool has_candidates() const { return !with_integrals_ && drawn_.basis->diagonal && !drawn_.basis->nodal; }
  void build();
  void set_up();
  /// Displacement fields that the markers and nodes follow: modes_, or all of [B, Ψ].
  int field_count() const { return deflection_ ? deflection_->field_count() : modes_; }
  Matrix3X node_fields(int node) const;
  std::vector<int> indices_of(const std::vector<int>& ids) const;
  using MarkerRecipe = std::function<MarkerShape()>;
  /// Keeps the recipe too: another fidelity shapes all markers anew.
  Marker add_marker(MarkerRecipe recipe);
  /// Bm, Theta: of all fields; Theta_pairs, 3 x pairs: turns of second order beyond those of the fields, or empty.
  MarkerShape shape(const Vector3& c, const Matrix3X& Bm, const Matrix3X& Theta, const Matrix3& R0,
                    MarkerNodes nodes = {}, const Matrix3X& Theta_pairs = Matrix3X(3, 0)) const;
  MarkerShape node_shape(int node, const Matrix3& orientation) const;
  MarkerShape average_shape(const NodeAverage& mean, const Matrix3& orientation) const;
  /// Turns of second order of a mean, 3 x pairs; Theta: of first order.
  Matrix3X mean_turns(const NodeAverage& mean, const Matrix3X& Theta) const;
  /// out += (mass Mff + damping D + stiffness K^) x
  void add_modal(double mass, double damping, double stiffness, const double* x, double* out) const;

  void add_couplings(Cache& cache, const double* omega, const double* omega_dot, const Vector3& lift,
                     const TangentWeights& weights, BodyTangent& S) const;
  void add_linear_tangent(Cache& cache, const double* v_dot, const Vector3& gravity, const TangentWeights& weights,
                          Eigen::Map<VectorX>& linear) const;

  Parameters drawn_, parameters_;  // as given, and as they are at the present fidelity
  bool with_integrals_ = false;    // given by hand
  Fidelity fidelity_;
  MatrixX fields_;  // of set_fidelity(): the present displacement fields by those of the candidates; empty before
  int modes_ = 0;
  bool diagonal_ = true;
  std::unique_ptr<const FlexibleInertia> inertia_;   // of all fields
  std::unique_ptr<const DeflectionMap> deflection_;  // null: linear
  VectorX stiffness_, damping_;                      // diagonal, or entries along the pattern
  VectorX modal_mass_;                               // entries along the pattern; diagonal bases: ones
  LinearPattern pattern_;
  std::vector<MarkerShape> markers_;
  std::vector<MarkerRecipe> recipes_;
  Marker body_frame_;         // once asked for
  int modal_columns_ = kAll;  // that modal markers have, the least
};

extern template std::unique_ptr<BodyBatch> make_body_batch<FlexibleBody>();

}  // namespace lithe
