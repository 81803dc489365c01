#pragma once

#include <algorithm>
#include <memory>
#include <optional>

#include "engine/cones/cone_problem.h"
#include "engine/cones/contact_islands.h"
#include "engine/contact/rigid_contacts.h"
#include "engine/model/state.h"
#include "engine/motion/equations_of_motion.h"
#include "integrators/static_friction.h"

namespace lithe {

class Archive;

/// How rigid surfaces that meet at one time share an impact.
enum class Impacts {
  simultaneous,  // one problem for all, Newton's restitution at each: three equal balls in touch, or so near that their
                 // gaps close within the step, leave with -1/3, 2/3, 2/3
  sequential,    // one pair after another as their gaps close within the step: the limit of small gaps: 0, 0, 1
};

/// The contact part of a time-stepping method (Moreau 1999; Acary & Brogliato 2008): impulses r at the end of a step
/// that was computed without contact, from v to v_free along the displacement d. Impulses act when gaps close: for
/// contact i, whose gap and its rate within the step are known, the impulse of an impact acts for the rest of the step,
/// one that keeps surfaces at rest for half of it: w_i. So
///   v' = v_free + Σ Y r,   d' = d + Σ w_i Y r_across + Σ Y p,   gap' >= aim ⊥ p >= 0,   p near w_i r_normal,
/// where the target gaps are those after a bounce at its time, or zero, and the target of v' is the velocity along H
/// at the step's end. Contacts that hold a body which hits another within the step act up to that time. A ball in free
/// flight bounces at the time of its impact, to round-off; bodies at rest, and bodies hit by others, neither
/// sink nor float. A gap that an impact of others closes takes part in that impact like surfaces in touch, u' >= -e u:
/// elastic bodies keep their energy however near they are. Where the step does not resolve how bodies respond, so that
/// this would add energy, impulses act by a law of the mean velocity instead, which can only take it (keep_energy).
/// Impacts, touches and separations are reported by pair
/// (RigidContacts::happenings).
class ContactImpulses {
 public:
  struct Parameters {
    Impacts impacts = Impacts::simultaneous;
    double tolerance = 1e-8;           // of impulses, relative to the largest
    double position_tolerance = 1e-9;  // m: overlaps below it stay
  };
  ContactImpulses(Parameters parameters, std::unique_ptr<ConeSolver> solver);

  /// Leaves rigid contacts out of the equations until the next recall; what compliant laws remember stays.
  void leave_out_rigid(EquationsOfMotion& equations, const ContactMemory& last);
  /// With the equations evaluated in the middle of the step, q ⊕ h/2 v, and factorised with its weights. `start` is the
  /// state as the step begins. False where no point is near, or the step is to be cut().
  bool find(EquationsOfMotion& equations, const State& start, double h);
  /// Impulses that others have given to v_end: by how much they have moved it, and what of that contact itself has
  /// brought about. That part comes with the impulses of contact, and is not in how gaps close before them.
  struct Others {
    const VectorX &moved, &brought;
  };
  /// `v_end` and `d` come without contact and leave with it. After one find() any number of times, each from v_end and
  /// d without contact. `others`: null, there are none. Throws SimulationError where surfaces meet that no impulse can
  /// stop, since drives and joints hold their bodies.
  void act(EquationsOfMotion& equations, const State& start, double h, VectorX& v_end, VectorX& d,
           const Others* others = nullptr);
  /// Both. False where no point was near.
  bool apply(EquationsOfMotion& equations, const State& start, double h, VectorX& v_end, VectorX& d);
  /// Impulses of the last act(), the rows of RigidContacts::problem().
  const VectorX& total() const { return total_; }
  /// Zero, or a time before the step's end: find() or act() has not finished, the step is to be taken anew up to there.
  /// Of few pairs of rigid bodies that meet, which are to have their impact at a step's end; where a gap that an impact
  /// of several pairs has left closes again; where a fast body would pass through a thin one.
  double cut() const { return cut_; }
  /// The step was to end there: until then no step is longer, so that cuts leave the grid of steps as it is.
  void finish_by(double time) { end_ = std::max(end_, time); }
  double next_stop(double time, double t_stop) const { return end_ > time ? std::min(end_, t_stop) : t_stop; }
  /// Of a run that begins.
  void forget() { end_ = uncut_ = 0; }
  /// What the step did, for State::contacts: nothing where find() found none. `v` is its last velocity.
  void remember(EquationsOfMotion& equations, const VectorX& v, double h, ContactMemory& memory);
  /// Iterations of the solver in the last step: sweeps, factorisations.
  int iterations() const { return iterations_; }
  /// Number of steps whose impulses stayed above the tolerance; the first one gives a warning.
  long unconverged() const { return unconverged_; }
  void history(Archive& archive);

 private:
  /// Of one point: what its impulse aims at, and how long it works.
  struct Aim {
    double velocity;  // least normal velocity at the end
    double time;      // w, s
    double gap = 0;   // least gap there, m
  };
  /// How a gap closes that nothing pushes open.
  struct Closing {
    double time, speed;  // h where it does not
    double acceleration;
  };
  /// An impact of a point within the step.
  struct Impact {
    double time = 0, speed = 0;
    double share = 1;  // of the step's impulse; the rest holds the bodies afterwards
  };
  static constexpr int kFewImpacts = 3;  // pairs that meet within a step: more are of a pile
  /// Time at which a gap closes that starts at g with rate u and acceleration a; h if it does not.
  static double time_to_close(double g, double u, double a, double h);
  Closing closing(const RigidContacts::Point& point, double gap, double velocity, double h) const;
  Aim aim(const RigidContacts::Point& point, double restitution, const Closing& closing, double free_velocity,
          double gap, double free_gap, double h) const;
  void set_aims(RigidContacts& contacts, double h);
  bool would_pass(EquationsOfMotion& equations, const State& start, double h);
  void hold(RigidContacts& contacts, double h, VectorX& v_end, VectorX& d);
  static double scale_of(const ConeProblem& problem);
  ConeResult find_impulses(const ConeProblem& problem, VectorX& r);
  void judge(const ConeResult& result, double scale);
  void solve(const ConeProblem& problem, VectorX& r);
  void solve_bounces(RigidContacts& contacts, double h);
  void collide(RigidContacts& contacts, double h, VectorX& v_end, VectorX& d);
  bool join_impacts(RigidContacts& contacts, double h);
  void end_before_impacts(RigidContacts& contacts, double h);
  double end_before(RigidContacts& contacts, int island, double h);
  void displace(RigidContacts& contacts, VectorX& d);
  void place_slips(RigidContacts& contacts, double h, const VectorX& v_end, VectorX& d);
  void keep_energy(EquationsOfMotion& equations, const State& start, double h, const Others* others, VectorX& v_end,
                   VectorX& d);
  void mean_velocity(EquationsOfMotion& equations, const State& start, double h, const Others* others, VectorX& z);
  void resist(RigidContacts& contacts, double h, VectorX& v_end, VectorX& d);
  static void tell_of_impact(RigidContacts& contacts, const RigidContacts::Point& point, double time, double speed,
                             double impulse);
  void tell_of_meetings(RigidContacts& contacts, double h, const ContactMemory& last) const;
  void tell_of_partings(RigidContacts& contacts, double h, const ContactMemory& last) const;

  Parameters parameters_;
  std::unique_ptr<ConeSolver> solver_, single_, position_;
  StaticFriction friction_;
  bool acted_ = false;
  double cut_ = 0, uncut_ = 0;  // s; the step that was cut first
  double end_ = 0;              // of a step that was cut, s
  int iterations_ = 0;
  long unconverged_ = 0;
  std::vector<Closing> closings_;
  std::vector<std::optional<Impact>> impacts_;
  std::vector<Impact> fastest_;  // by group
  VectorX held_until_;           // time of the impact that ends what holds the point; -1: none
  ConeProblem some_;             // contacts that hold
  std::vector<int> some_points_;
  std::vector<char> wedged_, held_islands_;  // of solve_bounces(): by point; by group
  ContactIslands islands_;
  std::vector<int> meeting_;          // pairs with an impact, or that push each other, by group
  std::vector<char> holding_;         // by pair
  std::vector<char> goes_on_;         // meets others after its impact; by group
  std::vector<double> first_impact_;  // by group
  VectorX last_, growth_;             // RigidContacts::recall
  VectorX guess_;                     // of the impulses, from which solvers start
  VectorX brought_;                   // Others, along the rows
  VectorX of_groups_;                 // their velocities
  VectorX times_;                     // of what acts across or late, by point
  VectorX middle_;                    // q in the middle of the step
  VectorX u_, r_, total_, weights_, dv_, moved_, gaps_, free_gaps_, least_gaps_, now_, impulse_;
  ConeProblem alone_;
  // What the step's impulses r are in the end: y = Y (placed + late) is what they have moved.
  VectorX v_free_, d_free_, placed_, late_;
  // Of keep_energy(), by row, by group, by velocity, by point.
  VectorX start_velocity_, free_velocity_, work_, scale_, q_, rv_, forces_, at_rest_, no_multipliers_;
  std::vector<char> tied_, elastic_, pushed_, mean_;
  std::vector<ConeProblem::Contact> as_formed_, as_solved_;
  ContactMemory compliant_;
};

}  // namespace lithe
