#pragma once

#include <optional>
#include <vector>

#include "engine/model/state.h"
#include "engine/motion/projection.h"

namespace lithe {

/// Takes a motion through a pose where closed loops lose rank and branches of the motion meet (a parallelogram that
/// lies flat), on the branch on which its velocity is smooth.
///
/// Near such a pose, δ seconds away, an error ε in γ becomes ε/δ in v̇ and multipliers grow like 1/δ, while the motion
/// itself is smooth: methods shorten their steps towards it without end. One step of Gauss collocation across, no node
/// of which lies at the pose and each of which is moved onto the constraints, sees none of that.
class SingularPose {
 public:
  explicit SingularPose(EquationsOfMotion& equations);

  /// Time from the state to such a pose if the motion passes one within `reach` seconds, or has in the last `step`:
  /// then it is negative. Makes factors, and leaves others' last one behind.
  std::optional<double> find(const State& state, double step, double reach);
  /// Moves the state past the pose that lies `ahead`: as far beyond it, at least `step` in all, not past t_stop. False,
  /// and the state is as it was, where that does not converge.
  bool pass(State& state, double ahead, double step, double t_stop);

 private:
  std::optional<double> search(const State& state, double step, double from, double to, double reach);
  double nearness(const State& state, double later);
  bool place(double time, VectorX& q, VectorX& v);

  EquationsOfMotion& equations_;
  Projector projector_;
  VectorX d_, q_, v_, rows_, probe_, watched_;
  std::vector<int> left_out_;  // as the search found them
};

}  // namespace lithe
