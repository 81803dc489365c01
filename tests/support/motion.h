#pragma once

#include <random>

#include "engine/model/layout.h"

/// Random states and smooth motions through them, for checks by differences.
namespace lithe::test {

/// Uniform in [-size, size], the same numbers on every machine.
class RandomNumbers {
 public:
  explicit RandomNumbers(unsigned seed) : engine_(seed) {}
  double number(double size = 1) { return size * (2.0 * (engine_() / 4294967296.0) - 1); }
  VectorX vector(int n, double size = 1) {
    VectorX x(n);
    for (double& value : x) value = number(size);
    return x;
  }
  Vector3 vector3(double size = 1) { return vector(3, size); }
  Matrix3X matrix3x(int n, double size = 1) {
    Matrix3X x(3, n);
    for (int i = 0; i < n; ++i) x.col(i) = vector3(size);
    return x;
  }
  Matrix3 rotation() { return rotation_exp(vector3(2)); }

 private:
  std::mt19937 engine_;
};

/// The motion q(t) = q ⊕ (t v + ½ t² a): it passes through q with velocity v and acceleration a.
struct SmoothMotion {
  const Layout& layout;
  VectorX q, v, a;

  VectorX position(double t) const;
  VectorX velocity(double t) const;
};

/// f'(0) by the four-point difference, error O(h⁴).
template <class F>
auto derivative(F&& f, double h = 7e-4) {
  using Value = std::decay_t<decltype(f(0.0))>;
  return Value((8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h));
}

/// Derivative of f(q) with respect to turns and shifts of q: column j along the j-th velocity.
template <class F>
MatrixX jacobian(const Layout& layout, const VectorX& q, F&& f, double h = 7e-4) {
  MatrixX out;
  for (int j = 0; j < layout.v_count(); ++j) {
    const VectorX column = derivative(
        [&](double t) -> VectorX {
          VectorX moved(q.size());
          layout.retract(q, t * VectorX::Unit(layout.v_count(), j), moved);
          return f(moved);
        },
        h);
    if (j == 0) out.setZero(column.size(), layout.v_count());
    out.col(j) = column;
  }
  return out;
}

}  // namespace lithe::test
