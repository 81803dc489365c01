#pragma once

#include <span>
#include <vector>

#include "engine/body.h"

namespace lithe {

class Constraint;
class ForceElement;

/// A body that has a place and no axes. Its markers keep their directions in the world and bear forces alone: a moment
/// on it would turn nothing, and a joint that held its axes would hold the other body against the world. assemble()
/// refuses both.
class PointBody : public Body {};

/// Throws SceneError if the connector, whose markers are drawn so, may load a PointBody with a moment. Contacts are not
/// asked: their friction acts at the point of contact, and the body slides there.
void refuse_moments(const Constraint& joint, std::span<const Marker> markers, std::vector<MarkerKinematics> drawn);
void refuse_moments(const ForceElement& force, std::span<const Marker> markers, std::vector<MarkerKinematics> drawn);

}  // namespace lithe
