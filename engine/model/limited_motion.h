#pragma once

#include <optional>
#include <span>
#include <string>

#include "engine/model/marker.h"

namespace lithe {

/// A joint whose equations are those of the real one only within limits, beyond which others of their solutions begin.
class LimitedMotion {
 public:
  virtual ~LimitedMotion() = default;
  /// What is beyond its limit at a state that a run has reached: "is bent by 92.1 degrees, beyond its limit of 90".
  virtual std::optional<std::string> beyond_limit(std::span<const MarkerView> markers) const = 0;
};

}  // namespace lithe
