#pragma once

#include <string>
#include <vector>

#include "engine/motion/integrator.h"

namespace lithe {

/// The equations of motion as an implicit system F(t, y, ẏ) = 0 for the codes of others, stabilized to index 2 (Gear,
/// Gupta & Leimkuhler 1985), y = (q, v, λ, μ) with quaternions as four plain numbers e:
///   M (u - v) + Gᵀ μ = 0     u: velocities from q̇, of a quaternion u = 2 (e⁻¹ ∘ ė)_vec
///   |e|² - 1 = 0             one row a quaternion
///   M v̇ + Gᵀ λ - f = 0
///   g = 0
///   G v + ∂g/∂t = 0
/// The engine sees e/|e|. A redundant row holds its multipliers at zero in place of g and ġ, a row on velocities alone
/// its μ in place of g.
class StabilizedIndex2 {
 public:
  explicit StabilizedIndex2(EquationsOfMotion& equations);

  int size() const { return nq_ + nv_ + 2 * rows_; }
  int differential_count() const { return nq_ + nv_; }  // q and v, the first in y
  /// "link: omega_y", "'pin' row 2" of a component of y.
  std::string name(int index) const;

  void pack(const State& state, VectorRef y, VectorRef y_dot) const;
  void unpack(ConstVectorRef y, ConstVectorRef y_dot, State& state) const;
  /// What each component may err by, in the root mean square over q and v; multipliers are held loosely.
  void allowances(ConstVectorRef y, const Tolerance& tolerance, VectorRef out) const;

  void residual(double time, ConstVectorRef y, ConstVectorRef y_dot, VectorRef F);

  /// Compressed columns of ∂F/∂y + c ∂F/∂ẏ; the pattern does not change.
  const std::vector<int>& column_starts() const { return column_starts_; }
  const std::vector<int>& row_indices() const { return row_indices_; }
  void jacobian(double time, ConstVectorRef y, ConstVectorRef y_dot, double c, double* values);

 private:
  struct Rotation {
    int q, v;                                // first of e and of ω
    Eigen::Matrix<double, 3, 4> turn, rate;  // ∂ψ/∂e, ∂u/∂e
  };
  struct Coordinate {
    int q;         // of a velocity; of its quaternion if it is a rotation
    int rotation;  // index into rotations_, -1: none
    int axis;
  };
  struct Entry {
    int row, column;
    double value;
  };

  void load(double time, ConstVectorRef y, ConstVectorRef y_dot);
  void collect(const TangentWeights& weights, std::vector<Entry>& entries);
  void emit(int row, int column, double value);
  void emit_turn(int row, const Coordinate& at, double value);
  void form(double time, double c, ConstVectorRef y);
  void group_columns();
  void difference_rates(double time);

  EquationsOfMotion& equations_;
  int nq_, nv_, rows_;
  std::vector<Rotation> rotations_;
  std::vector<Coordinate> coordinates_;  // of each velocity
  std::vector<char> redundant_, rolling_;
  VectorX q_, v_, u_, v_dot_, lambda_, mu_, zero_v_, zero_rows_, force_;

  std::vector<Entry> stiffness_, damping_, mass_;  // every block of the engine's tangent: K + M, D + c M, M
  std::vector<std::vector<Entry>> compliant_;      // Jacobian of each compliant row
  std::vector<Entry> reactive_;                    // ∂σ/∂λ over the compliance: row, multiplier
  // ∂(G v)/∂q by differences: frames that no constraint ties together move at once, in groups.
  struct Shift {
    int entry, row;  // place in mass_ and rates_, constraint row
  };
  std::vector<std::vector<Shift>> shifts_;  // what each group tells
  std::vector<std::vector<int>> moved_;     // velocities that each group moves
  std::vector<double> rates_;               // beside each entry of G
  VectorX rate_, moved_rate_, increment_, moved_q_;

  std::vector<int> column_starts_, row_indices_;
  std::vector<int> places_;                   // of each emitted value
  std::vector<std::pair<int, int>> pattern_;  // (column, row) while the pattern is recorded
  double* values_ = nullptr;                  // null: record
  std::size_t emitted_ = 0;
};

}  // namespace lithe
