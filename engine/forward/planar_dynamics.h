#pragma once

#include <memory>
#include <vector>

#include "engine/forward/rigid_scene.h"

namespace lithe {

/// Rigid bodies that their joints hold in planes normal to one world axis, loops included: three velocities a body,
/// two rows a joint, and no rows or forces out of the plane. The joint forces Λ of a state follow from
///   (G M⁻¹ Gᵀ) Λ = G M⁻¹ f - γ,   M = diag(m, m, J),
/// by L D Lᵀ in 2 x 2 blocks, joint by joint in an order of least fill: linear cost for chains, trees of few joints a
/// body and their loops.
class PlanarDynamics final : public ForwardKernel {
 public:
  /// Null if a body can leave its plane, a joint is none of those below, rows depend on each other at t = 0, or there
  /// are more than a few loops.
  static std::unique_ptr<PlanarDynamics> make(const RigidScene& scene);

  ForwardMethod method() const override { return ForwardMethod::planar; }
  void accelerations(const double* q, const double* v, const double* load, double* v_dot) override;
  /// Newton steps in the metric of the masses; bodies are put back into their planes. False, and nothing changed, where
  /// a singular position leaves no way.
  bool project(double* q, double* v, double tolerance) override;

 private:
  struct Body {
    int q, v;
    bool in_plane;                         // coordinates (x, y, θ) instead of a frame
    double inverse_mass, inverse_inertia;  // about the normal
    Vector3 normal;                        // body axes
    Vector4 start;                         // quaternion at t = 0
    Vector4 upright, turned;  // of the turn since then, half its angle: cos = upright · e, sin = turned · e
    double height;            // coordinate out of the plane
    double angle;             // θ at t = 0
  };
  struct Point {
    double x = 0, y = 0;
  };
  struct Side {
    int body;  // -1: ground
    Point at;  // of the marker at t = 0 from the centre of mass; on the ground from the origin
  };
  /// Hinge: the sides' points coincide. Slider: B's point stays on the line through A's, and both turn alike.
  struct Joint {
    Side A, B;
    bool slides;
    Point normal;  // of the line, at t = 0; it turns with A
  };
  struct Pose {
    double x, y, c, s;  // centre of mass; cos and sin of the turn since t = 0
    double vx, vy, rate;
  };
  struct Rows {  // of one joint by one body's motions; x and y of a hinge are constant
    double x[2], y[2], turn[2];
  };
  struct Block {  // column-major
    double a = 0, b = 0, c = 0, d = 0;
  };
  struct Product {  // of the rows of two joints by a body that they share: block += left M⁻¹ rightᵀ
    int block, left, right;
    double inverse_mass, inverse_inertia;  // of two hinges: the first is negative if one has the body as A, one as B
  };
  struct Pivot {
    int joint, first_neighbour, last_neighbour, first_update, last_update;
  };
  struct Neighbour {
    int joint, block;
  };
  struct Update {  // block -= left D⁻¹ rightᵀ of two neighbours
    int block, left, right;
  };

  PlanarDynamics() = default;
  void plan();
  bool project_onto(double* q, double* v, double tolerance);
  void place(const double* q, const double* v);
  double write_gaps();                         // into rhs_; the largest
  void write_rows();                           // and γ
  void factorize(double* smallest = nullptr);  // the smallest pivot over its compliance
  void solve();                                // rhs_ becomes Λ
  void respond();                              // response_ = -M⁻¹ Gᵀ Λ
  void add_rates(const double* x);
  void write_motion(const Body& body, const double* a, const double* b, double* rates) const;
  void move(std::size_t body, double* q) const;
  double round_off() const;
  double largest_response() const;

  int e1_ = 0, e2_ = 1, e3_ = 2;  // world axes of the plane, and its normal
  Point gravity_;
  std::vector<Body> bodies_;
  std::vector<Joint> joints_;
  Pose ground_{0, 0, 1, 0, 0, 0, 0};
  std::vector<Pose> poses_;
  std::vector<Rows> rows_;               // of A, then of B, a joint
  std::vector<double> gamma_, rhs_;      // two a joint
  std::vector<double> compliance_;       // of each row by itself
  std::vector<double> free_, response_;  // three a body: motions without joints, and what joints add
  std::vector<double> saved_;            // coordinates, while they are projected
  std::vector<Product> hinge_products_, products_;
  std::vector<Pivot> pivots_;
  std::vector<Neighbour> neighbours_;
  std::vector<Update> updates_;
  std::vector<Block> blocks_;      // diagonal ones first
  std::vector<Block> inverse_;     // of the pivots
  std::vector<Block> eliminated_;  // neighbours' blocks times the inverse pivot, a place a neighbour
};

}  // namespace lithe
