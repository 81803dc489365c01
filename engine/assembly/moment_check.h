#pragma once

#include <span>
#include <vector>

#include "engine/model/body.h"

namespace lithe {

class Constraint;
class ForceElement;

/// Throws SceneError if the connector, whose markers are drawn so, may load a PointBody with a moment. Contacts are not
/// asked: their friction acts at the point of contact, and the body slides there.
void refuse_moments(const Constraint& joint, std::span<const Marker> markers, std::vector<MarkerKinematics> drawn);
void refuse_moments(const ForceElement& force, std::span<const Marker> markers, std::vector<MarkerKinematics> drawn);

}  // namespace lithe
