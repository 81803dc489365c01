#pragma once

#include "engine/model/body.h"

namespace lithe {

/// A body that is nowhere: a number with equations of its own, as the integral in a controller or the way that a rope
/// has passed over a pulley. Its markers carry that number; pages draw neither it nor a line to it.
class PlacelessBody : public Body {
 public:
  /// Whether its rates are those of masses. States of equations have no energy, and forces on them no power.
  virtual bool has_energy() const { return true; }
};

}  // namespace lithe
