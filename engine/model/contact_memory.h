#pragma once

#include <tuple>
#include <vector>

#include "engine/model/contact_point.h"

namespace lithe {

/// Memory of a contact point from one accepted state to the next: plain data, part of State. Sorted by element, A, B
/// (colliders) and feature.
struct ContactTrace {
  int element = 0;          // of the graph's contact elements
  ContactPoint point;       // as it was found
  Vector3 force, moment;    // on B, about the position, world axes, N, N m; rigid contacts: their mean over the step
  Vector3 on_A, on_B;       // what was in touch: the position in the axes of either side; rigid contacts: on_A has how
                            // fast they slid at the last step's start and end, m/s
  Vector3 bristle;          // deflection of the bristles, world axes, m; rigid contacts: velocity of B to A, m/s
  double impact_speed = 0;  // with which the surfaces met, m/s
};
using ContactMemory = std::vector<ContactTrace>;

/// By which traces are sorted, and points found again.
inline auto contact_key(int element, const ContactPoint& point) {
  return std::tuple(element, point.A.collider, point.B.collider, point.feature);
}

}  // namespace lithe
