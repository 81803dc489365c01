#pragma once

#include <cassert>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "engine/model/connector.h"
#include "engine/model/marker.h"

namespace lithe {

inline constexpr int kMaxMarkers = 8;     // of one joint or force that acts on all of them
inline constexpr int kMostMarkers = 256;  // of one that says which of them it acts on
inline constexpr int kMaxRows = 12;

/// Of a joint or force on more than kMaxMarkers markers, as one that slides along many: those that it acts on at one
/// state, at most kMaxMarkers. Wrenches are kept of these alone; the others feel nothing.
class ActingMarkers {
 public:
  void act_on(std::span<const int> markers) {
    assert(markers.size() <= kMaxMarkers);
    acting_ = static_cast<int>(markers.size());
    for (int i = 0; i < acting_; ++i) acting_on_[i] = markers[static_cast<std::size_t>(i)];
  }

 protected:
  /// Of all markers, those that a row keeps a wrench of.
  int kept(int markers) const { return acting_ > 0 ? acting_ : markers; }
  const Wrench& wrench_of(const Wrench* kept, int marker) const {
    if (acting_ == 0) [[likely]]
      return kept[marker];
    return acting_wrench(kept, marker);
  }

 private:
  const Wrench& acting_wrench(const Wrench* kept, int marker) const;

  int acting_ = 0;  // 0: all
  int acting_on_[kMaxMarkers];
};

/// The rows of one joint at one state: residual g, the wrench W of a unit multiplier on each marker, the rate ∂g/∂t and
/// the velocity terms of the second derivative:  g_dot = Σ W·V + rate,  g_dotdot = Σ W·V_dot + bias,  V = (v, w) of the
/// markers, summed over them. What the markers' own accelerations owe to velocities is the engine's business.
class ConstraintRows : public AngleMemory, public ActingMarkers {
 public:
  explicit ConstraintRows(int markers) : markers_(markers) {}

  /// A written row. `wrenches`: one per marker, in the order of the joint's marker list.
  void add(double residual, std::initializer_list<Wrench> wrenches, double bias, double rate = 0) {
    assert(static_cast<int>(wrenches.size()) == markers_);
    written_ = true;
    int m = 0;
    for (const Wrench& w : wrenches) set(m++, w);
    finish(residual, bias, rate);
  }

  /// A row on velocities alone, nonholonomic: g_dot = Σ W·V + rate = 0 where no g exists (rolling). Which of a joint's
  /// rows are such must not change.
  void add_velocity(std::initializer_list<Wrench> wrenches, double bias, double rate = 0) {
    velocity_[count_] = true;
    add(0, wrenches, bias, rate);
  }

  /// Opens a row with no wrench anywhere, one for each marker that it may act on; for the composed rows below.
  Wrench* open() {
    for (int m = 0; m < kept(markers_); ++m) set(m, {Vector3::Zero(), Vector3::Zero()});
    return wrench_[count_];
  }
  /// Opens a row on velocities alone.
  Wrench* open_velocity() {
    velocity_[count_] = true;
    return open();
  }
  /// Closes an open row that brings no stiffness of its own: it is differenced.
  void finish_written(double residual, double bias, double rate = 0) {
    written_ = true;
    finish(residual, bias, rate);
  }
  void finish(double residual, double bias, double rate = 0) {
    residual_[count_] = residual;
    bias_[count_] = bias;
    rate_[count_] = rate;
    ++count_;
  }

  /// Turns the last row g into g - f(t), with the rate and acceleration of f.
  void drive_last(double value, double rate, double acceleration) {
    residual_[count_ - 1] -= value;
    rate_[count_ - 1] -= rate;
    bias_[count_ - 1] -= acceleration;
  }

  /// Whether biases are read; where not, a row may leave out what they cost.
  bool bias_wanted() const { return bias_wanted_; }

  /// Multiplier of the row being written, while the stiffness of loaded joints is collected; else null stiffness().
  double multiplier() const { return multipliers_[count_]; }
  const double* multipliers() const { return multipliers_; }  // of all rows
  /// ∂(Σ_rows W λ)/∂(marker motions), 6 rows and columns a marker (translation, rotation; world axes).
  using Stiffness = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6 * kMaxMarkers, 6 * kMaxMarkers>;
  Stiffness* stiffness() {
    if (stiffness_ && !stiff_) stiffness_->setZero(6 * markers_, 6 * markers_), stiff_ = true;
    return stiffness_;
  }

  // The engine's side.
  void want_bias(bool wanted) { bias_wanted_ = wanted; }
  void collect_stiffness(const double* multipliers, Stiffness* into) { multipliers_ = multipliers, stiffness_ = into; }
  int count() const { return count_; }
  bool written() const { return written_; }
  bool stiff() const { return stiff_; }  // stiffness() has been asked for
  const Wrench& wrench(int row, int marker) const { return wrench_of(wrench_[row], marker); }
  /// The same where act_on() is not used.
  const Wrench& plain_wrench(int row, int marker) const { return wrench_[row][marker]; }
  double residual(int row) const { return residual_[row]; }
  double bias(int row) const { return bias_[row]; }
  double rate(int row) const { return rate_[row]; }
  bool on_velocity(int row) const { return velocity_[row]; }
  /// Whether rows 0 to 2 are p_1 - p_0 = 0: most joints have these, and their blocks need no wrench.
  bool hold_point() const { return hold_point_; }

 private:
  friend void coincident(const MarkerView&, const MarkerView&, ConstraintRows&);
  void set(int marker, const Wrench& w) { wrench_[count_][marker] = w; }

  int markers_, count_ = 0;
  bool written_ = false, stiff_ = false;
  bool velocity_[kMaxRows] = {};
  bool hold_point_ = false, bias_wanted_ = true;
  const double* multipliers_ = nullptr;
  Stiffness* stiffness_ = nullptr;
  Wrench wrench_[kMaxRows][kMaxMarkers];
  double residual_[kMaxRows], bias_[kMaxRows], rate_[kMaxRows];
};

/// The motions of marker B relative to marker A that a joint of two markers leaves free, where they are a lower pair's:
/// displacements along axes of A, and turns about its z axis or about any. What is not free is held, and nothing else:
/// in a tree of such joints the engine may then solve for these motions alone (engine/forward_dynamics.h).
struct JointFreedom {
  enum class Rotation { none, about_z, any };
  bool x = false, y = false, z = false;
  Rotation rotation = Rotation::none;
};

/// Rows that tie bodies: g(q, t) = 0, or g_dot = 0 alone. Knows markers, never bodies.
class Constraint : public Connector {
 public:
  virtual int row_count() const = 0;
  /// Writes the rows of one state. Constant size, no allocation.
  virtual void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const = 0;
  /// None where the joint is no lower pair, or is driven.
  virtual std::optional<JointFreedom> freedom() const { return std::nullopt; }
  /// Whether its rows may change while the bodies rest. Where nothing does, a scene at rest sleeps
  /// (engine/run/sleeping_integrator.h); a lower pair does not, and others that do not say so.
  virtual bool depends_on_time() const { return !freedom(); }
};

/// A constraint with its numbers of markers and rows known to the compiler.
template <int Markers, int Rows>
class Joint : public Constraint {
 public:
  static constexpr int kMarkers = Markers, kRows = Rows;
  int marker_count() const final { return Markers; }
  int row_count() const final { return Rows; }
};

// ---- the rows joints are composed of (docs/equations.md 7.2); each brings its own stiffness under load ----

/// Three rows p_B - p_A = 0. Inline: the compiler leaves out what nobody reads of its constant wrenches.
inline void coincident(const MarkerView& A, const MarkerView& B, ConstraintRows& rows) {
  rows.hold_point_ = rows.count_ == 0 && A.index == 0 && B.index == 1;
  const Vector3 d = B.p - A.p;
  const auto add = [&](int i) {  // constant wrenches: no stiffness
    Wrench* W = rows.open();
    W[A.index].force = -Vector3::Unit(i);
    W[B.index].force = Vector3::Unit(i);
    rows.finish(d[i], 0);
  };
  add(0), add(1), add(2);
}
/// One row a · b = 0, a fixed in A, b fixed in B, both in world axes now.
void perpendicular(const MarkerView& A, const Vector3& a, const MarkerView& B, const Vector3& b, ConstraintRows& rows);
/// One row a · (p_B - p_A) = 0, a fixed in A: B stays in the plane through A normal to a.
void in_plane(const MarkerView& A, const Vector3& a, const MarkerView& B, ConstraintRows& rows);
/// One row ½ (|p_B - p_A|² - L²) = 0.
void at_distance(const MarkerView& A, const MarkerView& B, double length, ConstraintRows& rows);
/// Three rows p_B - (p_A + R_A c) = 0: point B stays at c in the axes of A.
void at_point(const MarkerView& A, const Vector3& c, const MarkerView& B, ConstraintRows& rows);

}  // namespace lithe
