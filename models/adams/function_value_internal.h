#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/dual.h"
#include "engine/model/joint_by_residual.h"
#include "models/adams/adams_function.h"

/// Evaluates a function over a scalar S: a number, or one that carries derivatives. The context gives time() and
/// measure(place), in the units of the file.
namespace lithe::adams {

/// f(x), with its first two derivatives at the value of x.
inline double chained(double, const AdamsCurve::Value& f) { return f.value; }
inline InTime chained(const InTime& x, const AdamsCurve::Value& f) {
  return chain(
      x, f.value, [&] { return f.slope; }, [&] { return f.curvature; });
}
template <int N>
Dual<N> chained(const Dual<N>& x, const AdamsCurve::Value& f) {
  return chain(x, f.value, [&] { return f.slope; });
}

/// x^p; of a negative x for whole p alone.
template <class S>
S to_power(const S& x, const S& p) {
  using std::exp, std::log;
  const double e = dual::value_of(p);
  if (e == std::floor(e) && std::abs(e) <= 64) {
    S product(1.0), factor = x;
    for (int n = static_cast<int>(std::abs(e)); n > 0; n /= 2) {
      if (n % 2 == 1) product = product * factor;
      if (n > 1) factor = factor * factor;
    }
    return e < 0 ? S(1.0) / product : product;
  }
  if (dual::value_of(x) == 0 && e > 0) return S(0.0);
  return exp(p * log(x));
}

/// Cubic (STEP) or of order five (STEP5) from h0 at x0 to h1 at x1.
template <bool kFive, class S>
S step(const S& x, const S& x0, const S& h0, const S& x1, const S& h1) {
  if (x <= x0) return h0;
  if (x >= x1) return h1;
  const S u = (x - x0) / (x1 - x0);
  if constexpr (kFive) return h0 + (h1 - h0) * (u * u * u * (10.0 - u * (15.0 - 6.0 * u)));
  return h0 + (h1 - h0) * (u * u * (3.0 - 2.0 * u));
}

template <class S, class Context>
class Value {
 public:
  Value(const AdamsFunction& function, const Context& context) : f_(function), context_(context) {}
  S operator()() const { return at(f_.root); }

 private:
  S at(int place) const {
    using enum AdamsFunction::Operation;
    using std::sqrt, std::sin, std::cos, std::tan, std::asin, std::acos, std::atan, std::atan2, std::exp, std::log,
        std::tanh, std::abs;
    const AdamsFunction::Node& node = f_.nodes[static_cast<std::size_t>(place)];
    const auto a = [&](int i) -> S { return at(f_.arguments[static_cast<std::size_t>(node.first + i)]); };
    switch (node.operation) {
      case number:
        return S(node.number);
      case time:
        return context_.time();
      case measure:
        return context_.measure(node.index);
      case add: {
        S sum = a(0);
        for (int i = 1; i < node.count; ++i) sum += a(i);
        return sum;
      }
      case multiply: {
        S product = a(0);
        for (int i = 1; i < node.count; ++i) product = product * a(i);
        return product;
      }
      case divide:
        return a(0) / a(1);
      case power:
        return to_power(a(0), a(1));
      case negate:
        return -a(0);
      case branch: {
        const double test = dual::value_of(a(0));
        return a(test < 0 ? 1 : test == 0 ? 2 : 3);
      }
      case absolute: {
        const S x = a(0);
        return x < S(0.0) ? -x : x;
      }
      case arc_cosine:
        return acos(a(0));
      case arc_sine:
        return asin(a(0));
      case arc_tangent:
        return atan(a(0));
      case quadrant_arc_tangent:
        return atan2(a(0), a(1));
      case truncated:
        return S(std::trunc(dual::value_of(a(0))));
      case rounded:
        return S(std::round(dual::value_of(a(0))));
      case cosine:
        return cos(a(0));
      case sine:
        return sin(a(0));
      case tangent:
        return tan(a(0));
      case hyperbolic_tangent:
        return tanh(a(0));
      case square_root:
        return sqrt(a(0));
      case exponential:
        return exp(a(0));
      case logarithm:
        return log(a(0));
      case decimal_logarithm:
        return log(a(0)) * (1 / std::log(10.0));
      case hyperbolic_cosine: {
        const S e = exp(a(0));
        return (e + S(1.0) / e) * 0.5;
      }
      case hyperbolic_sine: {
        const S e = exp(a(0));
        return (e - S(1.0) / e) * 0.5;
      }
      case excess:
        return larger(a(0) - a(1), S(0.0));
      case maximum:
        return larger(a(0), a(1));
      case minimum:
        return -larger(-a(0), -a(1));
      case remainder: {
        const S x = a(0), y = a(1);
        return x - y * std::trunc(dual::value_of(x) / dual::value_of(y));
      }
      case with_sign: {
        const S x = a(0);
        const bool opposite = (dual::value_of(x) < 0) != (dual::value_of(a(1)) < 0);
        return opposite ? -x : x;
      }
      case cubic_step:
        return step<false>(a(0), a(1), a(2), a(3), a(4));
      case quintic_step:
        return step<true>(a(0), a(1), a(2), a(3), a(4));
      case haversine_step: {
        const S x = a(0), x0 = a(1), h0 = a(2), x1 = a(3), h1 = a(4);
        if (x <= x0) return h0;
        if (x >= x1) return h1;
        return (h0 + h1) * 0.5 + (h1 - h0) * 0.5 * sin((x - x0) / (x1 - x0) * M_PI - M_PI / 2);
      }
      case impact:
        return pushed(a(0), a(1), a(2), a(3), a(4), a(5), a(6));
      case bistop: {
        const S x = a(0), rate = a(1), k = a(4), e = a(5), c = a(6), d = a(7);
        return pushed(x, rate, a(2), k, e, c, d) - pushed(-x, -rate, -a(3), k, e, c, d);
      }
      case polynomial: {
        const S u = a(0) - a(1);
        S sum = a(node.count - 1);
        for (int i = node.count - 2; i >= 2; --i) sum = sum * u + a(i);
        return sum;
      }
      case chebyshev: {
        const S u = a(0) - a(1);
        S sum = a(2), before(1.0), now = u;
        for (int i = 3; i < node.count; ++i) {
          sum += a(i) * now;
          const S next = 2.0 * u * now - before;
          before = now, now = next;
        }
        return sum;
      }
      case harmonic: {
        const S wave = a(2) * sin(a(3) * (a(0) - a(1)) - a(4));
        return node.count > 5 ? wave + a(5) : wave;
      }
      case cosine_series:
      case sine_series: {
        const S angle = a(2) * (a(0) - a(1));
        S sum = a(3);
        for (int i = 4; i < node.count; ++i) {
          const S turned = static_cast<double>(i - 3) * angle;
          sum += a(i) * (node.operation == cosine_series ? cos(turned) : sin(turned));
        }
        return sum;
      }
      case curve: {
        const S x = a(0);
        const AdamsCurve::Value f = f_.curves[static_cast<std::size_t>(node.index)](dual::value_of(x));
        if (node.order == 0) return chained(x, f);
        if (node.order == 1) return chained(x, {f.slope, f.curvature, 0});
        return S(f.curvature);
      }
    }
    return S(0.0);
  }

  static S larger(const S& x, const S& y) { return x < y ? y : x; }
  /// IMPACT: k (x1 - x)^e - STEP(x, x1 - d, c, x1, 0) x' below x1, never negative.
  static S pushed(const S& x, const S& rate, const S& x1, const S& k, const S& e, const S& c, const S& d) {
    if (x >= x1) return S(0.0);
    return larger(k * to_power(x1 - x, e) - step<false>(x, x1 - d, c, x1, S(0.0)) * rate, S(0.0));
  }

  const AdamsFunction& f_;
  const Context& context_;
};

// ---- measures, SI ----

/// Of a pose, over any scalar: I against J, along the axes of K.
template <class S>
S measure_of_pose(AdamsMeasure::Kind kind, const PoseOf<S>& I, const PoseOf<S>& J, const PoseOf<S>& K) {
  using enum AdamsMeasure::Kind;
  using std::atan2, std::sqrt, std::asin, std::acos;
  using V = Eigen::Matrix<S, 3, 1>;
  const auto dot = [](const auto& a, const auto& b) -> S { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  switch (kind) {
    case DM: {
      const V d = I.p - J.p;
      return sqrt(dot(d, d));
    }
    case DX:
      return dot(V(I.p - J.p), K.R.col(0));
    case DY:
      return dot(V(I.p - J.p), K.R.col(1));
    case DZ:
      return dot(V(I.p - J.p), K.R.col(2));
    case AX:
      return atan2(S(-dot(I.R.col(2), J.R.col(1))), dot(I.R.col(2), J.R.col(2)));
    case AY:
      return atan2(dot(I.R.col(2), J.R.col(0)), dot(I.R.col(2), J.R.col(2)));
    case AZ:
      return atan2(dot(I.R.col(0), J.R.col(1)), dot(I.R.col(0), J.R.col(0)));
    // R_J^T R_I = Rz(psi) Rx(theta) Rz(phi); (r, c): entry
    case PSI:
      return atan2(dot(J.R.col(0), I.R.col(2)), S(-dot(J.R.col(1), I.R.col(2))));
    case THETA:
      return acos(dot(J.R.col(2), I.R.col(2)));
    case PHI:
      return atan2(dot(J.R.col(2), I.R.col(0)), dot(J.R.col(2), I.R.col(1)));
    // Rz(yaw) Ry(pitch) Rx(roll); Adams counts pitch the other way round
    case YAW:
      return atan2(dot(J.R.col(1), I.R.col(0)), dot(J.R.col(0), I.R.col(0)));
    case PITCH:
      return asin(dot(J.R.col(2), I.R.col(0)));
    case ROLL:
      return atan2(dot(J.R.col(2), I.R.col(1)), dot(J.R.col(2), I.R.col(2)));
    default:
      return S(0.0);
  }
}

}  // namespace lithe::adams
