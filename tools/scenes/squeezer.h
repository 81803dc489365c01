#pragma once

#include "engine/model/system_graph.h"

namespace lithe::scenes {

/// Angles of Andrews' squeezing mechanism (R03; Hairer & Wanner II, VII.7), rad.
struct SqueezerAngles {
  double beta, theta, gamma, phi, delta, omega, epsilon;
};
/// Those that the problem starts from.
inline constexpr SqueezerAngles kSqueezerStart{-6.17138900142764485e-2, 0,
                                               4.55279819163070365e-1,  2.22668390165885882e-1,
                                               4.87364979543842558e-1,  -2.22668390165885882e-1,
                                               1.23054744454982123};
struct SqueezerNumbers {
  double mass = 0.07050;            // of K5, kg
  double stiffness = 4530;          // N/m
  double natural_length = 0.07785;  // m
  double torque = 0.033;            // N m, on the crank
};
struct SqueezerPoints {
  Marker F, E, G, H;
};
/// Bodies K1 to K7, in this order; each one's x axis lies at the sum of angles that turns it.
SqueezerPoints draw_squeezer(SystemGraph& graph, const SqueezerAngles& at, const SqueezerNumbers& numbers = {});

}  // namespace lithe::scenes
