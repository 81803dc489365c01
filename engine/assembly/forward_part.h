#pragma once

#include <memory>

#include "engine/forward/rigid_scene.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

class Evaluator;
class System;

/// Forward dynamics of one evaluator: a kernel for its rigid scene, with the forces that act in it.
class ForwardPart final : public ForwardDynamics {
 public:
  ForwardPart(const System& system, int threads, Evaluator& evaluator)
      : system_(system), threads_(threads), evaluator_(evaluator) {}

  void accelerations(double time, ConstVectorRef q, ConstVectorRef v, VectorRef v_dot) override;
  bool project(double time, VectorRef q, VectorRef v, double tolerance) override;

 private:
  ForwardKernel& kernel();

  const System& system_;
  const int threads_;
  Evaluator& evaluator_;
  std::unique_ptr<ForwardKernel> kernel_;  // once asked for
};

}  // namespace lithe
