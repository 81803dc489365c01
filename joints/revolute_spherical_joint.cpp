#include "joints/revolute_spherical_joint.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"

namespace lithe {

RevoluteSphericalJoint::RevoluteSphericalJoint(Parameters parameters) : as_drawn_(!parameters.length) {
  if (as_drawn_) return;
  require::positive(*parameters.length, "length");
  length_ = *parameters.length;
}

void RevoluteSphericalJoint::initialize(std::span<const MarkerView> m) {
  initial::apart(m[0], m[1]);
  const Vector3 d = m[1].p - m[0].p;
  if (m[0].z().cross(d).norm() < 0.1 * d.norm())
    throw SceneError("its link, from the first marker to the second, lies along the axis of its hinge as drawn", "",
                     "orient the first marker so that its z axis, the hinge, is at right angles to the link");
  if (as_drawn_) length_ = d.norm();
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<RevoluteSphericalJoint>();

}  // namespace lithe
