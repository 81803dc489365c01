#include "joints/forces/spring_damper.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

SpringDamper::SpringDamper(Parameters parameters)
    : parameters_(parameters), natural_length_(parameters.natural_length.value_or(0.0)) {
  parameters.stiffness.require(require::not_negative, "stiffness");
  parameters.damping.require(require::not_negative, "damping");
  if (parameters.natural_length) parameters.natural_length->require(require::not_negative, "natural_length");
  parameters.preload.require_finite("preload");
}

void SpringDamper::initialize(std::span<const MarkerView> m) {
  const double length = (m[1].p - m[0].p).norm();
  natural_length_ = parameters_.natural_length.value_or(length);
  // In one place a tension has no line to act along. Without one the force k d + c ḋ is the same along every line.
  if (length > 1e-12 * (1 + m[0].p.norm() + m[1].p.norm())) return;
  const double stretch = parameters_.natural_length ? -natural_length_.at(0) : 0;
  const double tension = parameters_.stiffness.at(0) * stretch + parameters_.preload.at(0) +
                         (parameters_.law ? parameters_.law(stretch, 0).force : 0);
  if (tension == 0) return;
  throw SceneError(
      "its markers are in one place as drawn, where its tension of " + std::to_string(tension) + " N has no direction",
      "", "draw the markers apart, or give a natural_length of 0 and no preload; for forces along axes a Bushing");
}

template std::unique_ptr<ForceBatch> make_force_batch<SpringDamper>();

}  // namespace lithe
