#include "engine/assembly/forward_part.h"

#include "engine/assembly/evaluator.h"
#include "engine/assembly/find_rigid_scene.h"

namespace lithe {

void ForwardPart::accelerations(double time, ConstVectorRef q, ConstVectorRef v, VectorRef v_dot) {
  kernel().accelerations(q.data(), v.data(), evaluator_.applied_forces(time, q, v), v_dot.data());
}

bool ForwardPart::project(double, VectorRef q, VectorRef v, double tolerance) {
  if (!kernel().project(q.data(), v.data(), tolerance)) return false;
  evaluator_.place_measured_angles(q);
  return true;
}

ForwardKernel& ForwardPart::kernel() {
  if (!kernel_) {
    auto scene = find_rigid_scene(system_);
    scene->threads = threads_;
    kernel_ = make_forward_kernel(*scene);
  }
  return *kernel_;
}

}  // namespace lithe
