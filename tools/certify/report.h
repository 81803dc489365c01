#pragma once

#include <limits>
#include <string>
#include <vector>

#include "engine/study/certificate.h"

namespace lithe::certify {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The cheapest run by hand that is as good as what was asked; `cost` kUnknown if none was found.
struct HandTuned {
  std::string model;                                // "8 modes, stiffened; generalized-alpha, step 0.00125 s"
  double cost = kUnknown, by_tolerance = kUnknown;  // s of CPU: of all integrators; of those that need no step
};

/// One scene run to one precision: the unit of costs.
struct CertifiedRun {
  std::string scene;
  bool seen = true, is_long = false;  // of the scene
  double target = 0;                  // part of the largest change of each watched quantity
  std::string model, integrator;      // of the answer
  std::string failure;                // why there is no answer; empty if there is
  double tolerance = 0;
  double cost = kUnknown, answer_cost = kUnknown;  // s of CPU: of solve(), of its last run
  std::vector<CertificateCost> costs;              // what the first went into
  HandTuned tuned;
  double cost_ratio() const { return cost / tuned.cost; }
  double cost_ratio_by_tolerance() const { return cost / tuned.by_tolerance; }
};

/// One watched quantity of a run. Errors are parts of its largest change in the reference.
struct CertifiedCase {
  CertifiedRun run;
  std::string quantity;
  double stated = kUnknown, error = kUnknown;  // what solve() says and what is so; unknown without an answer
  StatedError parts;                           // of what is stated
  double reference_error = 0;                  // of the reference itself; 0: it came with its data
  bool met = false;                            // what was asked, as solve() says

  /// The true error is no larger than the stated one and `allowed`; not, if nothing finite is stated.
  bool covered(double allowed) const;
  bool covered() const { return covered(reference_error); }
  double overestimate() const { return stated / (error > reference_error ? error : reference_error); }
};

/// From here on a run by hand is not short, s: the assembly of models no longer counts.
constexpr double kShort = 0.02;

/// What the cases come to. Overestimates are of all cases with an answer, costs of all runs with a tuned one. True
/// errors below the reference's own count as that: they are not known.
struct CertifySummary {
  int scenes = 0, runs = 0, cases = 0;
  double coverage = 0, coverage_without_reference_error = 0;  // parts of all cases
  double median_overestimate = 0, median_cost_ratio = 0, median_cost_ratio_by_tolerance = 0;
  double worst_overestimate = 0;
  double coverage_at[3] = {kUnknown, kUnknown, kUnknown};                        // of 10, 1 and 0.1 %
  double median_cost_ratio_20ms = kUnknown, median_cost_ratio_short = kUnknown;  // by hand kShort or more; less
  double median_long_choosing = kUnknown;  // of long runs: cost without the run that answers, over that
  int not_met = 0;                         // cases of which solve() says that they are not as good as asked
  int within_target = 0;                   // cases whose true error is
  /// What is wanted of the half that factors are not set on: tools/certify.sh.
  bool keeps_promise() const;
};
CertifySummary summarize(const std::vector<CertifiedCase>& cases);
/// Those of one half of the scenes.
std::vector<CertifiedCase> of_half(const std::vector<CertifiedCase>& cases, bool seen);

/// The summary and all cases; what is not known is null.
void write_json(const std::vector<CertifiedCase>& cases, const std::string& path);
/// certify: stated over true error; certify_cost: cost of solve() over that of the best run by hand. svg and png.
void write_charts(const std::vector<CertifiedCase>& cases, const std::string& folder);
/// Markdown: the summary of each target, then a row a run, of its quantity with the largest true over stated error.
void write_table(const std::vector<CertifiedCase>& cases, const std::string& path);
/// The summary in words, and the cases that are not covered or not met.
std::string text(const std::vector<CertifiedCase>& cases);

}  // namespace lithe::certify
