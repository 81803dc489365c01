#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <compare>

/// Its functions are found by their arguments: lithe has a namespace log of its own, and formulas that are to serve
/// plain numbers too begin with `using std::log;`.
namespace lithe::dual {

template <int N, class T = double>
struct Dual;
struct InTime;

inline double value_of(double x) { return x; }
double value_of(const InTime& x);
template <int N, class T>
double value_of(const Dual<N, T>& x) {
  return value_of(x.value);
}

/// A number with N derivatives, T itself a number: Dual<12, Dual<12>> has second derivatives too. Formulas written over
/// the scalar are differentiated as they are computed (Griewank & Walther, Evaluating Derivatives, 2008, chapter 3).
template <int N, class T>
struct Dual {
  T value{};
  std::array<T, N> d{};

  Dual() = default;
  Dual(double number) : value(number) {}  // NOLINT: constants are numbers
  Dual(const T& number, const std::array<T, N>& derivatives) : value(number), d(derivatives) {}

  Dual& operator+=(const Dual& b) {
    value += b.value;
    for (int i = 0; i < N; ++i) d[i] += b.d[i];
    return *this;
  }
  Dual& operator-=(const Dual& b) {
    value -= b.value;
    for (int i = 0; i < N; ++i) d[i] -= b.d[i];
    return *this;
  }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator-(Dual a) {
    a.value = -a.value;
    for (T& x : a.d) x = -x;
    return a;
  }
  friend Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend Dual operator+(Dual a, double b) {
    a.value += b;
    return a;
  }
  friend Dual operator+(double a, const Dual& b) { return b + a; }
  friend Dual operator-(const Dual& a, double b) { return a + -b; }
  friend Dual operator-(double a, const Dual& b) { return -b + a; }
  friend Dual operator*(Dual a, double b) {
    a.value = a.value * b;
    for (T& x : a.d) x = x * b;
    return a;
  }
  friend Dual operator*(double a, const Dual& b) { return b * a; }
  friend Dual operator/(const Dual& a, double b) { return a * (1 / b); }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual out;
    out.value = a.value * b.value;
    for (int i = 0; i < N; ++i) out.d[i] = a.d[i] * b.value + a.value * b.d[i];
    return out;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    Dual out;
    const T inverse = T(1.0) / b.value;
    out.value = a.value * inverse;
    for (int i = 0; i < N; ++i) out.d[i] = (a.d[i] - out.value * b.d[i]) * inverse;
    return out;
  }
  /// By value, as what follows from it does in a program.
  friend auto operator<=>(const Dual& a, const Dual& b) { return value_of(a) <=> value_of(b); }
  friend bool operator==(const Dual& a, const Dual& b) { return value_of(a) == value_of(b); }
  /// f(x), from f and its first derivative there; of nested numbers these carry the second.
  template <class First>
  friend Dual chain(const Dual& x, const T& f, const First& first) {
    Dual out;
    out.value = f;
    const T slope = first();
    for (int i = 0; i < N; ++i) out.d[i] = slope * x.d[i];
    return out;
  }
};

/// A number with its first and second derivative by time.
struct InTime {
  double value = 0, rate = 0, acceleration = 0;

  InTime() = default;
  InTime(double number) : value(number) {}  // NOLINT: constants are numbers
  InTime(double x, double x_dot, double x_dotdot) : value(x), rate(x_dot), acceleration(x_dotdot) {}

  InTime& operator+=(const InTime& b) {
    value += b.value, rate += b.rate, acceleration += b.acceleration;
    return *this;
  }
  InTime& operator-=(const InTime& b) {
    value -= b.value, rate -= b.rate, acceleration -= b.acceleration;
    return *this;
  }
  InTime& operator*=(const InTime& b) { return *this = *this * b; }
  InTime& operator/=(const InTime& b) { return *this = *this / b; }

  friend InTime operator-(const InTime& a) { return {-a.value, -a.rate, -a.acceleration}; }
  friend InTime operator+(InTime a, const InTime& b) { return a += b; }
  friend InTime operator-(InTime a, const InTime& b) { return a -= b; }
  friend InTime operator*(const InTime& a, const InTime& b) {
    return {a.value * b.value, a.rate * b.value + a.value * b.rate,
            a.acceleration * b.value + 2 * a.rate * b.rate + a.value * b.acceleration};
  }
  friend InTime operator/(const InTime& a, const InTime& b) {
    const double inverse = 1 / b.value, x = a.value * inverse, x_dot = (a.rate - x * b.rate) * inverse;
    return {x, x_dot, (a.acceleration - 2 * x_dot * b.rate - x * b.acceleration) * inverse};
  }
  friend auto operator<=>(const InTime& a, const InTime& b) { return a.value <=> b.value; }
  friend bool operator==(const InTime& a, const InTime& b) { return a.value == b.value; }
  /// f(x), from f and its first two derivatives there.
  template <class First, class Second>
  friend InTime chain(const InTime& x, double f, const First& first, const Second& second) {
    const double slope = first();
    return {f, slope * x.rate, second() * x.rate * x.rate + slope * x.acceleration};
  }
};

inline double value_of(const InTime& x) { return x.value; }

template <class S>
inline constexpr bool is_differentiated = false;
template <int N, class T>
inline constexpr bool is_differentiated<Dual<N, T>> = true;
template <>
inline constexpr bool is_differentiated<InTime> = true;
template <class S>
concept Differentiated = is_differentiated<S>;

// ---- functions: f, f', f'' of the value x; derivatives are computed where they are asked for ----

// Of plain numbers too, where a formula is written once.
using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::exp, std::log, std::pow, std::sin,
    std::sqrt, std::tan, std::tanh;

#define LITHE_FUNCTION(name, f, first, second)                                               \
  template <int N, class T>                                                                  \
  Dual<N, T> name(const Dual<N, T>& argument) {                                              \
    const T& x = argument.value;                                                             \
    return chain(argument, T(f), [&]() -> T { return first; });                              \
  }                                                                                          \
  inline InTime name(const InTime& argument) {                                               \
    const double x = argument.value;                                                         \
    return chain(                                                                            \
        argument, f, [&]() -> double { return first; }, [&]() -> double { return second; }); \
  }
LITHE_FUNCTION(sqrt, sqrt(x), 0.5 / sqrt(x), -0.25 / (x * sqrt(x)))
LITHE_FUNCTION(sin, sin(x), cos(x), -sin(x))
LITHE_FUNCTION(cos, cos(x), -sin(x), -cos(x))
LITHE_FUNCTION(tan, tan(x), 1.0 + tan(x) * tan(x), 2.0 * tan(x) * (1.0 + tan(x) * tan(x)))
LITHE_FUNCTION(asin, asin(x), 1.0 / sqrt(1.0 - x * x), x / ((1.0 - x * x) * sqrt(1.0 - x * x)))
LITHE_FUNCTION(acos, acos(x), -1.0 / sqrt(1.0 - x * x), -x / ((1.0 - x * x) * sqrt(1.0 - x * x)))
LITHE_FUNCTION(atan, atan(x), 1.0 / (1.0 + x * x), -2.0 * x / ((1.0 + x * x) * (1.0 + x * x)))
LITHE_FUNCTION(exp, exp(x), exp(x), exp(x))
LITHE_FUNCTION(log, log(x), 1.0 / x, -1.0 / (x * x))
LITHE_FUNCTION(tanh, tanh(x), 1.0 - tanh(x) * tanh(x), -2.0 * tanh(x) * (1.0 - tanh(x) * tanh(x)))
LITHE_FUNCTION(abs, x < 0.0 ? -x : x, x < 0.0 ? -1.0 : 1.0, 0)
#undef LITHE_FUNCTION

/// Of a constant power.
template <Differentiated S>
S pow(const S& x, double p) {
  return p == 2 ? x * x : exp(p * log(x));
}
/// The quadrant is that of the values, which are not both zero.
template <Differentiated S>
S atan2(const S& y, const S& x) {
  const double angle = std::atan2(value_of(y), value_of(x));
  // Away from the axis that its quotient blows up at.
  if (std::abs(value_of(x)) >= std::abs(value_of(y))) {
    const S part = atan(y / x);
    return part + (angle - value_of(part));
  }
  const S part = -atan(x / y);
  return part + (angle - value_of(part));
}

}  // namespace lithe::dual

namespace lithe {
using dual::Dual;
using dual::InTime;
}  // namespace lithe

// ---- as Eigen's scalars ----
namespace Eigen {

template <int N, class T>
struct NumTraits<lithe::Dual<N, T>> : NumTraits<double> {
  using Real = lithe::Dual<N, T>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = double;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1 };
  enum { ReadCost = N + 1, AddCost = N + 1, MulCost = 3 * N + 1 };
};
template <>
struct NumTraits<lithe::InTime> : NumTraits<double> {
  using Real = lithe::InTime;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = double;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1 };
  enum { ReadCost = 3, AddCost = 3, MulCost = 8 };
};

template <lithe::dual::Differentiated S, class Operation>
struct ScalarBinaryOpTraits<S, double, Operation> {
  using ReturnType = S;
};
template <lithe::dual::Differentiated S, class Operation>
struct ScalarBinaryOpTraits<double, S, Operation> {
  using ReturnType = S;
};

}  // namespace Eigen
