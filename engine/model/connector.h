#pragma once

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "engine/model/element.h"
#include "engine/model/marker.h"

namespace lithe {

/// An angle that a connector measures and whose whole turns the engine counts: about axis `axis` of its marker
/// number A, from the next axis (z: from x) to that of marker B, or to the point of B.
struct MeasuredAngle {
  int A, B, axis;
  bool to_point = false;
};

/// The engine's memory of a connector's angles, for one evaluation.
class AngleMemory {
 public:
  /// The angle of place `i` in angles(), with the whole turns that it has made since the drawing; rad. Right as long as
  /// it moves by less than half a turn a step.
  double wound(int i, double angle) const {
    if (!quarter_turns_) return angle;
    return angle + 2 * std::numbers::pi * std::round((quarter_turns_[i] - angle * 2 / std::numbers::pi) / 4);
  }
  /// The engine's side: quarter turns that the angles have passed since they were zero, null for no memory.
  void recall(const double* quarter_turns) { quarter_turns_ = quarter_turns; }
  const double* quarter_turns() const { return quarter_turns_; }

 private:
  const double* quarter_turns_ = nullptr;
};

/// An element between markers: a constraint, a force element or a contact.
class Connector : public Element {
 public:
  ~Connector() override;
  virtual int marker_count() const = 0;
  /// Called by assemble() with the markers as drawn, to set values taken from the drawing (a distance, an offset).
  /// Again by each graph that shares the element (Simplification, islands): what it sets must depend on the markers
  /// alone.
  virtual void initialize(std::span<const MarkerView> /*markers*/) {}
  /// Angles whose turns are to be counted; asked once, by assemble().
  virtual std::vector<MeasuredAngle> angles() const { return {}; }

  /// As given to SystemGraph::add.
  const std::vector<Marker>& markers() const { return markers_; }

 private:
  friend class SystemGraph;
  std::vector<Marker> markers_;
};

}  // namespace lithe
