// limit_flexible: the same question for a flexible body. The hex8i rod of examples/data swings for T seconds about its
// hinge edge with nine modes, or 30 (limit_flexible_30); every size is known to the compiler. pendulum.cpp is measured
// beside it.
//
//   --dt 1e-3  step, s   --T 20  time, s   --rho 0.9  at infinity   --newton 1e-10  largest last correction   --repeat
//   5
//
// The body comes from Lithe's own reduction and inertia integrals, copied into arrays of fixed size; the frame sits on
// the hinge, whose nodes have no deformation. With l = Aᵀ(p̈ - g), s, J, Cr, h = Cr η̇, G_k = ∂J/∂η_k of
// docs/equations.md 2.3:
//   m (p̈ - g) + A (ω̇ × s + Ct η̈ + ω × (ω × s) + 2 ω × Ct η̇) + λ_123                      = 0
//   s × l + J ω̇ + Cr η̈ + J̇ ω + ω × (J ω + h) + n_x λ_4 + n_z λ_5                          = 0
//   η̈ + Ω² η + Ctᵀ l + Crᵀ ω̇ - ½ ω G ω - 2 Uᵀ ω                                            = 0
//   p = hinge,  (A e_y) · e_x = (A e_y) · e_z = 0:  n = e_y × Aᵀ e
// The modes' block is diagonal and goes first; an 11 x 11 matrix is left, factorised once a step.
#include <Eigen/LU>

#include "tools/bench/alpha_method.h"
#include "tools/bench/measure.h"
#include "tools/bench/scenes.h"

namespace lithe::bench {
namespace {

constexpr int kModes = LITHE_LIMIT_MODES;
using Modal = Eigen::Matrix<double, kModes, 1>;
using Modal3 = Eigen::Matrix<double, 3, kModes>;
using Modal6 = Eigen::Matrix<double, 6, kModes>;
using Modes3 = Eigen::Matrix<double, 3 * kModes, 1>;  // a Modal3, column after column
using Modes6 = Eigen::Matrix<double, 6 * kModes, 1>;
using Rows = Eigen::Matrix<double, 5, 1>;
using Small = Eigen::Matrix<double, 11, 1>;  // frame and rows

/// Symmetric matrix from (xx yy zz xy xz yz).
Matrix3 symmetric(const Vector6& c) {
  Matrix3 S;
  S << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  return S;
}

/// The rod's constants.
struct RodConstants {
  double mass;
  Vector3 s0, hinge, tip;
  Modal3 Ct, C0, tip_modes;
  Modal6 J1;
  Vector6 J0;
  Eigen::Matrix<double, 6 * kModes, kModes> J2;
  Eigen::Matrix<double, 3 * kModes, kModes> C1;
  Modal stiffness;

  explicit RodConstants(const ModalBasis& basis) {
    const InertiaIntegrals I = inertia_integrals(basis);
    const int end = basis.node_index(basis.node_set("tip").front());
    mass = I.mass, s0 = I.s0, hinge = basis.origin, tip = basis.nodes.col(end);
    Ct = I.Ct, C0 = I.C0, tip_modes = basis.node_modes(end);
    J1 = I.J1, J0 = I.J0, J2 = I.J2, C1 = I.C1;
    stiffness = basis.stiffness.diagonal();
  }
};

template <class Vector>
struct Motion {
  Vector rate = Vector::Zero(), acceleration = Vector::Zero(), mean = Vector::Zero(), increment = Vector::Zero();

  void predict(const AlphaMethod& method) { increment = method.predict(rate, acceleration, mean); }
  double correct(const AlphaMethod& method, const Vector& correction) {
    increment += correction;
    method.correct(correction, rate, acceleration, mean);
    return correction.cwiseAbs().maxCoeff();
  }
};

class FlexiblePendulum {
 public:
  FlexiblePendulum(const RodConstants& rod, const AlphaMethod& method) : rod_(rod), method_(method) {
    position_ = old_position_ = rod.hinge;
    attitude_ = old_attitude_ = Vector4(1, 0, 0, 0);
    eta_ = old_eta_ = Modal::Zero();
    multipliers_.setZero();
    // At rest as drawn: accelerations by the masses alone.
    evaluate();
    factorize(1, 0, 0);
    solve();
    linear_.acceleration = linear_.mean = shift_;
    angular_.acceleration = angular_.mean = turn_;
    modal_.acceleration = modal_.mean = strain_;
  }

  /// Returns the number of Newton iterations.
  int step(double tolerance) {
    old_position_ = position_;
    old_attitude_ = attitude_;
    old_eta_ = eta_;
    linear_.predict(method_);
    angular_.predict(method_);
    modal_.predict(method_);
    move();
    for (int iteration = 1;; ++iteration) {
      evaluate();
      if (iteration == 1) factorize(method_.acceleration_weight, method_.velocity_weight, 1);
      solve();
      const double largest = std::max(
          {linear_.correct(method_, shift_), angular_.correct(method_, turn_), modal_.correct(method_, strain_)});
      move();
      if (largest <= tolerance || iteration == 20) return iteration;
    }
  }

  Vector3 tip() const { return position_ + rotation_matrix(attitude_) * (rod_.tip + rod_.tip_modes * eta_); }

 private:
  void move() {
    position_ = old_position_ + linear_.increment;
    attitude_ = rotated(old_attitude_, angular_.increment);
    eta_ = old_eta_ + modal_.increment;
  }

  /// The residuals, and what the tangent needs of the deformed body.
  void evaluate() {
    const Vector3 &w = angular_.rate, &w_dot = angular_.acceleration;
    const Modal &rate = modal_.rate, &eta_dot_dot = modal_.acceleration;
    A_ = rotation_matrix(attitude_);
    // Inertia of the deformed body: G_k = J1_k + 2 J2_kl η_l, J = J0 + ½ (J1_k + G_k) η_k, Cr_k = C0_k - C1_k η.
    G_.noalias() = rod_.J2 * (2 * eta_);
    Eigen::Map<Modal6> G(G_.data());
    G += rod_.J1;
    s_ = rod_.s0 + rod_.Ct * eta_;
    J_ = symmetric(rod_.J0 + (rod_.J1 + G) * (0.5 * eta_));
    J_rate_ = symmetric(G * rate);
    Eigen::Map<Modes3>(U_.data()).noalias() = rod_.C1 * rate;
    Modes3 turned;
    turned.noalias() = rod_.C1 * eta_;
    Cr_ = rod_.C0 - Eigen::Map<const Modal3>(turned.data());
    s_rate_ = rod_.Ct * rate;
    spin_ = J_ * w + Cr_ * rate;

    const Vector3 lift = linear_.acceleration - Vector3(0, 0, -9.81), lift_body = A_.transpose() * lift;
    const Vector3 pull = w_dot.cross(s_) + rod_.Ct * eta_dot_dot + w.cross(Vector3(w.cross(s_) + 2 * s_rate_));
    force_ = rod_.mass * lift + A_ * pull + multipliers_.head<3>();
    hinge_axes();
    torque_ = s_.cross(lift_body) + J_ * w_dot + Cr_ * eta_dot_dot + J_rate_ * w + w.cross(spin_) +
              normals_ * multipliers_.tail<2>();
    const Vector6 ww(0.5 * w[0] * w[0], 0.5 * w[1] * w[1], 0.5 * w[2] * w[2], w[0] * w[1], w[0] * w[2], w[1] * w[2]);
    modal_force_ = eta_dot_dot + rod_.stiffness.cwiseProduct(eta_);
    modal_force_.noalias() += rod_.Ct.transpose() * lift_body;
    modal_force_.noalias() += Cr_.transpose() * w_dot;
    modal_force_.noalias() -= G.transpose() * ww;
    modal_force_.noalias() -= U_.transpose() * (2 * w);
  }

  /// The hinge's rows: position, then the body's y axis against the world's x and z axes.
  void hinge_axes() {
    const Vector3 x = A_.row(0), z = A_.row(2);
    gap_ << position_ - rod_.hinge, x[1], z[1];
    normals_.col(0) << x[2], 0, -x[0];
    normals_.col(1) << z[2], 0, -z[0];
  }

  /// Weights of the derivatives by v̇, v and q. What Newton does not need is left out: loads, modal gyroscopics.
  void factorize(double a, double d, double k) {
    const Vector3& w = angular_.rate;
    const Matrix3 W = skew(w), s = skew(s_);
    const Eigen::Map<const Modal6> G(G_.data());
    Modal3 Gw;
    for (int m = 0; m < kModes; ++m) Gw.col(m) = symmetric(G.col(m)) * w;
    inverse_ = (k * rod_.stiffness.array() + a).inverse();
    const Modal3 ACt = A_ * rod_.Ct;
    frame_modal_.topRows<3>() = a * ACt + (2 * d) * (A_ * (W * rod_.Ct));
    frame_modal_.bottomRows<3>() = a * Cr_ + d * (Gw + W * Cr_ + U_);
    modal_frame_.leftCols<3>() = a * ACt.transpose();
    modal_frame_.rightCols<3>() = (a * Cr_ - d * (Gw + 2 * U_)).transpose();
    modal_frame_ = (inverse_.asDiagonal() * modal_frame_).eval();

    Eigen::Matrix<double, 11, 11> S = Eigen::Matrix<double, 11, 11>::Zero();
    S.block<6, 6>(0, 0).noalias() = -(frame_modal_ * modal_frame_);
    S.block<3, 3>(0, 0).diagonal().array() += a * rod_.mass;
    const Matrix3 As = a * (A_ * s);
    S.block<3, 3>(0, 3) -= As + d * (A_ * (skew(w.cross(s_)) + W * s + 2 * skew(s_rate_)));
    S.block<3, 3>(3, 0) -= As.transpose();
    S.block<3, 3>(3, 3) += a * J_ + d * (J_rate_ + W * J_ - skew(spin_));
    S.block<3, 3>(0, 6).setIdentity();
    S.block<3, 3>(6, 0).setIdentity();
    S.block<3, 2>(3, 9) = normals_;
    S.block<2, 3>(9, 3) = normals_.transpose();
    factor_.compute(S);
  }

  /// Corrections of frame, modes and multipliers.
  void solve() {
    const Modal alone = inverse_.cwiseProduct(modal_force_);
    Small right;
    right << force_, torque_, gap_;
    right.head<6>().noalias() -= frame_modal_ * alone;
    const Small y = factor_.solve(right);
    shift_ = -y.head<3>();
    turn_ = -y.segment<3>(3);
    strain_ = modal_frame_ * y.head<6>() - alone;
    multipliers_ -= y.tail<5>();
  }

  const RodConstants& rod_;
  const AlphaMethod method_;
  Vector3 position_, old_position_;
  Vector4 attitude_, old_attitude_;
  Modal eta_, old_eta_;
  Motion<Vector3> linear_, angular_;
  Motion<Modal> modal_;
  Rows multipliers_;

  Matrix3 A_, J_, J_rate_;
  Vector3 s_, s_rate_, spin_;
  Modal3 Cr_, U_;  // columns C1_k η̇
  Modes6 G_;
  Vector3 force_, torque_;
  Modal modal_force_;
  Rows gap_;
  Eigen::Matrix<double, 3, 2> normals_;

  Modal inverse_;  // of the modes' block
  Eigen::Matrix<double, 6, kModes> frame_modal_;
  Eigen::Matrix<double, kModes, 6> modal_frame_;  // times the inverse
  Eigen::PartialPivLU<Eigen::Matrix<double, 11, 11>> factor_;
  Vector3 shift_, turn_;
  Modal strain_;
};

}  // namespace
}  // namespace lithe::bench

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const int repeats = arguments.integer("repeat", 5);
    const double end = arguments.number("T", 20), tolerance = arguments.number("newton", 1e-10);
    const long steps = std::max(1L, std::lround(end / arguments.number("dt", 1e-3)));
    const AlphaMethod method(end / static_cast<double>(steps), arguments.number("rho", 0.9));
    arguments.finish();

    const lithe::FiniteElementModel model = rod_model();
    const RodConstants rod(*lithe::make_basis(model, lithe::HingeFrame{model.node_set("hinge")}, kModes));
    const Cost cost = least_of(repeats, [&] {
      FlexiblePendulum pendulum(rod, method);
      Cost run{.steps = steps, .factorizations = steps};
      const double started = cpu_seconds();
      for (long i = 0; i < steps; ++i) run.newton_iterations += pendulum.step(tolerance);
      run.seconds = cpu_seconds() - started;
      Eigen::Map<lithe::Vector3>(run.tip) = pendulum.tip();
      return run;
    });
    JsonLine line;
    line.add("program", "limit_flexible").add("modes", kModes);
    cost.add_to(line).print();
  });
}
