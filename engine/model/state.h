#pragma once

#include <vector>

#include "engine/base/math.h"
#include "engine/model/contact_memory.h"

namespace lithe {

/// A snapshot of a system: plain data, a copy is a snapshot. Slices belong to bodies and constraints by Layout.
struct State {
  double time = 0;  // s
  VectorX q;  // coordinates; a body with a frame has (p, e, eta): metres, unit quaternion w x y z, modal coordinates
  VectorX v;  // velocities (p_dot world axes, omega body axes, eta_dot)
  VectorX v_dot;   // accelerations, as the integrator left them
  VectorX lambda;  // Lagrange multipliers: M v_dot + Gᵀ lambda = f; empty: not found yet (Multipliers)
  VectorX
      quarter_turns;  // that each measured angle of a joint has passed since it was zero: where whole turns are kept
  ContactMemory contacts;     // memory of surfaces in touch; of rigid ones, their action in the last step
  std::vector<int> left_out;  // rows that repeat others here, sorted (EquationsOfMotion::redundant_rows); empty: those
                              // that assemble() found
};

/// Bit for bit, but for the turns of angles.
inline bool same(const State& a, const State& b) {
  const auto equal = [](const VectorX& x, const VectorX& y) { return x.size() == y.size() && x == y; };
  return a.time == b.time && equal(a.q, b.q) && equal(a.v, b.v) && equal(a.v_dot, b.v_dot) && equal(a.lambda, b.lambda);
}

}  // namespace lithe
