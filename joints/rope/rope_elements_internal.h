#pragma once

#include <optional>
#include <vector>

#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "engine/model/force_element.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/placeless_body.h"

/// What reeve() (joints/rope/rope.h) makes a rope of, after it has checked it.
namespace lithe {

/// A rope's material: tension T = EA ε + c ε̇, where the viscous part is at most as large as the elastic one, so that a
/// rope never pushes and a slack one is caught without a jump.
struct RopeSection {
  double axial_stiffness = 0;  // EA, N
  double axial_damping = 0;    // c, N s
};

/// A span as drawn, from wheel A to wheel B. Signed radii R, m: the rope runs counter-clockwise about the z axis of the
/// wheel's marker (R > 0), or clockwise; 0: the rope ends at the marker's point.
struct RopeSpanDrawing {
  double R_A = 0, R_B = 0;
  double drawn_length = 0;      // Λ₀ with its parts of the arcs, m
  double rest_length = 0;       // L₀, of its unstretched material, m
  double arc_A = 0, arc_B = 0;  // its parts of the arcs, m
};

/// The geometric length of a span, from a point of the rope on wheel A to one on wheel B that do not turn with φ:
///   Λ = ℓ + R_A φ_A - R_B φ_B + as drawn,   ℓ² = c² - (R_A - R_B)²,   φ = bearing of the centres + asin((R_A - R_B)/c)
/// c: distance of the markers; φ: direction of the straight part in the axes of either marker, turns counted. The
/// wheels' planes coincide about: bearings are taken in each marker's own xy plane. Its derivative by the motion of the
/// markers is exact: ∂ℓ and ∂φ add up to (ℓ/c) ∂c + R_A ∂bearing_A - R_B ∂bearing_B.
struct MeasuredSpan {
  double length, rate;      // Λ without the constant, m; m/s
  double straight;          // ℓ, m
  double angle_A, angle_B;  // φ in the axes of A and, less half a turn, in those of B; where R = 0 not set
  Wrench on_A, on_B;        // ∂Λ
};
/// The angles that a span between markers number A and B counts.
void add_span_angles(int A, int B, const RopeSpanDrawing& drawing, std::vector<MeasuredAngle>& to);
/// `place`: of its first angle among the connector's; moved behind its last.
MeasuredSpan measure_span(const MarkerView& A, const MarkerView& B, const RopeSpanDrawing& drawing,
                          const AngleMemory& memory, int& place);

/// A span's wheels and its line on pages: half of either arc, from a point that stays on the carrier, and the straight
/// part.
class DrawnSpan {
 public:
  /// By the span as drawn.
  void set(const RopeSpanDrawing& drawing, const MeasuredSpan& drawn);
  int point_count() const;
  /// Fills that many columns of `points` from column `at`; moves `at` behind them.
  void add_points(const MarkerView& A, const MarkerView& B, const MeasuredSpan& now, Matrix3X& points, int& at) const;

 private:
  RopeSpanDrawing drawing_;
  double start_ = 0, end_ = 0;  // φ where its arcs begin and end, rad
};
/// A disc as large as a wheel; none without radius.
std::vector<DrawnShape> drawn_wheel(double radius);

/// Stretch of a span, ε = Λ/L - 1 of its material L.
struct RopeStretch {
  double strain = 0;  // ε, 0 where it is slack
  double tension = 0, stiffness = 0, damping = 0, energy = 0;
  RopeStretch(const RopeSection& section, double length, double rate, double material, double material_rate);
};

/// The travel of a rope over one pulley: a body without frame whose first coordinate s is the unstretched length that
/// has passed, positive from the rope's first end to its last; its mass is that of the rope beside it. Where the rope
/// may slip, the rate of a second coordinate keeps how far it has slipped (m). Marker 0 stays at the origin, marker 1
/// moves along x by s and along y by the second coordinate.
class RopeTravel final : public PlacelessBody {
 public:
  struct Parameters {
    double mass = 0;   // kg
    double speed = 0;  // of s as drawn, m/s
    bool slips = false;
  };
  struct Cache : BodyCache {
    explicit Cache(const RopeTravel&) {}
  };
  /// Throws SceneError for a mass that is not positive.
  explicit RopeTravel(Parameters parameters);
  Coordinates coordinates() const override { return {.frames = 0, .linear = parameters_.slips ? 2 : 1}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override;
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState&, const double* v_dot, const Vector3&, double* r) const override;
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                   BodyTangent& tangent) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState& state, const Vector3&) const override;

 private:
  const Parameters parameters_;
};

/// A whole rope without mass over pulleys without friction: one tension all along.
///   T = EA (Λ/L - 1) + c Λ̇/L,   Λ: sum over its spans,   V = ½ EA ε² L
class IdealRope final : public ForceElement, public DrawableConnector {
 public:
  static constexpr int kRows = 1;
  struct Parameters {
    RopeSection section;
    std::vector<RopeSpanDrawing> spans;  // span i ties markers i and i + 1
  };
  explicit IdealRope(Parameters parameters) : parameters_(std::move(parameters)) {}

  int marker_count() const override { return static_cast<int>(parameters_.spans.size()) + 1; }
  int row_count() const override { return kRows; }
  bool depends_on_time() const override { return false; }
  std::vector<MeasuredAngle> angles() const override;
  void initialize(std::span<const MarkerView> markers) override;
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  std::vector<DrawnShape> drawn_shapes(int marker) const override;
  void drawn_line(std::span<const MarkerView> markers, const AngleMemory&, Matrix3X& points) const override;

 private:
  const Parameters parameters_;
  double offset_ = 0, rest_length_ = 0;
  std::vector<DrawnSpan> drawn_;
};

/// A span between two wheels over which the rope travels: markers A, B, and those of the travels s at either, if any.
///   L = L₀ + s_A - s_B,   T = EA (Λ/L - 1) + c ε̇,   V = ½ EA ε² L - w·((L - a_A - a_B) (p_A + p_B)/2 + a_A p_A + a_B
///   p_B)
/// with its weight per length w half at either wheel, that of the arcs a at their own.
/// Forces are -∂V: a travel feels T (1 + ε/2), its material's tension and energy (Eshelby).
class RopeSpan final : public ForceElement, public DrawableConnector {
 public:
  static constexpr int kRows = 1;
  struct Parameters {
    RopeSection section;
    RopeSpanDrawing drawing;
    Vector3 weight{0, 0, 0};  // w, N/m, world axes
    bool travels_A = false, travels_B = false;
  };
  explicit RopeSpan(Parameters parameters) : parameters_(parameters) {}

  int marker_count() const override { return 2 + parameters_.travels_A + parameters_.travels_B; }
  int row_count() const override { return kRows; }
  bool depends_on_time() const override { return false; }
  std::vector<MeasuredAngle> angles() const override;
  void initialize(std::span<const MarkerView> markers) override;
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// The wheel at its beginning; that at its end if it is the rope's.
  std::vector<DrawnShape> drawn_shapes(int marker) const override;
  void drawn_line(std::span<const MarkerView> markers, const AngleMemory&, Matrix3X& points) const override;

 private:
  const Parameters parameters_;
  double offset_ = 0;
  DrawnSpan drawn_;
};

/// Friction between a rope and the surface of a pulley (Euler, Eytelwein), with bristles that stick and slip:
///   F = (T_in + T_out) tanh(u μα/2),   u = z within [-1, 1]: T_out = T_in e^(uμα) where F alone holds the difference
///   δ ż = v (1 - A(z, v) |z|/1.1),   v = (1 + ε) ṡ - R θ̇
/// u: the part of the friction that is used; δ: travel at which it is full; v: speed of the rope over the surface where
/// it runs on, with the strain ε of the span that it comes from, which makes elastic creep. A is 0 up to |z| = 0.7,
/// where bristles are elastic and nothing drifts, and 1 from |z| = 1 on (elasto-plastic: Dupont, Hayward, Armstrong &
/// Altpeter, 2002); sliding, |z| = 1.1. α: wrap as it is now. Where nothing slides as a whole the slip arc still loses
/// ṡ (T_in - T_out)²/2EA.
/// Markers: carriers of the wheel before, of this and of the next one; travels here, before and behind, if any; carrier
/// and wheel of the angle θ, if it turns. Rows: F, and the rate of what has slipped.
class RopeFriction final : public ForceElement {
 public:
  static constexpr int kRows = 2;
  struct Parameters {
    RopeSection section;
    RopeSpanDrawing in, out;
    Vector3 weight{0, 0, 0};  // w, N/m: T at the pulley is that of the middle and half of the span's weight
    double friction = 0;      // μ
    double presliding = 0;    // δ, m
    double wrap = 0;          // α as drawn, rad
    bool travels_before = false, travels_behind = false;
    std::optional<JointCoordinate> wheel{};  // θ, about z of the pulley's marker
  };
  explicit RopeFriction(Parameters parameters) : parameters_(parameters) {}

  int marker_count() const override;
  int row_count() const override { return kRows; }
  bool depends_on_time() const override { return false; }
  std::vector<MeasuredAngle> angles() const override;
  void initialize(std::span<const MarkerView> markers) override;
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  struct Motion;
  Motion motion(std::span<const MarkerView> markers, const AngleMemory& memory) const;

  const Parameters parameters_;
  double offset_in_ = 0, offset_out_ = 0, angle_ = 0, turned_ = 0;  // Λ, φ_out - φ_in and θ as drawn
};

extern template std::unique_ptr<BodyBatch> make_body_batch<RopeTravel>();
extern template std::unique_ptr<ForceBatch> make_force_batch<IdealRope>();
extern template std::unique_ptr<ForceBatch> make_force_batch<RopeSpan>();
extern template std::unique_ptr<ForceBatch> make_force_batch<RopeFriction>();

}  // namespace lithe
