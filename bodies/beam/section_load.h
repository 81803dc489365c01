#pragma once

#include "bodies/beam/beam.h"
#include "bodies/beam/slender_body.h"

namespace lithe {

/// (n, m) at any section of a beam: force (N) and moment (N m) of the part behind on the part before, about the
/// section's origin and in its axes; damping included. Each element has them best in its middle; between (and up to the
/// ends) the line through the middles of the two nearest elements that no station separates: at `Parameters::stations`,
/// where large loads act, they may jump (at a station itself: the values behind it). An element alone between stations
/// has a constant force, whose arm makes the moment linear. The error is of second order in the length of the elements.
/// SceneError beyond the ends.
Vector6 section_load(const Beam& beam, const BodyState& state, double arc);
/// The same as a sensor: n_1 … n_3 (N), m_1 … m_3 (N m).
Sensor section_load(const Beam& beam, double arc, Located name = "");

/// Of a slender body by its present model: as above of the exact beam. Reduced, by what its modes in use strain its
/// elements, linear in them: bending under loads that the modes follow; the axial force that spin or weight put on
/// a body of bending modes is not in them. Rigid: zero.
Vector6 section_load(const SlenderBody& body, const BodyState& state, double arc);
/// The same as a sensor; it follows SlenderBody::set_fidelity().
Sensor section_load(const SlenderBody& body, double arc, Located name = "");

}  // namespace lithe
