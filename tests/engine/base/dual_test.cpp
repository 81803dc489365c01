#include "engine/base/dual.h"

#include <gtest/gtest.h>

#include "engine/base/math.h"
#include "tests/support/methods.h"

/// Numbers with derivatives against closed forms and against each other.
namespace lithe::test::dual_test {
namespace {

/// A function with all that there is in it.
template <class S>
S all_of(const S& x, const S& y) {
  using std::log;  // beside lithe's namespace of that name
  S out = sin(x) * cos(y) + tan(x * y) / sqrt(x + 2.0) - exp(-y) * log(x + 3.0);
  out += atan2(y, x) + asin(0.3 * x) - acos(0.2 * y) + atan(x - y) * tanh(y) + abs(x - 4.0) + pow(x, 2.5) - pow(y, 2);
  out *= 1.5;
  out /= y + 2;
  return -out + (x > y ? x : y);
}

/// By complex steps the first derivatives would need other functions: central differences of sixth order.
double difference(const auto& f, double h) {
  return (45 * (f(h) - f(-h)) - 9 * (f(2 * h) - f(-2 * h)) + f(3 * h) - f(-3 * h)) / (60 * h);
}

/// The plain function, as numbers without derivatives give it.
double plain(double x, double y) {
  using D = Dual<1>;
  return all_of(D(x), D(y)).value;
}

TEST(Dual, FirstDerivativesAreThose) {
  for (const auto& [x, y] : {std::pair(0.7, 0.4), {0.3, 0.9}, {1.1, -0.5}}) {
    Dual<2> a(x), b(y);
    a.d[0] = 1, b.d[1] = 1;
    const Dual<2> f = all_of(a, b);
    const double dx = difference([&, x, y](double h) { return plain(x + h, y); }, 1e-3),
                 dy = difference([&, x, y](double h) { return plain(x, y + h); }, 1e-3);
    expect_below("by x", std::abs(f.d[0] - dx), 1e-9 * (1 + std::abs(dx)));
    expect_below("by y", std::abs(f.d[1] - dy), 1e-9 * (1 + std::abs(dy)));
  }
}

TEST(Dual, SecondDerivativesAreThoseOfTheFirst) {
  using Twice = Dual<2, Dual<2>>;
  const double x = 0.7, y = 0.4;
  Twice a(x), b(y);
  a.value.d[0] = 1, a.d[0] = 1.0, b.value.d[1] = 1, b.d[1] = 1.0;
  const Twice f = all_of(a, b);
  const auto gradient = [](double u, double v) {
    Dual<2> p(u), q(v);
    p.d[0] = 1, q.d[1] = 1;
    return all_of(p, q).d;
  };
  for (int i = 0; i < 2; ++i) {
    expect_below("value", std::abs(f.value.d[i] - gradient(x, y)[i]), 1e-14 * (1 + std::abs(f.value.d[i])));
    const double dx = difference([&](double h) { return gradient(x + h, y)[i]; }, 1e-3),
                 dy = difference([&](double h) { return gradient(x, y + h)[i]; }, 1e-3);
    expect_below("by x", std::abs(f.d[i].d[0] - dx), 1e-8 * (1 + std::abs(dx)));
    expect_below("by y", std::abs(f.d[i].d[1] - dy), 1e-8 * (1 + std::abs(dy)));
  }
  EXPECT_NEAR(f.d[0].d[1], f.d[1].d[0], 1e-13 * (1 + std::abs(f.d[0].d[1])));
}

/// Along a motion x(t), y(t): the same from nested numbers, f_xx x_dot² + … + f_x x_dotdot.
TEST(Dual, InTimeIsTheChainRule) {
  using Twice = Dual<2, Dual<2>>;
  const InTime x(0.7, 1.3, -0.4), y(0.4, -0.8, 2.1), f = all_of(x, y);
  Twice a(x.value), b(y.value);
  a.value.d[0] = 1, a.d[0] = 1.0, b.value.d[1] = 1, b.d[1] = 1.0;
  const Twice g = all_of(a, b);
  const double rates[] = {x.rate, y.rate}, accelerations[] = {x.acceleration, y.acceleration};
  double rate = 0, acceleration = 0;
  for (int i = 0; i < 2; ++i) {
    rate += g.value.d[i] * rates[i], acceleration += g.value.d[i] * accelerations[i];
    for (int j = 0; j < 2; ++j) acceleration += g.d[i].d[j] * rates[i] * rates[j];
  }
  EXPECT_NEAR(f.rate, rate, 1e-13 * (1 + std::abs(rate)));
  EXPECT_NEAR(f.acceleration, acceleration, 1e-12 * (1 + std::abs(acceleration)));
}

TEST(Dual, ServesAsAScalarOfEigen) {
  using D = Dual<3>;
  Eigen::Matrix<D, 3, 1> x;
  for (int i = 0; i < 3; ++i) x[i] = i + 1.0, x[i].d[i] = 1;
  const Vector3 a(0.3, -0.2, 0.5);
  const Eigen::Matrix<D, 3, 1> constant = a.cast<D>(), turned = x.cross(constant);
  EXPECT_EQ(turned[0].d[1], a[2]);
  EXPECT_EQ(turned[0].d[2], -a[1]);
  const D length = x.norm();
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(length.d[i], (i + 1) / std::sqrt(14.0), 1e-15);
  EXPECT_NEAR(x.dot(constant).d[2], 0.5, 1e-15);
  EXPECT_NEAR((2.0 * x).squaredNorm().d[0], 8, 1e-14);
}

TEST(Dual, AtanKnowsItsQuadrant) {
  for (int k = -7; k < 8; ++k) {
    const double phi = 0.4 * k;
    Dual<1> angle(phi);
    angle.d[0] = 1;
    const Dual<1> back = atan2(2.0 * sin(angle), 2.0 * cos(angle));
    EXPECT_NEAR(back.value, phi, 1e-15);
    EXPECT_NEAR(back.d[0], 1, 1e-15);
  }
}

}  // namespace
}  // namespace lithe::test::dual_test
