#include <gtest/gtest.h>

#include "engine/study/progress.h"

namespace lithe::test::study_progress_test {
namespace {

TEST(StudyProgress, TellsTheTimeLeftFromRunsThatGrowDearer) {
  Progress progress({4, 4}, 60, Progress::Show::never);
  progress.begin(0, "first 1e-2");
  EXPECT_LT(progress.seconds_left(), 0) << "nothing is known before the first run has ended";
  EXPECT_EQ(progress.text(), "[>                   ] 0/8  first 1e-2   left ?");
  progress.end(1);
  // Twice as dear a run until more is known: 2 + 4 + 8, and as much a run for the other line.
  EXPECT_DOUBLE_EQ(progress.seconds_left(), 14 + 4 * (15.0 / 4));
  progress.begin(1, "second 1e-2");
  progress.end(3);
  progress.begin(0, "first 1e-3");
  progress.end(1.5);
  // 1.5 (1.5 + 1.5²) of the first, 3 (2 + 4 + 8) of the second.
  EXPECT_DOUBLE_EQ(progress.seconds_left(), 1.5 * (1.5 + 2.25) + 42);
  EXPECT_EQ(progress.text(), "[=======>            ] 3/8  first 1e-3   left 0:48");
}

TEST(StudyProgress, RunsThatDoNotTakePlaceAreNotWaitedFor) {
  Progress progress({3, 1}, 60, Progress::Show::never);
  progress.begin(0, "slow");
  progress.end(60);
  progress.skip(0, 2);
  progress.begin(1, "quick");
  progress.end(0.5);
  EXPECT_DOUBLE_EQ(progress.seconds_left(), 0);
  EXPECT_EQ(progress.text(), "[====================] 2/2  quick   left 0:00");
}

TEST(StudyProgress, NoRunIsExpectedToTakeLongerThanItsLimit) {
  Progress progress({10}, 5, Progress::Show::never);
  progress.begin(0, "a");
  progress.end(1);
  progress.begin(0, "b");
  progress.end(400);
  EXPECT_LE(progress.seconds_left(), 8 * 5);
}

TEST(StudyProgress, DrawsOnlyWhereItIsAskedTo) {
  const auto written = [](Progress::Show show) {
    std::FILE* file = std::tmpfile();
    {
      Progress progress({1}, 1, show, file);
      progress.begin(0, "run");
      progress.end(0.1);
    }
    const long size = std::ftell(file);
    std::fclose(file);
    return size;
  };
  EXPECT_EQ(written(Progress::Show::on_terminal), 0) << "a file is no terminal";
  EXPECT_EQ(written(Progress::Show::never), 0);
  EXPECT_GT(written(Progress::Show::always), 0);
}

}  // namespace
}  // namespace lithe::test::study_progress_test
