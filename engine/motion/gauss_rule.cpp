#include "engine/motion/gauss_rule.h"

#include <cmath>

namespace lithe {

/// Zeros of Legendre's polynomial by Newton, from their asymptotic places.
GaussRule::GaussRule(int count) : nodes(count), weights(count), stages(count, count) {
  constexpr int kNewton = 8;
  for (int i = 0; i < count; ++i) {
    double x = -std::cos(M_PI * (i + 0.75) / (count + 0.5)), slope = 1;
    for (int k = 0; k < kNewton; ++k) {
      double p = 1, before = 0;
      for (int n = 1; n <= count; ++n) {
        const double next = ((2 * n - 1) * x * p - (n - 1) * before) / n;
        before = p, p = next;
      }
      slope = count * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    nodes[i] = (1 + x) / 2;
    weights[i] = 1 / ((1 - x * x) * slope * slope);
  }
  for (int i = 0; i < count; ++i) stages.row(i) = integrals(nodes[i]).transpose();
}

VectorX GaussRule::basis(double x) const {
  VectorX values = VectorX::Ones(count());
  for (int k = 0; k < count(); ++k)
    for (int j = 0; j < count(); ++j)
      if (j != k) values[k] *= (x - nodes[j]) / (nodes[k] - nodes[j]);
  return values;
}

/// By the rule itself, which is exact for them.
VectorX GaussRule::integrals(double x) const {
  VectorX sums = VectorX::Zero(count());
  for (int q = 0; q < count(); ++q) sums += x * weights[q] * basis(x * nodes[q]);
  return sums;
}

}  // namespace lithe
