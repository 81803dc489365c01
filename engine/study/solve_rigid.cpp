#include <algorithm>
#include <cmath>

#include "engine/study/solve_internal.h"

namespace lithe::solving {
namespace {

constexpr int kRungs = 3;

/// The least of what steps leave must be little for estimates to rest on them.
bool is_sound(const Asked& asked, const Ladder& ladder) {
  if (ladder.runs.size() < 2) return false;
  const auto left = left_by_pace(asked, ladder);
  const auto change = sample_changes(asked.sensors, ladder.last().samples);
  for (std::size_t w = 0; w < asked.count(); ++w)
    if (!(left[w] <= kSound * std::max(change[w], round_off(asked, ladder.last().samples, w)))) return false;
  return true;
}

/// Steps as long as the samples are apart and half of that, or finer ones; a tolerance where these do not do.
void run_rigid(const Asked& asked, RigidMotion& rigid) {
  const auto models = asked.bodies.rigid();
  if (asked.methods.by_step) {
    Ladder ladder;
    Pace pace{asked.interval(), 0};
    for (int rung = 0; rung < kRungs && !is_sound(asked, ladder); ++rung, pace = finer(pace)) {
      if (ladder.runs.size() == 2) ladder.runs.erase(ladder.runs.begin()), ladder.paces.erase(ladder.paces.begin());
      add_run(asked, models, pace, 1, true, ladder, rigid.why);
    }
    if (is_sound(asked, ladder)) {
      rigid.ladder = std::move(ladder);
      rigid.pace = rigid.ladder.paces.front();
      return;
    }
  }
  rigid.pace = {0, kFirstTolerance};
  add_run(asked, models, rigid.pace, 1, true, rigid.ladder, rigid.why);
}

/// The run as deformation would have it: what it shows at once, and what it does to the motion at large.
Table predict(const Asked& asked, RigidMotion& rigid) {
  const ModelRun& run = rigid.run();
  rigid.deformed =
      model_error(asked.graph, asked.bodies, run, asked.bodies.all(), Missing::modes, asked.sensors, asked.stride);
  Table predicted = rigid.deformed.samples;
  const ModelRun moved = run_at(asked, asked.bodies.rigid(), rigid.pace, 1, false, rigid.deformed.feedback);
  if (!moved.reached()) return predicted;
  const std::size_t width = predicted.columns.size();
  for (int row = 0; row < predicted.row_count(); ++row)
    for (std::size_t c = 1; c < width; ++c) {
      const int at = row * asked.stride, column = static_cast<int>(c);
      predicted.values[static_cast<std::size_t>(row) * width + c] +=
          moved.samples.at(at, column) - run.samples.at(at, column);
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
