#pragma once

namespace lithe {

enum class ContactChange {
  none,
  meeting,  // surfaces touch; rigid ones without an impact
  parting,
  impact,  // of rigid surfaces, faster than their rest_speed
};

/// What happened between two colliders of a contact.
struct ContactEvent {
  ContactChange change = ContactChange::none;
  int a = -1, b = -1;  // places of the colliders in the contact's list
  double speed = 0;    // with which they met, m/s: of an impact
  double impulse = 0;  // along the normal, N s: of an impact
};

}  // namespace lithe
