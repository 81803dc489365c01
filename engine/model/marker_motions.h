#pragma once

#include <span>
#include <vector>

#include "engine/model/marker.h"

namespace lithe {

/// The motions of a connector's markers at one state, and the views of them that its evaluate() takes.
class MarkerMotions {
 public:
  /// `motion_of(marker)` gives the MarkerKinematics of one.
  template <class MotionOf>
  MarkerMotions(const std::vector<Marker>& markers, MotionOf&& motion_of) {
    gather(markers, motion_of);
  }
  MarkerMotions() = default;
  /// Others, where these are kept; allocates only for more than there have been.
  template <class MotionOf>
  void gather(const std::vector<Marker>& markers, MotionOf&& motion_of) {
    views_.clear(), kinematics_.clear();
    kinematics_.reserve(markers.size());  // views refer to it
    for (const Marker& m : markers) {
      kinematics_.push_back(motion_of(m));
      views_.emplace_back(kinematics_.back(), static_cast<int>(views_.size()));
    }
  }
  MarkerMotions(const MarkerMotions&) = delete;

  operator std::span<const MarkerView>() const { return views_; }
  const MarkerKinematics& operator[](std::size_t i) const { return kinematics_[i]; }
  std::size_t size() const { return views_.size(); }

 private:
  std::vector<MarkerKinematics> kinematics_;
  std::vector<MarkerView> views_;
};

}  // namespace lithe
