#include "engine/run/kinks.h"

#include <cmath>
#include <limits>

#include "engine/contact/contact_forces.h"
#include "engine/observe/sensors.h"

namespace lithe {
namespace {

/// Gap of two colliders, or how far they are from each other at least; 0 within its round-off: surfaces that start in
/// touch would meet at every step whose gap has the other sign by its last digits.
EventFunction gap_of(int element, int a, int b) {
  return [=](Snapshot& now) {
    ContactForces& contacts = *now.contacts();
    const double size = contacts.extent(element, a) + contacts.extent(element, b);
    const double gap = contacts.gap(element, a, b, size > 0 ? size : 1.0);
    const ContactPlaces& places = contacts.places()[element];
    const double scale = size + places.collider(a).p.norm() + places.collider(b).p.norm();
    return std::abs(gap) <= 16 * std::numeric_limits<double>::epsilon() * scale ? 0 : gap;
  };
}

}  // namespace

std::vector<Kink> find_kinks(const System& system) {
  std::vector<Kink> kinks;
  for (const auto& entry : system.graph().forces())
    for (const CoordinateSwitch& s : entry.force->switches())
      kinks.push_back({entry.force->name(), watch(coordinate(s.coordinate, entry.force->name())), s.value});
  for (const ContactRecord& record : system.contacts()) {
    if (record.element->law() != ContactElement::Law::compliant) continue;  // time stepping tells of rigid ones
    for (const auto& [a, b] : record.element->located_pairs())
      kinks.push_back({record.element->name(), gap_of(record.number, a, b), 0, a, b});
  }
  return kinks;
}

}  // namespace lithe
