#pragma once

#include "bodies/beam/slender_body.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {

/// A rod on a hinge, driven off its rest by its first speed; parameters mass, inertia, length, speed.
ParametricScene pendulum();
/// A top on a ball joint that tumbles about all axes; parameters mass, inertia, length, spin.
ParametricScene tumbling_top();
/// Three rods on a table, hinged in a loop with redundant rows, a spring and damper; mass, offset, stiffness, damping.
ParametricScene redundant_loop();
/// A slender rod on a driven hinge: as a beam, with modes, with modes and deflections of second order; thickness, E,
/// density, turn.
ParametricScene driven_rod(const char* name, const Fidelity& fidelity, int elements);
/// Andrews' squeezer (Schiehlen 1990), driven by its motor from rest; mass, stiffness, torque, natural_length.
ParametricScene squeezer();

}  // namespace lithe::test
