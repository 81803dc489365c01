#pragma once

#include <memory>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/assembly/workspace.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

class ContactForces;
class HeldBlocks;
class LeastNorm;
class ReachedState;
class TangentFactors;
class ThreadTeam;

/// Evaluates one state of a system: walks the batches and writes the blocks of M, f, g, G and of the tangent in place.
/// One a thread. Bodies and markers that no connector uses: evaluated.h; what sensors ask: Snapshot.
class Evaluator final : public EquationsOfMotion, public StepMemory {
 public:
  explicit Evaluator(const System& system);
  ~Evaluator() override;

  const Facts& facts() const override { return facts_; }
  Parts parts() override;

  void evaluate(double time, ConstVectorRef q, ConstVectorRef v, Level level) override;
  void residual(ConstVectorRef v_dot, ConstVectorRef lambda, VectorRef r) override;
  void constraint(Level which, VectorRef out) const override;
  BodyEnergy energy() override;
  void factorize(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                 const VectorX* increment) override;
  void solve(VectorRef rv, VectorRef rl) const override;
  void visit_blocks(const std::function<void(int, int, ConstMatrixRef)>& visit) const override;

  void recall(const VectorX& quarter_turns) override;
  void track(VectorX& quarter_turns) const override;
  void recall_rows(const std::vector<int>& left_out) override;
  void track_rows(std::vector<int>& left_out) const override { left_out = facts_.redundant_rows; }
  void recall(const ContactMemory& contacts) override;
  void track_contacts(State& state) override;
  bool loses_angle(const State& state) override;
  void check(const State& state) override;

  const System& system() const { return system_; }
  const Workspace& workspace() const { return work_; }
  /// How often evaluate() was called.
  long evaluations() const { return evaluations_; }
  /// Of the body at that place in SystemGraph::bodies(), ground first.
  BodyState body_state(std::size_t place);
  /// Null: the scene has no contacts.
  ContactForces* contacts() { return contacts_.get(); }
  TangentFactors& factors() { return *factors_; }
  ThreadTeam& team() { return *team_; }

  /// Writes S, the weighted derivative of the residual, and the compliances of force rows; as for factorize().
  void write_tangent(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                     const VectorX* increment);
  /// Sets the tensions that joints' reactions make (friction), where no residual() has done so for this lambda.
  void react(ConstVectorRef lambda);

  // ---- what forward dynamics takes from the evaluation ----
  /// Generalized forces besides gravity at a state: loads and compliant rows; null if the scene has none.
  const double* applied_forces(double time, ConstVectorRef q, ConstVectorRef v);
  /// Places the markers that track() reads, where the scene measures angles.
  void place_measured_angles(ConstVectorRef q);

 private:
  void make_contacts();
  bool has_forces() const { return !system_.batches_.forces.empty() || contacts_; }
  void add_applied_forces();
  void add_part_tangent(std::size_t part, const TangentWeights& weights, ConstVectorRef lambda);
  template <class Job>
  void for_each_part(const Job& job);
  const double* as_felt(ConstVectorRef lambda);

  const System& system_;
  Workspace work_;
  std::unique_ptr<ThreadTeam> team_;
  long evaluations_ = 0;
  std::vector<std::unique_ptr<BodyBatch::Caches>> caches_;
  Facts facts_;
  std::unique_ptr<ContactForces> contacts_;  // null: the scene has none
  std::unique_ptr<RigidContacts> rigid_contacts_;
  std::unique_ptr<HeldBlocks> held_;
  std::unique_ptr<TangentFactors> factors_;
  std::unique_ptr<ForwardDynamics> forward_;  // null: the scene has none
  std::unique_ptr<LeastNorm> least_norm_;     // once asked for
  std::unique_ptr<ReachedState> reached_;     // null: there is nothing to check
};

}  // namespace lithe
