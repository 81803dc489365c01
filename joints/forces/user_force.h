#pragma once

#include <functional>

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"

namespace lithe {

/// Force and torque at a marker by a law of the scene's own: any function of time and of the marker's motion, in world
/// axes. It must depend on nothing else, for the engine asks for it at trial states too.
///   graph.add<UserForce>("wind", {sail.marker()}, {[](double t, const MarkerView& m) { return force({t, 0, 0}); }});
/// Newton sees how it varies with the pose, not with the velocity: a stiff damper is better a SpringDamper.
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
