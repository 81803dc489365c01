#include "engine/factor/banded_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// The factor of a band against a dense one, for real and complex matrices, and what it refuses.
namespace lithe::test::banded_cholesky_test {
namespace {

struct Band {
  int size, band;
  LinearPattern pattern;
  MatrixX definite, semidefinite;  // with entries in the band alone

  Band(int size, int band) : size(size), band(band), definite(size, size), semidefinite(size, size) {
    RandomNumbers random(11);
    std::vector<std::pair<int, int>> entries;
    for (int j = 0; j < size; ++j)
      for (int i = j; i <= std::min(size - 1, j + band); ++i) entries.emplace_back(i, j);
    pattern.rows.resize(static_cast<Eigen::Index>(entries.size())), pattern.columns = pattern.rows;
    for (std::size_t k = 0; k < entries.size(); ++k)
      pattern.rows[k] = entries[k].first, pattern.columns[k] = entries[k].second;
    for (MatrixX* D : {&definite, &semidefinite}) {  // sums of dyads within the band
      D->setZero();
      for (int j = 0; j + band < size; ++j) {
        const VectorX x = random.vector(band + 1, 1);
        D->block(j, j, band + 1, band + 1) += x * x.transpose();
      }
    }
    definite += 0.1 * MatrixX::Identity(size, size);
  }

  template <class Matrix>
  std::vector<typename Matrix::Scalar> entries(const Matrix& D) const {
    std::vector<typename Matrix::Scalar> out;
    for (Eigen::Index k = 0; k < pattern.rows.size(); ++k) out.push_back(D(pattern.rows[k], pattern.columns[k]));
    return out;
  }
};

TEST(BandedCholesky, SolvesAsADenseFactorDoes) {
  for (const auto& [size, band] :
       {std::pair(1, 0), {4, 0}, {7, 1}, {60, 8}, {61, 8}, {9, 8}, {10, 8}, {12, 8}, {9, 5}, {26, 24}, {40, 20}}) {
    const Band scene(size, band);
    BandedCholesky<double> factor(size, scene.pattern);
    for (const double weight : {1.0, 3.0}) {  // the second time with other values
      const MatrixX D = scene.definite + weight * scene.semidefinite;
      ASSERT_TRUE(factor.factorize(scene.entries(D).data()));
      MatrixX x = MatrixX::Random(size, 3);
      const MatrixX right = x;
      factor.solve(x);
      expect_below("real, " + std::to_string(band), (D * x - right).norm() / right.norm(), 1e-12);
    }
  }
}

/// Semidefinite ones at two angles, as M and K are weighed by Radau's complex stages.
TEST(BandedCholesky, SolvesComplexCombinations) {
  const Band scene(61, 8);
  BandedCholesky<std::complex<double>> factor(61, scene.pattern);
  using Complex = std::complex<double>;
  for (const Complex shift : {Complex(2.7, 3.1), Complex(-2.5, 0.4), Complex(0, 1)}) {
    const Eigen::MatrixXcd D = shift * scene.definite.cast<Complex>() + scene.semidefinite.cast<Complex>();
    ASSERT_TRUE(factor.factorize(scene.entries(D).data()));
    Eigen::MatrixXcd x = Eigen::MatrixXcd::Random(61, 4);
    const Eigen::MatrixXcd right = x;
    factor.solve(x);
    expect_below("complex", (D * x - right).norm() / right.norm(), 1e-11);
  }
}

TEST(BandedCholesky, RefusesWhatIsNotDefinite) {
  const Band scene(20, 3);
  BandedCholesky<double> factor(20, scene.pattern);
  MatrixX D;
  for (const int row : {0, 10, 19}) {  // of an end, of the middle, of the other end
    D = scene.definite;
    D(row, row) = -1;
    EXPECT_FALSE(factor.factorize(scene.entries(D).data()));
    D(row, row) = std::nan("");
    EXPECT_FALSE(factor.factorize(scene.entries(D).data()));
  }
  EXPECT_TRUE(factor.factorize(scene.entries(scene.definite).data()));
}

TEST(BandedCholesky, SuitsANarrowBandThatIsFilled) {
  EXPECT_TRUE(BandedCholesky<double>::suits(60, Band(60, 8).pattern));
  EXPECT_FALSE(BandedCholesky<double>::suits(60, Band(60, 30).pattern));
  LinearPattern corner = Band(60, 1).pattern;  // and an entry in the far corner
  corner.rows.conservativeResize(corner.rows.size() + 1), corner.columns.conservativeResize(corner.rows.size());
  corner.rows[corner.rows.size() - 1] = 59, corner.columns[corner.rows.size() - 1] = 0;
  EXPECT_FALSE(BandedCholesky<double>::suits(60, corner));
}

}  // namespace
}  // namespace lithe::test::banded_cholesky_test
