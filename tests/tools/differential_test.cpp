// A selection of tools/differential: its scenes are run by two methods, simplified, restarted and in another order.
#include <gtest/gtest.h>

#include "engine/base/log.h"
#include "tools/differential/judgement.h"

namespace lithe::test::differential_test {
namespace {

using namespace differential;

TEST(Differential, ScenesMoveAlikeByEveryWay) {
  const log::Quiet quiet;
  int ran = 0;
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    const Judgement judgement = judge(draw_scene(seed));
    EXPECT_TRUE(judgement.verdict == Verdict::agree || judgement.verdict == Verdict::refused)
        << kVerdictNames[static_cast<int>(judgement.verdict)] << ": " << judgement.text << "\n"
        << text_of(draw_scene(seed));
    ran += judgement.verdict == Verdict::agree;
  }
  EXPECT_GE(ran, 25);
}

}  // namespace
}  // namespace lithe::test::differential_test
