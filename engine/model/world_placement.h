#pragma once

#include <vector>

#include "engine/base/rotations.h"
#include "engine/model/marker.h"

namespace lithe {

/// Pose of a joint in the world, in the configuration as drawn.
struct WorldFrame {
  Vector3 point{0, 0, 0};   // m
  Vector3 axis{0, 0, 1};    // z of its markers: the axis of the joint; any length
  Vector3 x_axis{0, 0, 0};  // towards x of its markers; zero: as axes_along() takes it
};

/// Both markers of a joint, made at one frame of the world:
///   graph.add<RevoluteJoint>("pin", at_world(crank, rod, {.point = {0.3, 0, 0.1}, .axis = {0, 1, 0}}));
/// For every body with marker_at_world(point, orientation): ground, rigid bodies, point masses, flexible bodies (where
/// they have a node), bodies of plug-ins that have a frame.
template <class A, class B>
std::vector<Marker> at_world(A& first, B& second, const WorldFrame& frame) {
  const Matrix3 axes = axes_along(frame.axis, frame.x_axis);
  return {first.marker_at_world(frame.point, axes), second.marker_at_world(frame.point, axes)};
}

}  // namespace lithe
