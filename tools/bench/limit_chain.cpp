// limit_chain: how fast can a computer be at one scene? Unit rods of 1 kg and 1 m, ball-jointed one to the next, start
// level and at rest, and fall. Nothing here is general: this is the yardstick beside which chain.cpp is measured.
//
//   --n 1000   rods        --dt 1e-3  step, s       --T 1       time, s
//   --rho 0.9  at infinity --newton 1e-9  largest last correction    --repeat 5  runs, the cheapest counts
//
// Equations of a rod, with λ_in, λ_out the multipliers of its two joints and B = A (½ e_x)~:
//   m (v̇ - g) + λ_in - λ_out = 0
//   J ω̇ + ω × J ω + Bᵀ (λ_in + λ_out) = 0        and for each joint   p_in end - p_out end of the rod before = 0.
// A Newton step takes the rods out first, a scalar and a 3x3 matrix each; 3x3 blocks of the joints remain, tied to
// their neighbours alone, and go from the free end to the pin. One factorization a step serves all its iterations.
#include <Eigen/LU>
#include <vector>

#include "engine/base/math.h"
#include "tools/bench/alpha_method.h"
#include "tools/bench/measure.h"

namespace lithe::bench {
namespace {

constexpr double kMass = 1, kHalf = 0.5, kGravity = 9.81;
const Vector3 kInertia(1.25e-3, 1.0 / 12, 1.0 / 12);

/// Position or attitude of a rod through a step.
struct Motion {
  Vector3 rate, acceleration, mean;
  Vector3 increment;  // since the step began
};

struct Rod {
  Vector3 position;
  Vector4 attitude;
  Motion linear, angular;
  Vector3 old_position;
  Vector4 old_attitude;
  Matrix3 A, B;
  Matrix3 compliance;     // inverse of the angular block
  Vector3 force, torque;  // residuals; solve() leaves them divided by their blocks
};

/// Block row of one joint: diagonal (inverted when factorised), coupling to the next joint, and that one's share.
struct JointRow {
  Matrix3 diagonal, next, lower;
  Vector3 gap, multiplier, correction;
};

class FallingChain {
 public:
  FallingChain(int count, const AlphaMethod& method) : method_(method), rods_(count), joints_(count + 1) {
    for (int i = 0; i < count; ++i) {
      Rod& rod = rods_[i];
      rod.position = Vector3(2 * kHalf * i + kHalf, 0, 0);
      rod.attitude = Vector4(1, 0, 0, 0);
      for (Motion* motion : {&rod.linear, &rod.angular})
        motion->rate = motion->acceleration = motion->mean = Vector3::Zero();
    }
    for (JointRow& joint : joints_)
      joint.multiplier = joint.correction = Vector3::Zero();  // beyond the tip: always zero
    start();
  }

  /// Returns the number of Newton iterations.
  int step(double tolerance) {
    for (Rod& rod : rods_) {
      rod.old_position = rod.position;
      rod.old_attitude = rod.attitude;
      for (Motion* motion : {&rod.linear, &rod.angular})
        motion->increment = method_.predict(motion->rate, motion->acceleration, motion->mean);
      move(rod);
    }
    for (int iteration = 1;; ++iteration) {
      evaluate();
      if (iteration == 1) factorize(method_.acceleration_weight, method_.velocity_weight);
      solve();
      if (correct() <= tolerance || iteration == 20) return iteration;
    }
  }

  Vector3 tip() const { return rods_.back().position + kHalf * rotation_matrix(rods_.back().attitude).col(0); }

 private:
  static void move(Rod& rod) {
    rod.position = rod.old_position + rod.linear.increment;
    rod.attitude = rotated(rod.old_attitude, rod.angular.increment);
  }

  /// Accelerations and multipliers of the chain at rest: the same elimination with the masses themselves.
  void start() {
    evaluate();
    factorize(1, 0);
    solve();
    const int count = static_cast<int>(rods_.size());
    for (int i = 0; i < count; ++i) {
      Rod& rod = rods_[i];
      rod.linear.acceleration = rod.linear.mean = linear_correction(i);
      rod.angular.acceleration = rod.angular.mean = angular_correction(i);
      joints_[i].multiplier += joints_[i].correction;
    }
  }

  /// Residuals at the present state.
  void evaluate() {
    const Vector3 gravity(0, 0, -kGravity);
    Vector3 end = Vector3::Zero();
    for (std::size_t i = 0; i < rods_.size(); ++i) {
      Rod& rod = rods_[i];
      const Vector3 &in = joints_[i].multiplier, &out = joints_[i + 1].multiplier, &w = rod.angular.rate;
      rod.A = rotation_matrix(rod.attitude);
      rod.B.col(0).setZero();
      rod.B.col(1) = kHalf * rod.A.col(2);
      rod.B.col(2) = -kHalf * rod.A.col(1);
      const Vector3 arm = kHalf * rod.A.col(0);
      joints_[i].gap = rod.position - arm - end;
      end = rod.position + arm;
      rod.force = kMass * (rod.linear.acceleration - gravity) + in - out;
      rod.torque = kInertia.cwiseProduct(rod.angular.acceleration) + w.cross(Vector3(kInertia.cwiseProduct(w))) +
                   rod.B.transpose() * (in + out);
    }
  }

  void factorize(double mass_weight, double velocity_weight) {
    mobility_ = 1 / (mass_weight * kMass);
    const Matrix3 arm = skew(Vector3(kHalf, 0, 0));
    const int count = static_cast<int>(rods_.size());
    Matrix3 before = Matrix3::Zero();  // what the rod before adds to the joint's diagonal
    for (int i = 0; i < count; ++i) {
      Rod& rod = rods_[i];
      const Vector3& w = rod.angular.rate;
      const Vector3 load = rod.A.transpose() * (joints_[i].multiplier + joints_[i + 1].multiplier);
      // ∂/∂ω of the gyroscopic torque, and ∂(Bᵀ λ)/∂θ, the stiffness of the loaded joints.
      Matrix3 K = velocity_weight * (skew(w) * kInertia.asDiagonal().toDenseMatrix() - skew(kInertia.cwiseProduct(w))) -
                  arm * skew(load);
      K.diagonal() += mass_weight * kInertia;
      rod.compliance = K.inverse();
      const Matrix3 turning = rod.B * rod.compliance * rod.B.transpose();
      Matrix3 here = turning;
      here.diagonal().array() += mobility_;
      joints_[i].diagonal = before + here;
      joints_[i].next = turning;
      joints_[i].next.diagonal().array() -= mobility_;
      before = here;
    }
    // From the free end inwards. The coupling is symmetric but for the load's share, which Newton makes good.
    for (int i = count - 1; i > 0; --i) {
      JointRow &outer = joints_[i], &inner = joints_[i - 1];
      outer.diagonal = outer.diagonal.inverse().eval();
      outer.lower = inner.next * outer.diagonal;
      inner.diagonal.noalias() -= outer.lower * inner.next.transpose();
    }
    joints_[0].diagonal = joints_[0].diagonal.inverse().eval();
  }

  /// Corrections of the multipliers: (G K⁻¹ Gᵀ) y = gap - G K⁻¹ r, by the factor.
  void solve() {
    const int count = static_cast<int>(rods_.size());
    Vector3 carried = Vector3::Zero();
    for (int i = 0; i < count; ++i) {
      Rod& rod = rods_[i];
      rod.torque = (rod.compliance * rod.torque).eval();
      rod.force *= mobility_;
      const Vector3 turn = rod.B * rod.torque;
      joints_[i].correction = joints_[i].gap - rod.force - turn + carried;
      carried = rod.force - turn;
    }
    for (int i = count - 1; i > 0; --i) joints_[i - 1].correction.noalias() -= joints_[i].lower * joints_[i].correction;
    joints_[0].correction = (joints_[0].diagonal * joints_[0].correction).eval();
    for (int i = 1; i < count; ++i) {
      joints_[i].correction.noalias() -= joints_[i - 1].next.transpose() * joints_[i - 1].correction;
      joints_[i].correction = (joints_[i].diagonal * joints_[i].correction).eval();
    }
  }

  Vector3 linear_correction(int i) const {
    return mobility_ * (joints_[i + 1].correction - joints_[i].correction) - rods_[i].force;
  }
  Vector3 angular_correction(int i) const {
    const Rod& rod = rods_[i];
    return -rod.torque - rod.compliance * (rod.B.transpose() * (joints_[i].correction + joints_[i + 1].correction));
  }

  /// Applies the corrections; returns the largest component.
  double correct() {
    double largest = 0;
    const int count = static_cast<int>(rods_.size());
    for (int i = 0; i < count; ++i) {
      Rod& rod = rods_[i];
      const Vector3 shift = linear_correction(i), turn = angular_correction(i);
      rod.linear.increment += shift;
      rod.angular.increment += turn;
      method_.correct(shift, rod.linear.rate, rod.linear.acceleration, rod.linear.mean);
      method_.correct(turn, rod.angular.rate, rod.angular.acceleration, rod.angular.mean);
      move(rod);
      joints_[i].multiplier += joints_[i].correction;
      largest = std::max({largest, shift.cwiseAbs().maxCoeff(), turn.cwiseAbs().maxCoeff()});
    }
    return largest;
  }

  const AlphaMethod method_;
  std::vector<Rod> rods_;
  std::vector<JointRow> joints_;  // one more than rods: nothing hangs on the last
  double mobility_ = 0;           // inverse of the linear block
};

}  // namespace
}  // namespace lithe::bench

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const int count = arguments.integer("n", 1000), repeats = arguments.integer("repeat", 5);
    const double end = arguments.number("T", 1), tolerance = arguments.number("newton", 1e-9);
    const long steps = std::max(1L, std::lround(end / arguments.number("dt", 1e-3)));
    const AlphaMethod method(end / static_cast<double>(steps), arguments.number("rho", 0.9));
    arguments.finish();

    const Cost cost = least_of(repeats, [&] {
      FallingChain chain(count, method);
      Cost run{.steps = steps, .factorizations = steps};
      const double started = cpu_seconds();
      for (long i = 0; i < steps; ++i) run.newton_iterations += chain.step(tolerance);
      run.seconds = cpu_seconds() - started;
      Eigen::Map<lithe::Vector3>(run.tip) = chain.tip();
      return run;
    });
    JsonLine line;
    line.add("program", "limit_chain").add("n", count);
    line.add("us_per_link_step", cost.microseconds_per_step() / count, 5);
    line.add("peak_bytes", peak_memory());
    cost.add_to(line).print();
  });
}
