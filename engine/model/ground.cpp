#include "engine/model/ground.h"

#include "engine/base/checks.h"

namespace lithe {

Marker Ground::marker(const Point& position, const Matrix3& orientation) {
  require::at("ground", [&] {
    require::finite(position.at, "marker position");
    require::rotation(orientation, "marker orientation");
  });
  markers_.push_back({position.at, orientation});
  return new_marker();
}

void Ground::marker_kinematics(const BodyState& state, int marker, Level, MarkerKinematics& k) const {
  k.p = k.r = markers_[marker].position;
  k.R = markers_[marker].orientation;
  k.v = k.w = k.bias_v = k.bias_w = Vector3::Zero();
  k.A = &state.cache->A;
  k.elastic = nullptr;
}

}  // namespace lithe
