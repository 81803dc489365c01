#pragma once

#include <vector>

#include "engine/base/math.h"
#include "engine/model/layout.h"

namespace lithe {

/// How small motions are carried through a step q' = q ⊕ d, in the axes of velocities (ṗ world, turn in body axes, η):
///   δq' = E δq + T δd,   E: exp(-ψ~) of each rotation, T: Jr(ψ); one elsewhere
class ChartMaps {
 public:
  void at(const Layout& layout, const VectorX& d);

  /// In place, for columns of length v_count.
  void carry(MatrixX& columns) const { apply(&Frame::carry, false, columns); }              // E
  void carry_transposed(MatrixX& columns) const { apply(&Frame::carry, true, columns); }    // Eᵀ
  void turn(MatrixX& columns) const { apply(&Frame::turn, false, columns); }                // T
  void turn_transposed(MatrixX& columns) const { apply(&Frame::turn, true, columns); }      // Tᵀ
  void change(MatrixX& columns) const { apply(&Frame::change, false, columns); }            // T⁻¹
  void change_transposed(MatrixX& columns) const { apply(&Frame::change, true, columns); }  // T⁻ᵀ

 private:
  struct Frame {
    int rotation;  // its first velocity
    Matrix3 carry, turn, change;
  };
  void apply(Matrix3 Frame::*map, bool transposed, MatrixX& columns) const;
  std::vector<Frame> frames_;
};

/// δJr(ψ) x along δψ: differences of fourth order, of entries of order one.
Vector3 right_jacobian_change(const Vector3& psi, const Vector3& by, const Vector3& x);

/// Of the rates ḋ = Jr⁻¹(d) v: adds what is wanted of them to the same of d and v; a column a want.
void add_chart_rate_products(const Layout& layout, const VectorX& d, const VectorX& v, const MatrixX& wanted,
                             MatrixX& of_d, MatrixX& of_v);

}  // namespace lithe
