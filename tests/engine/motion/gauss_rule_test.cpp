#include "engine/motion/gauss_rule.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lithe::test::gauss_rule_test {
namespace {

TEST(GaussRule, IntegratesPolynomialsOfTwiceItsNodes) {
  for (int n = 1; n <= 10; ++n) {
    const GaussRule rule(n);
    ASSERT_EQ(rule.count(), n);
    for (int power = 0; power < 2 * n; ++power)
      EXPECT_NEAR(rule.weights.dot(rule.nodes.array().pow(power).matrix()), 1.0 / (power + 1), 1e-14) << n << power;
    EXPECT_GT(std::abs(rule.weights.dot(rule.nodes.array().pow(2 * n).matrix()) - 1.0 / (2 * n + 1)), 1e-13) << n;
  }
}

TEST(GaussRule, IntegratesWithinTheStepWhatItsNodesTell) {
  for (int n = 1; n <= 10; ++n) {
    const GaussRule rule(n);
    for (double x : {0.0, 0.17, 0.5, 1.0})
      for (int power = 0; power < n; ++power) {
        const VectorX values = rule.nodes.array().pow(power);
        EXPECT_NEAR(rule.integrals(x).dot(values), std::pow(x, power + 1) / (power + 1), 1e-13);
        EXPECT_NEAR(rule.basis(x).dot(values), power == 0 ? 1 : std::pow(x, power), 1e-12);
      }
    for (int i = 0; i < n; ++i)
      EXPECT_LT((rule.stages.row(i).transpose() - rule.integrals(rule.nodes[i])).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace lithe::test::gauss_rule_test
