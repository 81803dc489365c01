#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/study/model_error.h"
#include "engine/study/solve.h"

/// The phases of solve(), which pass values: each takes what was asked and what those before it found.
///   Asked -> RigidMotion -> Choice -> Answer -> Solution
namespace lithe::solving {

/// How time goes by: fixed steps, or a tolerance.
struct Pace {
  double step = 0;       // s; 0: by tolerance
  double tolerance = 0;  // relative
};

/// What is asked, and what the scene as drawn says of it before anything runs.
struct Asked {
  SystemGraph& graph;
  BodyModels& bodies;  // runs leave them at their fidelity
  double duration;     // s
  const std::vector<Want>& wants;
  const SolveMethods& methods;
  const SolveOptions& options;
  std::vector<CertificateCost>& costs;  // of all runs and estimates, as they are made
  std::vector<Sensor> sensors{};        // of the wants
  int finer = 1;                        // of the samples that errors are looked for at, to those asked for
  int stride = 1;                       // of the samples that estimates look at
  bool simplify = false;                // the graph can be: runs do it where it pays, and steps end at every sample
  bool redundant = false;               // rows repeat others: reactions are more certain of the simpler graph
  bool contacts = false;                // surfaces meet and part: no order of accuracy holds across that
  bool impacts = false;                 // and velocities jump there
  std::vector<std::string> simplification{};
  std::vector<std::string> remarks{};

  std::size_t count() const { return wants.size(); }
  /// Bodies can be drawn with other numbers of elements, and exact.
  bool has_meshes() const;
  /// A run at this pace is of the simpler graph. Not in steps that are longer than samples are apart.
  bool simplifies(const Pace& pace) const;
  int samples() const { return finer * options.samples; }
  double interval() const { return duration / samples(); }  // s, of the samples
};

/// Runs of one model, each at a finer pace than the one before: their differences tell what is left in the last.
struct Ladder {
  std::vector<ModelRun> runs;
  std::vector<Pace> paces;

  const ModelRun& last() const { return runs.back(); }
  /// The first by steps, or by tolerance, as the last is.
  std::size_t begun() const;
};

/// What rigid bodies do, and what deformation would do to it. Vectors hold a number a wanted quantity; if no run
/// reaches the end, all but the amplification are empty.
struct RigidMotion {
  Ladder ladder;                      // two runs, or one by tolerance; empty: none reaches the end
  std::size_t used = 0;               // of these, with its dynamics: estimates rest on it
  std::size_t coarsest = 0;           // of these, that differences may rest on
  Pace pace;                          // of the run used, at which models begin
  std::string why;                    // none reaches the end
  ModelError deformed;                // by all candidate modes
  std::vector<double> change;         // largest in the motion predicted with all modes
  std::vector<double> bounds;         // allowed errors
  std::vector<double> deformation;    // change by all modes, feedback included
  std::vector<double> amplification;  // what the motion at large makes of a deformation, at least 1
  double elastic_scale = 1;           // largest modal coordinate

  bool reached() const { return !ladder.runs.empty(); }
  const ModelRun& run() const { return ladder.runs[used]; }
  double deformed_by(std::size_t w) const { return deformation.empty() ? 0 : deformation[w]; }
};

/// What parts of the model do to the wanted quantities, as far as it is known.
struct Effects {
  std::vector<ModelError::Coordinate> modes;       // candidates, each by itself
  std::vector<double> second_order, fourth_order;  // of deflection; empty: not looked for
};

/// The models to begin with.
struct Choice {
  std::vector<Fidelity> models;
  bool rigid = false;   // rigid bodies do
  bool untold = false;  // what is wanted does not move in the first order: effects are shares of strain energy
  Effects effects;
  std::vector<CertificateTrial> trials;
  std::vector<std::string> remarks;
};

/// The errors of a run, a number a wanted quantity.
struct Judgement {
  std::vector<double> change, bounds;
  std::vector<StatedError> errors;
  Effects effects;

  /// The largest error in parts of what is allowed.
  double largest_part() const;
  /// Its parts likewise, each where it is largest; those that are unknown count for none.
  StatedError largest_parts() const;
};

/// The run that answers, and how it was come by.
struct Answer {
  ModelRun run;
  Judgement judgement;
  std::vector<CertificateTrial> trials;
  int chosen = -1;  // of the trials
  std::vector<std::string> remarks;
  std::string why;  // the last run failed

  bool met() const { return chosen >= 0 && judgement.largest_part() <= 1; }
};

// ---- phases ----

/// Throws SceneError as solve() does.
Asked ask(SystemGraph& graph, BodyModels& bodies, double duration, const std::vector<Want>& wants,
          const SolveMethods& methods, const SolveOptions& options, std::vector<CertificateCost>& costs);
RigidMotion look_at_rigid(const Asked& asked);
Choice choose(const Asked& asked, const RigidMotion& rigid);
Answer accept_rigid(const Asked& asked, const RigidMotion& rigid, const Choice& choice);
/// Chosen is -1 if no model with modes reaches the end.
Answer refine(const Asked& asked, const RigidMotion& rigid, const Choice& choice);
/// Of scenes with rigid surfaces: models beside richer ones, and steps beside longer ones. Fills what rigid bodies do.
/// Throws SimulationError if no model reaches the end.
Answer answer_with_impacts(const Asked& asked, RigidMotion& rigid);
/// The error by the meshes of the answer; where modes do not do, exact bodies, with as many elements as it takes. An
/// answer without meshes comes back as it is. Throws SimulationError if still no model reaches the end.
Answer refine_meshes(const Asked& asked, const RigidMotion& rigid, Answer answer);
/// `begun`: thread_seconds() when solve() was called.
Solution certify(const Asked& asked, const RigidMotion& rigid, const Answer& answer, double begun);

// ---- what several of them use ----

/// The graph is left at the models. Absolute tolerances follow from `elastic_scale`, the largest modal coordinate.
ModelRun run_at(const Asked& asked, const std::vector<Fidelity>& models, const Pace& pace, double elastic_scale,
                bool dynamics, const std::vector<RecordedWrench::Parameters>& wrenches = {});
/// What these richer models would have made of a run (model_error.h).
ModelError estimate(const Asked& asked, const ModelRun& run, const std::vector<Fidelity>& richer, int stride,
                    Detail detail);
/// One more run of a ladder; false, and `why`, if it does not reach the end.
bool add_run(const Asked& asked, const std::vector<Fidelity>& models, const Pace& pace, double elastic_scale,
             bool dynamics, Ladder& ladder, std::string& why);
/// What its pace leaves over in the last run, by the differences of the runs; infinite of a single one.
std::vector<double> left_by_pace(const Asked& asked, const Ladder& ladder);
/// Finer paces until that is within `allowed`, a single run of fixed steps compared with a `coarser` one; from fixed
/// steps to tolerances where the steps would be many. The ladder ends with the finest that reaches the end.
void refine_pace(const Asked& asked, const std::vector<Fidelity>& models, const std::vector<double>& allowed,
                 double elastic_scale, bool coarser, Ladder& ladder);
/// Half the step, a tenth of the tolerance.
Pace finer(const Pace& pace);
/// Allowed errors of a motion with these changes.
std::vector<double> allowed(const Asked& asked, const std::vector<double>& change, const Table& samples);
/// Of a quantity, far above what it changes by when it does not change.
double round_off(const Asked& asked, const Table& samples, std::size_t w);
CertificateTrial trial(const Asked& asked, const ModelRun& run, double error);
/// The trial of a run that is judged, as the one chosen so far.
void note(const Asked& asked, Answer& answer);
bool is_rigid(const std::vector<Fidelity>& models);
/// The finest order of deflection that any body has data for.
Deflection finest(const Asked& asked);
Deflection order_of(const std::vector<Fidelity>& models);
std::vector<Fidelity> deflected(const Asked& asked, std::vector<Fidelity> models, Deflection deflection);
/// Candidate modes, but for those with the smallest effects, which stay out while they sum to less than the share.
std::vector<Fidelity> with_modes(const Asked& asked, const std::vector<ModelError::Coordinate>& modes,
                                 const std::vector<double>& amplification, const std::vector<double>& bounds,
                                 double share);

// ---- factors ----

// Shares of what is allowed, in the choice.
inline constexpr double kModesShare = 0.3;    // of all modes that are left out, together
inline constexpr double kRicherShare = 0.05;  // of those that the richer model beside it leaves out
inline constexpr double kModelShare = 0.6;    // of what a model is off by beside the richer one
inline constexpr double kRigidShare = 0.95;   // of all deformation, for rigid bodies to do
inline constexpr double kPaceShare = 0.9;     // of what the model leaves, for the pace

// What is measured beside a richer model is stated so much larger, and what is estimated, of the first order.
inline constexpr double kMeasured = 1.6, kCaution = 2.5;
inline constexpr double kBeyond = 1.5;     // of the order of deflection after the last
inline constexpr double kPredicted = 1.7;  // of the change by all deformation, feedback included
inline constexpr double kFirstTolerance = 1e-3, kLoosest = 1e-1, kTightest = 1e-9;
inline constexpr double kRoundOff = 1e-3;  // of what round_off() takes for a change
inline constexpr double kNoShare = 1e-9;   // modes below this part of what is allowed are idle
inline constexpr int kLooks = 50, kFeedbackStride = 2, kFewestSamples = 100;
inline constexpr double kSound = 0.08;  // of a change, that steps may leave in a rigid run that estimates rest on
// Of an error of second order found by halving the step; of one of tolerances, over the ratio of the two.
inline constexpr double kStepsCaution = 2, kToleranceCaution = 3;
// Of two meshes, errors being of second order: caution, the least ratio of their elements, and what may be left.
inline constexpr double kMeshCaution = 1.8, kMeshRatio = 1.3, kMeshShare = 0.5;
inline constexpr int kFewestElements = 4, kMostElements = 2000;
// Of what deformation does, beyond the candidate modes, at most. Where bodies touch, no candidate is made for the load,
// and what the highest do tells nothing of it.
inline constexpr double kCandidates = 5e-4, kCandidatesTouched = 1e-3;
// Of the second order, by make_basis() (Reduction::deflection_tolerance).
inline constexpr double kFieldsLeftOut = 0.002;
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace lithe::solving
