#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "engine/assembly/evaluator.h"
#include "engine/gradient/parameter_derivative.h"
#include "engine/gradient/parameter_terms.h"
#include "engine/motion/step_derivative.h"

namespace lithe {

/// LinearEquations of a system. Directions are differenced (fourth order, exact to some 1e-12: what elements leave out
/// of their tangents for Newton is in it). Transposed products take the elements' own tangents where these agree with
/// such differences along a random direction, or with what dampers' rows add that turn; else all columns are
/// differenced, those together that no row shares.
class TangentEquations final : public LinearEquations {
 public:
  /// How parameters act: forwards and backwards, or backwards alone. Null, where it is not asked for.
  /// `at_rest`: of an equilibrium, where stiff strips leave smaller steps of differences little but round-off.
  explicit TangentEquations(const System& system, ParameterDerivative* parameters = nullptr,
                            ParameterTerms* terms = nullptr, bool at_rest = false);
  ~TangentEquations() override;

  const Layout& layout() const override { return equations_.layout(); }
  const std::vector<int>& velocity_rows() const override { return equations_.velocity_rows(); }
  EquationsOfMotion& equations() override { return equations_; }
  void at(const State& state) override;
  void along(const Direction& direction, VectorX& force, VectorX& rows, VectorX* rates = nullptr) override;
  void parameter_columns(MatrixX& force, MatrixX& rows, MatrixX* rates = nullptr) override;
  void factorize(const TangentWeights& weights, const VectorX& increment, bool transposed) override;
  void solve(VectorX& force, VectorX& rows) override;
  void pull(const VectorX& mu, const VectorX& nu, Pulled& out) override;
  void add_parameter_products(const MatrixX& mu, const MatrixX& nu, double factor, MatrixX& out) override;
  void factorize_complex(const ComplexTangentWeights& weights) override;
  void solve_complex(ComplexVectorX& force, ComplexVectorX& rows) override;
  void solve_mass(MatrixX& force, MatrixX& rows) override;
  void accelerations(VectorX& v_dot, VectorX& lambda) override;
  void add_weighted(const WeightedSum& sum, const MatrixX& mu, const MatrixX& nu, double factor, MatrixX& turn,
                    MatrixX& velocity, MatrixX& gradient) override;

  /// How transposed products have been found so far.
  enum class Tangents { of_elements, with_row_rates, differenced };
  Tangents tangents() const { return tangents_; }

 private:
  void evaluate(double offset, const Direction& direction, VectorX& force, VectorX& rows, VectorX* rates);
  void difference_along(const Direction& direction, VectorX& force, VectorX& rows, VectorX* rates, double& scale);
  void check_tangents();
  bool agrees(const VectorX& force, const VectorX& own, const VectorX& terms, double all) const;
  VectorX terms_of_elements(const VectorX& turn, const VectorX& velocity);
  double find_terms_of_force();
  double round_off() const;
  void stand();
  void factorize_formed(const TangentWeights& weights, const VectorX& increment);
  void find_row_rates(const VectorX* acceleration);
  void add_turning_rows(const VectorX& x, VectorX& out, bool transposed) const;
  void form(std::vector<double>& blocks, const TangentWeights& weights, const VectorX& a, const VectorX& l);
  void add_stiffness_products(const MatrixX& mu, const VectorX& a, const VectorX& l, double factor, MatrixX& out);
  void add_row_products(const std::vector<double>& values, const VectorX& nu, VectorX& out) const;
  void find_colours();
  void difference_columns();

  Evaluator equations_;
  ParameterDerivative* parameters_;
  ParameterTerms* terms_;
  const bool at_rest_;
  State state_;
  State near_;
  double scale_ = 0;           // of derivatives near the state, by the size of their directions
  double terms_of_force_ = 0;  // the size of what cancels in the equations
  Tangents tangents_ = Tangents::of_elements;
  bool ready_ = false;      // the tangents of the present state are checked or differenced
  bool evaluated_ = false;  // the evaluator stands at the state
  unsigned seed_ = 1;
  long looks_ = 0;  // at the elements' tangents
  // Of the elements, by q, v, v_dot; d/dt and d²/dt² of the rows along the motion, with the axes that they act in.
  bool formed_ = false;
  std::vector<double> K_blocks_, D_blocks_, M_blocks_, G_rate_, G_second_, factor_blocks_;
  std::vector<Matrix3> charts_;  // of each frame
  MatrixX moved_;
  // Differenced tangents.
  std::vector<std::vector<int>> colours_;    // slices, differenced together
  std::vector<std::vector<int>> influence_;  // of each slice: the slices whose rows it moves
  Eigen::SparseMatrix<double> K_, D_;
  VectorX force_, force_before_, rows_;
};

}  // namespace lithe
