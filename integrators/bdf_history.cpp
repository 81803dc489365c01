#include "integrators/bdf_history.h"

#include <algorithm>
#include <numeric>

#include "engine/archive/archive.h"
#include "engine/base/error.h"

namespace lithe {

void BdfHistory::reset(const Layout& layout, double time, const VectorX& q) {
  size_ = 0;
  std::iota(columns_.begin(), columns_.end(), 0);
  base_time_ = time;
  base_ = q;
  q_.setZero(layout.q_count(), kCapacity);
  d_.setZero(layout.v_count(), kCapacity);
  v_.setZero(layout.v_count(), kCapacity);
  lambda_.setZero(layout.row_count(), kCapacity);
}

void BdfHistory::push(double time, const VectorX& q, const VectorX& d, const VectorX& v, const VectorX& lambda) {
  std::rotate(columns_.begin(), columns_.end() - 1, columns_.end());
  size_ = std::min(size_ + 1, kCapacity);
  const int at = columns_[0];
  times_[at] = time;
  q_.col(at) = q;
  d_.col(at) = d;
  v_.col(at) = v;
  lambda_.col(at) = lambda;
}

void BdfHistory::drop(int point) {
  std::rotate(columns_.begin() + point, columns_.begin() + point + 1, columns_.begin() + size_);
  --size_;
}

void BdfHistory::recentre(const Layout& layout) {
  base_time_ = time(0);
  base_ = q_.col(columns_[0]);
  for (int i = 0; i < size_; ++i) layout.difference(base_, q_.col(columns_[i]), d_.col(columns_[i]));
}

void BdfHistory::history(Archive& archive) {
  archive("points", size_);
  archive("columns", columns_);
  archive("times", times_);
  archive("base_time", base_time_);
  archive("base", base_);
  archive("q", q_);
  archive("d", d_);
  archive("v", v_);
  archive("lambda", lambda_);
  const bool sound = size_ >= 0 && size_ <= kCapacity &&
                     std::all_of(columns_.begin(), columns_.end(), [](int c) { return c >= 0 && c < kCapacity; });
  if (!sound)
    throw FileError("the checkpoint's multistep history is damaged", archive.source(), "resume from an older one");
}

void BdfHistory::extrapolation_weights(double t, int order, Weights& w) const {
  w[0] = 0;
  for (int i = 1; i <= order + 1; ++i) {
    w[i] = 1;
    for (int j = 1; j <= order + 1; ++j)
      if (j != i) w[i] *= (t - time(j - 1)) / (time(i - 1) - time(j - 1));
  }
}

void BdfHistory::error_weights(double t, int order, Weights& w) const {
  double c = 0;
  for (int i = 0; i < order; ++i) c += 1 / (t - time(i));
  const double share = 1 / (1 + c * (t - time(order)));
  extrapolation_weights(t, order, w);
  for (int i = 1; i <= order + 1; ++i) w[i] *= -share;
  w[0] = share;
}

void BdfHistory::combine(const MatrixX& of, const Weights& w, int count, VectorX& out) const {
  out.setZero();
  for (int i = 0; i < count; ++i) out += w[i + 1] * of.col(columns_[i]);
}

}  // namespace lithe
