#pragma once

#include "engine/model/body.h"

namespace lithe {

/// A body with positions and no axes: a point mass, a cable. Its markers keep their directions in the world and
/// transmit forces only: a moment on it would have no effect, and a joint that held its axes would fix the other body's
/// axes in the world. assemble() refuses both.
class PointBody : public Body {};

}  // namespace lithe
