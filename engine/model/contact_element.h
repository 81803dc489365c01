#pragma once

#include <memory>
#include <utility>

#include "engine/model/connector.h"
#include "engine/model/contact_point.h"

namespace lithe {

/// Motion at a contact point in its frame: axis 0 along the normal, from A to B, axes 1 and 2 across.
struct ContactMotion {
  double gap = 0;           // m
  double curvature = 0;     // 1/m
  Vector3 velocity;         // of B's material point relative to A's, m/s; [0]: rate of the gap
  Vector3 spin;             // of B relative to A, rad/s
  Vector3 slip;             // that motion across the normal since the last accepted state, m; [0] is zero
  Vector3 bristle;          // deflection at that state, m
  double impact_speed = 0;  // with which the surfaces met, m/s; 0: they meet now
};

/// Load of a contact law on B, about the point, in the contact's frame; the opposite acts on A.
struct ContactLoad {
  Vector3 force, moment;  // N, N m; force[0] >= 0: surfaces push
  double energy = 0;      // stored, J
  Vector3 bristle;        // new deflection, m
};

/// Parameters of contact between rigid surfaces.
struct RigidContact {
  double restitution = 0;      // of Newton: normal speed after over that before, reversed
  double rest_speed = 0;       // m/s: below this approach speed they do not bounce
  double friction = 0;         // Coulomb's μ, of surfaces that slide
  double static_friction = 0;  // of those that do not, at least as much
  double rolling = 0;          // m: largest rolling moment over normal force
  double spinning = 0;         // m: largest moment about the normal over normal force
};

/// Surfaces that push where they touch: one marker per collider. A kind of its own beside constraints and force
/// elements: its contact points are found again at every state, and loads act at them instead of at its markers. Its
/// angles are not counted, and initialize() is not called. User's type: joints/contact/contact.h.
class ContactElement : public Connector {
 public:
  enum class Law {
    compliant,  // a force of depth and velocity: any integrator
    rigid,      // impulses that keep surfaces apart: time stepping (integrators/moreau_jean.h) alone
    sensing,    // none
  };
  virtual Law law() const = 0;
  virtual std::unique_ptr<ContactDetector> make_detector() const = 0;
  /// Of a compliant law.
  virtual ContactLoad load(const ContactMotion& motion) const = 0;
  /// Whether that load knows slip, bristle or impact speed.
  virtual bool remembers() const = 0;
  /// Whether moments resist rolling and spinning: six rows a point instead of three.
  virtual bool has_moments() const = 0;
  /// Of a rigid law.
  virtual RigidContact rigid() const = 0;
  /// Pairs of colliders whose touches, separations and impacts simulations report as events.
  virtual std::vector<std::pair<int, int>> located_pairs() const = 0;
};

}  // namespace lithe
