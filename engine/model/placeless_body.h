#pragma once

#include "engine/model/body.h"

namespace lithe {

/// A body that is nowhere: a number with equations of its own, as the integral in a controller or the way that a rope
/// has passed over a pulley. Its markers carry that number; pages draw neither it nor a line to it.
class PlacelessBody : public Body {};

}  // namespace lithe
