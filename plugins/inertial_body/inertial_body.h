#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "engine/plugin.h"
#include "plugins/inertial_body/brick.h"
#include "plugins/inertial_body/brick_mesh.h"

namespace lithe {

/// A solid of 8-node bricks in the inertial frame: no body frame, no modes, no smallness. Total Lagrangian, large
/// rotation and large deflection, St. Venant-Kirchhoff, consistent mass (Bathe, Finite Element Procedures, 6.2; the
/// bricks: brick.h). q: positions of all nodes in world axes, v: their velocities;
///   M v̇ + ∂U/∂q + D v = M g,   M constant, D v: mass- and stiffness-proportional
/// It is what linear floating-frame bodies are judged against, and bears what they cannot: stiffening by spin and load,
/// buckling, large bending. Its cost grows with its nodes, and its highest frequency with its finest element: implicit
/// integrators only.
class InertialBody final : public Body, public DrawableBody {
 public:
  struct Parameters {
    std::shared_ptr<const BrickMesh> mesh{};  // nodes, bricks, material; or
    std::filesystem::path mesh_file{};        // a CalculiX deck to read them from
    // Rayleigh damping. Mass-proportional brakes all motion, rigid motion too; stiffness-proportional acts on the rate
    // of the Green-Lagrange strain, S = C:(E + β Ė), so that rigid motion feels nothing of it.
    double mass_damping = 0;                    // α, 1/s
    double stiffness_damping = 0;               // β, s
    Vector3 position{0, 0, 0};                  // of the mesh origin at t = 0, world axes, m
    Matrix3 orientation = Matrix3::Identity();  // mesh axes to world axes
    Vector3 velocity{0, 0, 0};                  // of the mesh origin, world axes, m/s
    Vector3 angular_velocity{0, 0, 0};          // mesh axes, rad/s
  };
  static constexpr Field<Parameters> kParameters[] = {{"mesh_file", &Parameters::mesh_file},
                                                      {"mass_damping", &Parameters::mass_damping},
                                                      {"stiffness_damping", &Parameters::stiffness_damping},
                                                      {"position", &Parameters::position},
                                                      {"orientation", &Parameters::orientation},
                                                      {"velocity", &Parameters::velocity},
                                                      {"angular_velocity", &Parameters::angular_velocity}};
  struct Cache : BodyCache {
    std::vector<brick::Modes> modes;
    VectorX force;                  // ∂U/∂q + stiffness-proportional damping
    double strain_energy = 0;       // J
    std::vector<Matrix6X> elastic;  // of each marker; no columns before it is asked for
    explicit Cache(const InertialBody&);
  };

  /// Throws SceneError for a missing or unsound mesh, NaN, negative damping; FileError for a deck that cannot be read.
  explicit InertialBody(Parameters parameters);

  const Parameters& parameters() const { return parameters_; }
  const BrickMesh& mesh() const { return *parameters_.mesh; }
  int node_count() const { return mesh().node_count(); }
  double mass() const { return mass_; }

  // ---- markers; orientations are given in mesh axes ----
  /// A node by its label. Solids have no nodal rotation: its axes turn with the nodes of the elements around it.
  Marker node(int id, const Matrix3& orientation = Matrix3::Identity());
  /// The mean of nodes (RBE3): mean position, and the rotation that fits them best (least squares). What nodes on a
  /// line, or fewer than three, leave open is taken from the elements around them.
  Marker average(const std::vector<int>& ids, const Matrix3& orientation = Matrix3::Identity());

  // ---- results, world axes ----
  Matrix3X positions(const BodyState&) const;   // 3 x nodes, m
  Matrix3X velocities(const BodyState&) const;  // 3 x nodes, m/s
  /// Six components a column, in the order xx, yy, zz, xy, yz, xz (shear not doubled).
  struct StressField {
    Matrix6X cauchy;                          // true stress, world axes, Pa
    Matrix6X second_piola_kirchhoff, strain;  // S (Pa) and E, mesh axes
  };
  /// At the Gauss points: column 8 * element + point.
  StressField stress(const BodyState&) const;
  /// Extrapolated to the nodes and averaged over the elements that meet there.
  StressField nodal_stress(const BodyState&) const;
  /// Linear momentum, and angular momentum about the world origin.
  Vector3 linear_momentum(const BodyState&) const;
  Vector3 angular_momentum(const BodyState&) const;

  Coordinates coordinates() const override {
    return {.frames = 0, .linear = 3 * node_count(), .pattern = &bricks_.pattern()};
  }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override;
  /// Where an element is too distorted for its modes to be found, forces become NaN: integrators take a smaller step.
  void evaluate(const BodyState&, Level) const override;
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  /// Exact but for ∂(D v)/∂q.
  void add_tangent(const BodyState&, const double* v_dot, const Vector3& gravity, const TangentWeights&,
                   BodyTangent&) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3& gravity) const override;

  DrawnMesh drawn_mesh(bool with_stress) const override;
  void drawn_points(const BodyState&, const DrawnMesh& mesh, Matrix3X& points) const override;
  std::vector<std::pair<int, double>> nodes_of_marker(int marker) const override;

 private:
  /// Position: the mean of `points`; rotation: the best fit to the weighted arms about `center`.
  struct MarkerShape {
    std::vector<int> points;
    struct Arm {
      int node;
      double weight;
      Vector3 rho;  // from the weighted centre, mesh axes, m
    };
    std::vector<Arm> arms;
    Matrix3 orientation;
  };
  Marker add_marker(std::vector<int> points, const std::vector<std::pair<int, double>>& fitted,
                    const Matrix3& orientation);
  std::vector<int> neighbours(const std::vector<int>& nodes) const;
  /// out += weight M x
  void add_mass_product(double weight, const double* x, double* out) const;

  const Parameters parameters_;
  brick::Bricks bricks_;
  double mass_ = 0;
  struct MassEntry {
    int i, j;  // nodes, i > j
    double m;  // kg
  };
  std::vector<MassEntry> mass_entries_;
  VectorX mass_diagonal_;
  std::vector<MarkerShape> markers_;
};

}  // namespace lithe
