#pragma once

#include <algorithm>

#include "engine/assembly/batch.h"
#include "engine/model/placeless_body.h"

namespace lithe {

/// First-order states z of elements (filters, pressures, bristles, imported models) as a body: three of them are the
/// velocity of a point of unit mass without weight, so that a force on it is their derivative and every integrator
/// carries them. Points, not linear coordinates, since Newton's matrix has a full block for each and for each two:
/// ∂ż/∂z need not be symmetric. Marker i is the point of the states 3i to 3i + 2; points without states rest.
///   auto& states = graph.add<FirstOrderStates>("pressures", {.start = z0});
/// An element given `states.point(i)` as its marker m reads z from markers[m].v and sets ż by
/// rows.add_load(markers[m], {ż, 0}).
class FirstOrderStates final : public PlacelessBody {
 public:
  struct Parameters {
    VectorX start{};  // z
  };
  struct Cache : BodyCache {
    explicit Cache(const FirstOrderStates&) {}
  };
  explicit FirstOrderStates(Parameters parameters);

  /// One at least.
  static int points_for(int states) { return std::max(1, (states + 2) / 3); }
  int point_count() const { return points_for(static_cast<int>(start_.size())); }
  Marker point(int i) const { return {this, i}; }
  /// Where state i stands in the body's velocities.
  static int place(int i) { return 6 * (i / 3) + i % 3; }

  Coordinates coordinates() const override { return {.frames = point_count(), .linear = 0}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override;
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState&, const double* v_dot, const Vector3&, double* r) const override;
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                   BodyTangent& tangent) const override;
  void marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const override;
  /// None: states are no motion.
  BodyEnergy energy(const BodyState&, const Vector3&) const override { return {}; }
  bool has_energy() const override { return false; }

 private:
  const VectorX start_;
};

extern template std::unique_ptr<BodyBatch> make_body_batch<FirstOrderStates>();

}  // namespace lithe
