#pragma once

#include "engine/model/body.h"

namespace lithe {

/// A body that has a place, or places, and no axes: a point mass, a cable. Its markers keep their directions in the
/// world and bear forces alone: a moment on it would turn nothing, and a joint that held its axes would hold the other
/// body against the world. assemble() refuses both.
class PointBody : public Body {};

}  // namespace lithe
