// One body's sparse block, softened until it is indefinite, and until it is singular.
#include "engine/factor/linear_block.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/factor/block_factor.h"

namespace lithe::test::linear_block_test {
namespace {

/// A free chain of n springs and masses, D = tridiag(-1, 2, -1) - softening E: its eigenvalues are
/// 4 sin²(kπ / 2(n+1)) - softening. Two rows hold its ends; every second coordinate
/// is in another unit, as rotations beside translations.
struct Chain {
  static constexpr int n = 40;
  LinearPattern pattern;
  BlockStructure structure;
  std::vector<double> values;
  MatrixX whole = MatrixX::Zero(n + 2, n + 2);
  double unit;

  double scale(int i) const { return i < n && i % 2 == 1 ? unit : 1; }

  static double eigenvalue(int k) { return 4 * std::pow(std::sin(k * M_PI / (2 * (n + 1))), 2); }

  explicit Chain(double softening, double unit = 1) : unit(unit) {
    pattern.rows.resize(2 * n - 1), pattern.columns.resize(2 * n - 1);
    int entry = 0;
    for (int i = 0; i < n; ++i) {
      pattern.rows[entry] = pattern.columns[entry] = i, ++entry;
      if (i + 1 < n) pattern.rows[entry] = i + 1, pattern.columns[entry] = i, ++entry;
    }
    structure.velocity_count = n, structure.row_count = 2;
    const int block = structure.reserve(2 * n - 1), G = structure.reserve(2 * n);
    structure.linears.push_back({0, n, -1, 0, -1, -1, block, &pattern});
    structure.rows.push_back({0, 2, -1});
    structure.jacobians.push_back({0, -1, -1, 0, G, 0});
    values.assign(structure.value_count, 0);
    for (int k = 0; k < 2 * n - 1; ++k) {
      const int i = pattern.rows[k], j = pattern.columns[k];
      const double value = (i == j ? 2 - softening : -1) * scale(i) * scale(j);
      values[block + k] = whole(i, j) = whole(j, i) = value;
    }
    for (const auto& [row, i] : {std::pair(0, 0), std::pair(1, n - 2)})
      values[G + row + 2 * i] = whole(n + row, i) = whole(i, n + row) = scale(i);
  }

  VectorX solve(const VectorX& right) const {
    BlockFactor factor(structure);
    factor.factorize(values);
    VectorX x = right;
    factor.solve(x.data());
    return x;
  }
};

TEST(LinearBlock, IsSolvedWhereSofteningMakesItIndefinite) {
  for (const double unit : {1.0, 1e-6}) {
    // Below the first eigenvalue it is definite; then one, two, ten of its eigenvalues are negative.
    for (const int negative : {0, 1, 2, 10}) {
      const double softening = 0.5 * (Chain::eigenvalue(negative) + Chain::eigenvalue(negative + 1));
      const Chain chain(softening, unit);
      VectorX right(Chain::n + 2);
      for (int i = 0; i < right.size(); ++i) right[i] = chain.scale(i) * std::cos(3 * i);
      const VectorX x = chain.solve(right);
      // The residual, row by row, over the sizes of its terms: round-off times a growth of pivots of some tens.
      const VectorX left = (chain.whole * x - right).cwiseAbs(),
                    terms = chain.whole.cwiseAbs() * x.cwiseAbs() + right.cwiseAbs();
      EXPECT_LT(left.cwiseQuotient(terms).maxCoeff(), 1e-11) << negative << " negative, unit " << unit;
    }
  }
}

/// Cholesky fails by a pivot that is round-off or below; LU has a pivot of round-off then. What divides by it is noise.
TEST(LinearBlock, ThatIsSingularGivesNoNumberInsteadOfNoise) {
  for (const int k : {1, 2, 10}) {
    const VectorX x = Chain(Chain::eigenvalue(k)).solve(VectorX::Ones(Chain::n + 2));
    EXPECT_FALSE(x.allFinite()) << k;
  }
  EXPECT_TRUE(Chain(Chain::eigenvalue(2) + 1e-9).solve(VectorX::Ones(Chain::n + 2)).allFinite());
}

/// The same block of values is not factorised twice; another one after it is.
TEST(LinearBlock, GoesOnAfterASingularBlock) {
  const Chain sound(0), singular(Chain::eigenvalue(1));
  BlockFactor factor(sound.structure);
  for (const Chain* chain : {&sound, &singular, &singular, &sound}) {
    factor.factorize(chain->values);
    VectorX x = VectorX::Ones(Chain::n + 2);
    factor.solve(x.data());
    EXPECT_EQ(x.allFinite(), chain == &sound);
  }
}

}  // namespace
}  // namespace lithe::test::linear_block_test
