#pragma once

#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/page/page.h"
#include "engine/study/study.h"

namespace lithe {

/// What can be wrong with a run.
enum class Cause {
  bad_parameter,       // the scene cannot be drawn
  open_joint,          // joints do not close as drawn
  inconsistent_start,  // velocities, or a given state, contradict the joints
  redundant_rows,      // rows of joints repeat others
  singular_position,   // joints lose rank on the way
  incompatible_drive,  // a drive asks for what joints or other drives do not allow
  locked,              // no freedom is left
  free_body,           // a body tied to nothing
  bad_unit,            // mass, inertia, length, gravity or stiffness in other units
  mass_ratio,          // a body next to without mass
  no_number,           // a force or a joint gives NaN
  stiff,               // a high frequency limits the steps of an explicit method
  discontinuity,       // a force law jumps
  step_too_large,      // or the tolerance too loose
  below_round_off,     // the tolerance is finer than the arithmetic
  unstable_method,     // energy grows at any step
  chaos,               // small errors grow by themselves
  negative_damping,    // a force feeds the motion that it should damp
  drawn_twice,         // two elements do the same
  overlap,             // surfaces are in each other as drawn
  too_few_modes,       // a deformable body lacks the modes that its loads bend
  lost_turns,          // an angle turned by more than half a turn a step, and its turns are read
  unknown
};
std::string to_string(Cause cause);

/// One cause that speaks for itself.
struct Finding {
  Cause cause = Cause::unknown;
  bool alarm = true;     // false: worth knowing, the run bears it
  double certainty = 0;  // 0 … 1, by which alarms are ranked
  std::string what;      // "the spring 'bump' between 'wheel' and ground rings at 3.2e+05 rad/s: …"
  std::string fix;       // what to change
};

/// A run that was tried again with another setting or method.
struct Cure {
  Cause cause = Cause::unknown;
  std::string tried;  // "a tenth of the step, 1e-3 s"
  bool helped = false;
  std::string result;  // how that run went
};

/// Why a run fails or degrades, most likely cause first.
struct Diagnosis {
  std::string outcome;            // how the run went, one sentence
  bool reached = false;           // it came to its end
  std::vector<Finding> findings;  // alarms first
  std::vector<Cure> cures;
  /// No alarm.
  bool sound() const { return findings.empty() || !findings.front().alarm; }
  /// All of it as text for people.
  std::string text() const;
};

struct DiagnoseOptions {
  double setting = 1e-6;  // tolerance or step (s) given to the method
  bool try_cures = false;
  std::vector<StudyMethod> others{};  // for cures: methods of another kind, each run at 1e-6 or at a tenth of the step
  long max_steps = 20000;             // of a run
  double time_limit = 5;              // s of CPU a run
};

/// Draws the scene, looks it over, runs it by the method, and where that fails, takes long, or differs from a run with
/// a finer setting, looks for the cause. Throws nothing that the scene throws: that is the diagnosis.
Diagnosis diagnose(const StudyScene& scene, const StudyMethod& method, const DiagnoseOptions& options = {});

/// Findings as a page lists them: write_page(run, "crane.html", {.findings = page_findings(diagnosis)}).
std::vector<PageFinding> page_findings(const Diagnosis& diagnosis);

/// Looks over a system and a state to start from, without a run: ranks, units, start values, free bodies, elements
/// drawn twice, surfaces that overlap. The length is that of the scene, m.
std::vector<Finding> look_over(const System& system, const State& start, double characteristic_length = 1);

}  // namespace lithe
