#pragma once

#include <span>

#include "engine/model/force_element.h"

namespace lithe {

/// A force element whose parts load each other, such as the balls of a preloaded bearing: its rows do not show these
/// loads, but their round-off is in what it does to its bodies.
class InternalLoads {
 public:
  virtual ~InternalLoads() = default;
  /// Sum of their sizes at one state, N.
  virtual double internal_load(std::span<const MarkerView> markers, const AngleMemory& memory) const = 0;
};

}  // namespace lithe
