#pragma once

#include <vector>

#include "engine/contact/rigid_contacts.h"

namespace lithe {

/// Which coefficient of friction holds at each rigid contact in a step, where the static one is above the kinetic one:
///   - a point that rests as the step begins has the static cone, one that slides the kinetic one;
///   - a point whose slip would turn back within the step has come to rest between, so that it has the static cone;
///   - one that the static cone does not hold has broken away and has the kinetic one. It did so within the step, where
///     the load of its pair, a straight line in time through the middles of this step and the last one, passed the
///     static cone: its coefficient is the mean over the step of what held it before and of the kinetic one after.
/// So a point sticks and slides by what it did before (hysteresis), as Coulomb's law with two coefficients has it, and
/// the time of breaking away is found to second order in the step.
class StaticFriction {
 public:
  /// At the start of a step of h: sets the coefficients of the problem. `last`: impulses of the last step, `growth` as
  /// RigidContacts::recall has it. A contact that moves by less than `at_rest` (m) in a step rests.
  void begin(RigidContacts& contacts, const ContactMemory& memory, const VectorX& last, const VectorX& growth, double h,
             double at_rest);
  /// Looks at impulses that solve the problem: true where they are not of the right coefficients, which the problem has
  /// now. A few times at most.
  bool revise(RigidContacts& contacts, const VectorX& r);
  /// How fast each point slides, m/s; zero where no contact has two coefficients.
  const VectorX& slip_at_start() const { return start_; }
  const VectorX& slip_at_end() const { return end_; }
  /// A point's slip at the end, where other impulses have taken the place of those looked at last.
  void leave(int point, double slip) {
    if (any_) end_[point] = slip;
  }
  /// What broke away within the step: how long it was held, s (0: it did not break away), and by which share of itself
  /// its impulse across differs from what would have held it to the end (negative: it is smaller).
  const VectorX& held_time() const { return held_time_; }
  const VectorX& released() const { return released_; }

 private:
  enum class Phase { equal, slides, sticks, breaks, settled };
  struct Load {  // of the points of one pair in one phase
    Eigen::Vector2d across{0, 0};
    double normal = 0, slip = 0, last_ratio = 0;
  };
  Load load(const RigidContacts& contacts, const VectorX& r, int first, int end, Phase phase) const;
  bool settle(RigidContacts& contacts, int first, int end, Phase phase, double ratio, double last_ratio);

  bool any_ = false;
  double h_ = 0, at_rest_ = 0;  // s, m
  std::vector<Phase> phases_;
  std::vector<char> rested_;       // through the last step
  VectorX earlier_, start_, end_;  // slip at the start of the last step, of this one, at its end
  VectorX held_slip_;              // with the static cone
  VectorX held_time_, released_;
  VectorX last_, growth_, u_;
};

}  // namespace lithe
