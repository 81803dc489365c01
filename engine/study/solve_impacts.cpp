#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/study/solve_internal.h"

namespace lithe::solving {
namespace {

using Models = std::vector<Fidelity>;

/// The lower candidates of each body, one in so many.
Models lower(const Asked& asked, int part) {
  Models models = asked.bodies.all(finest(asked));
  for (Fidelity& m : models) m.modes.resize((m.modes.size() + static_cast<std::size_t>(part) - 1) / part);
  return models;
}

/// Runs with ever more modes, from rigid bodies to all candidates, and what all of them still leave out: no load is
/// known that would drive the modes left out, for impacts are impulses.
struct ModelSequence {
  std::vector<ModelRun> runs;             // of the same steps
  std::vector<double> modes, deflection;  // left out by the last
  std::vector<double> second;             // done by the orders of deflection

  const ModelRun& richest() const { return runs.back(); }
};

/// As errors fell from one to the next, so they fall on.
std::vector<double> falls_on(const Asked& asked, const Table& a, const Table& b, const Table& c) {
  std::vector<double> last = sample_differences(asked.sensors, b, c);
  const auto before = sample_differences(asked.sensors, a, b);
  for (std::size_t w = 0; w < asked.count(); ++w)
    last[w] *= kBeyond * (before[w] > 0 ? std::min(1.0, last[w] / before[w]) : 1);
  return last;
}

/// At the longest steps at which all of them reach the end.
ModelSequence run_sequence(const Asked& asked, Pace& pace) {
  std::string why;
  for (int round = 0; round < asked.options.most_runs; ++round, pace = finer(pace)) {
    Ladder ladder;
    const auto add = [&](const Models& models) { return add_run(asked, models, pace, 1, false, ladder, why); };
    if (!add(asked.bodies.rigid())) continue;
    if (asked.bodies.count() > 0 && !(add(lower(asked, 4)) && add(lower(asked, 2)) && add(lower(asked, 1)))) continue;
    ModelSequence sequence{std::move(ladder.runs), std::vector<double>(asked.count(), 0), {}, {}};
    sequence.deflection = sequence.second = sequence.modes;
    const auto& runs = sequence.runs;
    if (runs.size() == 1) return sequence;
    sequence.modes = falls_on(asked, runs[1].samples, runs[2].samples, runs[3].samples);
    if (finest(asked) == Deflection::linear) return sequence;
    if (!add(asked.bodies.all())) continue;
    const Table& linear = ladder.last().samples;
    sequence.second = sample_differences(asked.sensors, linear, runs[3].samples);
    sequence.deflection = falls_on(asked, runs[0].samples, linear, runs[3].samples);
    return sequence;
  }
  throw SimulationError("no model of the scene reached the end: " + why, "solve",
                        "run the scene by itself first: diagnose() tells why it fails");
}

}  // namespace

Answer answer_with_impacts(const Asked& asked, RigidMotion& rigid) {
  Pace pace{asked.interval(), 0};
  const ModelSequence sequence = run_sequence(asked, pace);
  const Table& richest = sequence.richest().samples;
  rigid.ladder = {{sequence.runs.front()}, {pace}};
  rigid.pace = pace;
  rigid.amplification.assign(asked.count(), 1);
  rigid.deformation = sample_differences(asked.sensors, sequence.runs.front().samples, richest);
  rigid.change = sample_changes(asked.sensors, richest);
  rigid.bounds = allowed(asked, rigid.change, richest);
  Answer answer{
      .run = {},
      .judgement = {rigid.change, rigid.bounds, {}, {{}, sequence.second, rigid.deformation}},
      .remarks = {"surfaces are rigid: steps are judged by halving them, models by richer ones; modes beyond the "
                  "candidates as errors fall from half of them to all"}};
  Judgement& j = answer.judgement;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const bool unknown =
      asked.bodies.count() > 0 && !asked.options.small_deflection && finest(asked) == Deflection::linear;
  for (const ModelRun& run : sequence.runs) {
    const auto off = sample_differences(asked.sensors, run.samples, richest);
    j.errors.assign(asked.count(), {});
    for (std::size_t w = 0; w < asked.count(); ++w) {
      j.errors[w].truncation = kMeasured * off[w] + sequence.modes[w];
      j.errors[w].deflection = unknown ? nan : sequence.deflection[w];
    }
    const bool last = &run == &sequence.runs.back();
    if (!last && !(j.largest_part() <= kModelShare)) continue;
    std::vector<double> left(asked.count());
    for (std::size_t w = 0; w < asked.count(); ++w)
      left[w] = kPaceShare * std::max(j.bounds[w] - j.errors[w].truncation - sequence.deflection[w],
                                      (1 - kModelShare) * j.bounds[w]);
    Ladder ladder{{run}, {pace}};
    refine_pace(asked, run.models, left, 1, false, ladder);
    const auto time = left_by_pace(asked, ladder);
    answer.run = ladder.last();
    for (std::size_t w = 0; w < asked.count(); ++w) {
      j.errors[w].time = time[w];
      j.errors[w].solver = answer.run.residual + kRoundOff * round_off(asked, answer.run.samples, w);
    }
    note(asked, answer);
    break;
  }
  return answer;
}

}  // namespace lithe::solving
