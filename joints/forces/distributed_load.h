#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/model/motion_law.h"

namespace lithe {

/// A load spread over nodes of a flexible body: pressure, traction, weight of a payload. The body converts a field
/// of nodal forces into at most six forces at weighted means of its nodes, of the same virtual work; see
/// FlexibleBody::nodal_load().
///   const NodalLoad wind = blade.nodal_load(nodes, forces);
///   graph.add<DistributedLoad>("wind", wind.markers, {.forces = wind.forces, .amplitude = ramp(0, 1)});
class DistributedLoad final : public ForceElement {
 public:
  enum class Axes { body, world };
  struct Parameters {
    std::vector<Vector3> forces;  // N, one a marker
    Axes axes = Axes::body;       // the field turns with the body frame, or keeps its direction
    MotionLaw amplitude{};        // factor over time; none: 1
  };
  /// Throws SceneError for no force, more than eight, and for a value that is not finite.
  explicit DistributedLoad(Parameters parameters);

  int marker_count() const override { return static_cast<int>(parameters_.forces.size()); }
  int row_count() const override { return 0; }
  bool depends_on_time() const override { return static_cast<bool>(parameters_.amplitude); }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  const Parameters parameters_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<DistributedLoad>();

}  // namespace lithe
