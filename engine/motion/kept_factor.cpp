#include "engine/motion/kept_factor.h"

#include "engine/archive/archive.h"
#include "engine/base/error.h"

namespace lithe {

void KeptFactor::remember(const TangentWeights& weights, double time, const State& start, ConstVectorRef q,
                          ConstVectorRef v, ConstVectorRef v_dot, ConstVectorRef lambda) {
  weights_ = weights;
  at_.time = time;
  at_.q = q, at_.v = v, at_.v_dot = v_dot, at_.lambda = lambda;
  at_.quarter_turns = start.quarter_turns;
  at_.contacts = start.contacts;
}

void KeptFactor::make(EquationsOfMotion& equations, const TangentWeights& weights, double time, const State& start,
                      ConstVectorRef q, ConstVectorRef v, ConstVectorRef v_dot, ConstVectorRef lambda,
                      const VectorX* increment) {
  remember(weights, time, start, q, v, v_dot, lambda);
  kind_ = Kind::real;
  if (increment)
    increment_ = *increment;
  else
    increment_.resize(0);
  factorize(equations);
  equations.memory().track_rows(at_.left_out);
}

void KeptFactor::make_complex(EquationsOfMotion& equations, const TangentWeights& weights,
                              const ComplexTangentWeights& complex, double time, const State& start, ConstVectorRef q,
                              ConstVectorRef v, ConstVectorRef v_dot, ConstVectorRef lambda) {
  remember(weights, time, start, q, v, v_dot, lambda);
  kind_ = Kind::complex;
  complex_ = complex;
  increment_.resize(0);
  factorize(equations);
  equations.memory().track_rows(at_.left_out);
}

void KeptFactor::factorize(EquationsOfMotion& equations) const {
  const VectorX* increment = increment_.size() > 0 ? &increment_ : nullptr;
  equations.factorize(weights_, at_.v_dot, at_.lambda, increment);
  if (kind_ == Kind::complex)
    equations.parts().complex_factor->factorize_complex(complex_, at_.v_dot, at_.lambda, increment);
}

void KeptFactor::history(Archive& archive, EquationsOfMotion& equations) {
  archive.group("factor", [&] {
    archive("kind", kind_);
    if (kind_ == Kind::none) return;
    archive("position", weights_.position);
    archive("velocity", weights_.velocity);
    archive("acceleration", weights_.acceleration);
    std::array<double, 6> parts{complex_.position.real(), complex_.position.imag(),     complex_.velocity.real(),
                                complex_.velocity.imag(), complex_.acceleration.real(), complex_.acceleration.imag()};
    archive("complex", parts);
    complex_ = {{parts[0], parts[1]}, {parts[2], parts[3]}, {parts[4], parts[5]}};
    archive("at", at_);
    archive("increment", increment_);
    if (!archive.loads()) return;
    const Layout& layout = equations.layout();
    if (at_.q.size() != layout.q_count() || at_.v.size() != layout.v_count() || at_.v_dot.size() != layout.v_count() ||
        at_.lambda.size() != layout.row_count() || (increment_.size() > 0 && increment_.size() != layout.v_count()))
      throw FileError("the checkpoint's factor does not fit the scene", archive.source(), "resume from an older one");
    equations.memory().recall(at_.quarter_turns);
    equations.memory().recall_rows(at_.left_out);
    equations.memory().recall(at_.contacts);
    equations.evaluate(at_.time, at_.q, at_.v, Level::velocity);
    VectorX unused(at_.v.size());
    equations.residual(at_.v_dot, at_.lambda, unused);
    factorize(equations);
  });
}

}  // namespace lithe
