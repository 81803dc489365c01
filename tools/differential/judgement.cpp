#include "tools/differential/judgement.h"

#include <algorithm>
#include <cmath>

namespace lithe::differential {
namespace {

constexpr double kTolerance = 1e-8, kNudge = 1e-6;

std::string type_of(const std::string& refusal) { return refusal.substr(0, refusal.find(':')); }

std::string scientific(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

/// In allowances; the kind that is worst.
std::pair<double, int> worst_of(const Difference& apart, const Difference& disturbed, double tolerance) {
  double worst = 0;
  int kind = 0;
  for (int k = 0; k < static_cast<int>(Kind::count); ++k) {
    const double allowance = tolerance * std::max(1.0, disturbed.of[k] / kNudge);
    if (apart.of[k] / allowance > worst) worst = apart.of[k] / allowance, kind = k;
  }
  return {worst, kind};
}

Method other_method(const DrawnScene& scene) {
  if (scene.impacts) return Method::nonsmooth_alpha;
  if (scene.stiff) return Method::radau;  // undamped modes hold BDF's steps, stability those of Runge-Kutta
  constexpr Method kMethods[] = {Method::runge_kutta8, Method::radau, Method::bdf};
  return kMethods[scene.seed % 3];
}

}  // namespace

Judgement judge(const DrawnScene& scene, const std::function<void(const std::string&)>& begins) {
  const Method method = scene.impacts ? Method::moreau_jean : Method::automatic;
  const auto run_way = [&](const Way& way) {
    begins(way.name + " at " + scientific(way.tolerance));
    return run(scene, way);
  };
  const Way plain{.name = "as drawn", .method = method, .tolerance = kTolerance};
  const Track base = run_way(plain);
  Way again = plain;
  again.name = "restarted", again.resume = true;
  const Track resumed = run_way(again);

  std::vector<Way> ways;
  for (const char* name : {"another method", "simplified", "another order"}) {
    ways.push_back(plain);
    ways.back().name = name;
  }
  ways[0].method = other_method(scene);
  if (!scene.impacts) ways[0].tolerance = 0.1 * kTolerance;  // theirs is of a step, Automatic's of the motion
  ways[1].simplify = true;
  ways[2].order = scene.seed + 1;
  std::vector<Track> tracks;
  for (const Way& way : ways) tracks.push_back(run_way(way));

  // Refused: by all or by none.
  const std::string refusal = type_of(base.refused);
  for (std::size_t i = 0; i <= tracks.size(); ++i) {
    const Track& track = i < tracks.size() ? tracks[i] : resumed;
    if (type_of(track.refused) != refusal)
      return {Verdict::uneven, "as drawn: " + (refusal.empty() ? std::string("runs") : base.refused) + "\n" +
                                   (i < tracks.size() ? ways[i].name : again.name) + ": " +
                                   (track.refused.empty() ? std::string("runs") : track.refused)};
  }
  if (!refusal.empty()) return {Verdict::refused, base.refused};
  if (resumed.values != base.values) {
    const Difference apart = difference(scene.units, base, resumed);
    const auto [worst, kind] = worst_of(apart, {}, kTolerance);
    return {Verdict::restart, "after a restart " + apart.where[kind] + " differs by " + scientific(apart.of[kind])};
  }

  Way disturbed = plain;
  disturbed.name = "disturbed", disturbed.nudge = kNudge;
  const Track moved = run_way(disturbed);
  if (!moved.refused.empty()) return {Verdict::uneven, "disturbed: " + moved.refused};
  const Difference sensitivity = difference(scene.units, base, moved);

  Judgement out;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    // Two methods of time stepping differ by their order in the step, and so do one method's steps of a scene and of
    // its simple form, whose bodies are others.
    const bool rules = scene.impacts && i < 2;
    const Difference apart = difference(scene.units, base, tracks[i]);
    const auto [worst, kind] = worst_of(apart, sensitivity, rules ? 1e4 * kTolerance : kTolerance);
    if (worst <= out.worst) continue;
    out.worst = worst;
    out.text = ways[i].name + ": " + apart.where[kind] + " differs by " + scientific(apart.of[kind]) +
               ", sensitivity " + scientific(sensitivity.of[kind] / kNudge) + ", " + scientific(worst) + " allowances";
    if (worst <= kAllowed) continue;
    // Do both go to one answer, and which of them was far from it?
    Way tight = plain, other = ways[i];
    const double tighter = scene.impacts ? 1.0 / 8 : 1.0 / 30;
    tight.tolerance *= tighter, other.tolerance *= tighter;
    const Track tight_base = run_way(tight), tight_other = run_way(other);
    if (!tight_base.refused.empty() || !tight_other.refused.empty())
      return {Verdict::uneven, out.text + "\nat a tighter tolerance: " + tight_base.refused + tight_other.refused,
              worst};
    const double left = difference(scene.units, tight_base, tight_other).of[kind];
    out.text += "; at " + scientific(tight.tolerance) + " by " + scientific(left) + "; from there as drawn was " +
                scientific(difference(scene.units, tight_base, base).of[kind]) + " away, " + ways[i].name + " " +
                scientific(difference(scene.units, tight_base, tracks[i]).of[kind]);
    const Verdict verdict = left < 0.3 * apart.of[kind] ? Verdict::loose : Verdict::disagree;
    if (out.verdict != Verdict::disagree) out.verdict = verdict;
    if (verdict == Verdict::disagree) return out;
  }
  return out;
}

}  // namespace lithe::differential
