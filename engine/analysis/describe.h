#pragma once

#include <string>

#include "engine/assembly/system.h"

namespace lithe {

/// A readable summary of a system: bodies and their coordinates, rows and rank, degrees of freedom, every
/// redundant row with the row it repeats, and each free motion at the start with the velocity that identifies it and
/// the bodies that take part:
///   2 bodies, 14 coordinates, 12 velocities, 11 constraint rows of rank 10, 2 degrees of freedom
///   redundant rows, handled:
///     'guide' row 2 repeats 'pin' row 5
///   free motions at the start:
///     1. rod: omega_y, with slider
/// Throws nothing; from 1500 velocities on free motions are not named (they are found densely).
std::string describe(const System& system);

}  // namespace lithe
