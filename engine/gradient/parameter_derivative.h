#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/gradient/moved_drawing.h"
#include "engine/motion/step_derivative.h"

namespace lithe {

inline constexpr int kFewParameters = 24;  // have drawings of their own

/// How equations, start and sensors change with the parameters of a scene: drawings at value ± step and ± 2 step are
/// compared at the same state (central differences of fourth order). Few parameters have drawings of their own. Of
/// many, those that act on different rows of the equations are moved together in one drawing, so that a step costs as
/// many evaluations as there are such groups, not as there are parameters.
class ParameterDerivative {
 public:
  enum class Grouping { by_rows, apart };
  /// `probes`: states of the run, at which rows are compared. `columns`: the sensors' columns that are wanted.
  ParameterDerivative(const ParametricScene& scene, std::vector<DesignParameter> parameters, const Drawing& nominal,
                      const std::vector<State>& probes, std::vector<Drawing::Place> columns,
                      Grouping grouping = Grouping::by_rows);
  ~ParameterDerivative();

  int count() const { return static_cast<int>(parameters_.size()); }
  int group_count() const { return static_cast<int>(groups_.size()); }
  /// The changes of the state that start() left and of the method's history, a column a parameter.
  const Variation& start() const { return start_; }

  /// ∂r/∂p, ∂g/∂p and, where asked for, ∂ġ/∂p at a state with its accelerations and multipliers.
  void columns(const State& state, MatrixX& force, MatrixX& rows, MatrixX* rates = nullptr);
  void add_products(const State& state, const VectorX& mu, const VectorX& nu, VectorX& out);
  /// The drawings in which a parameter moves alone (Grouping::apart), with their weights in its derivative.
  void visit(int k, const std::function<void(Evaluator&, double weight)>& look);
  /// Whether the sensor's column depends on any parameter directly, and ∂F/∂p at a state: zero where not.
  bool seen_by(int column) const { return seen_[static_cast<std::size_t>(column)]; }
  void sensor(int column, const State& state, VectorX& out);

 private:
  struct Moved;
  struct Group;
  void difference_start(int k, const std::vector<std::unique_ptr<Moved>>& drawings);
  std::vector<int> rows_of(const Moved& drawing) const;
  bool is_seen(Moved& drawing);
  void check_smooth(int k, std::vector<std::unique_ptr<Moved>>& drawings) const;
  std::unique_ptr<Moved> draw(const std::vector<int>& members, double steps) const;
  template <class Take>
  void difference(const State& state, const Take& take);

  const ParametricScene scene_;
  std::vector<DesignParameter> parameters_;
  const Drawing& nominal_;
  std::vector<State> probes_;
  std::vector<Drawing::Place> columns_;
  std::vector<bool> seen_;
  Variation start_;
  std::vector<std::unique_ptr<Group>> groups_;
  std::vector<VectorX> nominal_rows_;  // r, the rows and their rates at the probes
  VectorX difference_, part_, other_;
};

}  // namespace lithe
