#pragma once

// What a compiled scene is made of besides its equations; `lithe compile` copies this text into the header it writes.
// Needs the standard library alone. Compile with -ffp-contract=off: where products are fused is said here, so that one
// scene and many in lanes give the same bits.
#include <array>
#include <cmath>
#include <vector>
#ifdef __FMA__
#include <immintrin.h>
#endif

namespace lithe_compiled {

/// Two, four or eight doubles in one register.
template <int Width>
struct RegisterOf;
template <>
struct RegisterOf<2> {
  typedef double Type __attribute__((vector_size(16)));
};
template <>
struct RegisterOf<4> {
  typedef double Type __attribute__((vector_size(32)));
};
template <>
struct RegisterOf<8> {
  typedef double Type __attribute__((vector_size(64)));
};

/// N doubles, one a scene, in registers of the machine's width. Nothing ever passes from one lane to another.
template <int N>
class Pack {
 public:
#if defined(__AVX512F__)
  static constexpr int kWidth = N < 8 ? N : 8;
#elif defined(__AVX__)
  static constexpr int kWidth = N < 4 ? N : 4;
#else
  static constexpr int kWidth = 2;
#endif
  static constexpr int kParts = N / kWidth;
  using Register = typename RegisterOf<kWidth>::Type;

  Pack() = default;
  Pack(double x) {  // NOLINT: implicit on purpose
    for (Register& r : part)
      for (int k = 0; k < kWidth; ++k) r[k] = x;
  }
  double operator[](int lane) const { return part[lane / kWidth][lane % kWidth]; }
  void set(int lane, double x) { part[lane / kWidth][lane % kWidth] = x; }

  Register part[kParts];
};

template <int N, class F>
inline Pack<N> each_part(F&& f) {
  Pack<N> result;
  for (int i = 0; i < Pack<N>::kParts; ++i) result.part[i] = f(i);
  return result;
}
template <int N>
inline Pack<N> operator+(const Pack<N>& a, const Pack<N>& b) {
  return each_part<N>([&](int i) { return a.part[i] + b.part[i]; });
}
template <int N>
inline Pack<N> operator-(const Pack<N>& a, const Pack<N>& b) {
  return each_part<N>([&](int i) { return a.part[i] - b.part[i]; });
}
template <int N>
inline Pack<N> operator*(const Pack<N>& a, const Pack<N>& b) {
  return each_part<N>([&](int i) { return a.part[i] * b.part[i]; });
}
template <int N>
inline Pack<N> operator/(const Pack<N>& a, const Pack<N>& b) {
  return each_part<N>([&](int i) { return a.part[i] / b.part[i]; });
}
template <int N>
inline Pack<N> operator-(const Pack<N>& a) {
  return each_part<N>([&](int i) { return -a.part[i]; });
}

/// a b + c, rounded once where the machine can, for one number as for many.
#ifdef __FMA__
inline double product_plus(double a, double b, double c) { return __builtin_fma(a, b, c); }
template <class Register>
inline Register product_plus_of_registers(Register a, Register b, Register c) {
#ifdef __AVX512F__
  if constexpr (sizeof(Register) == 64) return _mm512_fmadd_pd(a, b, c);
#endif
  if constexpr (sizeof(Register) == 32) return _mm256_fmadd_pd(a, b, c);
  if constexpr (sizeof(Register) == 16) return _mm_fmadd_pd(a, b, c);
}
#else
inline double product_plus(double a, double b, double c) { return a * b + c; }
template <class Register>
inline Register product_plus_of_registers(Register a, Register b, Register c) {
  return a * b + c;
}
#endif
template <int N>
inline Pack<N> product_plus(const Pack<N>& a, const Pack<N>& b, const Pack<N>& c) {
  return each_part<N>([&](int i) { return product_plus_of_registers(a.part[i], b.part[i], c.part[i]); });
}
/// a b - c and c - a b.
template <class S>
inline S product_minus(const S& a, const S& b, const S& c) {
  return product_plus(a, b, -c);
}
template <class S>
inline S minus_product(const S& a, const S& b, const S& c) {
  return product_plus(-a, b, c);
}

/// Sine and cosine within a unit in the last place for |x| < 1e6 rad, without a branch: x less the nearest multiple k
/// of a quarter turn, kept in three parts, then polynomials (a Chebyshev fit; relative error 2e-17) and the quarter by
/// arithmetic that is exact.
template <class S>
inline void sine_cosine(const S& x, S& sine, S& cosine) {
  const S round(0x1.8p52);
  const S k = product_plus(x, S(0.6366197723675814), round) - round;
  const S first = minus_product(k, S(1.5707963267341256), x), second(6.077100506303966e-11);
  const S rounded = minus_product(k, second, first), lost = minus_product(k, second, first - rounded);
  const S third = minus_product(k, S(2.0222662487959506e-21), lost), r = rounded + third, rest = (rounded - r) + third;
  const S z = r * r;
  S p = product_plus(z, S(1.5917848524808262e-10), S(-2.5051127944014188e-08));
  p = product_plus(z, p, S(2.755731608381636e-06));
  p = product_plus(z, p, S(-0.00019841269836722418));
  p = product_plus(z, p, S(0.008333333333330925));
  p = product_plus(z, p, S(-0.16666666666666666));
  const S s = r + product_plus(p * z, r, rest);
  S c = product_plus(z, S(-1.1382456778061306e-11), S(2.0876143827993133e-09));
  c = product_plus(z, c, S(-2.7557317260008837e-07));
  c = product_plus(z, c, S(2.480158729874307e-05));
  c = product_plus(z, c, S(-0.0013888888888887382));
  c = product_plus(z, c, S(0.041666666666666664));
  // 1 - z / 2 with what its rounding loses.
  const S half = S(0.5) * z, near = S(1) - half;
  c = near + minus_product(r, rest, product_plus(z * z, c, (S(1) - near) - half));
  // Quarter m = k mod 4 in {-2 ... 2}: its sine is what is left of m by two, its cosine 1 or -1 where nothing is.
  const S m = minus_product(product_plus(k, S(0.25), round) - round, S(4), k);
  const S turned = minus_product(product_plus(m, S(0.5), round) - round, S(2), m);
  const S even = minus_product(turned, turned, S(1)) * minus_product(S(0.5) * m, m, S(1));
  sine = product_plus(turned, c, even * s);
  cosine = minus_product(turned, s, even * c);
}

/// Brings a quaternion that is nearly of length 1 there, without a root: two rounds of Newton's method for 1 / |e|.
template <class S>
inline void normalize(S* e) {
  const S square = product_plus(e[0], e[0], product_plus(e[1], e[1], product_plus(e[2], e[2], e[3] * e[3])));
  const S first = minus_product(S(0.5), square, S(1.5));
  const S factor = first * minus_product(S(0.5), square * first * first, S(1.5));
  for (int i = 0; i < 4; ++i) e[i] = e[i] * factor;
}

/// Rates of positions: velocities, and of a quaternion e with turning ω in the outer body's axes ½ e ∘ (0, ω).
template <class Scene, class S>
inline void position_rates(const S* q, const S* v, S* rates) {
  for (int i = 0; i < Scene::kVelocities; ++i)
    if (Scene::kPositionOf[i] >= 0) rates[Scene::kPositionOf[i]] = v[i];
  for (const auto& at : Scene::kQuaternions) {
    const S *e = q + at[0], *w = v + at[1];
    S* d = rates + at[0];
    const S half(0.5);
    d[0] = -half * product_plus(e[1], w[0], product_plus(e[2], w[1], e[3] * w[2]));
    d[1] = half * product_plus(e[0], w[0], minus_product(e[3], w[1], e[2] * w[2]));
    d[2] = half * product_plus(e[0], w[1], minus_product(e[1], w[2], e[3] * w[0]));
    d[3] = half * product_plus(e[0], w[2], minus_product(e[2], w[0], e[1] * w[1]));
  }
}

/// One step of `step` seconds by the classical Runge-Kutta method of order 4; u constant within it.
template <class Scene, class S>
inline void step_runge_kutta(S* q, S* v, const S* u, double step) {
  constexpr int n = Scene::kPositions, m = Scene::kVelocities;
  std::array<S, n> at = {}, rates, sum_q;
  std::array<S, m> speed = {}, accelerations, sum_v;
  const double forward[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  for (int i = 0; i < n; ++i) at[i] = sum_q[i] = q[i];
  for (int i = 0; i < m; ++i) speed[i] = sum_v[i] = v[i];
  for (int stage = 0; stage < 4; ++stage) {
    if (stage > 0) {
      const S h(forward[stage] * step);
      for (int i = 0; i < n; ++i) at[i] = product_plus(h, rates[i], q[i]);
      for (int i = 0; i < m; ++i) speed[i] = product_plus(h, accelerations[i], v[i]);
    }
    position_rates<Scene>(at.data(), speed.data(), rates.data());
    Scene::accelerations(at.data(), speed.data(), u, accelerations.data());
    const S h(weight[stage] * step);
    for (int i = 0; i < n; ++i) sum_q[i] = product_plus(h, rates[i], sum_q[i]);
    for (int i = 0; i < m; ++i) sum_v[i] = product_plus(h, accelerations[i], sum_v[i]);
  }
  for (int i = 0; i < n; ++i) q[i] = sum_q[i];
  for (int i = 0; i < m; ++i) v[i] = sum_v[i];
  for (const auto& quaternion : Scene::kQuaternions) normalize(q + quaternion[0]);
}

/// One step by the semi-implicit Euler method, of order 1: velocities first, then positions with the new ones.
template <class Scene, class S>
inline void step_euler(S* q, S* v, const S* u, double step) {
  std::array<S, Scene::kVelocities> accelerations;
  std::array<S, Scene::kPositions> rates;
  const S h(step);
  Scene::accelerations(q, v, u, accelerations.data());
  for (int i = 0; i < Scene::kVelocities; ++i) v[i] = product_plus(h, accelerations[i], v[i]);
  position_rates<Scene>(q, v, rates.data());
  for (int i = 0; i < Scene::kPositions; ++i) q[i] = product_plus(h, rates[i], q[i]);
  for (const auto& quaternion : Scene::kQuaternions) normalize(q + quaternion[0]);
}

inline double lane(double x, int) { return x; }
inline void set_lane(double& x, int, double to) { x = to; }
template <int N>
inline double lane(const Pack<N>& x, int k) {
  return x[k];
}
template <int N>
inline void set_lane(Pack<N>& x, int k, double to) {
  x.set(k, to);
}
template <class S>
struct LaneCount {
  static constexpr int value = 1;
};
template <int N>
struct LaneCount<Pack<N>> {
  static constexpr int value = N;
};

/// One run of a sweep: where it starts, and where and why it ended.
template <class Scene>
struct SweepPoint {
  enum class End { reached, event, not_finite };
  std::array<double, Scene::kPositions> q;
  std::array<double, Scene::kVelocities> v;
  std::array<double, Scene::kInputs> u;
  long steps = 0;  // made; of a run that ends by itself, the one that ended it included
  End end = End::reached;
};

/// Runs all points for `steps` steps of Runge-Kutta, as many at a time as S has lanes. A run ends before where
/// event(q, v), of S, falls below zero, and where a number is no longer finite; its lane goes to the next point, the
/// others see nothing of it. The answers are the same to the bit for any number of lanes.
template <class Scene, class S, class Event>
void sweep(std::vector<SweepPoint<Scene>>& points, double step, long steps, Event&& event) {
  constexpr int lanes = LaneCount<S>::value;
  std::array<S, Scene::kPositions> q;
  std::array<S, Scene::kVelocities> v;
  std::array<S, Scene::kInputs> u;
  std::array<long, lanes> point, done = {};
  long next = 0, running = 0;
  const long count = static_cast<long>(points.size());
  const auto start = [&](int k) {  // a lane that has no work left repeats the last point, unheard
    point[k] = next < count ? next++ : -1;
    running += point[k] >= 0;
    const auto& from = points[point[k] >= 0 ? point[k] : count - 1];
    for (int i = 0; i < Scene::kPositions; ++i) set_lane(q[i], k, from.q[i]);
    for (int i = 0; i < Scene::kVelocities; ++i) set_lane(v[i], k, from.v[i]);
    for (int i = 0; i < Scene::kInputs; ++i) set_lane(u[i], k, from.u[i]);
    done[k] = 0;
  };
  if (count == 0 || steps <= 0) return;
  for (int k = 0; k < lanes; ++k) start(k);
  while (running > 0) {
    step_runge_kutta<Scene>(q.data(), v.data(), u.data(), step);
    S finite(0.0);  // x - x is 0, or NaN
    for (const S& x : q) finite = finite + (x - x);
    for (const S& x : v) finite = finite + (x - x);
    const S sign = event(q.data(), v.data());
    for (int k = 0; k < lanes; ++k) {
      if (point[k] < 0) continue;
      ++done[k];
      const bool lost = lane(finite, k) != 0,  // NaN differs from all
          met = lane(sign, k) < 0;
      if (!lost && !met && done[k] < steps) continue;
      auto& to = points[point[k]];
      for (int i = 0; i < Scene::kPositions; ++i) to.q[i] = lane(q[i], k);
      for (int i = 0; i < Scene::kVelocities; ++i) to.v[i] = lane(v[i], k);
      to.steps = done[k];
      using End = typename SweepPoint<Scene>::End;
      to.end = lost ? End::not_finite : met ? End::event : End::reached;
      --running;
      start(k);
    }
  }
}

}  // namespace lithe_compiled
