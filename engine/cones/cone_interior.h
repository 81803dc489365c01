#pragma once

#include "engine/cones/dense_cones.h"

namespace lithe {

/// Primal-dual interior point method on the second-order cones, Nesterov and Todd's scaling, Mehrotra's predictor and
/// corrector. Coulomb's law enters by De Saxcé's change of variables (De Saxcé and Feng, 1998): y_n + Σ limit |y_d| in
/// place of y_n makes it a complementarity of cones. Without a start value it reaches the neighbourhood of a solution
/// in some 15 factorisations, for redundant contacts and unequal masses too. That term makes the problem nonconvex: the
/// method may stall.
class ConeInterior {
 public:
  enum class SlipTerm {
    linearized,  // within each step: fast
    lagged,      // by the velocities before it, a convex problem each step: slower, stalls elsewhere
  };
  /// At most so many steps, until gap and residual are `accuracy` of the free velocities' size. Returns how many. The
  /// start lies on the axes of the cones, `start` of that size: where it stalls from one, it may not from another.
  int solve(const DenseCones& cones, SlipTerm slip_term, int most, double accuracy, VectorX& x, double start);

 private:
  /// One disc over its normal, or a normal alone: z = (limit x_n, x_d) and its dual y, both in the cone z_0 >= |z_1,2|.
  struct Cone {
    DenseCones::Disc disc;
    Vector3 z, y, dz, dy;
    Vector3 w, lambda;  // scaling V = η V(w): V y = V⁻¹ z = λ
    double eta;
    Vector3 aim;  // V⁻¹ dz + V dy

    Vector3 gather(const VectorX& x) const;
    void scatter(const Vector3& a, VectorX& x) const;
    void scale();
    Vector3 stretched(const Vector3& a) const;  // V a
    Vector3 shrunk(const Vector3& a) const;     // V⁻¹ a
    void add_barrier(MatrixX& M) const;         // V⁻² in the rows of x
  };

  void place(const DenseCones& cones, double size, VectorX& x);
  double slip(const Cone& cone) const;
  void build(const DenseCones& cones, SlipTerm slip_term);
  template <class Factor>
  double find_direction(const Factor& factor);
  template <class Factor>
  bool advance(const Factor& factor, double gap, VectorX& x);

  std::vector<Cone> cones_;
  VectorX u_, residual_, right_, dx_;
  MatrixX M_;
};

}  // namespace lithe
