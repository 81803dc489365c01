#pragma once

#include "bodies/rigid_body.h"
#include "joints/forces/first_order_states.h"
#include "joints/tyre/tyre.h"
#include "models/read_tir.h"

/// What the tests of tyres drive.
namespace lithe::test {

inline TyreCoefficients car_tyre() { return read_tir(LITHE_EXAMPLE_DATA "/tyres/car.tir"); }

/// The car's without what makes left and right differ, rolling resistance, and the effect of camber on the side force:
/// straight ahead it has no force along the road.
inline TyreCoefficients even_tyre() {
  TyreCoefficients c = car_tyre();
  for (double* x : {&c.phx1, &c.phx2, &c.phy1, &c.phy2, &c.pvy1, &c.pvy2, &c.pvy3, &c.pvy4, &c.pky6,
                    &c.pky7, &c.pey3, &c.pey4, &c.rhx1, &c.rhy1, &c.rby3, &c.rvy1, &c.rvy2, &c.qhz1,
                    &c.qhz2, &c.qdz6, &c.qdz7, &c.qez4, &c.ssz1, &c.qsy1, &c.qsy2, &c.qsy3, &c.qsy4})
    *x = 0;
  return c;
}

/// Of a wheel that rolls along x: its z axis, the axle, points to the left.
inline Matrix3 axle_left(double heading = 0) {
  return rotation_about({0, 0, 1}, heading) * rotation_about({1, 0, 0}, -std::numbers::pi / 2);
}

/// Deflection under a load, of a wheel that does not turn: F_z0 (q_fz1 r + q_fz2 r²) = load.
inline double sag(const TyreCoefficients& c, double load) {
  const double linear = std::sqrt(std::pow(c.vertical_stiffness * c.unloaded_radius / c.fnomin, 2) - 4 * c.q_fz2);
  const double root = std::sqrt(linear * linear + 4 * c.q_fz2 * load / c.fnomin);
  return c.unloaded_radius * (root - linear) / (2 * c.q_fz2);
}

/// A tyre and the states of its carcass.
inline const Tyre& draw_tyre(SystemGraph& graph, const std::string& name, Marker road, Marker wheel,
                             Tyre::Parameters parameters) {
  auto& carcass = graph.add<FirstOrderStates>(name + " carcass", {.start = VectorX::Zero(3)});
  return graph.add<Tyre>(name, {road, wheel, carcass.point(0)}, std::move(parameters));
}

}  // namespace lithe::test
