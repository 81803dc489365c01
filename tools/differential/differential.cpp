// Differential fuzzing of scenes: random graphs of bodies, joints, forces and contacts, each run by two methods,
// simplified, restarted half-way and with its elements in another order. Exit code 1 if there are findings.
//   differential --scenes 10000 --first 1 --jobs 2 --seconds-each 60
//   differential --scene 4711 [--without 3,7]     one of them alone, in this process, with what it is made of
// More: --shrink 0.
#include <cstdio>
#include <sstream>

#include "engine/base/log.h"
#include "tools/bench/measure.h"
#include "tools/differential/campaign.h"
#include "tools/differential/judgement.h"

namespace lithe::differential {
namespace {

void judge_alone(std::uint32_t seed, const std::string& left_out) {
  std::vector<int> numbers;
  std::istringstream words(left_out);
  for (std::string word; std::getline(words, word, ',');) numbers.push_back(std::stoi(word));
  const DrawnScene scene = without(draw_scene(seed), numbers);
  std::printf("%s", text_of(scene).c_str());
  const log::Quiet quiet;
  const Judgement judgement = judge(scene, [](const std::string& way) {
    std::printf("%s ...\n", way.c_str());
    std::fflush(stdout);
  });
  std::printf("%s\n%s\n", kVerdictNames[static_cast<int>(judgement.verdict)], judgement.text.c_str());
}

void program(bench::Arguments& arguments) {
  const std::string scene = arguments.text("scene", "");
  if (!scene.empty()) {
    const std::string left_out = arguments.text("without", "");
    arguments.finish();
    return judge_alone(static_cast<std::uint32_t>(std::stoul(scene)), left_out);
  }
  CampaignOptions options;
  options.first = static_cast<std::uint32_t>(arguments.integer("first", 1));
  options.scenes = arguments.integer("scenes", options.scenes);
  options.jobs = arguments.integer("jobs", options.jobs);
  options.seconds_each = arguments.number("seconds-each", options.seconds_each);
  options.shrink = arguments.integer("shrink", 1) != 0;
  arguments.finish();
  if (const int findings = run_campaign(options)) throw std::runtime_error(std::to_string(findings) + " findings");
}

}  // namespace
}  // namespace lithe::differential

int main(int count, char** words) { return lithe::bench::run_program(count, words, lithe::differential::program); }
