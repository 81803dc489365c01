#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/study/model_error.h"
#include "engine/study/solve.h"

namespace lithe {

/// One call of solve(): its runs, what they told, and the sheet.
class Solver {
 public:
  Solver(SystemGraph& graph, double duration, const std::vector<Want>& wants, const SolveMethods& methods,
         const SolveOptions& options);
  Solution solve();

 private:
  static bool is_rigid(const std::vector<Fidelity>& models) {
    return std::all_of(models.begin(), models.end(), [](const Fidelity& m) { return m.modes.empty(); });
  }
  RunRequest request(double tolerance, bool dynamics) const;

  RunRequest rigid_request(bool dynamics) const {
    return {duration_, samples(), {kFirstTolerance, 1e-2 * kFirstTolerance}, simplify_, dynamics};
  }

  std::size_t count() const { return wants_.size(); }

  /// That errors are looked for at: those of the answer, or more.
  int samples() const { return finer_ * options_.samples; }

  double deformation(std::size_t w) const { return deformation_.empty() ? 0 : deformation_[w]; }

  // ---- 1. rigid bodies, and what deformation would do (solve.cpp) ----
  void look_at_contacts();
  void simplify();
  void look_at_rigid();
  void set_bounds();
  double round_off(std::size_t w) const;
  void find_tolerance();

  bool is_rough() const {
    return !rigid_.reached() || std::find(rigid_.rough.begin(), rigid_.rough.end(), true) != rigid_.rough.end();
  }
  double time_worth(std::size_t w) const;

  // ---- 2. which modes, which order ----
  double severity(const ModelError::Coordinate& c) const;
  std::vector<Fidelity> first_choice();
  bool close_to_all() const;
  std::vector<Fidelity> with_modes(double share) const;
  void add_second_order(std::vector<Fidelity>& models);
  bool counts(const std::vector<double>& effect) const;
  Deflection finest() const;
  std::vector<Fidelity> deflected(std::vector<Fidelity> models, Deflection deflection) const;
  static Deflection order_of(const std::vector<Fidelity>& models);
  std::vector<Fidelity> fallback();

  // ---- 3. the answer (solve_answer.cpp) ----
  void accept_rigid();
  void refine(std::vector<Fidelity> models);
  bool try_steps(const std::vector<Fidelity>& models);
  bool complete(std::vector<Fidelity>& models) const;
  void judge();
  void judge_rough();
  double largest_part() const;
  bool improve(std::vector<Fidelity>& models, double& share);
  static bool add_modes(std::vector<Fidelity>& models, const std::vector<Fidelity>& more);
  bool raise_order(std::vector<Fidelity>& models) const;
  ModelRun run(const std::vector<Fidelity>& models, double tolerance, bool dynamics);

  void note_trial(const ModelRun& r, double error) {
    trials_.push_back({model_text(bodies_, r.models), r.tolerance.relative, true, error, r.cost});
  }

  // ---- the sheet (solve_sheet.cpp) ----
  Solution finish();
  ChosenBody describe(std::size_t b) const;
  void remark();

  SystemGraph& graph_;
  double duration_;
  const std::vector<Want>& wants_;
  const SolveMethods& methods_;
  const SolveOptions& options_;
  BodyModels bodies_;
  std::vector<Sensor> sensors_;
  double begun_ = 0, tolerance_ = kFirstTolerance;
  int finer_ = 1;    // of the samples to those asked for
  int stride_ = 1;   // of the samples that estimates look at
  double step_ = 0;  // s, of the answer; 0: steps by tolerance
  std::vector<double> step_error_;
  double elastic_scale_ = 1;  // largest modal coordinate

  ModelRun rigid_, tighter_, predicted_, answer_;
  std::optional<ModelRun> corrected_;  // the rigid run under the feedback of deformation
  ModelError linear_, first_;          // from the rigid run to all candidates, and to those first chosen
  std::vector<ModelError::Coordinate> effects_;
  // A number a wanted quantity: largest change, allowed error, change by deformation, by its second and fourth order,
  // what the motion at large makes of a deformation, error over tolerance.
  std::vector<double> change_, bounds_, deformation_, second_order_, fourth_order_, amplification_, time_worth_;
  int chosen_ = -1;  // of the trials
  bool simplify_ = false;
  std::vector<std::string> simplification_;
  std::vector<StatedError> errors_;
  std::vector<CertificateTrial> trials_;
  std::vector<std::string> remarks_;

  // ---- factors ----

  // Shares of what is allowed, in the choice: what is stated in the end is estimated along the answer itself.
  static constexpr double kModesShare = 0.25;  // of all modes that are left out, together
  static constexpr double kSecondOrder = 0.6;  // of the second order, if it is left out
  static constexpr double kTimeShare = 0.1;
  static constexpr double kRigidShare = 0.95;  // of all deformation, for rigid bodies to do

  // Estimates are of the first order: what is stated is so much more.
  static constexpr double kCaution = 2.5;
  static constexpr double kPredicted = 2;  // of the change by all deformation, feedback included
  static constexpr double kFirstTolerance = 1e-3, kLoosest = 1e-2, kTightest = 1e-9;
  // Error of elastic motion over tolerance times motion, of explicit methods and of implicit ones.
  static constexpr double kExplicitTime = 0.5, kImplicitTime = 1.5;
  static constexpr double kRoundOff = 1e-3;  // of what round_off() takes for a change
  static constexpr double kNoShare = 1e-9;   // modes below this part of what is allowed are idle
  static constexpr int kMostChoices = 6, kLooks = 25, kFewestSamples = 100;
  // Error of the finer of two runs of a method of second order over their difference, a third, with caution; and what
  // may be of it.
  static constexpr double kStepsLeft = 0.6, kStepsShare = 0.4;
  static constexpr double kCoarse = 3e-3;  // of a change: what is wanted better is not tried so
  // Error of reactions and accelerations over their change by a tolerance ten times looser.
  static constexpr double kRoughTime = 0.3;
  static constexpr double kCandidates = 5e-4;  // of what deformation does, beyond the candidate modes
  // Of the second order, by make_basis() (Reduction::deflection_tolerance).
  static constexpr double kFieldsLeftOut = 0.004;
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
};

}  // namespace lithe
