#include "joints/contact/contact.h"

#include <algorithm>

#include "engine/base/checks.h"
#include "joints/contact/bullet_detector.h"

namespace lithe {

std::uint32_t groups(std::initializer_list<int> numbers) {
  std::uint32_t bits = 0;
  for (int n : numbers) {
    if (n < 0 || n > 31)
      throw SceneError("there is no group " + std::to_string(n), "groups", "number groups from 0 to 31");
    bits |= std::uint32_t{1} << n;
  }
  return bits;
}

Contact::Contact(std::vector<lithe::Collider> colliders, Parameters parameters)
    : colliders_(std::move(colliders)), parameters_(std::move(parameters)) {
  if (colliders_.size() < 2) throw SceneError("has fewer than two colliders", "", "list every shape that may touch");
  for (const lithe::Collider& c : colliders_)
    if (c.group < 0 || c.group > 31)
      throw SceneError("a collider is of group " + std::to_string(c.group), "", "number groups from 0 to 31");
  if (const auto* compliance = std::get_if<Compliance>(&parameters_.law)) check(*compliance);
  if (const auto* rigid = std::get_if<RigidSurfaces>(&parameters_.law)) {
    require::not_negative(rigid->restitution, "restitution");
    if (rigid->restitution > 1)
      throw SceneError("restitution is above 1", "", "give 0 (no bounce) to 1 (all of the speed comes back)");
    require::not_negative(rigid->rest_speed, "rest_speed");
  }
  check(parameters_.friction);
  const int n = static_cast<int>(colliders_.size());
  bool any = false;
  for (int a = 0; a < n && !any; ++a)
    for (int b = a + 1; b < n && !any; ++b) any = may_meet(a, b);
  if (!any)
    throw SceneError("no two of its colliders may meet", "",
                     "put them on different bodies, and let .meets of each hold the other's group");
}

bool Contact::may_meet(int a, int b) const {
  const lithe::Collider &A = colliders_[a], &B = colliders_[b];
  return A.marker.body != B.marker.body && (A.meets >> B.group & 1) && (B.meets >> A.group & 1);
}

ContactElement::Law Contact::law() const { return static_cast<Law>(parameters_.law.index()); }

std::unique_ptr<ContactDetector> Contact::make_detector() const { return make_bullet_detector(*this); }

ContactLoad Contact::load(const ContactMotion& motion) const {
  return compliant_load(std::get<Compliance>(parameters_.law), parameters_.friction, motion);
}

bool Contact::remembers() const {
  const auto* compliance = std::get_if<Compliance>(&parameters_.law);
  return compliance && (parameters_.friction.bristle_stiffness > 0 ||
                        (compliance->restitution < 1 && compliance->dissipation != Dissipation::fixed));
}

bool Contact::has_moments() const { return parameters_.friction.rolling > 0 || parameters_.friction.spinning > 0; }

RigidContact Contact::rigid() const {
  const auto& law = std::get<RigidSurfaces>(parameters_.law);
  const ContactFriction& f = parameters_.friction;
  return {.restitution = law.restitution,
          .rest_speed = law.rest_speed,
          .friction = f.coefficient,
          .static_friction = std::max(f.coefficient, f.static_coefficient),
          .rolling = f.rolling,
          .spinning = f.spinning};
}

std::vector<std::pair<int, int>> Contact::located_pairs() const {
  std::vector<std::pair<int, int>> pairs;
  if (law() == Law::sensing) return pairs;
  const int n = static_cast<int>(colliders_.size());
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b) {
      if (!may_meet(a, b)) continue;
      if (static_cast<int>(pairs.size()) == parameters_.located) return {};
      pairs.emplace_back(a, b);
    }
  return pairs;
}

}  // namespace lithe
