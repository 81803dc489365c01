#include "engine/run/driven_oscillator.h"

#include <cmath>

namespace lithe {

OscillatorState driven(const OscillatorState& start, double w2, double d, double force_then, double force, double h) {
  const double slope = (force - force_then) / h, lag = d * slope / (w2 * w2);
  const double z = start.z - (force_then / w2 - lag), rate = start.rate - slope / w2;
  const double s = d / 2, inner = w2 - s * s, root = std::sqrt(std::abs(inner)), decay = std::exp(-s * h);
  double c = decay, r = decay * h;  // decay times cos and sin / root of what oscillates
  if (inner > 1e-14 * w2) {
    c = decay * std::cos(root * h), r = decay * std::sin(root * h) / root;
  } else if (inner < -1e-14 * w2) {
    const double slow = std::exp((root - s) * h), fast = std::exp((-root - s) * h);
    c = (slow + fast) / 2, r = (slow - fast) / (2 * root);
  }
  return {force / w2 - lag + (c + s * r) * z + r * rate, slope / w2 - w2 * r * z + (c - s * r) * rate};
}

}  // namespace lithe
