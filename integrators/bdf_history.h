#pragma once

#include <array>

#include "engine/model/layout.h"

namespace lithe {

class Archive;

/// The past of a multistep method: points (t, q, v, λ), newest first, all in one chart, q = base ⊕ d; and weights of
/// the polynomials through them, for steps of any lengths.
class BdfHistory {
 public:
  static constexpr int kCapacity = 7;
  using Weights = std::array<double, kCapacity + 1>;

  /// Empties it; q, at this time, is the base. Allocates.
  void reset(const Layout& layout, double time, const VectorX& q);
  void push(double time, const VectorX& q, const VectorX& d, const VectorX& v, const VectorX& lambda);
  void drop(int point);
  /// Takes the newest point as base.
  void recentre(const Layout& layout);
  void history(Archive& archive);

  int size() const { return size_; }
  double time(int point) const { return times_[columns_[point]]; }
  auto d(int point) const { return d_.col(columns_[point]); }
  auto v(int point) const { return v_.col(columns_[point]); }
  const VectorX& base() const { return base_; }
  double base_time() const { return base_time_; }

  /// p'(t) = Σ w_i y_i of the polynomial through y_0 at t and the `order` newest points y_1, y_2, …
  void derivative_weights(double t, int order, Weights& w) const {
    derivative_weights(
        t, order, [this](int point) { return time(point); }, w);
  }
  template <class Time>
  static void derivative_weights(double t, int order, const Time& time, Weights& w) {
    w[0] = 0;
    for (int i = 1; i <= order; ++i) {
      const double from = t - time(i - 1);
      w[0] += 1 / from;
      w[i] = -1 / from;
      for (int j = 1; j <= order; ++j)
        if (j != i) w[i] *= (t - time(j - 1)) / (time(i - 1) - time(j - 1));
    }
  }
  /// p(t) = Σ w_i y_i of the polynomial through the `order` + 1 newest points y_1, y_2, …; w_0 = 0.
  void extrapolation_weights(double t, int order, Weights& w) const;
  /// Local error Σ w_i y_i of a BDF step of this order that ended with y_0 at t, from the `order` + 1 newest points:
  /// with Ψ_i = t - t_i and c = p' weight of y_0, (y_0 - extrapolation)/(1 + c Ψ_{order + 1}).
  void error_weights(double t, int order, Weights& w) const;

  /// out = Σ w_i d_i over `count` points, and the same of v and λ.
  void combine_d(const Weights& w, int count, VectorX& out) const { combine(d_, w, count, out); }
  void combine_v(const Weights& w, int count, VectorX& out) const { combine(v_, w, count, out); }
  void combine_lambda(const Weights& w, int count, VectorX& out) const { combine(lambda_, w, count, out); }

 private:
  void combine(const MatrixX& of, const Weights& w, int count, VectorX& out) const;

  int size_ = 0;
  std::array<int, kCapacity> columns_{};  // of the points, newest first
  std::array<double, kCapacity> times_{};
  double base_time_ = 0;
  VectorX base_;
  MatrixX q_, d_, v_, lambda_;  // a column a point
};

}  // namespace lithe
