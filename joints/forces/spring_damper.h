#pragma once

#include <optional>

#include "engine/assembly/batch.h"
#include "engine/model/adjustable.h"
#include "engine/model/force_element.h"
#include "engine/model/tension_law.h"

namespace lithe {

/// Spring and damper along the line between two markers.
///   σ = k (l - l₀) + c l̇ + σ₀,   l = |p_B - p_A|,   V = ½ k (l - l₀)² + σ₀ (l - l₀);   or σ(l - l₀, l̇) by a law
/// σ > 0 pulls the markers together. A stiffness, damping, natural length or preload may be an Input. If they
/// coincide (l = 0), the line has no direction: the force is taken as zero.
class SpringDamper final : public Force</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    Adjustable stiffness = 0;                    // k, N/m
    Adjustable damping = 0;                      // c, N s/m
    std::optional<Adjustable> natural_length{};  // l₀, m; none: as drawn
    Adjustable preload = 0;                      // σ₀, N: tension at the natural length
    TensionLaw law{};  // added to these: tabulated_spring(...), or a function of stretch and speed
  };

  /// Throws SceneError for a stiffness, damping or natural length that is negative, and for a value that is not finite.
  explicit SpringDamper(Parameters parameters);

  double natural_length(double time = 0) const { return natural_length_.at(time); }

  bool depends_on_time() const override {
    return parameters_.stiffness.varies() || parameters_.damping.varies() || natural_length_.varies() ||
           parameters_.preload.varies();
  }
  void evaluate(double t, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    const double k = parameters_.stiffness.at(t), c = parameters_.damping.at(t), preload = parameters_.preload.at(t);
    const Vector3 d = B.p - A.p;
    const double length = d.norm();
    const Vector3 n = length > 0 ? Vector3(d / length) : Vector3(0, 0, 0);
    const double stretch = length - natural_length_.at(t), speed = n.dot(B.v - A.v);
    const Tension more = parameters_.law ? parameters_.law(stretch, speed) : Tension{};
    rows.add({force(-n), force(n)}, k * stretch + c * speed + preload + more.force, k + more.stiffness,
             c + more.damping, (0.5 * k * stretch + preload) * stretch + more.energy);
  }
  /// Of what its line turns: σ (E - n nᵀ) / l between the ends, σ held. Along the line its row is stiff by itself.
  void add_stiffness(std::span<const MarkerView> markers, const double* tensions, ConstraintRows::Stiffness& K) const {
    const Vector3 d = markers[1].p - markers[0].p;
    const double square = d.squaredNorm();
    if (square == 0) return;
    const Matrix3 across = tensions[0] / std::sqrt(square) * (Matrix3::Identity() - d / square * d.transpose());
    for (const int i : {0, 6})
      for (const int j : {0, 6}) K.block<3, 3>(i, j) += i == j ? across : Matrix3(-across);
  }
  /// Takes the natural length from the drawing if none was given. Refuses markers in one place with a tension there.
  void initialize(std::span<const MarkerView> markers) override;

 private:
  Parameters parameters_;
  Adjustable natural_length_ = 0;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<SpringDamper>();

}  // namespace lithe
