#pragma once

#include <functional>

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"

namespace lithe {

/// Force and torque at a marker, in world axes, by a function of the scene: any function of time and of the marker's
/// motion. It must depend on nothing else, since the engine evaluates it at trial states too.
///   graph.add<UserForce>("wind", {sail.marker()}, {[](double t, const MarkerView& m) { return force({t, 0, 0}); }});
/// Newton's method uses its derivative by the pose, not by the velocity: for a stiff damper use a SpringDamper.
class UserForce final : public Force</*markers=*/1, /*rows=*/0> {
 public:
  struct Parameters {
    std::function<Wrench(double time, const MarkerView& marker)> law;  // N and N m, world axes
  };

  /// Throws SceneError without a law.
  explicit UserForce(Parameters parameters);

  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    rows.add_load(markers[0], parameters_.law(time, markers[0]));
  }

 private:
  const Parameters parameters_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<UserForce>();

}  // namespace lithe
