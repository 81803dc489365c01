#include "joints/forces/spring_damper.h"

#include "engine/batch_of.h"
#include "engine/checks.h"

namespace lithe {

SpringDamper::SpringDamper(Parameters parameters) : parameters_(parameters), as_drawn_(parameters.natural_length < 0) {
  require::not_negative(parameters.stiffness, "stiffness");
  require::not_negative(parameters.damping, "damping");
  require::finite(parameters.natural_length, "natural_length");
  require::finite(parameters.preload, "preload");
}

void SpringDamper::initialize(std::span<const MarkerView> m) {
  if (as_drawn_) parameters_.natural_length = (m[1].p - m[0].p).norm();
}

template std::unique_ptr<ForceBatch> make_force_batch<SpringDamper>();

}  // namespace lithe
