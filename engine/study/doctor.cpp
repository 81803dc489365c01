#include "engine/study/doctor.h"

#include <algorithm>
#include <cmath>

#include "engine/base/number_text.h"
#include "engine/study/doctor_internal.h"

namespace lithe {
namespace doctor {

double finer_setting(const StudyMethod& method, double setting) {
  return method.setting == StudyMethod::Setting::step ? setting / 10 : std::max(setting / 100, 1e-12);
}

std::string setting_words(const StudyMethod& method, double setting) {
  return method.setting == StudyMethod::Setting::step ? "at h = " + number(setting) + " s"
                                                      : "at tolerance " + number(setting);
}

double Case::growth(const Watched& of) const {
  const double scale = std::max({finer.largest_kinetic, std::abs(run.first_energy) * 1e-3, 1e-9});
  return (of.largest_energy - of.first_energy) / scale;
}

double Case::difference(const Watched& a, const Watched& b) const {
  if (!a.reached || !b.reached) return 0;
  double worst = 0;
  for (std::size_t i = 0; i < a.watch_at_end.size(); ++i)
    worst = std::max(worst, std::abs(a.watch_at_end[i] - b.watch_at_end[i]) / scene.characteristic_length);
  return worst;
}

bool Case::degraded() const {
  return !run.reached || difference(run, finer) > 1e-2 || (conservative && growth(run) > 0.05) || zigzags();
}

namespace {

std::string outcome_words(const StudyMethod& method, double setting, const Watched& run) {
  const std::string who = run.integrator + " " + setting_words(method, setting);
  if (run.reached)
    return who + " reached " + time_text(run.last.time) + " in " + std::to_string(run.statistics.steps) + " steps";
  if (run.too_slow) return who + " crept: " + run.why;
  return who + " stopped at " + time_text(run.last.time) + ": " + run.why;
}

/// Alarms before notes, the surest first; one finding a cause.
void rank(std::vector<Finding>& findings) {
  std::stable_sort(findings.begin(), findings.end(), [](const Finding& a, const Finding& b) {
    return a.alarm != b.alarm ? a.alarm : a.certainty > b.certainty;
  });
  std::vector<Finding> once;
  for (Finding& f : findings)
    if (std::none_of(once.begin(), once.end(), [&](const Finding& o) { return o.cause == f.cause; }))
      once.push_back(std::move(f));
  findings = std::move(once);
}

/// Runs the scene otherwise, where a run can fix its cause.
void try_cures(const Drawn& drawn, const StudyScene& scene, const StudyMethod& method, const DiagnoseOptions& options,
               const Watched& first, Diagnosis& diagnosis) {
  const auto attempt = [&](Cause cause, const StudyMethod& by, double setting, const std::string& tried) {
    const Watched run = run_watched(*drawn.system, drawn.sensors, drawn.system->initial_state(), scene.duration,
                                    *by.make(setting), options);
    const double kinetic = std::max({run.largest_kinetic, std::abs(first.first_energy) * 1e-3, 1e-9});
    const bool calm =
        !is_conservative(*drawn.system, run.samples) || run.largest_energy - run.first_energy < 0.05 * kinetic;
    diagnosis.cures.push_back(
        {cause, tried, run.reached && calm, outcome_words(by, setting, run) + (calm ? "" : "; but its energy grows")});
    return diagnosis.cures.back().helped;
  };
  const auto another = [&](Cause cause) {
    for (const StudyMethod& other : options.others) {
      const double setting = other.setting == StudyMethod::Setting::tolerance ? 1e-6
                             : method.setting == StudyMethod::Setting::step   ? options.setting / 10
                                                                              : scene.duration / 1000;
      if (attempt(cause, other, setting, "another method, " + other.name)) return;
    }
  };
  for (const Finding& finding : diagnosis.findings) {
    if (!finding.alarm) continue;
    const double finer = finer_setting(method, options.setting);
    switch (finding.cause) {
      case Cause::step_too_large:
      case Cause::singular_position:
        attempt(finding.cause, method, finer, "the same method " + setting_words(method, finer));
        break;
      case Cause::below_round_off:
        attempt(finding.cause, method, 1e-10, "the same method " + setting_words(method, 1e-10));
        break;
      case Cause::stiff:
      case Cause::unstable_method:
        another(finding.cause);
        break;
      default:
        break;  // the scene itself is to be fixed
    }
    if (!diagnosis.cures.empty() && diagnosis.cures.back().helped) return;
  }
}

}  // namespace
}  // namespace doctor

using namespace doctor;

Diagnosis diagnose(const StudyScene& scene, const StudyMethod& method, const DiagnoseOptions& options) {
  Diagnosis diagnosis;
  std::vector<Finding>& findings = diagnosis.findings;
  const auto refused = [&](const std::string& why, Finding finding) {
    diagnosis.outcome = "the scene is refused: " + why;
    findings.push_back(std::move(finding));
    return diagnosis;
  };
  // 1. Draw and assemble it.
  std::unique_ptr<Drawn> drawn;
  try {
    drawn = std::make_unique<Drawn>(scene);
  } catch (const Error& error) {
    return refused(error.problem(),
                   {Cause::bad_parameter, true, 0.95, error.problem() + " (" + error.where() + ")", error.fix()});
  }
  try {
    drawn->assemble();
  } catch (const SceneError& error) {
    return refused(error.problem(), of_refused_scene(*drawn, error));
  }
  const System& system = *drawn->system;

  // 2. Look it over, run it, and once more with a finer setting.
  findings = look_over(system, system.initial_state(), scene.characteristic_length);
  const auto run_at = [&](double setting) {
    const auto integrator = method.make(setting);
    return run_watched(system, drawn->sensors, system.initial_state(), scene.duration, *integrator, options);
  };
  const Watched run = run_at(options.setting), finer = run_at(finer_setting(method, options.setting));
  diagnosis.reached = run.reached;
  diagnosis.outcome = outcome_words(method, options.setting, run);

  // 3. What went wrong.
  const Case c{*drawn, scene, method, options, run, finer, is_conservative(system, run.samples)};
  if (method.setting == StudyMethod::Setting::tolerance && options.setting < 1e-14)
    findings.push_back({Cause::below_round_off, true, 0.98,
                        "a tolerance of " + number(options.setting) + " is below round-off, 2e-16 of each coordinate",
                        "give 1e-12 at the finest; 1e-6 to 1e-9 is usual"});
  for (Finding& finding : of_motion(c)) findings.push_back(std::move(finding));
  if (c.degraded()) {
    for (Finding& finding : of_run(c)) findings.push_back(std::move(finding));
    rank(findings);
    if (diagnosis.sound()) {
      std::string limiting;
      if (run.statistics.limiting >= 0)
        limiting = "; " + system.layout().velocity_name(run.statistics.limiting) + " limited the last step";
      findings.insert(findings.begin(), {Cause::unknown, true, 0.1, diagnosis.outcome + limiting,
                                         "try a smaller step, another tolerance and another method"});
    }
  } else if (run.rejected_often()) {
    for (Finding& finding : find_jumps(c)) {
      finding.alarm = false;  // the error control bears it
      findings.push_back(std::move(finding));
    }
  }
  rank(findings);
  if (options.try_cures) try_cures(*drawn, scene, method, options, run, diagnosis);
  return diagnosis;
}

std::string to_string(Cause cause) {
  static const char* const names[] = {"bad parameter",
                                      "open joint",
                                      "inconsistent start",
                                      "redundant rows",
                                      "singular position",
                                      "incompatible drive",
                                      "locked mechanism",
                                      "free body",
                                      "bad unit",
                                      "extreme mass ratio",
                                      "not finite",
                                      "stiff",
                                      "discontinuity",
                                      "step too large",
                                      "tolerance below round-off",
                                      "unstable method",
                                      "chaos",
                                      "negative damping",
                                      "drawn twice",
                                      "overlap",
                                      "too few modes",
                                      "lost turns",
                                      "unknown"};
  return names[static_cast<int>(cause)];
}

std::vector<PageFinding> page_findings(const Diagnosis& diagnosis) {
  std::vector<PageFinding> out;
  for (const Finding& f : diagnosis.findings) out.push_back({to_string(f.cause), f.what, f.fix, f.alarm});
  return out;
}

std::string Diagnosis::text() const {
  std::string text = outcome + "\n";
  if (findings.empty()) text += "nothing is wrong with it\n";
  for (const Finding& f : findings)
    text +=
        (f.alarm ? to_string(f.cause) : "note, " + to_string(f.cause)) + ": " + f.what + "\n  fix:  " + f.fix + "\n";
  for (const Cure& cure : cures)
    text += "tried " + cure.tried + ": " + (cure.helped ? "helped" : "did not help") + "; " + cure.result + "\n";
  return text;
}

}  // namespace lithe
