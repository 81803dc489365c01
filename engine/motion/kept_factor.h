#pragma once

#include "engine/model/state.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

class Archive;

/// An iteration matrix that an integrator keeps over steps, with the place where it was made: from there it is made
/// again when a run is resumed, with the same bits.
class KeptFactor {
 public:
  /// The equations have been evaluated at (time, q, v), with what `start` remembers (quarter_turns, contacts), and
  /// their residual at (v_dot, lambda): factorises there.
  void make(EquationsOfMotion& equations, const TangentWeights& weights, double time, const State& start,
            ConstVectorRef q, ConstVectorRef v, ConstVectorRef v_dot, ConstVectorRef lambda, const VectorX* increment);
  /// The same, and with complex weights.
  void make_complex(EquationsOfMotion& equations, const TangentWeights& weights, const ComplexTangentWeights& complex,
                    double time, const State& start, ConstVectorRef q, ConstVectorRef v, ConstVectorRef v_dot,
                    ConstVectorRef lambda);
  /// There is none any more.
  void forget() { kind_ = Kind::none; }
  void history(Archive& archive, EquationsOfMotion& equations);

 private:
  enum class Kind { none, real, complex };
  void remember(const TangentWeights& weights, double time, const State& start, ConstVectorRef q, ConstVectorRef v,
                ConstVectorRef v_dot, ConstVectorRef lambda);
  void factorize(EquationsOfMotion& equations) const;

  Kind kind_ = Kind::none;
  TangentWeights weights_{};
  ComplexTangentWeights complex_{};
  State at_;  // where; quarter_turns and contacts as they were recalled
  VectorX increment_;
};

}  // namespace lithe
