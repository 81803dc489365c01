#include "engine/plugin.h"

using namespace lithe;

/// Massless rod with a ball at each end: the markers keep their distance; five freedoms are left.
///   g = ½ (d·d − ℓ²),   ġ = d·ḋ,   bias = ḋ·ḋ,   where d = p_B − p_A
/// Its multiplier is the rod's tension over ℓ.
class MasslessRod final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    double length = 1.0;  // ℓ, metres
  };
  static constexpr Field<Parameters> kParameters[] = {{"length", &Parameters::length}};
  explicit MasslessRod(Parameters parameters) : length_(parameters.length) { require::positive(length_, "length"); }

  void evaluate(double /*time*/, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    const Vector3 d = B.p - A.p, d_dot = B.v - A.v;
    rows.add(0.5 * (d.dot(d) - length_ * length_), {force(-d), force(d)}, d_dot.dot(d_dot));
  }

 private:
  const double length_;
};

LITHE_EXPORT_JOINT(MasslessRod, "massless_rod")
