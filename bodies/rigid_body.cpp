#include "bodies/rigid_body.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

RigidBody::RigidBody(Parameters parameters)
    : RigidFrameBody({parameters.mass, parameters.inertia.matrix},
                     {{parameters.position, parameters.orientation}, parameters.velocity, parameters.angular_velocity}),
      parameters_(std::move(parameters)) {
  require::positive(parameters_.mass, "mass");
  require::inertia(parameters_.inertia.matrix, "inertia");
  require::finite(parameters_.position, "position");
  require::rotation(parameters_.orientation, "orientation");
  require::finite(parameters_.velocity, "velocity");
  require::finite(parameters_.angular_velocity, "angular_velocity");
}

Marker RigidBody::marker(const Point& position, const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(), [&] {
    require::finite(position.at, "marker position");
    require::rotation(orientation, "marker orientation");
  });
  return place_marker(position.at, orientation);
}

Marker RigidBody::marker_at_world(const Point& point, const Matrix3& orientation) {
  const Matrix3 to_body = parameters_.orientation.transpose();
  return marker(to_body * (point.at - parameters_.position), to_body * orientation);
}

template std::unique_ptr<BodyBatch> make_body_batch<RigidBody>();

}  // namespace lithe
