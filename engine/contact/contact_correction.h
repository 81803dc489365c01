#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "engine/contact/contact_forces.h"

namespace lithe {

/// The stiffness of contacts in the iteration matrix, K₀ + Hᵀ D H', whose other part K₀ is factorised (Sherman,
/// Morrison & Woodbury):  x = x₀ - Z (E + D W)⁻¹ D H' x₀,  x₀ = K₀⁻¹ b,  Z = K₀⁻¹ Hᵀ,  W = H' Z. Exact for all bodies,
/// elastic parts and couplings alike; its cost grows with the square of the rows in touch.
template <class Scalar>
class ContactCorrection {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// `solve(x)`: x := K₀⁻¹ x, `unknowns` long, velocities first. Transposed: of K₀ᵀ + H'ᵀ Dᵀ H, with solve of K₀ᵀ.
  template <class Solve>
  void form(const ContactForces& forces, Scalar position, Scalar velocity, int unknowns, Solve&& solve,
            bool transposed = false) {
    // Newton keeps a factor over evaluations that find other points: these are its own.
    rows_ = forces.rows();
    right_ = forces.right();
    if (transposed)
      for (const ContactRows::Row& row : rows_.points())
        for (const ContactRows::Side& side : row.sides)
          std::copy_n(rows_.values(side), row.rows * side.count, right_.begin() + side.H);
    const auto left = [&](const ContactRows::Side& side) {
      return transposed ? forces.right().data() + side.H : rows_.values(side);
    };
    const int m = forces.stiff_rows();
    active_ = m > 0;
    if (!active_) return;
    const ContactRows& rows = rows_;
    // 1. Z, a column for each row.
    Z_.setZero(unknowns, m);
    for (const ContactRows::Row& row : rows.points())
      for (const ContactRows::Side& side : row.sides)
        for (int c = 0; c < side.count; ++c)
          for (int i = 0; i < row.rows; ++i) Z_(side.velocity + c, row.first + i) += left(side)[i + row.rows * c];
    for (int k = 0; k < m; ++k) solve(Z_.col(k).data());
    // 2. D, and E + D W.
    D_.setZero(m, m);
    int at = 0;
    for (const ContactRows::Row& row : rows.points())
      for (int c = 0; c < row.rows; ++c)
        for (int i = 0; i < row.rows; ++i, ++at)
          (transposed ? D_(row.first + c, row.first + i) : D_(row.first + i, row.first + c)) =
              -(position * forces.by_position()[at] + velocity * forces.by_velocity()[at]);
    small_.resize(m, m);
    y_.resize(m);
    for (int k = 0; k < m; ++k) {
      motion(Z_.col(k).data());
      multiply();
      small_.col(k) = Dy_;
    }
    small_.diagonal().array() += Scalar(1);
    factor_.compute(small_);
  }
  /// x₀ to x.
  void apply(Scalar* x) {
    if (!active_) return;
    motion(x);
    multiply();
    y_ = factor_.solve(Dy_);
    Eigen::Map<Vector>(x, Z_.rows()).noalias() -= Z_ * y_;
  }
  bool active() const { return active_; }
  /// The blocks of Hᵀ D H', for the sparse codes of others.
  template <class Visit>
  void visit(Visit&& visit) const {
    for (const ContactRows::Row& row : rows_.points())
      for (const ContactRows::Side& a : row.sides)
        for (const ContactRows::Side& b : row.sides) {
          if (a.count == 0 || b.count == 0) continue;
          const Eigen::Map<const MatrixX> Ha(rows_.values(a), row.rows, a.count),
              Hb(right_.data() + b.H, row.rows, b.count);
          visit(a.velocity, b.velocity,
                MatrixX(Ha.transpose() * D_.block(row.first, row.first, row.rows, row.rows) * Hb));
        }
  }
  void clear() { active_ = false; }

 private:
  /// y = H' x.
  void motion(const Scalar* x) {
    y_.setZero();
    for (const ContactRows::Row& row : rows_.points())
      for (const ContactRows::Side& side : row.sides) {
        const double* H = right_.data() + side.H;
        for (int c = 0; c < side.count; ++c, H += row.rows)
          for (int i = 0; i < row.rows; ++i) y_[row.first + i] += H[i] * x[side.velocity + c];
      }
  }
  /// D y, by blocks.
  void multiply() {
    Dy_.resize(y_.size());
    for (const ContactRows::Row& row : rows_.points())
      Dy_.segment(row.first, row.rows).noalias() =
          D_.block(row.first, row.first, row.rows, row.rows) * y_.segment(row.first, row.rows);
  }

  ContactRows rows_;
  std::vector<double> right_;
  Matrix Z_, D_, small_;
  Vector y_, Dy_;
  Eigen::PartialPivLU<Matrix> factor_;
  bool active_ = false;
};

}  // namespace lithe
