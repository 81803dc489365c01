#pragma once

#include <limits>
#include <tuple>
#include <variant>
#include <vector>

#include "engine/model/contact_point.h"

namespace lithe {

/// What a compliant law keeps of a point.
struct CompliantMemory {
  Vector3 on_A = Vector3::Zero(), on_B = Vector3::Zero();  // what was in touch: the position in the axes of a side, m
  Vector3 bristle = Vector3::Zero();                       // deflection of the bristles, world axes, m
  double impact_speed = 0;                                 // with which the surfaces met, m/s
};

/// What a rigid law keeps of a point: its last step.
struct RigidMemory {
  Vector3 velocity = Vector3::Zero();  // of B's material point relative to A's that the step left, world axes, m/s
  double slip_at_start = std::numeric_limits<double>::quiet_NaN();  // how fast the surfaces slid, m/s; NaN: not known
  double slip_at_end = std::numeric_limits<double>::quiet_NaN();
};

/// Memory of a contact point from one accepted state to the next: plain data, part of State. Sorted by element, A, B
/// (colliders) and feature.
struct ContactTrace {
  int element = 0;        // of the graph's contact elements
  ContactPoint point;     // as it was found
  Vector3 force, moment;  // on B, about the position, world axes, N, N m; rigid contacts: their mean over the step
  std::variant<CompliantMemory, RigidMemory> memory;  // by the element's law
};
using ContactMemory = std::vector<ContactTrace>;

/// By which traces are sorted, and points found again.
inline auto contact_key(int element, const ContactPoint& point) {
  return std::tuple(element, point.A.collider, point.B.collider, point.feature);
}

}  // namespace lithe

// Part of each State that is copied: compiled once, in contact_memory.cpp.
extern template class std::vector<lithe::ContactTrace>;
