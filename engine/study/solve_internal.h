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

/// What is asked, and what the scene as drawn says of it before anything runs.
struct Asked {
  SystemGraph& graph;
  BodyModels& bodies;  // runs leave them at their fidelity
  double duration;     // s
  const std::vector<Want>& wants;
  const SolveMethods& methods;
  const SolveOptions& options;
  std::vector<Sensor> sensors{};  // of the wants
  int finer = 1;                  // of the samples that errors are looked for at, to those asked for
  int stride = 1;                 // of the samples that estimates look at
  bool simplify = false;          // the graph can be: runs do it
  std::vector<std::string> simplification{};
  std::vector<std::string> remarks{};

  std::size_t count() const { return wants.size(); }
  /// Bodies can be drawn with other numbers of elements, and exact.
  bool has_meshes() const;
  int samples() const { return finer * options.samples; }
};

/// What rigid bodies do, and what deformation would do to it. Vectors hold a number a wanted quantity; if the run
/// fails, all but the amplification are empty.
struct RigidMotion {
  ModelRun run;
  std::optional<ModelRun> tighter;    // at a tenth of the tolerance
  std::optional<ModelRun> corrected;  // under the feedback of deformation
  ModelError deformed;                // by all candidate modes
  std::vector<double> change;         // largest in the motion predicted with all modes
  std::vector<double> bounds;         // allowed errors
  std::vector<double> deformation;    // change by all modes, feedback included
  std::vector<double> amplification;  // what the motion at large makes of a deformation, at least 1
  std::vector<double> time_worth;     // error over tolerance
  double elastic_scale = 1;           // largest modal coordinate
  double tolerance = 0;               // for the answer

  double deformed_by(std::size_t w) const { return deformation.empty() ? 0 : deformation[w]; }
  /// Reactions or accelerations are wanted.
  bool is_rough() const;
};

/// What parts of the model do to the wanted quantities, as far as it is known.
struct Effects {
  std::vector<ModelError::Coordinate> modes;       // candidates, each by itself
  std::vector<double> second_order, fourth_order;  // of deflection; empty: not looked for
};

/// The models to begin with.
struct Choice {
  std::vector<Fidelity> models;
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
          const SolveMethods& methods, const SolveOptions& options);
RigidMotion look_at_rigid(const Asked& asked);
Choice choose(const Asked& asked, const RigidMotion& rigid);
Answer accept_rigid(const Asked& asked, const RigidMotion& rigid, const Choice& choice);
/// Chosen is -1 if no model with modes reaches the end.
Answer refine(const Asked& asked, const RigidMotion& rigid, const Choice& choice);
/// The error by the meshes of the answer; where modes do not do, exact bodies, with as many elements as it takes. An
/// answer without meshes comes back as it is. Throws SimulationError if still no model reaches the end.
Answer refine_meshes(const Asked& asked, const RigidMotion& rigid, Answer answer);
/// `begun`: thread_seconds() when solve() was called.
Solution certify(const Asked& asked, const RigidMotion& rigid, const Answer& answer, double begun);

// ---- what several of them use ----

/// Absolute tolerances follow from the largest modal coordinate.
RunRequest request(const Asked& asked, double tolerance, double elastic_scale, bool dynamics);
ModelRun run_logged(const Asked& asked, const std::vector<Fidelity>& models, const RunRequest& request);
/// Allowed errors of a motion with these changes.
std::vector<double> allowed(const Asked& asked, const std::vector<double>& change, const Table& samples);
/// Of a quantity, far above what it changes by when it does not change.
double round_off(const Asked& asked, const Table& samples, std::size_t w);
CertificateTrial trial(const Asked& asked, const ModelRun& run, double error);
/// The trial of a run that is judged, as the one chosen so far.
void note(const Asked& asked, Answer& answer);
/// With fixed steps, s.
ModelRun run_stepped(const Asked& asked, const std::vector<Fidelity>& models, double step, bool dynamics);

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

// Shares of what is allowed, in the choice: what is stated in the end is estimated along the answer itself.
inline constexpr double kModesShare = 0.25;  // of all modes that are left out, together
inline constexpr double kSecondOrder = 0.6;  // of the second order, if it is left out
inline constexpr double kTimeShare = 0.1;
inline constexpr double kRigidShare = 0.95;  // of all deformation, for rigid bodies to do

// Estimates are of the first order: what is stated is so much more.
inline constexpr double kCaution = 2.5;
inline constexpr double kPredicted = 2;  // of the change by all deformation, feedback included
inline constexpr double kFirstTolerance = 1e-3, kLoosest = 1e-2, kTightest = 1e-9;
// Error of elastic motion over tolerance times motion, of explicit methods and of implicit ones.
inline constexpr double kExplicitTime = 0.5, kImplicitTime = 1.5;
inline constexpr double kRoundOff = 1e-3;  // of what round_off() takes for a change
inline constexpr double kNoShare = 1e-9;   // modes below this part of what is allowed are idle
inline constexpr int kMostChoices = 6, kLooks = 25, kFewestSamples = 100;
// Error of the finer of two runs of a method of second order over their difference, a third, with caution; and what
// may be of it.
inline constexpr double kStepsLeft = 0.6, kStepsShare = 0.4;
inline constexpr double kCoarse = 3e-3;  // of a change: what is wanted better is not tried so
// Of two meshes, errors being of second order: caution, the least ratio of their elements, and what may be left.
inline constexpr double kMeshCaution = 1.8, kMeshRatio = 1.3, kMeshShare = 0.5;
inline constexpr int kFewestElements = 4, kMostElements = 2000;
// Error of reactions and accelerations over their change by a tolerance ten times looser.
inline constexpr double kRoughTime = 0.3;
inline constexpr double kCandidates = 5e-4;  // of what deformation does, beyond the candidate modes
// Of the second order, by make_basis() (Reduction::deflection_tolerance).
inline constexpr double kFieldsLeftOut = 0.004;
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace lithe::solving
