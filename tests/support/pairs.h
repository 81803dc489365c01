#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bodies/flexible/reduction.h"
#include "engine/model/system_graph.h"

/// Scenes of two markers on every pairing of bodies, to hang a joint or a force between. A new kind of body joins them
/// by one more entry.
namespace lithe::test {

struct Pair {
  std::string name;
  /// Draws the bodies so that marker B sits at `gap` from marker A, in A's axes, and has the same axes.
  std::function<std::vector<Marker>(SystemGraph&, const Vector3& gap)> draw;
};

/// Ground, rigid bodies, markers that modes move in the most general way, flexible bodies reduced and nodal, the ends
/// of beams and places between their nodes: each as A and as B.
const std::vector<Pair>& pairs();

/// One marker of a new body with that pose in the world, off the body's centre and turned against it.
Marker draw_rigid(SystemGraph& graph, const std::string& name, const Vector3& position, const Matrix3& orientation);
Marker draw_modal(SystemGraph& graph, const std::string& name, const Vector3& position, const Matrix3& orientation,
                  int modes = 3);
/// Off the axis of a straight beam of two elements: at its end, or between nodes.
Marker draw_beam(SystemGraph& graph, const std::string& name, const Vector3& position, const Matrix3& orientation,
                 bool inside);
/// The mean of four nodes of a small finite-element model, reduced to `modes` or nodal (kAllNodal).
Marker draw_flexible(SystemGraph& graph, const std::string& name, const Vector3& position, const Matrix3& orientation,
                     int modes = 4);

}  // namespace lithe::test
