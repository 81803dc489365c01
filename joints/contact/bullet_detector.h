#pragma once

#include <memory>

#include "engine/model/contact_point.h"

namespace lithe {

class Contact;

/// Finds the points of a contact's shapes by Bullet's trees and distance algorithms; borrows the contact.
std::unique_ptr<ContactDetector> make_bullet_detector(const Contact& contact);

}  // namespace lithe
