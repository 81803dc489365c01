#pragma once

#include <algorithm>
#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"

#include "engine/base/math.h"

namespace lithe {

/// Force and torque on a body's frame as they were recorded, linear between samples; the last holds on.
class RecordedWrench final : public Force</*markers=*/1, /*rows=*/0> {
 public:
  struct Parameters {
    double interval = 1;  // s, of the samples, two or more, from t = 0
    Matrix3X force;       // N, world axes
    Matrix3X torque;      // N m, axes of the marker
    Marker marker{};      // that it is recorded for
  };
  explicit RecordedWrench(Parameters parameters) : parameters_(std::move(parameters)) {}

  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const auto& p = parameters_;
    const double place = std::clamp(time / p.interval, 0.0, static_cast<double>(p.force.cols() - 1));
    const auto i = std::min(static_cast<Eigen::Index>(place), p.force.cols() - 2);
    const double s = place - static_cast<double>(i);
    rows.add_load(markers[0], {(1 - s) * p.force.col(i) + s * p.force.col(i + 1),
                               markers[0].R * ((1 - s) * p.torque.col(i) + s * p.torque.col(i + 1))});
  }

 private:
  const Parameters parameters_;
};

}  // namespace lithe
