#pragma once

#include <memory>

#include "engine/assembly/system.h"
#include "engine/motion/integrator.h"

namespace lithe {

/// Bullet's own stepper, for comparison: what a game engine's speed costs in accuracy. It moves a copy of the scene, a
/// btDiscreteDynamicsWorld of rigid bodies, by symplectic Euler, a fixed number of sweeps over contacts and joints, and
/// positions pushed back by a part of their error a step. Nothing of it is solved to a tolerance: joints open, and how
/// far surfaces overlap depends on the step. (Catto, Iterative dynamics with temporal coherence, 2005; Bullet 3.24)
///
/// It knows rigid bodies, gravity, contacts under a rigid law (of a body: one contact element, one group), and the
/// joints spherical, revolute, fixed and prismatic. Ground alone may bear half spaces and triangles. Coulomb's cone is
/// Bullet's: one direction a point, along the sliding. Restitution is Bullet's: a gap left when a step begins is taken
/// off the speed, over the step. A body turns by 45 degrees a step at most, faster spins are cut.
/// State::lambda is left empty, State::v_dot is the mean over the step.
class BulletStepper final : public Integrator {
 public:
  enum class Solver {
    sequential_impulse,  // projected Gauss-Seidel
    nncg,                // the same, accelerated by nonlinear conjugate gradients (Silcowitz et al. 2010)
    dantzig,             // direct, for a few bodies
    lemke,               // direct; fails on redundant points (a cube on a plane)
  };
  struct Parameters {
    double step = 1.0 / 240;  // s
    int iterations = 10;      // sweeps; of direct solvers, over what these leave
    Solver solver = Solver::sequential_impulse;
    double margin = 0.04;  // m: hulls and cones are this much larger, boxes and cylinders rounded by it, a tenth of
                           // their half width at most; triangles hold off by it. Of some shapes Bullet lets none rest
                           // on triangles with more than 0.02
    bool split_impulse = true;           // deep overlaps are pushed out without giving speed
    double restitution_threshold = 0.2;  // m/s: closing more slowly bodies do not bounce
  };

  /// Borrows the system. Throws SceneError naming the first element that Bullet's stepper does not support, or a
  /// parameter.
  BulletStepper(const System& system, Parameters parameters);
  BulletStepper(const System&& system, Parameters parameters) = delete;
  ~BulletStepper() override;

  std::string name() const override;
  const IntegratorStatistics& statistics() const override { return statistics_; }
  bool handles_rigid_contacts() const override { return true; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;

 private:
  class World;

  const System& system_;
  const Parameters parameters_;
  std::unique_ptr<World> world_;
  IntegratorStatistics statistics_;
  VectorX q_, v_;
};

}  // namespace lithe
