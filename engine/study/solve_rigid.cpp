#include <algorithm>
#include <cmath>

#include "engine/model/islands.h"
#include "engine/study/solve_internal.h"

namespace lithe::solving {
namespace {

constexpr int kRungs = 3;

/// What steps leave in the last, in parts of what changes.
double left_in(const Asked& asked, const Ladder& ladder) {
  if (ladder.runs.size() < 2) return kInfinity;
  const auto left = left_by_pace(asked, ladder);
  const auto change = sample_changes(asked.sensors, ladder.last().samples);
  double most = 0;
  for (std::size_t w = 0; w < asked.count(); ++w)
    most = std::max(most, left[w] / std::max(change[w], round_off(asked, ladder.last().samples, w)));
  return most;
}

/// Steps as long as the samples are apart and half of that, or finer ones; a tolerance where these do not do. Where no
/// load, drive or touch can fall between long steps, the first are judged by steps twice as long. Estimates rest on the
/// first that is sound.
void run_rigid(const Asked& asked, RigidMotion& rigid) {
  const auto models = asked.bodies.rigid();
  Ladder& ladder = rigid.ladder;
  double left = kInfinity;
  const int first = asked.contacts || depends_on_time(asked.graph) ? 0 : -1;
  for (int rung = first; asked.methods.by_step && rung < kRungs && left > kSound; ++rung) {
    add_run(asked, models, {std::ldexp(asked.interval(), -rung), 0}, 1, rung >= 0, ladder, rigid.why);
    left = left_in(asked, ladder);
  }
  if (left > kSound) {
    ladder = {};
    add_run(asked, models, {0, kFirstTolerance}, 1, true, ladder, rigid.why);
  }
  // The last two; across a touch the difference from steps that are not sound says nothing.
  const bool alone = asked.contacts && 4 * left > kSound;
  const auto unused = static_cast<std::ptrdiff_t>(ladder.runs.size()) - (alone ? 1 : 2);
  if (unused > 0) {
    ladder.runs.erase(ladder.runs.begin(), ladder.runs.begin() + unused);
    ladder.paces.erase(ladder.paces.begin(), ladder.paces.begin() + unused);
  }
  if (ladder.runs.empty()) return;
  const bool coarse_does = ladder.runs.size() == 2 && 4 * left <= kSound;
  rigid.coarsest = coarse_does ? 0 : ladder.runs.size() - 1;
  rigid.used = coarse_does && !ladder.runs.front().states.empty() ? 0 : ladder.runs.size() - 1;
  rigid.pace = ladder.paces[rigid.used];
}

/// The run as deformation would have it: what it shows at once, and what it does to the motion at large.
Table predict(const Asked& asked, RigidMotion& rigid) {
  const ModelRun& run = rigid.run();
  const int stride = std::min(asked.stride, kFeedbackStride);
  rigid.deformed = estimate(asked, run, asked.bodies.all(), stride, Detail::whole);
  Table predicted = rigid.deformed.samples;
  const auto bounds = allowed(asked, sample_changes(asked.sensors, run.samples), run.samples);
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (rigid.deformed.effect[w] > bounds[w]) return predicted;  // bodies must deform: their own runs tell the rest
  const ModelRun& still = rigid.ladder.runs[rigid.coarsest];
  const ModelRun moved =
      run_at(asked, asked.bodies.rigid(), rigid.ladder.paces[rigid.coarsest], 1, false, rigid.deformed.feedback);
  if (!moved.reached()) return predicted;
  const std::size_t width = predicted.columns.size();
  for (int row = 0; row < predicted.row_count(); ++row)
    for (std::size_t c = 1; c < width; ++c) {
      const int at = row * stride, column = static_cast<int>(c);
      predicted.values[static_cast<std::size_t>(row) * width + c] +=
          moved.samples.at(at, column) - still.samples.at(at, column);
    }
  return predicted;
}

}  // namespace

RigidMotion look_at_rigid(const Asked& asked) {
  RigidMotion rigid;
  rigid.amplification.assign(asked.count(), 1);
  run_rigid(asked, rigid);
  if (!rigid.reached()) return rigid;
  const Table& samples = rigid.run().samples;
  const Table predicted = asked.bodies.count() > 0 ? predict(asked, rigid) : samples;
  rigid.change = sample_changes(asked.sensors, predicted);
  double amplitude = 0;
  for (const auto& c : rigid.deformed.coordinates) amplitude = std::max(amplitude, c.amplitude);
  if (amplitude > 0) rigid.elastic_scale = amplitude;
  rigid.deformation = sample_differences(asked.sensors, predicted, samples);
  rigid.bounds = allowed(asked, rigid.change, samples);
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (asked.bodies.count() > 0 && rigid.deformed.effect[w] > 0)
      rigid.amplification[w] = std::max(1.0, rigid.deformation[w] / rigid.deformed.effect[w]);
  return rigid;
}

}  // namespace lithe::solving
