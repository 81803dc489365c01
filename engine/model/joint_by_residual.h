#pragma once

#include "engine/base/dual.h"
#include "engine/model/constraint.h"
#include "engine/model/force_element.h"
#include "engine/model/tension_law.h"

namespace lithe {

/// Position and axes of a marker as a function of S: a number, or one that carries derivatives (engine/base/dual.h).
template <class S>
struct PoseOf {
  Eigen::Matrix<S, 3, 1> p;  // m, world axes
  Eigen::Matrix<S, 3, 3> R;  // marker axes to world axes
  auto x() const { return R.col(0); }
  auto y() const { return R.col(1); }
  auto z() const { return R.col(2); }
};

namespace by_residual {

/// Poses of M markers with derivatives by their 6 M motions: translations, then turns exp(θ~) R, in world axes; time is
/// the one behind them, where N has room for it. Good until the next call of the thread: what is zero stays so, and to
/// write it anew would cost more than all the rest.
template <int M, int N>
const std::array<PoseOf<Dual<N>>, M>& moved(std::span<const MarkerView> markers) {
  thread_local std::array<PoseOf<Dual<N>>, M> poses;
  for (int m = 0; m < M; ++m) {
    const MarkerView& marker = markers[static_cast<std::size_t>(m)];
    PoseOf<Dual<N>>& pose = poses[static_cast<std::size_t>(m)];
    for (int k = 0; k < 3; ++k) pose.p[k].value = marker.p[k], pose.p[k].d[6 * m + k] = 1;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) {
        Dual<N>& entry = pose.R(r, c);
        entry.value = marker.R(r, c);
        // e_i × a: row r of it
        entry.d[6 * m + 3 + (r + 1) % 3] = marker.R((r + 2) % 3, c);
        entry.d[6 * m + 3 + (r + 2) % 3] = -marker.R((r + 1) % 3, c);
      }
  }
  return poses;
}

/// The same twice: the outer derivative is the wrench, the inner one how it changes where the markers have moved
/// before.
template <int M, int N>
const std::array<PoseOf<Dual<N, Dual<N>>>, M>& moved_twice(std::span<const MarkerView> markers) {
  thread_local std::array<PoseOf<Dual<N, Dual<N>>>, M> poses;
  const auto& once = moved<M, N>(markers);
  for (int m = 0; m < M; ++m) {
    const PoseOf<Dual<N>>& pose = once[static_cast<std::size_t>(m)];
    auto& twice = poses[static_cast<std::size_t>(m)];
    for (int k = 0; k < 3; ++k) twice.p[k].value = pose.p[k], twice.p[k].d[6 * m + k] = 1.0;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) {
        auto& entry = twice.R(r, c);
        entry.value = pose.R(r, c);
        entry.d[6 * m + 3 + (r + 1) % 3] = pose.R((r + 2) % 3, c);
        entry.d[6 * m + 3 + (r + 2) % 3] = -pose.R((r + 1) % 3, c);
      }
  }
  return poses;
}

/// Along the motion of the markers, without their accelerations.
template <int M>
std::array<PoseOf<InTime>, M> in_time(std::span<const MarkerView> markers) {
  std::array<PoseOf<InTime>, M> poses;
  for (int m = 0; m < M; ++m) {
    const MarkerView& marker = markers[static_cast<std::size_t>(m)];
    for (int k = 0; k < 3; ++k) poses[m].p[k] = {marker.p[k], marker.v[k], 0};
    for (int c = 0; c < 3; ++c) {
      const Vector3 rate = marker.w.cross(Vector3(marker.R.col(c))), turn = marker.w.cross(rate);
      for (int r = 0; r < 3; ++r) poses[m].R(r, c) = {marker.R(r, c), rate[r], turn[r]};
    }
  }
  return poses;
}

}  // namespace by_residual

/// A joint from its residual alone, written once over the scalar; its wrenches, velocity terms, dependence on time and
/// stiffness under load are derived, exactly:
///   struct Rod final : JointByResidual<Rod, /*markers=*/2, /*rows=*/1> {
///     double length = 1;
///     template <class S> void residual(std::span<const PoseOf<S>> m, S* g) const {
///       g[0] = 0.5 * ((m[1].p - m[0].p).squaredNorm() - length * length);
///     }
///   };
/// A residual that depends on time has it first: residual(const S& time, std::span<const PoseOf<S>>, S* g). It must be
/// smooth where the joint moves. Written rows cost less where much is known of them: docs/equations.md 7.5.
template <class Derived, int Markers, int Rows>
class JointByResidual : public Joint<Markers, Rows> {
 public:
  bool depends_on_time() const override { return kTimed; }

  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const final {
    constexpr int kMotions = 6 * Markers, kDerivatives = kMotions + (kTimed ? 1 : 0);
    if (rows.stiffness()) add_stiffness(time, markers, rows);
    std::array<Dual<kDerivatives>, Rows> g;
    Dual<kDerivatives> now(time);
    if constexpr (kTimed) now.d[kMotions] = 1;
    const auto& moved = by_residual::moved<Markers, kDerivatives>(markers);
    residual<Dual<kDerivatives>>(now, moved, g.data());
    std::array<InTime, Rows> along;
    const auto motion = by_residual::in_time<Markers>(markers);
    residual<InTime>({time, 1, 0}, motion, along.data());
    for (int r = 0; r < Rows; ++r) {
      Wrench* W = rows.open();
      const double* d = g[r].d.data();
      for (int m = 0; m < Markers; ++m, d += 6) W[m] = {Vector3(d[0], d[1], d[2]), Vector3(d[3], d[4], d[5])};
      rows.finish(g[r].value, along[r].acceleration, kTimed ? g[r].d[kDerivatives - 1] : 0);
    }
  }

 private:
  static constexpr bool kTimed = requires(const Derived& joint, std::span<const PoseOf<InTime>> poses, InTime* g) {
    joint.template residual<InTime>(*g, poses, g);
  };

  template <class S>
  void residual(const S& time, std::span<const PoseOf<S>> poses, S* g) const {
    const auto& joint = static_cast<const Derived&>(*this);
    if constexpr (kTimed)
      joint.template residual<S>(time, poses, g);
    else
      joint.template residual<S>(poses, g);
  }

  /// ∂(Σ W λ)/∂(marker motions), from second derivatives of Σ λ g.
  void add_stiffness(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const {
    constexpr int N = 6 * Markers;
    using Twice = Dual<N, Dual<N>>;
    std::array<Twice, Rows> g;
    const auto& moved = by_residual::moved_twice<Markers, N>(markers);
    residual<Twice>(time, moved, g.data());
    Twice loaded;
    for (int r = 0; r < Rows; ++r) loaded += rows.multipliers()[r] * g[r];
    ConstraintRows::Stiffness& K = *rows.stiffness();
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i) K(i, j) += loaded.d[i].d[j];
  }
};

/// A force from its potential alone, written once over the scalar: loads -∂V/∂(poses).
///   template <class S> S potential(std::span<const PoseOf<S>> m) const;
/// or with the time first. Its tangent is differenced.
template <class Derived, int Markers>
class ForceByPotential : public Force<Markers, /*rows=*/0> {
 public:
  bool depends_on_time() const override { return kTimed; }

  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const final {
    using D = Dual<6 * Markers>;
    const auto& moved = by_residual::moved<Markers, 6 * Markers>(markers);
    const auto& force = static_cast<const Derived&>(*this);
    D V;
    if constexpr (kTimed)
      V = force.template potential<D>(D(time), moved);
    else
      V = force.template potential<D>(moved);
    rows.add_energy(V.value);
    const double* d = V.d.data();
    for (int m = 0; m < Markers; ++m, d += 6)
      rows.add_load(markers[static_cast<std::size_t>(m)], {-Vector3(d[0], d[1], d[2]), -Vector3(d[3], d[4], d[5])});
  }

 private:
  static constexpr bool kTimed = requires(const Derived& force, std::span<const PoseOf<InTime>> poses, InTime t) {
    force.template potential<InTime>(t, poses);
  };
};

/// A spring and damper on any length or angle of markers, written once over the scalar; its row is compliant, so that
/// it may be stiff:
///   template <class S> S stretch(std::span<const PoseOf<S>> m) const;   // m or rad
///   Tension tension(double stretch, double speed) const;                // engine/model/tension_law.h
template <class Derived, int Markers>
class ForceByStretch : public Force<Markers, /*rows=*/1> {
 public:
  bool depends_on_time() const override { return false; }

  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const final {
    const auto& moved = by_residual::moved<Markers, 6 * Markers>(markers);
    const auto& force = static_cast<const Derived&>(*this);
    const auto length = force.template stretch<Dual<6 * Markers>>(moved);
    Wrench* W = rows.open();
    const double* d = length.d.data();
    double speed = 0;
    for (int m = 0; m < Markers; ++m, d += 6) {
      W[m] = {Vector3(d[0], d[1], d[2]), Vector3(d[3], d[4], d[5])};
      const MarkerView& marker = markers[static_cast<std::size_t>(m)];
      speed += W[m].force.dot(marker.v) + W[m].torque.dot(marker.w);
    }
    const Tension tension = force.tension(length.value, speed);
    rows.add_energy(tension.energy);
    rows.finish(tension.force, tension.stiffness, tension.damping);
  }
};

}  // namespace lithe
