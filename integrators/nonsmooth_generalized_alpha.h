#pragma once

#include "integrators/contact_impulses.h"
#include "integrators/generalized_alpha.h"
#include "integrators/joint_friction_impulses.h"
#include "integrators/reaction_states.h"

namespace lithe {

/// The generalized-alpha method with impulses of rigid contacts (Chen, Acary, Virlez & Brüls 2013, in the decoupled
/// form of Cosimo et al. 2020): the smooth motion of each step by GeneralizedAlpha, stabilized index 2, with joints
/// closed in position and velocity and damping of unresolved modes by the spectral radius; then contact
/// (integrators/contact_impulses.h) along S = M + h/2 D + h²/4 K in its middle. For stiff and flexible scenes, where
/// MoreauJean would ring. After a step with impulses the acceleration-like state keeps its distance from
/// v̇, so that what slides or rests for long is of order 2 too. Friction in joints feels contact's impulses
/// (JointFrictionImpulses, ReactionStates).
class NonsmoothGeneralizedAlpha final : public GeneralizedAlpha {
 public:
  struct Parameters {
    double step = 0;               // s; must be given
    double spectral_radius = 0.8;  // at infinite frequency
    ContactImpulses::Parameters contact{};
  };
  /// Solver of impulses: null takes AutomaticConeSolver. Throws SceneError for a step that is not positive, a spectral
  /// radius outside [0, 1).
  explicit NonsmoothGeneralizedAlpha(Parameters parameters, std::unique_ptr<ConeSolver> solver = nullptr);

  std::string name() const override { return "nonsmooth generalized-alpha"; }
  bool handles_rigid_contacts() const override { return true; }
  bool follows_equations() const override { return false; }  // lambda: of the step's impulses
  const ContactImpulses& impulses() const { return impulses_; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;

 private:
  ContactImpulses impulses_;
  JointFrictionImpulses friction_;
  ReactionStates pressed_;
  State start_;
  VectorX v_, d_, q_, rv_, rl_, drift_;
  // Of the smooth motion at the end of a step that jumped: State has the mean over the step there.
  bool jumped_ = false;
  VectorX smooth_v_dot_, smooth_lambda_;
  VectorX no_lambda_;  // the storage of State::lambda while that has none
};

}  // namespace lithe
