#pragma once

#include <memory>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/assembly/workspace.h"
#include "engine/model/joint_coordinate.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

class ContactForces;
class LeastNorm;
template <class Scalar>
class BlockFactorOf;
template <class Scalar>
class ContactCorrection;

/// Evaluates one system: walks the batches and writes the blocks of M, f, g, G in place. One a thread.
class Assembler final : public EquationsOfMotion, public StepMemory, public ComplexFactor, public HeldCoordinates {
 public:
  explicit Assembler(const System& system);
  ~Assembler() override;

  const Facts& facts() const override { return facts_; }
  Parts parts() override;
  void recall_rows(const std::vector<int>& left_out) override;
  void track_rows(std::vector<int>& left_out) const override { left_out = facts_.redundant_rows; }
  void recall(const VectorX& quarter_turns) override;
  void track(VectorX& quarter_turns) const override;
  void recall(const ContactMemory& contacts) override;
  void track_contacts(State& state) override;
  void evaluate(double time, ConstVectorRef q, ConstVectorRef v, Level level) override;
  void residual(ConstVectorRef v_dot, ConstVectorRef lambda, VectorRef r) override;
  void constraint(Level which, VectorRef out) const override;
  void factorize(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                 const VectorX* increment) override;
  void solve(VectorRef rv, VectorRef rl) const override;
  BodyEnergy energy() override;
  void factorize_complex(const ComplexTangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                         const VectorX* increment) override;
  void solve_complex(ComplexVectorRef rv, ComplexVectorRef rl) const override;
  void visit_blocks(const std::function<void(int, int, ConstMatrixRef)>& visit) const override;
  bool hold(const std::vector<int>& velocities) override;

  // ---- what sensors ask of the state evaluated last ----
  const System& system() const { return system_; }
  BodyState body_state(const Body& body);
  /// Of the body at that place in SystemGraph::bodies(), without looking for it.
  BodyState body_state_at(std::size_t place);
  MarkerKinematics marker(Marker marker, Level level);
  const Workspace& workspace() const { return work_; }
  /// Null: the scene has no contacts.
  ContactForces* contacts() { return contacts_.get(); }

  /// Sets the tensions that joints' reactions make (friction), where no residual() has done so for this lambda.
  void react(ConstVectorRef lambda);
  /// A connector's own part of the quarter_turns.
  const double* quarter_turns_of(const Connector& connector) const;
  /// Index into Layout::bodies(); -1: ground.
  int find_body(const Body& body) const;
  /// Place of an angle in State::quarter_turns; -1 if no connector of the system measures it.
  int find_angle(const JointCoordinate& coordinate) const;

  /// The multipliers of least norm with the same Gᵀ lambda, at the state evaluated last. Does nothing without redundant
  /// rows.
  void minimum_norm(VectorRef lambda);

  // ---- what derivatives of a run take: tangents and their transposes, without contacts and without friction by
  // reactions (SceneError) ----
  /// The blocks of S = weighted derivative of the residual, as factorize() forms them, for add_tangent_product().
  void form_tangent(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                    const VectorX* increment);
  /// out += S x or Sᵀ x, compliant rows eliminated, with the blocks formed last.
  void add_tangent_product(const VectorX& x, VectorX& out, bool transposed) const;
  /// Factorises [Sᵀ Gᵀ; G 0] instead of [S Gᵀ; G 0], for solve(). The blocks formed last are then those of Sᵀ.
  void factorize_transposed(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                            const VectorX* increment);
  /// rates += G v.
  void add_rates(const double* v, VectorRef rates) const;

  // ---- what forward dynamics takes from the evaluation ----
  /// Generalized forces besides gravity at a state: loads and compliant rows; null if the scene has none.
  const double* applied_forces(double time, ConstVectorRef q, ConstVectorRef v);
  /// Places the markers that track() reads, where the scene measures angles.
  void place_measured_angles(ConstVectorRef q);

 private:
  friend class SystemBuilder;
  void add_row_forces(const double* lambda, const double* tension, double* r) const;  // Gᵀ (lambda, tension)
  void exchange_weak_rows();
  void form(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda, const VectorX* increment);
  void release_from_joints();
  bool has_forces() const { return !system_.batches_.forces.empty() || contacts_; }
  void add_applied_forces();
  void add_contact_diagonals(const TangentWeights& weights);

  const System& system_;
  Workspace work_;
  std::vector<std::unique_ptr<BodyBatch::Caches>> caches_;
  std::unique_ptr<BlockFactorOf<double>> factor_;
  struct ComplexPart;
  std::unique_ptr<ComplexPart> complex_;                           // once asked for
  std::unique_ptr<ContactForces> contacts_;                        // null: the scene has none
  std::unique_ptr<ContactCorrection<double>> contact_correction_;  // likewise
  std::unique_ptr<RigidContacts> rigid_contacts_;
  Facts facts_;
  VectorX weak_rates_;                     // of exchange_weak_rows()
  std::unique_ptr<LeastNorm> least_norm_;  // once asked for
  /// Linear coordinates that stand still, and what that leaves of the blocks.
  struct Held {
    std::vector<int> velocities;
    std::vector<std::pair<int, int>> jacobian;  // first value, count: zero
    std::vector<int> couplings, diagonals;      // values of S: zero, and the weight of the acceleration
  } held_;
  mutable VectorX unknowns_;  // velocities, constraint rows, compliant rows
  VectorX zero_v_, zero_rows_;
  std::unique_ptr<ForwardDynamics> forward_;  // null: the scene has none
};

}  // namespace lithe
