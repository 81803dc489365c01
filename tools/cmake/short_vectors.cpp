// Clang 16 with AVX-512, from -O2 on, loses the first entry of a vector of at most 2, 3 or 5 entries that is assigned a difference:
// Eigen 3.4 assigns the entries before an aligned one apart. 4 and 6 are right, and so is GCC. 0: the compiler does it right.
#include <Eigen/Core>
using Short = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2>;
[[gnu::noinline]] double length(const Eigen::VectorXd& x, const Eigen::VectorXd& y, int first, int count, double* entries) {
  const Short way = x.segment(first, count) - y.segment(first, count);
  entries[0] = way[0], entries[1] = way[1];
  return way.norm();
}
int main() {
  Eigen::VectorXd x(3), y(3);
  x << 1, 2, 3;
  y << 10, 0, 0;
  double entries[2];
  return length(x, y, 1, 2, entries) > 3.6 && entries[0] == 2 && entries[1] == 3 ? 0 : 1;
}
