#pragma once

#include <optional>

#include "engine/motion/integrator.h"
#include "engine/motion/projection.h"
#include "engine/motion/step_derivative.h"
#include "integrators/contact_impulses.h"
#include "integrators/joint_friction_impulses.h"
#include "integrators/reaction_states.h"

namespace lithe {

/// Time stepping for scenes with contacts of rigid surfaces (Moreau 1999; Jean 1999): velocities may jump, impulses of
/// contact are found together with Coulomb's cone at each step, none is missed however many there are. The motion
/// without contact is the linearly implicit midpoint rule in the stabilized index-2 form,
///   [S Gᵀ; G 0] (v_free - v, Λ) = (h f, -ġ),   S = M + h/2 D + h²/4 K  at q ⊕ h/2 v,   d = h/2 (v + v_free),
/// then contact (integrators/contact_impulses.h), then joints are closed along the same factor. Fixed step, no Newton
/// iteration but for bodies with linear coordinates, since stiff elements that turn are not linear in a step: some two
/// corrections, twenty at most, to what closes joints too; for bodies in nodal coordinates with the mean of the forces
/// along the step, which keeps their energy. A step whose corrections do not end is halved. A step ends early where few
/// rigid bodies meet, so that their impact is at its end. Order 2 between impacts, for bodies that turn while they are
/// held too, and over impacts, but for those of many that share bodies within one step. Stable for stiff springs and
/// modes at any step; it does not damp.
class MoreauJean final : public Integrator, public DifferentiableSteps {
 public:
  struct Parameters {
    double step = 0;  // s; must be given
    ContactImpulses::Parameters contact{};
  };
  /// Solver of impulses: null takes AutomaticConeSolver, sweeps first and the direct solver where they do not do.
  /// Throws SceneError for a step that is not positive.
  explicit MoreauJean(Parameters parameters, std::unique_ptr<ConeSolver> solver = nullptr);

  std::string name() const override { return "Moreau-Jean"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }
  bool handles_rigid_contacts() const override { return true; }
  bool follows_equations() const override { return false; }  // lambda: of the step's impulses
  const ContactImpulses& impulses() const { return impulses_; }
  /// Of steps with the same points open, sticking and sliding. Steps that end early at an impact count with the rest of
  /// theirs as one.
  std::unique_ptr<RepeatedStep> repeated_step(EquationsOfMotion& equations) const override;
  std::string refuse_repetition(EquationsOfMotion& equations) const override;
  bool within_step(const State& state) const override;

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;

 private:
  friend class RepeatedMoreauJean;
  bool correct(EquationsOfMotion& equations, const State& state, double h);
  StepResult halve(EquationsOfMotion& equations, State& state, double time);
  bool settle(EquationsOfMotion& equations, const State& state, double h);
  void close_joints(EquationsOfMotion& equations, double time);

  Parameters parameters_;
  ContactImpulses impulses_;
  JointFrictionImpulses friction_;
  ReactionStates pressed_;
  IntegratorStatistics statistics_;
  std::optional<Projector> projector_;
  VectorX q_, v_, d_, rv_, rl_;
  VectorX lambda_;                        // of the last state that had any; where joints rub by it, of this one
  VectorX mean_, more_, total_, lack_;    // of correct()
  VectorX push_, late_;                   // impulses of contact, and what they have moved beside the mean velocity
  VectorX free_, response_, linear_;      // of settle()
  bool deforms_ = false, nodal_ = false;  // some body; without a frame
};

}  // namespace lithe
