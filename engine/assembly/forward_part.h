#pragma once

#include <memory>

#include "engine/forward/rigid_scene.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

class Evaluator;

/// Forward dynamics of one evaluator: a kernel for its rigid scene, with the forces that act in it.
class ForwardPart final : public ForwardDynamics {
 public:
  ForwardPart(const RigidScene& scene, Evaluator& evaluator) : scene_(scene), evaluator_(evaluator) {}

  void accelerations(double time, ConstVectorRef q, ConstVectorRef v, VectorRef v_dot) override;
  bool project(double time, VectorRef q, VectorRef v, double tolerance) override;

 private:
  ForwardKernel& kernel();

  const RigidScene& scene_;
  Evaluator& evaluator_;
  std::unique_ptr<ForwardKernel> kernel_;  // once asked for
};

}  // namespace lithe
