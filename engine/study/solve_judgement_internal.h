#pragma once

#include <map>

#include "engine/study/solve_internal.h"

namespace lithe::solving {

/// What a model leaves out: by a richer one beside it, both at one pace, so that what the pace leaves falls out of the
/// difference; and by the estimate of the modes that neither has.
class ModelJudge {
 public:
  ModelJudge(const Asked& asked, const RigidMotion& rigid, const Choice& choice);

  Judgement& judgement() { return judgement_; }
  const ModelRun& rich() const { return rich_; }
  const Pace& pace() const { return pace_; }

  /// Compares with this one from now on.
  void compare_with(ModelRun rich, const Pace& pace);
  /// The change of what is wanted, and so what is allowed. What was measured in a motion that longer steps made too
  /// large is less by as much.
  void measure_scale(const ModelRun& run);
  /// What the modes left out do along the motion of the run, by their equations of this order; and how far the first
  /// order carries here: the change by deformation as it came, over that predicted.
  void find_rest(const ModelRun& run, Deflection order);
  /// What the orders do, by runs of the same modes.
  void note_order(const ModelRun& run);
  /// The run is of other modes than those before.
  void forget_orders() { by_order_.clear(); }

  /// Modes that are left out sum to less than the share of what is allowed.
  std::vector<Fidelity> modes_within(double share) const;
  /// What the models of the ladder leave out of each quantity.
  std::vector<double> model_errors(const Ladder& ladder);
  /// Modes that the richer model has make the better part of the difference measured last.
  bool by_modes(const std::vector<Fidelity>& models) const;
  /// What the orders of deflection do, in parts of what is allowed.
  double by_second_order() const;
  /// By how much two runs are apart, in parts of what is allowed.
  double apart(const Table& samples, const Table& others) const;
  /// The errors of the last run of the ladder.
  void judge(const Ladder& ladder);

 private:
  /// What a motion of these changes is to be taken by where the answer changes less, a number a quantity.
  std::vector<double> scaled(std::vector<double> change) const;
  void find_by_inertia(const ModelRun& run);
  void measure_off(const Ladder& ladder);
  double left_out(const std::vector<Fidelity>& models, std::size_t w) const;
  double beyond(std::size_t w) const;
  double unseen(const std::vector<Fidelity>& models, std::size_t w) const;
  double beyond_candidates(std::size_t w) const;

  const Asked& asked_;
  const RigidMotion& rigid_;
  const bool untold_;
  Judgement judgement_;
  ModelRun rich_;
  Pace pace_;                             // of the richer run
  std::vector<double> carried_;           // what the motion at large makes of a deformation, at least 1
  std::vector<double> deformed_;          // change by deformation, as a run has it
  std::vector<double> by_inertia_;        // part of modes beyond the candidates in it, along the run looked at last
  std::map<Deflection, Table> by_order_;  // of the same modes at one pace
  bool known_fourth_ = false;
  std::vector<double> off_;  // beside the richer model
};

}  // namespace lithe::solving
