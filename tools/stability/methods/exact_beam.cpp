#include "tools/stability/methods/exact_beam.h"

#include <algorithm>
#include <cmath>

#include "engine/base/math.h"

namespace lithe::lab {
namespace {

/// Legendre's polynomial and its derivative at x.
std::pair<double, double> legendre(int degree, double x) {
  double before = 1, now = x;
  for (int k = 2; k <= degree; ++k) {
    const double next = ((2 * k - 1) * x * now - (k - 1) * before) / k;
    before = now, now = next;
  }
  return {now, degree * (x * now - before) / (x * x - 1)};
}

/// Gauss-Lobatto points of [-1, 1] with weights, and the matrix of derivatives there.
struct Lobatto {
  VectorX points, weights;
  MatrixX derivative;
  explicit Lobatto(int p) : points(p + 1), weights(p + 1), derivative(MatrixX::Zero(p + 1, p + 1)) {
    points[0] = -1, points[p] = 1;
    for (int i = 1; i < p; ++i) {
      double x = -std::cos(M_PI * i / p);
      for (int k = 0; k < 50; ++k) {  // Newton for P' = 0, by Legendre's equation
        const auto [P, slope] = legendre(p, x);
        x -= slope * (1 - x * x) / (2 * x * slope - p * (p + 1) * P);
      }
      points[i] = x;
    }
    VectorX values(p + 1);
    for (int i = 0; i <= p; ++i) {
      values[i] = i == 0 ? (p % 2 ? -1 : 1) : i == p ? 1 : legendre(p, points[i]).first;
      weights[i] = 2 / (p * (p + 1) * values[i] * values[i]);
    }
    for (int i = 0; i <= p; ++i)
      for (int j = 0; j <= p; ++j)
        if (i != j) derivative(i, j) = values[i] / values[j] / (points[i] - points[j]);
    derivative(0, 0) = -p * (p + 1) / 4.0, derivative(p, p) = p * (p + 1) / 4.0;
  }
};

}  // namespace

double ExactBeam::smallest_deflection(const std::function<Motion(double time)>& hub, double end, int degree) const {
  const Lobatto lobatto(degree);
  const int n = degree + 1;
  using Nodal = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 16, 3>;  // places in the hub's axes, and the section's turn
  const MatrixX D = lobatto.derivative * 2 / length;
  const VectorX w = lobatto.weights * length / 2;

  const auto accelerations = [&](const Motion& motion, const Nodal& y, const Nodal& v, Nodal& a) {
    const Nodal slope = D * y;
    Nodal stress(n, 3), body(n, 3);  // ∂ of the virtual work by slope and by y
    for (int i = 0; i < n; ++i) {
      const double c = std::cos(y(i, 2)), s = std::sin(y(i, 2));
      const double stretch = c * slope(i, 0) + s * slope(i, 1) - 1, slip = -s * slope(i, 0) + c * slope(i, 1);
      const double N = axial * stretch, Q = shear * slip;
      stress.row(i) << w[i] * (c * N - s * Q), w[i] * (s * N + c * Q), w[i] * bending * slope(i, 2);
      body.row(i) << 0, 0, w[i] * (N * slip - Q * (1 + stretch));
    }
    a = -D.transpose() * stress - body;
    const double rate = motion.rate, gain = motion.acceleration;
    for (int i = 0; i < n; ++i) {
      a(i, 0) = a(i, 0) / (w[i] * line) + 2 * rate * v(i, 1) + gain * y(i, 1) + rate * rate * y(i, 0);
      a(i, 1) = a(i, 1) / (w[i] * line) - 2 * rate * v(i, 0) - gain * y(i, 0) + rate * rate * y(i, 1);
      a(i, 2) = a(i, 2) / (w[i] * rotary) - gain;
    }
    a.row(0).setZero();
  };

  Nodal y = Nodal::Zero(n, 3), v = Nodal::Zero(n, 3), a1(n, 3), a2(n, 3), a3(n, 3), a4(n, 3);
  y.col(0) = (lobatto.points.array() + 1) * length / 2;
  // The sections' turns against the shear's stiffness are fastest, beside waves across the closest points.
  const double gap = (lobatto.points[1] + 1) * length / 2;
  const double fastest =
      std::hypot(std::sqrt(shear / rotary), 3 * std::sqrt(std::max(axial / line, bending / rotary)) / gap);
  const long count = std::lround(std::ceil(end * fastest / 2));
  const double h = end / static_cast<double>(count);
  double smallest = 0;
  for (long k = 0; k < count; ++k) {
    const double t = static_cast<double>(k) * h;
    const Motion middle = hub(t + h / 2);
    accelerations(hub(t), y, v, a1);
    const Nodal v2 = v + h / 2 * a1;
    accelerations(middle, y + h / 2 * v, v2, a2);
    const Nodal v3 = v + h / 2 * a2;
    accelerations(middle, y + h / 2 * v2, v3, a3);
    const Nodal v4 = v + h * a3;
    accelerations(hub(t + h), y + h * v3, v4, a4);
    y += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    smallest = std::min(smallest, y(n - 1, 1));
    if (!y.allFinite()) return NAN;
  }
  return smallest;
}

}  // namespace lithe::lab
