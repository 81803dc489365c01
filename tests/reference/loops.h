#pragma once

#include <vector>

#include "joints/revolute_joint.h"
#include "tests/reference/mechanism.h"

/// Closed loops of the benchmarks, drawn; gravity is 9.81 m/s^2 along -y.
namespace lithe::test {

/// R02: N + 1 uprights (bodies 0 .. N) from ground pins (i, 0) and N couplers, all links 1 m and 1 kg; 3-D hinges about
/// z. Every upright's top starts at 1 m/s along x.
inline void draw_four_bars(SystemGraph& graph, int windows) {
  const auto at = [](double x, double y) { return Vector3(x, y, 0); };
  const auto link = [&](const std::string& name, const Vector3& a, const Vector3& b, double speed_a) {
    return rod(graph, name, a, b, 1, 0, at(speed_a, 0), at(1, 0));
  };
  std::vector<Part> uprights, couplers;
  for (int i = 0; i <= windows; ++i) uprights.push_back(link("upright " + std::to_string(i), at(i, 0), at(i, 1), 0));
  for (int i = 0; i < windows; ++i) couplers.push_back(link("coupler " + std::to_string(i), at(i, 1), at(i + 1, 1), 1));
  for (int i = 0; i <= windows; ++i) {
    const std::string number = std::to_string(i);
    graph.add<RevoluteJoint>("pin " + number, {graph.ground().marker(at(i, 0)), uprights[i].at(at(i, 0))});
    if (i < windows) graph.add<RevoluteJoint>("right " + number, {uprights[i].at(at(i, 1)), couplers[i].at(at(i, 1))});
    if (i > 0) graph.add<RevoluteJoint>("left " + number, {uprights[i].at(at(i, 1)), couplers[i - 1].at(at(i, 1))});
  }
}

/// The same links at rest, exactly flat along x: the rows lose rank by the number of windows, and several motions
/// begin.
inline void draw_flat_four_bars(SystemGraph& graph, int windows) {
  const auto at = [](double x) { return Vector3(x, 0, 0); };
  std::vector<Part> uprights, couplers;
  for (int i = 0; i <= windows; ++i)
    uprights.push_back(rod(graph, "upright " + std::to_string(i), at(i), at(i + 1), 1, 0));
  for (int i = 0; i < windows; ++i)
    couplers.push_back(rod(graph, "coupler " + std::to_string(i), at(i + 1), at(i + 2), 1, 0));
  for (int i = 0; i <= windows; ++i) {
    const std::string number = std::to_string(i);
    graph.add<RevoluteJoint>("pin " + number, {graph.ground().marker(at(i)), uprights[i].at(at(i))});
    if (i < windows)
      graph.add<RevoluteJoint>("right " + number, {uprights[i].at(at(i + 1)), couplers[i].at(at(i + 1))});
    if (i > 0) graph.add<RevoluteJoint>("left " + number, {uprights[i].at(at(i + 1)), couplers[i - 1].at(at(i + 1))});
  }
}

/// R04: rods P1P2 ... P5P6 (bodies 0 .. 4), hinges 1 .. 6; the first and the last on ground. P3 is the second rod's far
/// end, 0.5 m along x from its centre.
inline void draw_bricard(SystemGraph& graph) {
  const Vector3 P[] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};
  const Vector3 axis[] = {Vector3::UnitY(), Vector3::UnitZ(), Vector3::UnitX(),
                          Vector3::UnitY(), Vector3::UnitZ(), Vector3::UnitX()};
  std::vector<Part> rods;
  for (int i = 0; i < 5; ++i) rods.push_back(rod(graph, "rod " + std::to_string(i + 1), P[i], P[i + 1], 1, 0.1));
  for (int i = 0; i < 6; ++i) {
    const Matrix3 axes = axes_with_z(axis[i]);
    const Marker before = i > 0 ? rods[i - 1].at(P[i], axes) : graph.ground().marker(P[i], axes);
    const Marker after = i < 5 ? rods[i].at(P[i], axes) : graph.ground().marker(P[i], axes);
    graph.add<RevoluteJoint>("hinge " + std::to_string(i + 1), {before, after});
  }
}

}  // namespace lithe::test
