#include "engine/run/kinks.h"

#include "engine/contact/contact_forces.h"
#include "engine/observe/sensors.h"

namespace lithe {
namespace {

/// Gap of two colliders, or how far they are from each other at least.
EventFunction gap_of(int element, int a, int b) {
  return [=](Snapshot& now) {
    ContactForces& contacts = *now.contacts();
    const double size = contacts.extent(element, a) + contacts.extent(element, b);
    return contacts.gap(element, a, b, size > 0 ? size : 1.0);
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
