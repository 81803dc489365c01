#pragma once

#include "engine/cones/joint_friction_problem.h"
#include "engine/model/state.h"
#include "engine/motion/equations_of_motion.h"
#include "integrators/contact_impulses.h"

namespace lithe {

/// Friction in joints as a part of a time-stepping method (FrictionByImpulses): impulses p along the directions D in
/// which the surfaces slide, and with them the joints' reactions Λ, from a step that was computed without friction.
/// With the step's factor of [S Gᵀ; G 0], in its middle,
///   (Y, L) = K⁻¹ (D, 0),   v' = v_free + Y p,   Λ' = Λ_free + L p,   d' = d_free + h/2 Y p,
/// while velocities are those at the step's end: with joints closed there, surfaces that stick rest there to round-off.
/// Implicit in the normal force too, so that a joint which jams stays at rest. Order 2 while surfaces slide or stick,
/// 1 over the steps in which they begin to. With contacts of rigid surfaces, whose impulses r load the joints as well,
/// both are found by turns until neither changes: one problem of all, Gauss-Seidel by blocks, over-relaxed by Aitken.
class JointFrictionImpulses {
 public:
  /// Of a run that begins.
  void prepare(EquationsOfMotion& equations);
  /// At the start of a step: how the surfaces slide, and takes their friction out of the equations, that of the last
  /// step out of the velocities.
  void leave_out(EquationsOfMotion& equations, State& state);
  /// As leave_out() found it: the step was not taken.
  void put_back(VectorX& v) const;
  /// With the equations evaluated in the middle of the step from `start` to `time`, and factorised with its weights. v,
  /// d and the rows' impulses come without friction and contact; q and v leave with them, joints closed. False: no
  /// joint has any friction. `contacts`: that find() has found some; null: none are near. To be cut() they do not
  /// finish.
  bool apply(EquationsOfMotion& equations, const State& start, double time, ContactImpulses* contacts, VectorX& rows,
             const VectorX& d, VectorX& q, VectorX& v);
  /// Keeps its mean forces over h in the velocities that are for it.
  void keep(EquationsOfMotion& equations, double h, VectorX& v, VectorX& v_dot) const;
  /// What they have done in the last apply(), as generalized impulses in the directions of the state evaluated last.
  void add_impulses(EquationsOfMotion& equations, VectorX& to) const;
  /// Sweeps of the solver in the last step.
  int sweeps() const { return sweeps_; }

 private:
  /// Surfaces of bodies that are tied: what unit impulses do to these bodies, and to the joints that press.
  struct Mechanism {
    std::vector<int> surfaces, velocities, rows;  // rows: of the joints that press
    std::vector<int> first_rows;                  // of each surface's joint, in `rows`
    std::vector<std::pair<int, int>> directions;  // of all: surface, which of its own
    MatrixX Y, L;                                 // velocities x directions, rows x directions
  };
  /// to += of all mechanisms, Y x or L x.
  void add_moved(const VectorX& x, VectorX& to) const;
  void add_pressed(const VectorX& x, VectorX& to) const;
  int place(const std::pair<int, int>& direction) const;
  void respond(EquationsOfMotion& equations);
  void form(EquationsOfMotion& equations, double h);
  void feel(EquationsOfMotion& equations, const ContactImpulses& contacts);
  void hold(VectorX& correction);
  void relax(double& factor);

  JointFrictionProblem problem_;
  std::vector<Mechanism> mechanisms_;
  std::vector<std::vector<Matrix3X>> by_lambda_;  // of each surface
  std::vector<char> sticks_;                      // by surface
  std::vector<int> held_;                         // directions
  MatrixX held_W_;                                // theirs
  VectorX p_, last_, residual_, residual_before_, kept_, d_, v_, rv_, rl_, closed_, corrected_, felt_, way_, speeds_,
      x_, held_way_;
  VectorX moved_, alone_, brought_;    // by p; by p without contacts; the rest
  VectorX hit_v_, hit_d_, hit_rows_;   // by contacts
  std::vector<int> places_, of_kept_;  // of what is kept; its directions
  int sweeps_ = 0;
  bool warned_ = false;
};

}  // namespace lithe
