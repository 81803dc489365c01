#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "engine/model/appearance.h"
#include "engine/model/contact_element.h"
#include "joints/contact/laws.h"
#include "joints/contact/shapes.h"

namespace lithe {

/// A shape on a body (at a marker of it). Colliders of one body never touch each other.
struct Collider {
  Marker marker;
  Shape shape;
  int group = 0;                      // 0 ... 31
  std::uint32_t meets = 0xffffffffu;  // groups that it can touch, one bit each; both colliders of a pair must agree
};
/// Bits of some groups: meets = groups({0, 2}).
std::uint32_t groups(std::initializer_list<int> numbers);

/// Rigid surfaces: impulses that keep them apart. For time stepping (integrators/moreau_jean.h).
struct RigidSurfaces {
  double restitution = 0;    // of Newton
  double rest_speed = 1e-3;  // m/s: below this approach speed they do not bounce
};
/// Surfaces without forces: sensors report where they touch.
struct Sensing {};

/// Contact between any of its colliders, all under one law; different laws: several contacts.
///   graph.add<Contact>("floor", {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
///                      {.law = Compliance{.stiffness = 1e7}, .friction = {.coefficient = 0.3}});
/// With a compliant law it is a force for every integrator; where it touches and parts is located as an event. With
/// RigidSurfaces the friction is Coulomb's own, static_coefficient where surfaces stick and coefficient where they
/// slide; Stribeck's curve and the regularisation are not used. Impacts, meeting and parting are events too. Events are
/// those of up to `located` pairs.
class Contact final : public ContactElement, public DrawableConnector {
 public:
  using Collider = lithe::Collider;
  struct Parameters {
    std::variant<Compliance, RigidSurfaces, Sensing> law = RigidSurfaces{};
    ContactFriction friction{};
    int located = 16;  // events are reported if no more pairs than this can touch
  };
  /// Throws SceneError: fewer than two colliders, a group that there is not, no pair that may meet, bad parameters.
  Contact(std::vector<Collider> colliders, Parameters parameters);

  const std::vector<Collider>& colliders() const { return colliders_; }
  const Parameters& parameters() const { return parameters_; }
  /// Whether two of them can touch.
  bool may_meet(int a, int b) const;

  int marker_count() const override { return static_cast<int>(colliders_.size()); }
  Law law() const override;
  std::unique_ptr<ContactDetector> make_detector() const override;
  ContactLoad load(const ContactMotion& motion) const override;
  bool remembers() const override;
  bool has_moments() const override;
  RigidContact rigid() const override;
  std::vector<std::pair<int, int>> located_pairs() const override;
  std::vector<DrawnShape> drawn_shapes(int marker) const override;

 private:
  const std::vector<Collider> colliders_;
  const Parameters parameters_;
};

}  // namespace lithe
