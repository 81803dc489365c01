#pragma once

#include "engine/model/contact_element.h"
#include "engine/model/contact_memory.h"
#include "engine/observe/sensors.h"

namespace lithe {

// Loads and gaps of contacts at a state. Compliant contacts are evaluated at the state; for rigid ones it is their mean
// force over the step that led to it. Colliders by their place in the contact's list.

/// Force (N) and moment (N m, about the collider's marker) of all contacts of the element on that collider's body,
/// world axes: force_x … moment_z.
Sensor contact_force(const ContactElement& contact, int collider, Located name = "");
/// The same of one pair, on collider b.
Sensor contact_force(const ContactElement& contact, int a, int b, Located name = "");
/// Deepest overlap of a pair, m; 0 where they are apart.
Sensor penetration(const ContactElement& contact, int a, int b, Located name = "");
/// Deepest overlap of all pairs, m.
Sensor penetration(const ContactElement& contact, Located name = "");
/// Gap of a pair, m, negative where they overlap; at most `reach`.
Sensor gap(const ContactElement& contact, int a, int b, double reach, Located name = "");
/// Number of points in touch; also for contacts that only sense.
Sensor contact_count(const ContactElement& contact, Located name = "");
/// J: energy stored by the normal laws of compliant contacts.
Sensor contact_energy(const ContactElement& contact, Located name = "");
/// W: power of the loads of all points on the bodies: minus the rate of the stored energy, minus the dissipated power.
Sensor contact_power(const ContactElement& contact, Located name = "");

/// All points in touch at a snapshot, with their loads.
ContactMemory contacts(Snapshot& now, const ContactElement& contact);

}  // namespace lithe
