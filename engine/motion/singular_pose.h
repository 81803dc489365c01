#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/model/state.h"
#include "engine/motion/gauss_rule.h"
#include "engine/motion/projection.h"

namespace lithe {

class Archive;

/// Takes a motion through poses where closed loops lose rank and branches of the motion meet (a parallelogram that
/// lies flat), on the branch on which its velocity is smooth.
///
/// Near such a pose, δ seconds away, an error ε in γ becomes ε/δ in v̇ and multipliers grow like 1/δ, while the motion
/// itself is smooth: methods shorten their steps towards it without end, and what short steps reach is noise. One step
/// of Gauss collocation across, begun where steps were still long, no node of which lies at the pose and each of which
/// is moved onto the constraints, sees none of that. Two rules of different order must agree on where it ends.
class SingularPose {
 public:
  explicit SingularPose(EquationsOfMotion& equations);

  /// Of each step, before it: where a way across may begin.
  void remember(const State& state);

  /// From a state before steps became short, over poses that lie between it and some steps behind `now`. False: there
  /// is no such pose, or no way across (is_blocked). Makes factors, and leaves others' last one behind.
  bool cross(const State& now, double step);
  /// From rest in such a pose, where several motions begin: along the one that is nearest to what the forces would
  /// begin if the pose allowed it, in the metric of the mass (Gauss's principle of least constraint, over the motions
  /// that the constraints allow). Sets v_dot to its acceleration. False: it does not rest in such a pose, or no force
  /// acts.
  bool leave(State& state);
  /// Whether the last cross() knew of a pose, but not how to go on behind it.
  bool is_blocked() const { return blocked_; }
  /// Of the pose last found.
  double pose() const { return pose_; }
  /// What the log is to say of a way that has begun, once.
  std::string take_message() { return std::exchange(message_, {}); }

  /// Whether a crossing is under way at that time.
  bool covers(double time) const { return rule_ >= 0 && time >= begin_ && time < end_; }
  /// The next stop on the way across, at most that far.
  double next_stop(double time, double at_most) const;
  void follow(State& state, double time);

  void history(Archive& archive);

 private:
  double time_to_turn(const State& state, double angle) const;
  int begin_of_way(double now) const;
  bool cross_from(const State& from, double now, double step);
  double nearness(ConstVectorRef q, double time);
  std::optional<double> locate(const State& from, double window, double earliest, double latest);
  double clearance(double length, double pose) const;
  bool agree(const State& from, double length, double pose, double& off);
  bool collocate(const State& from, double length, const GaussRule& rule, MatrixX& d_rates, MatrixX& rates);
  void take(const State& from, double length, int rule, const MatrixX& d_rates, const MatrixX& rates);
  bool place(double time, VectorX& q, VectorX& v);
  bool find_branch(const State& state, VectorX& v_dot);

  EquationsOfMotion& equations_;
  Projector projector_;
  VectorX d_, q_, v_, rate_, lambda_, rows_, probe_;
  std::vector<int> left_out_;  // as the search found them
  static constexpr int kSamples = 48;
  std::array<double, kSamples + 1> near_{};  // nearness over the window
  double window_ = 0;                        // s
  // The way across.
  int rule_ = -1;  // none
  double begin_ = 0, end_ = 0;
  VectorX q_begin_, v_begin_;
  MatrixX d_rates_, rates_;  // at the nodes
  double pose_ = 0;          // s
  bool blocked_ = false;
  std::string message_;
  // States some way apart, in turn: the one before the last step, and where a way across began (-1: nowhere).
  static constexpr int kKept = 6;
  std::array<State, kKept> kept_;
  int last_ = 0, anchor_ = -1;
  double keep_until_ = 0;  // s: the anchor
};

}  // namespace lithe
