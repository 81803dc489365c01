// What a pace leaves over, by the differences of runs whose errors are known.
#include <gtest/gtest.h>

#include "engine/study/solve_judgement_internal.h"

namespace lithe::solving {
namespace {

/// A question about one number, and runs whose answers are made up.
struct KnownErrors {
  SystemGraph graph;
  BodyModels bodies{graph};
  std::vector<Want> wants{want({"x", {"x"}, [](Snapshot&, std::span<double>) {}}, percent(1))};
  SolveMethods methods;
  SolveOptions options;
  std::vector<CertificateCost> costs;
  Asked asked{graph, bodies, 1, wants, methods, options, costs, {wants[0].sensor}};

  /// Goes from 0 to 1, but for the error.
  static ModelRun run(long steps, double error, double tolerance = 0) {
    ModelRun run;
    run.samples = {{"t", "x"}, {0, 0, 1, 1 + error}};
    run.statistics.steps = steps;
    run.tolerance = {tolerance, 0};
    return run;
  }
};

TEST(SolvePace, two_tolerances_are_compared_by_the_steps_that_they_took) {
  KnownErrors known;
  const auto error = [](long steps) { return 10.0 / static_cast<double>(steps * steps); };  // second order
  for (long more : {118L, 125L, 150L}) {  // a tenth of the tolerance: hardly more steps
    const Ladder ladder{{known.run(100, error(100), 0.1), known.run(more, error(more), 0.01)}, {{0, 0.1}, {0, 0.01}}};
    EXPECT_NEAR(left_by_pace(known.asked, ladder)[0], error(more), 1e-12) << more;
  }
  // Where the steps double or more, the tolerances tell: three tenths of the difference.
  const Ladder many{{known.run(100, error(100), 0.1), known.run(400, error(400), 0.01)}, {{0, 0.1}, {0, 0.01}}};
  EXPECT_NEAR(left_by_pace(known.asked, many)[0], 0.3 * (error(100) - error(400)), 1e-12);
  // Where they are fewer, three times it; where they are the same, the tolerance of the finer.
  const Ladder fewer{{known.run(100, 1e-3, 0.1), known.run(90, 2e-3, 0.01)}, {{0, 0.1}, {0, 0.01}}};
  EXPECT_NEAR(left_by_pace(known.asked, fewer)[0], 3e-3, 1e-12);
  const Ladder same{{known.run(100, 1e-3, 0.1), known.run(100, 1e-3, 0.01)}, {{0, 0.1}, {0, 0.01}}};
  EXPECT_NEAR(left_by_pace(known.asked, same)[0], 0.01 * 1.001, 1e-12);
}

TEST(SolvePace, fixed_steps_of_second_order_leave_no_more_than_is_stated) {
  KnownErrors known;
  for (double finer : {2.0, 4.0, 8.0}) {
    const double fine = 0.1 / (finer * finer);
    const Ladder ladder{{known.run(10, 0.1), known.run(20, fine)}, {{0.1, 0}, {0.1 / finer, 0}}};
    EXPECT_NEAR(left_by_pace(known.asked, ladder)[0], std::min(finer, 4.0) * fine, 1e-12) << finer;  // with caution
  }
  // Differences that do not fall as of second order: the first is assumed, or all of the last difference.
  const Ladder slow{{known.run(10, 0.3), known.run(20, 0.2), known.run(40, 0.1)}, {{0.1, 0}, {0.05, 0}, {0.025, 0}}};
  EXPECT_NEAR(left_by_pace(known.asked, slow)[0], 0.1, 1e-12);
}

TEST(SolvePace, what_was_measured_in_a_motion_that_was_too_large_counts_in_proportion) {
  KnownErrors known;
  RigidMotion rigid;
  rigid.amplification = {1};
  rigid.change = {10}, rigid.bounds = {0.1};
  Choice choice;
  choice.effects.second_order = {4}, choice.effects.fourth_order = {0.4};
  ModelJudge judge(known.asked, rigid, choice);
  judge.measure_scale(known.run(10, 0));  // it changes by 1, not by 10
  EXPECT_NEAR(judge.judgement().effects.second_order[0], 0.4, 1e-12);
  EXPECT_NEAR(judge.judgement().effects.fourth_order[0], 0.04, 1e-12);
  EXPECT_NEAR(judge.judgement().bounds[0], 0.01, 1e-12);
  judge.measure_scale(known.run(10, 1));  // by 2: what is known of less is not made more
  EXPECT_NEAR(judge.judgement().effects.second_order[0], 0.4, 1e-12);
}

}  // namespace
}  // namespace lithe::solving
