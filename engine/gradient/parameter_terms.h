#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/gradient/differences.h"
#include "engine/gradient/moved_drawing.h"
#include "engine/motion/step_derivative.h"

namespace lithe {

/// How weighted sums of the equations, sensors and the drawn start change with very many parameters, for the adjoint.
/// The sum μ · r + ν · g is one of terms: of each body, each joint and each row of a force. Parameters that act on
/// different terms are moved together in one drawing, so that a step costs as many evaluations as parameters act on
/// the busiest term. Which act where is found from few drawings: parameters with names that differ in digits alone are
/// moved together by steps of different lengths, and the length tells whose term it is. What two of them move is moved
/// apart.
///   A term that is linear in its parameter takes one evaluation a step, one without a third derivative two, others
///   four.
class ParameterTerms {
 public:
  /// Null, with the reason: what cannot be told apart so. `with_start`: for add_drawn().
  static std::unique_ptr<ParameterTerms> find(const ParametricScene& scene,
                                              const std::vector<DesignParameter>& parameters, const Drawing& nominal,
                                              const std::vector<State>& probes,
                                              const std::vector<Drawing::Place>& columns, bool with_start,
                                              std::string& why);
  ~ParameterTerms();

  int count() const { return static_cast<int>(parameters_.size()); }
  int group_count() const;  // evaluations a state

  /// gradient += factor times the derivatives of the sums at the state, a column a want.
  void add_products(const State& state, const WeightedSum& sum, const MatrixX& mu, const MatrixX& nu, double factor,
                    MatrixX& gradient);
  /// ∂F/∂p of a sensor's column at a state.
  void sensor(int column, const State& state, VectorX& out);
  /// gradient += wanted · ∂(drawn q and v)/∂p, before the drawing is moved onto its joints.
  void add_drawn(const MatrixX& turn, const MatrixX& velocity, MatrixX& gradient) const;

 private:
  struct Group;
  struct Touch;
  struct Search;
  enum class Shape { linear, quadratic, general };  // of a parameter's terms
  static std::span<const Offset> offsets(Shape shape);

  ParameterTerms(const ParametricScene& scene, const std::vector<DesignParameter>& parameters, const Drawing& nominal,
                 const std::vector<State>& probes, const std::vector<Drawing::Place>& columns);
  std::unique_ptr<MovedDrawing> draw(const std::vector<int>& members, const std::vector<double>& steps) const;
  void terms(Evaluator& equations, const State& state, const WeightedSum& sum, const MatrixX& mu, const MatrixX& nu,
             MatrixX& values, MatrixX* sizes = nullptr) const;
  int term_count() const { return slices_ + constraints_ + forces_; }
  bool decode(std::vector<int> members, Search& search);
  void gather();
  void difference_start(int k);

  const ParametricScene scene_;
  std::vector<DesignParameter> parameters_;
  const Drawing& nominal_;
  std::vector<State> probes_;
  std::vector<Drawing::Place> columns_;
  int slices_ = 0, constraints_ = 0, forces_ = 0;
  Evaluator equations_;                    // as drawn
  std::vector<std::vector<int>> touched_;  // terms of each parameter, columns last
  std::vector<Shape> shapes_;
  struct Start {
    int first;
    VectorX turn, velocity;  // of the velocities from there on
  };
  std::vector<std::vector<Start>> starts_;  // of each parameter
  std::vector<std::unique_ptr<Group>> groups_;
  mutable VectorX r_, force_;
  MatrixX nominal_terms_, values_, change_;
};

}  // namespace lithe
