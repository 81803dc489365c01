#pragma once

namespace lithe {

/// A force element on more than kMaxMarkers markers, of which each feels the motions of all: Newton's matrix has a
/// block for each two of their frames, which its batch fills.
class CoupledMarkers {
 public:
  virtual ~CoupledMarkers() = default;
};

}  // namespace lithe
