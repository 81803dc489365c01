#pragma once

#include <vector>

#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "engine/model/force_element.h"
#include "engine/model/internal_loads.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// Motion of the inner ring against the outer one, or the loads that belong to it, in the axes of the outer ring:
///   u_x, u_y, u_z (m, N),  θ_x, θ_y (rad, N m)
/// θ: the direction of the inner ring's axis, θ_x = -y · z_inner, θ_y = x · z_inner.
using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

/// What a bearing loses; nothing by default.
///   damping:  F = F_el + τ d/dt F_el, the material of the contacts as a Kelvin-Voigt solid
///   friction: T = (M_0 + f_1 |F| d_m) tanh(ω / ω_c),  M_0 = 0.1 N m f_0 d_m³ max(160, (1e6 ν n)^(2/3)), d_m in m, ν in
///             m²/s, n in rpm (Palmgren 1957); |F|: of the force between the rings
struct BearingLosses {
  double damping_time = 0;   // τ, s
  double load_factor = 0;    // f_1, some 0.0002 to 0.001
  double speed_factor = 0;   // f_0, some 1 to 4
  double viscosity = 2e-5;   // ν of the lubricant, kinematic, m²/s
  double creep_speed = 0.1;  // ω_c, rad/s: below it the bearing creeps
};

/// Of one rolling element: the force between it and the inner ring along the line of contact, and the angle of that
/// line against the radial plane, positive where it pushes the inner ring back along -z. The same at the outer ring,
/// where the load of fast balls is another.
struct RollingElementLoad {
  double force = 0;          // N
  double contact_angle = 0;  // rad
  double outer_force = 0, outer_angle = 0;
};

/// Frequencies of a bearing whose outer ring stands, in the unit of the inner ring's speed (Hz or rad/s).
struct BearingFrequencies {
  double cage = 0;        // FTF: ½ (1 - γ) n
  double outer_pass = 0;  // BPFO: elements over a point of the outer ring
  double inner_pass = 0;  // BPFI: over a point of the inner ring
  double spin = 0;        // BSF: of an element about its own axis
};

/// A bearing with rolling elements between two markers, inner ring and outer ring: five elastic freedoms, and a free
/// turn about z. Each element is loaded at its own azimuth, which follows the cage (pure rolling),
///   ψ = ½ (1 - γ) φ + 2π j / Z,   γ = D cos α / d_m,   φ: turn of the inner ring against the outer one since the
///   drawing,
/// so a loaded bearing shakes at the pass frequency of its elements: its varying compliance. In the plane of an element
/// the inner ring moves by w = u_z, p = u_x cos ψ + u_y sin ψ and q = θ_y cos ψ - θ_x sin ψ; its law is a potential
/// V(w, p, q), so loads are -∂V, moments about z included, and the energy account closes. Quasi-static: the elements
/// have no mass. Twelve compliant rows: six, along u, θ and ψ, carry the loads, the others what these grow by.
class RollingBearing : public Force</*markers=*/2, /*rows=*/12>, public DrawableConnector, public InternalLoads {
 public:
  std::vector<MeasuredAngle> angles() const override { return {{.A = 1, .B = 0, .axis = 2}}; }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// Refuses z axes that differ and rings that are not drawn one in the other.
  void initialize(std::span<const MarkerView> markers) override;
  std::vector<DrawnShape> drawn_shapes(int marker) const override;
  double internal_load(std::span<const MarkerView> markers, const AngleMemory& memory) const override;

  // ---- the bearing alone; `cage`: ψ of the first element, rad ----

  /// Load that holds the inner ring at a deflection, counted from the drawing: N, N m.
  Vector5 load(const Vector5& deflection, double cage = 0) const;
  /// Its derivative, symmetric: N/m, N, N m.
  Matrix5 stiffness(const Vector5& deflection, double cage = 0) const;
  /// Static deflection under a load on the inner ring. Throws SceneError for a load that the bearing does not carry.
  Vector5 deflection(const Vector5& load, double cage = 0) const;
  std::vector<RollingElementLoad> element_loads(const Vector5& deflection, double cage = 0) const;
  /// `speed` of the inner ring.
  BearingFrequencies frequencies(double speed) const;
  int element_count() const { return layout_.count; }

 protected:
  struct Arrangement {
    int count;                        // Z
    double diameter, pitch_diameter;  // D, d_m, m
    double contact_angle = 0;         // α, rad
    double width = 0;                 // drawn, m
    BearingLosses losses{};
  };
  /// What an element does in its plane: V and its derivatives by (w, p, q).
  struct PlaneLoad {
    double energy = 0;
    Vector3 force = Vector3::Zero();
    Matrix3 stiffness = Matrix3::Zero();
    RollingElementLoad element{};
  };
  /// Throws SceneError for elements that do not fit on the pitch circle, and for what is negative or not finite.
  RollingBearing(const Arrangement& arrangement, const char* elements);
  virtual PlaneLoad in_plane(const Vector3& motion) const = 0;

 private:
  struct Loads {
    double energy = 0;
    Vector6 force = Vector6::Zero();      // ∂V by u, θ and ψ
    Matrix6 stiffness = Matrix6::Zero();  // ∂²V
  };
  struct Rings;
  using Reading = void (*)(const Vector6& at, const std::vector<RollingElementLoad>& each, std::span<double> values);
  friend Sensor ring_deflection(const RollingBearing&, Located);
  friend Sensor rolling_element_loads(const RollingBearing&, Located);
  friend Sensor contact_angles(const RollingBearing&, Located);
  static Sensor ring_sensor(const RollingBearing& bearing, Located name, std::vector<std::string> endings,
                            std::vector<std::string> units, Reading read);

  Loads loads(const Vector6& at, std::vector<RollingElementLoad>* each = nullptr) const;
  Rings rings(const MarkerView& inner, const MarkerView& outer, const AngleMemory& memory) const;
  double friction(double speed, double load, double& slope) const;

  const Arrangement layout_;
  double cage_ratio_;       // ½ (1 - γ)
  double drawn_angle_ = 0;  // of the rings, rad
};

/// Deflection of a bearing: columns x, y, z (m), tilt_x, tilt_y (rad).
Sensor ring_deflection(const RollingBearing& bearing, Located name = "");
/// Force between each rolling element and the inner ring, 1 … Z, N.
Sensor rolling_element_loads(const RollingBearing& bearing, Located name = "");
/// Contact angle of each, rad; of one without load that of its line of centres.
Sensor contact_angles(const RollingBearing& bearing, Located name = "");

}  // namespace lithe
