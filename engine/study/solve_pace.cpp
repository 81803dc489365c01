#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/log.h"
#include "engine/base/number_text.h"
#include "engine/study/solve_internal.h"
#include "engine/study/study_run.h"

namespace lithe::solving {
namespace {

constexpr double kMostImpactSteps = 60;  // a sample
constexpr double kMostSteps = 16;        // a sample, before a tolerance is tried instead
constexpr double kFewSteps = 5;          // a sample: of fewer, the way to the simpler graph and back costs more
constexpr double kResolved = 2.5;        // ω h of the highest mode, where explicit steps cost less
constexpr double kMostFiner = 12;        // than the last: what needs more is tried by a tolerance
constexpr double kLongestJump = 8;       // from one step to the next
constexpr double kMostCaution = 4;       // of errors of second order
constexpr double kStalled = 0.5;  // of the last but one: errors that finer steps leave so large do not fall with them

/// Below which a tolerance costs less: steps that resolve the highest mode need no implicit method.
double shortest_step(const Asked& asked, const std::vector<Fidelity>& models) {
  double highest = 0;
  for (std::size_t b = 0; b < models.size(); ++b) {
    const VectorX stiffness = asked.bodies.bodies()[b]->candidate_stiffness();
    for (int mode : models[b].modes) highest = std::max(highest, std::sqrt(stiffness[mode]));
  }
  const double shortest = asked.interval() / kMostSteps;
  return highest == 0 ? shortest : std::min(shortest, kResolved / highest);
}

void book(const Asked& asked, const std::string& what, long steps, double cost) {
  auto at = std::find_if(asked.costs.begin(), asked.costs.end(), [&](const auto& c) { return c.what == what; });
  if (at == asked.costs.end()) at = asked.costs.insert(at, {what});
  ++at->runs, at->steps += steps, at->cost += cost;
}

std::string kind(const std::vector<Fidelity>& models, const Pace& pace) {
  if (is_rigid(models)) return "rigid bodies";
  return std::string(order_of(models) == Deflection::exact ? "exact bodies, " : "modes, ") +
         (pace.step > 0 ? "fixed steps" : "by tolerance");
}

/// How much finer the last run is than the one before.
double ratio(const Pace& coarse, const Pace& fine) {
  return fine.step > 0 ? coarse.step / fine.step : coarse.tolerance / fine.tolerance;
}

/// The next of a ladder that is `part` times what is allowed, and was `before`; none below the tightest tolerance.
std::optional<Pace> next_pace(const Asked& asked, const std::vector<Fidelity>& models, const Pace& last, double part,
                              double before) {
  if (last.step > 0) {
    const double wanted = last.step / std::sqrt(part);
    if (asked.impacts)
      return last.step > asked.interval() / kMostImpactSteps ? std::optional(finer(last)) : std::nullopt;
    if (wanted < shortest_step(asked, models) || wanted < last.step / kMostFiner || part > kStalled * before)
      return Pace{0, kLoosest};
    return Pace{last.step / std::clamp(std::exp2(std::ceil(std::log2(last.step / wanted))), 2.0, kLongestJump), 0};
  }
  if (last.tolerance <= kTightest) return {};
  return Pace{0, std::max(kTightest, last.tolerance * std::clamp(kToleranceCaution / 10 / part, 1e-3, 0.1))};
}

}  // namespace

std::size_t Ladder::begun() const {
  std::size_t first = runs.size();
  while (first > 0 && (paces[first - 1].step > 0) == (paces.back().step > 0)) --first;
  return first;
}

bool Asked::simplifies(const Pace& pace) const {
  const bool pays = redundant || pace.step < interval() / kFewSteps;  // by tolerance: 0
  return simplify && pays && pace.step <= interval();
}

Pace finer(const Pace& pace) { return {pace.step / 2, pace.tolerance / 10}; }

ModelRun run_at(const Asked& asked, const std::vector<Fidelity>& models, const Pace& pace, double elastic_scale,
                bool dynamics, const std::vector<RecordedWrench::Parameters>& wrenches) {
  RunRequest request{asked.duration, asked.samples(), {0, 0}, asked.simplifies(pace), dynamics};
  request.meets_samples = pace.step > 0 && pace.step <= asked.interval();
  if (pace.step == 0) request.tolerance = {pace.tolerance, std::min(1e-2, elastic_scale) * pace.tolerance};
  const MakeIntegratorBy<Tolerance> by_step = [&](const Tolerance&) {
    return asked.impacts ? asked.methods.by_step_with_impacts(pace.step) : asked.methods.by_step(pace.step);
  };
  ModelRun run = run_model(asked.graph, asked.bodies, models, asked.sensors,
                           pace.step > 0 ? by_step : asked.methods.by_tolerance, request, wrenches);
  run.step = pace.step, run.tolerance = request.tolerance;
  book(asked, kind(models, pace), run.statistics.steps, run.cost);
  log::debug("solve: " + model_text(asked.bodies, models) +
             (pace.step > 0 ? ", step " + duration_text(pace.step) : ", tolerance " + short_number(pace.tolerance)) +
             ": " + duration_text(run.cost) + (run.reached() ? "" : ", " + run.why));
  return run;
}

ModelError estimate(const Asked& asked, const ModelRun& run, const std::vector<Fidelity>& richer, int stride,
                    Detail detail) {
  const double begun = thread_seconds();
  ModelError error = model_error(asked.graph, asked.bodies, run, richer, asked.sensors, stride, detail);
  book(asked, "estimates along a run", 0, thread_seconds() - begun);
  return error;
}

bool add_run(const Asked& asked, const std::vector<Fidelity>& models, const Pace& pace, double elastic_scale,
             bool dynamics, Ladder& ladder, std::string& why) {
  ModelRun run = run_at(asked, models, pace, elastic_scale, dynamics);
  why = run.why;
  if (!run.reached()) return false;
  ladder.runs.push_back(std::move(run));
  ladder.paces.push_back(pace);
  return true;
}

std::vector<double> left_by_pace(const Asked& asked, const Ladder& ladder) {
  const std::size_t n = ladder.runs.size(), first = ladder.begun();
  if (n < first + 2) return std::vector<double>(asked.count(), kInfinity);
  const auto apart = [&](std::size_t i) {
    return sample_differences(asked.sensors, ladder.runs[i - 1].samples, ladder.runs[i].samples);
  };
  std::vector<double> left = apart(n - 1);
  if (asked.contacts) return left;
  const double r = ratio(ladder.paces[n - 2], ladder.paces[n - 1]);
  if (ladder.paces.back().step == 0) {
    // A stiff method may hardly shorten its steps: errors fall with the steps taken, not with what was asked for. Runs
    // of the same steps tell nothing of each other's: then the tolerance stands for its error.
    const ModelRun& last = ladder.last();
    const double longer =
        static_cast<double>(last.statistics.steps) / static_cast<double>(ladder.runs[n - 2].statistics.steps);
    const double falls = longer > 1 ? 1 / (longer * longer - 1) : kInfinity;
    const auto change = sample_changes(asked.sensors, last.samples);
    for (std::size_t w = 0; w < asked.count(); ++w)
      left[w] = std::max(left[w] * std::clamp(falls, std::min(1.0, kToleranceCaution / r), kToleranceCaution),
                         longer == 1 ? last.tolerance.relative * change[w] : 0.0);
    return left;
  }
  std::vector<double> before(asked.count(), kInfinity);
  double r_before = 2;
  if (n > first + 2) before = apart(n - 2), r_before = ratio(ladder.paces[n - 3], ladder.paces[n - 2]);
  for (std::size_t w = 0; w < asked.count(); ++w) {
    // Of second order? Then the differences fall as they should; if not, the first is assumed.
    const double expected = before[w] * (1 - 1 / (r * r)) / (r_before * r_before - 1);
    const bool second_order = left[w] < kStepsCaution * expected;
    left[w] *= std::min(1.0, second_order ? std::min(r, kMostCaution) / (r * r - 1) : kStepsCaution / (r - 1));
  }
  return left;
}

void refine_pace(const Asked& asked, const std::vector<Fidelity>& models, const std::vector<double>& allowed,
                 double elastic_scale, bool coarser, Ladder& ladder) {
  std::string why;
  double part = kInfinity;
  while (!ladder.runs.empty()) {
    const std::vector<double> left = left_by_pace(asked, ladder);
    const double before = std::exchange(part, 0);
    for (std::size_t w = 0; w < asked.count(); ++w) part = std::max(part, left[w] / allowed[w]);
    if (part <= 1) return;
    const Pace& last = ladder.paces.back();
    const bool single = ladder.runs.size() - ladder.begun() < 2;
    if (single && last.step > 0 && coarser) {
      Ladder twice;
      if (add_run(asked, models, {2 * last.step, 0}, elastic_scale, false, twice, why)) {
        ladder.runs.insert(ladder.runs.end() - 1, std::move(twice.runs.back()));
        ladder.paces.insert(ladder.paces.end() - 1, twice.paces.back());
        continue;
      }
    }
    const std::optional<Pace> next = single ? finer(last) : next_pace(asked, models, last, part, before);
    if (!next) return;
    if (add_run(asked, models, *next, elastic_scale, false, ladder, why)) continue;
    // What is so loose may fail where a tighter one does not.
    if (next->tolerance < kLoosest || !add_run(asked, models, finer(*next), elastic_scale, false, ladder, why)) return;
  }
}

}  // namespace lithe::solving
