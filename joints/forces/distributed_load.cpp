#include "joints/forces/distributed_load.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

DistributedLoad::DistributedLoad(Parameters parameters) : parameters_(std::move(parameters)) {
  if (parameters_.forces.empty() || static_cast<int>(parameters_.forces.size()) > kMaxMarkers)
    throw SceneError("it has " + std::to_string(parameters_.forces.size()) + " forces", "",
                     "make markers and forces by body.nodal_load(nodes, forces)");
  for (const Vector3& F : parameters_.forces) require::finite(F, "forces");
}

void DistributedLoad::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  const double factor = parameters_.amplitude ? parameters_.amplitude(time).value : 1;
  for (const MarkerView& m : markers) {
    Vector3 F = factor * parameters_.forces[m.index];
    if (parameters_.axes == Axes::body)
      F = m.R * F;
    else if (!parameters_.amplitude)
      rows.add_energy(-F.dot(m.p));
    rows.add_load(m, force(F));
  }
}

template std::unique_ptr<ForceBatch> make_force_batch<DistributedLoad>();

}  // namespace lithe
