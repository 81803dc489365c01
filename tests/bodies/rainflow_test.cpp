#include "bodies/fatigue/rainflow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <tuple>

#include "bodies/fatigue/sn_curve.h"
#include "engine/base/error.h"
#include "tests/support/message_of.h"

namespace lithe::test::rainflow_test {
namespace {

using Key = std::tuple<double, double, double>;  // range, mean, count

std::vector<Key> sorted(const std::vector<LoadCycle>& cycles) {
  std::vector<Key> keys;
  for (const LoadCycle& c : cycles) keys.emplace_back(c.range, c.mean, c.count);
  std::sort(keys.begin(), keys.end());
  return keys;
}

/// The four-point rule on the whole history: while any inner range is no larger than both beside it, it is a cycle and
/// goes; what is left are half cycles.
std::vector<LoadCycle> counted_by_hand(const std::vector<double>& history) {
  std::vector<double> turns;
  for (std::size_t i = 0; i < history.size(); ++i)
    if (i == 0 || i + 1 == history.size() || (history[i] - history[i - 1]) * (history[i + 1] - history[i]) < 0)
      turns.push_back(history[i]);
  std::vector<LoadCycle> cycles;
  const auto range = [&](std::size_t i) { return std::abs(turns[i + 1] - turns[i]); };
  for (std::size_t i = 0; i + 3 < turns.size();) {
    if (range(i + 1) > range(i) || range(i + 1) > range(i + 2)) {
      ++i;
      continue;
    }
    cycles.push_back({range(i + 1), 0.5 * (turns[i + 1] + turns[i + 2]), 1});
    turns.erase(turns.begin() + static_cast<std::ptrdiff_t>(i) + 1, turns.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    i = 0;
  }
  for (std::size_t i = 0; i + 1 < turns.size(); ++i) cycles.push_back({range(i), 0.5 * (turns[i] + turns[i + 1]), 0.5});
  return cycles;
}

/// ASTM E1049-85, figure 6 and its table: A to I.
TEST(Rainflow, CountsTheExampleOfTheStandard) {
  const std::vector<double> history{-2, 1, -3, 5, -1, 3, -4, 4, -2};
  std::map<double, double> counts;
  for (const LoadCycle& cycle : rainflow(history)) counts[cycle.range] += cycle.count;
  EXPECT_EQ(counts, (std::map<double, double>{{3, 0.5}, {4, 1.5}, {6, 0.5}, {8, 1.0}, {9, 0.5}}));
  // E-F, its one whole cycle, lies about 1.
  const auto cycles = rainflow(history);
  const auto whole = std::find_if(cycles.begin(), cycles.end(), [](const LoadCycle& c) { return c.count == 1; });
  ASSERT_NE(whole, cycles.end());
  EXPECT_EQ(whole->range, 4);
  EXPECT_EQ(whole->mean, 1);
}

TEST(Rainflow, OfSumsOfWavesIsThatCountedByHand) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> history;
    const double a = number(random), b = number(random), w = 3 + 2 * number(random), noise = trial % 3 == 0 ? 0.3 : 0;
    for (int i = 0; i < 300; ++i)
      history.push_back(std::sin(0.2 * i) + a * std::sin(0.2 * w * i + b) + noise * number(random) + 0.001 * i * a);
    const auto cycles = rainflow(history);
    EXPECT_EQ(sorted(cycles), sorted(counted_by_hand(history))) << trial;
    // A cycle goes its range twice: in all as far as the history goes.
    double gone = 0, there = 0;
    for (const LoadCycle& c : cycles) gone += 2 * c.count * c.range;
    for (std::size_t i = 1; i < history.size(); ++i) there += std::abs(history[i] - history[i - 1]);
    EXPECT_NEAR(gone, there, 1e-10 * there);
  }
}

TEST(Rainflow, OfFlatAndShortHistoriesIsNothing) {
  EXPECT_TRUE(rainflow(std::vector<double>{}).empty());
  EXPECT_TRUE(rainflow(std::vector<double>{3, 3, 3}).empty());
  EXPECT_EQ(sorted(rainflow(std::vector<double>{0, 1, 1, 2})), (std::vector<Key>{{2, 1, 0.5}}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_says(message_of<SceneError>([&] { rainflow(std::vector<double>{0, nan}); }), {"history"});
}

TEST(SnCurve, HasTwoSlopesAndACutOff) {
  // EN 1993-1-9, category 71: 71 MPa at 2e6 cycles, knee at 5e6 and 52.3 MPa, cut-off at 1e8 and 28.7 MPa.
  const double knee = 71e6 * std::pow(2.0 / 5, 1.0 / 3), least = knee * std::pow(5e6 / 1e8, 1.0 / 5);
  EXPECT_NEAR(knee, 52.3e6, 0.05e6);
  EXPECT_NEAR(least, 28.7e6, 0.05e6);
  const SnCurve curve{.range = knee, .cycles = 5e6, .exponent = 3, .exponent_below = 5, .cut_off = least};
  EXPECT_NEAR(curve.endured(71e6) / 2e6, 1, 1e-12);
  EXPECT_NEAR(curve.endured(knee * (1 - 1e-12)) / curve.endured(knee), 1, 1e-10);
  EXPECT_NEAR(curve.endured(least) / 1e8, 1, 1e-12);
  EXPECT_EQ(curve.endured(0.999 * least), std::numeric_limits<double>::infinity());
  EXPECT_EQ(curve.damage({0.5 * least, 0, 1}), 0);
}

TEST(SnCurve, HasExactlyTheDamageOfASineAndMoreOfALargerOne) {
  const SnCurve curve{.range = 100, .cycles = 1e6, .exponent = 5};
  const auto sine = [](double amplitude, double mean, int periods) {
    std::vector<double> history;
    for (int i = 0; i <= 40 * periods; ++i) history.push_back(mean + amplitude * std::cos(M_PI * i / 20));
    return rainflow(history);
  };
  for (const int periods : {1, 7, 100})
    EXPECT_NEAR(miner_sum(sine(60, 0, periods), curve), periods / (1e6 * std::pow(100.0 / 120, 5)), 1e-12 * periods);
  double last = 0;
  for (double amplitude = 1; amplitude < 200; amplitude *= 1.3) {
    const double damage = miner_sum(sine(amplitude, 0, 3), curve);
    EXPECT_GT(damage, last);
    last = damage;
  }
  // Goodman: of 120 about 200, with R_m = 500, as much as 120 / (1 - 0.4) about 0; compression is no help.
  SnCurve goodman = curve;
  goodman.tensile_strength = 500;
  EXPECT_NEAR(miner_sum(sine(60, 200, 10), goodman) / miner_sum(sine(100, 0, 10), curve), 1, 1e-10);
  EXPECT_NEAR(miner_sum(sine(60, -200, 10), goodman) / miner_sum(sine(60, 0, 10), curve), 1, 1e-10);
  expect_says(message_of<SceneError>([&] { goodman.damage({400, 300, 1}); }), {"reaches 500 Pa", "500 Pa"});
}

TEST(SnCurve, RefusesFiguresThatCannotBe) {
  const std::vector<LoadCycle> none;
  const auto refused = [&](const SnCurve& curve) { return message_of<SceneError>([&] { miner_sum(none, curve); }); };
  expect_says(refused({}), {"range of the S-N curve"});
  expect_says(refused({.range = 1, .cycles = -1}), {"cycles"});
  expect_says(refused({.range = 1, .exponent = 0}), {"exponent"});
  expect_says(refused({.range = 1, .cut_off = -1}), {"cut_off"});
  expect_says(refused({.range = 1, .tensile_strength = std::nan("")}), {"tensile_strength"});
}

}  // namespace
}  // namespace lithe::test::rainflow_test
