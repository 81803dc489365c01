#pragma once

#include <vector>

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/force_element.h"
#include "engine/model/system_graph.h"
#include "engine/observe/sensors.h"
#include "joints/forces/friction_law.h"
#include "joints/sliding/rail_curve.h"

namespace lithe {

/// A point slides along a rail: a curve through markers, which may be on a beam or a cable that bends, on a flexible
/// body, on a chain of bodies, or on the ground. Two rows; the slider may turn as it likes.
///   g = (n_2 · d, n_3 · d),   d = p - r(u),   r'(u) · d = 0
/// with n_2, n_3 across the rail. The place u follows from the positions alone, so that it needs no coordinate; since
/// r' · n = 0 a force λ n on the slider acts with -w_a(u) λ n on the markers a of the rail, w_a the weights of their
/// positions in r: sliding does no work, and the load passes from marker to marker without a jump.
///   u̇ = r' · (ṗ - Σ w_a Ṗ_a) / |r'|²,   g̈ = n · (p̈ - Σ w_a P̈_a - 2 u̇ Σ w_a' Ṗ_a - u̇² r'')
/// The rail goes on straight beyond its ends. Where it comes near itself, the stretch nearest to the slider counts.
/// Its markers have no torque: between them it is the curve that bends (RailCurve). Newton's matrix leaves out how
/// the rows turn under load.
///   add_sliding_joint(graph, "trolley", load.marker(), along(boom));
class SlidingJoint final : public Constraint {
 public:
  struct Parameters {
    int rail_markers = 0;  // as many as add_sliding_joint() was given
  };
  static constexpr int kRows = 2;

  /// SceneError for fewer than 3 or more than 255 markers of the rail.
  explicit SlidingJoint(Parameters parameters);
  int marker_count() const override { return rail_markers_ + 1; }
  int row_count() const override { return kRows; }
  bool depends_on_time() const override { return false; }
  /// SceneError for rail markers that coincide, and a slider farther from the rail than a tenth of its length.
  void initialize(std::span<const MarkerView> markers) override;
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;

  /// Where it is: u, the distance along the rail's markers as drawn, m; and the speed along the rail, m/s.
  struct Slide {
    double place, speed;
    Vector3 direction;
  };
  Slide slide(std::span<const MarkerView> markers) const;
  double length() const { return rail_.length(); }  // of the rail, m, as drawn; known once assembled

 private:
  friend class SlidingFriction;
  const int rail_markers_;
  RailCurve rail_;
};

/// Dry friction of a slider, driven by the joint's reaction N:
///   F = μ(s) (N + N₀) + c s,   s: speed along the rail, m/s,   μ(s): FrictionLaw
class SlidingFriction final : public ForceElement {
 public:
  struct Parameters {
    const SlidingJoint* joint = nullptr;
    double coefficient = 0;         // μ_k
    double static_coefficient = 0;  // μ_s; 0: μ_k
    double stribeck_speed = 0.1;    // v_s, m/s
    double creep_speed = 3e-3;      // v_c, m/s: below it the slider creeps
    double viscous = 0;             // c, N s/m
    double preload = 0;             // N₀, N
  };
  static constexpr int kRows = 1;
  /// Throws SceneError without a joint, and for what is negative or not finite.
  explicit SlidingFriction(Parameters parameters);
  int marker_count() const override { return parameters_.joint->marker_count(); }
  int row_count() const override { return kRows; }
  const Constraint* reaction_of() const override { return parameters_.joint; }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  Parameters parameters_;
  FrictionLaw law_;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<SlidingJoint>();
extern template std::unique_ptr<ForceBatch> make_force_batch<SlidingFriction>();

/// `rail`: markers in the order in which it passes them, 3 to 255. Of a cable's markers and others without axes of
/// their own, positions alone count.
SlidingJoint& add_sliding_joint(SystemGraph& graph, Located name, Marker slider, const std::vector<Marker>& rail);
/// On the joint's own markers; `friction.joint` is set.
SlidingFriction& add_sliding_friction(SystemGraph& graph, Located name, const SlidingJoint& joint,
                                      SlidingFriction::Parameters friction);

/// The nodes of a Beam or a Cable whose arc lengths (m) are from `from` to `to` (below zero: its end), as a rail.
template <class Line>
std::vector<Marker> along(Line& line, double from = 0, double to = -1) {
  std::vector<Marker> rail;
  const double slack = 1e-9 * line.length(), end = to < 0 ? line.length() : to;
  for (int i = 0; i < line.node_count(); ++i)
    if (line.arc(i) >= from - slack && line.arc(i) <= end + slack) rail.push_back(line.marker(line.arc(i)));
  return rail;
}

/// Distance along the rail as drawn, m; and the speed along it, m/s.
Sensor place_on_rail(const SlidingJoint& joint, Located name = "");
Sensor speed_on_rail(const SlidingJoint& joint, Located name = "");

}  // namespace lithe
