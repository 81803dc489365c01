#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace lithe::differential {

struct CampaignOptions {
  std::uint32_t first = 1;
  int scenes = 100;
  int jobs = 1;
  double seconds_each = 60;  // CPU time of all runs of a scene
  bool shrink = true;
};

/// What became of one scene: a verdict's name, "crash" or "hang", and what there is to say.
struct SceneReport {
  std::string outcome, text;
  bool finding() const { return outcome != "agree" && outcome != "refused"; }
};

/// Judges a scene in a process of its own, so that a crash or a hang ends that alone.
SceneReport judge_apart(std::uint32_t seed, const std::vector<int>& left_out, double seconds);

/// Leaves out elements as long as the finding stays the same; what was left out.
std::vector<int> shrink(std::uint32_t seed, const SceneReport& finding, double seconds);

/// Judges scenes, prints findings as they come and a table at the end; how many findings.
int run_campaign(const CampaignOptions& options);

}  // namespace lithe::differential
