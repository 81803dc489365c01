#pragma once

namespace lithe {

/// z and ż of an oscillator.
struct OscillatorState {
  double z = 0, rate = 0;
};

/// Where z̈ + d ż + w² z = f is after a time h, f linear over it from `force_then` to `force`: exact. The quasi-static
/// part, about which the rest moves freely, is f/w² - d ḟ/w⁴. w² > 0.
OscillatorState driven(const OscillatorState& start, double w2, double d, double force_then, double force, double h);

}  // namespace lithe
