#pragma once

#include <memory>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/assembly/workspace.h"
#include "engine/contact/contact_correction.h"
#include "engine/factor/block_factor.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

class Evaluator;

/// Factors of the tangent [S Gᵀ; G 0] whose blocks an evaluator writes, real and complex: what integrators ask through
/// EquationsOfMotion. Rows that repeat others are left out, and exchanged where the pose changes which ones do.
/// Compliant contacts are a correction of low rank.
class TangentFactors final : public ComplexFactor {
 public:
  /// Borrows all: `redundant_rows` are those of the equations, sorted; `contacts` may be null.
  TangentFactors(Evaluator& evaluator, Workspace& work, std::vector<int>& redundant_rows, ContactForces* contacts);
  ~TangentFactors() override;

  /// As EquationsOfMotion has them.
  void factorize(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda, const VectorX* increment);
  void solve(VectorRef rv, VectorRef rl) const;
  void visit_blocks(const std::function<void(int row, int column, ConstMatrixRef block)>& visit) const;

  void factorize_complex(const ComplexTangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                         const VectorX* increment) override;
  void solve_complex(ComplexVectorRef rv, ComplexVectorRef rl) const override;

  // ---- what derivatives of a run take: tangents and their transposes, without friction by reactions (SceneError) ----
  /// The blocks of S, the weighted derivative of the residual, for add_tangent_product(); without contacts.
  void form_tangent(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                    const VectorX* increment);
  /// out += S x or Sᵀ x, compliant rows eliminated, with the blocks formed last.
  void add_tangent_product(const VectorX& x, VectorX& out, bool transposed) const {
    add_tangent_product(work_.values, x, out, transposed);
  }
  /// The same with blocks that were formed before: formed() as it was then.
  void add_tangent_product(const std::vector<double>& blocks, const VectorX& x, VectorX& out, bool transposed) const;
  const std::vector<double>& formed() const { return work_.values; }
  /// Factorises [Sᵀ Gᵀ; G 0] instead of [S Gᵀ; G 0], for solve(), with contacts. The blocks formed last are then those
  /// of Sᵀ.
  void factorize_transposed(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                            const VectorX* increment);
  /// The same of blocks that were formed before, without contacts.
  void factorize_transposed(const std::vector<double>& blocks);
  /// The same at complex weights, for solve_complex(); corrections are turns of the present state.
  void factorize_complex_transposed(const ComplexTangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda);

  /// Leaves these rows out from the next factorisation on.
  void drop_rows(const std::vector<int>& rows) { factor_.drop_rows(rows); }
  /// Factorises [M Gᵀ; G 0] of the state evaluated last and returns the rows whose pivot is less than `tolerance` times
  /// their compliance: they depend on others, and are left out.
  std::vector<int> find_dependent_rows(double tolerance);
  bool has_loops() const { return factor_.guarded(); }

 private:
  void form_complex(const ComplexTangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                    const VectorX* increment);
  void add_contact_diagonals(const TangentWeights& weights);
  void exchange_weak_rows();
  void add_confirmed(const std::vector<int>& doubtful, const VectorX& reference, double tolerance,
                     std::vector<int>& dependent);
  int unknown_count() const { return static_cast<int>(unknowns_.size()); }

  Evaluator& evaluator_;
  const System& system_;
  const BlockStructure& blocks_;
  Workspace& work_;
  std::vector<int>& redundant_rows_;
  ContactForces* contacts_;
  BlockFactor factor_;
  std::unique_ptr<ContactCorrection<double>> contact_correction_;  // null: the scene has no contacts
  /// Of factorize_complex().
  struct ComplexPart {
    ComplexPart(const BlockStructure& structure, ThreadTeam* team) : factor(structure, team) {}
    ComplexBlockFactor factor;
    std::vector<std::complex<double>> values;
    ComplexVectorX unknowns;
    ContactCorrection<std::complex<double>> contacts;
  };
  std::unique_ptr<ComplexPart> complex_;  // once asked for
  VectorX weak_rates_;                    // of exchange_weak_rows()
  mutable VectorX unknowns_;              // velocities, constraint rows, compliant rows
};

}  // namespace lithe
