// limit_beam: how fast can a computer be at one beam? A straight cantilever of 1 m, clamped at its root, starts level
// and at rest, and falls: n elements of the helix between two nodes (docs/equations.md 4.6), rigid pieces at the nodes.
// Nothing here is general: this is the yardstick beside which beam.cpp is measured.
//
//   --n 100    elements    --dt 1e-3  step, s   --T 1  time, s
//   --rho 0.9  at infinity --newton 1e-9  largest last correction    --repeat 5  runs, the cheapest counts
//
// With d = (u, φ) = log(H_A⁻¹ H_B), T⁻¹(d) = [F, G; 0, F], F = E + ½ φ~ + k φ~², an element pulls at its ends with
//   (-T⁻ᵀ(-d), T⁻ᵀ(d)) C (d - d_0) / L                          in the axes of the ends.
// Nodes are tied to their neighbours alone: 6x6 blocks, eliminated from the tip to the root, once a step. What the
// resultants themselves add to the tangent stays out: one iteration more a step, and the cheaper for it (3.0 µs instead
// of 3.9 an element).
#include <Eigen/LU>
#include <vector>

#include "engine/base/math.h"
#include "tools/bench/alpha_method.h"
#include "tools/bench/beam_scene.h"
#include "tools/bench/measure.h"

namespace lithe::bench {
namespace {

constexpr double kGravity = 9.81;

struct Node {
  Vector3 position, old_position;
  Vector4 attitude, old_attitude;
  Vector6 rate, acceleration, mean, increment;  // (ṗ world axes, ω body axes)
  Matrix3 A;
  Vector6 residual, correction;
  Matrix6 diagonal, outer, lower;  // the last two: coupling to the node after, and its share in the elimination
};

/// T⁻¹(d) = [F, G; 0, F]; of -d: [F₋, G₋; 0, F₋]. And d itself.
struct Helix {
  Vector6 d;
  Matrix3 F, G, F_minus, G_minus;

  void between(const Node& a, const Node& b) {
    const Vector4 &p = a.attitude, &q = b.attitude;  // conj(p) q, small: never half a turn
    const double w = p.dot(q);
    Vector3 v(p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2],
              p[0] * q[2] + p[1] * q[3] - p[2] * q[0] - p[3] * q[1],
              p[0] * q[3] - p[1] * q[2] + p[2] * q[1] - p[3] * q[0]);
    if (w < 0) v = -v;
    const double s = v.norm();
    const double scale = s < 1e-4 ? 2 + s * s / 3 : 2 * std::atan2(s, std::abs(w)) / s;
    const Vector3 phi = scale * v, r = a.A.transpose() * (b.position - a.position);
    const double t = phi.squaredNorm();
    // k(t) and its derivative; the series serves up to a quarter turn.
    const double k = 1.0 / 12 + t * (1.0 / 720 + t * (1.0 / 30240 + t * (1.0 / 1209600 + t / 47900160)));
    const double k_t = 1.0 / 720 + t * (2.0 / 30240 + t * (3.0 / 1209600 + t * 4.0 / 47900160));
    const Vector3 turned = phi.cross(r), u = r - 0.5 * turned + k * phi.cross(turned);
    d << u, phi;
    const Matrix3 f = skew(phi), g = skew(u);
    const double along = phi.dot(u);
    Matrix3 ff = phi * phi.transpose(), fg = phi * u.transpose();
    fg += fg.transpose().eval();
    ff.diagonal().array() -= t;
    fg.diagonal().array() -= 2 * along;
    const Matrix3 even = k * ff, mixed = k * fg + (2 * k_t * along) * ff;
    F = even + 0.5 * f, F_minus = even - 0.5 * f;
    F.diagonal().array() += 1, F_minus.diagonal().array() += 1;
    G = mixed + 0.5 * g, G_minus = mixed - 0.5 * g;
  }
};

class FallingBeam {
 public:
  FallingBeam(int elements, const AlphaMethod& method) : method_(method), nodes_(elements + 1), helices_(elements) {
    const double length = BeamScene::kLength / elements;
    length_ = length;
    stiffness_ = BeamScene::stiffness() / length;
    mass_ = BeamScene::kMass * length;
    for (int axis = 0; axis < 3; ++axis)
      inertia_[axis] = BeamScene::inertia()[axis] * length + (axis == 0 ? 0 : mass_ * length * length / 12);
    // The piece at the tip: half as long, its centre a quarter of an element inside.
    tip_mass_ = mass_ / 2, tip_centre_ = -length / 4;
    for (int axis = 0; axis < 3; ++axis)
      tip_inertia_[axis] = BeamScene::inertia()[axis] * length / 2 +
                           (axis == 0 ? 0 : tip_mass_ * length * length * (1.0 / 48 + 1.0 / 16));
    for (int i = 0; i <= elements; ++i) {
      Node& node = nodes_[i];
      node.position = {i * length, 0, 0};
      node.attitude = {1, 0, 0, 0};
      node.rate = node.acceleration = node.mean = node.correction = Vector6::Zero();
      node.A.setIdentity();
    }
    evaluate();
    factorize(1, 0, 0);
    solve();
    for (Node& node : nodes_) node.acceleration = node.mean = node.correction;
  }

  /// Returns the number of Newton iterations.
  int step(double tolerance) {
    for (std::size_t i = 1; i < nodes_.size(); ++i) {
      Node& node = nodes_[i];
      node.old_position = node.position;
      node.old_attitude = node.attitude;
      node.increment = method_.predict(node.rate, node.acceleration, node.mean);
      move(node);
    }
    for (int iteration = 1;; ++iteration) {
      evaluate();
      if (iteration == 1) factorize(method_.acceleration_weight, method_.velocity_weight, 1);
      solve();
      double largest = 0;
      for (std::size_t i = 1; i < nodes_.size(); ++i) {
        Node& node = nodes_[i];
        node.increment += node.correction;
        method_.correct(node.correction, node.rate, node.acceleration, node.mean);
        move(node);
        largest = std::max(largest, node.correction.cwiseAbs().maxCoeff());
      }
      if (largest <= tolerance || iteration == 20) return iteration;
    }
  }

  Vector3 tip() const { return nodes_.back().position; }

 private:
  static void move(Node& node) {
    node.position = node.old_position + node.increment.head<3>();
    node.attitude = rotated(node.old_attitude, Vector3(node.increment.tail<3>()));
    node.A = rotation_matrix(node.attitude);
  }

  void evaluate() {
    const std::size_t last = nodes_.size() - 1;
    for (std::size_t i = 1; i < last; ++i) {
      Node& node = nodes_[i];
      const Vector3 w = node.rate.tail<3>();
      node.residual.head<3>() = mass_ * node.acceleration.head<3>();
      node.residual[2] += mass_ * kGravity;
      node.residual.tail<3>() =
          inertia_.cwiseProduct(node.acceleration.tail<3>()) + w.cross(Vector3(inertia_.cwiseProduct(w)));
    }
    Node& end = nodes_[last];
    const Vector3 w = end.rate.tail<3>(), turn = end.acceleration.tail<3>(), c(tip_centre_, 0, 0);
    const Vector3 lift = end.acceleration.head<3>() + Vector3(0, 0, kGravity);
    end.residual.head<3>() = tip_mass_ * (lift + end.A * (turn.cross(c) + w.cross(Vector3(w.cross(c)))));
    end.residual.tail<3>() = tip_inertia_.cwiseProduct(turn) + w.cross(Vector3(tip_inertia_.cwiseProduct(w))) +
                             tip_mass_ * c.cross(Vector3(end.A.transpose() * lift));
    for (std::size_t e = 0; e < last; ++e) {
      Node &a = nodes_[e], &b = nodes_[e + 1];
      Helix& h = helices_[e];
      h.between(a, b);
      Vector6 strain = h.d;
      strain[0] -= length_;
      const Vector6 s = stiffness_.cwiseProduct(strain);
      const Vector3 n = s.head<3>(), m = s.tail<3>();
      if (e > 0) {
        a.residual.head<3>() -= a.A * (h.F_minus.transpose() * n);
        a.residual.tail<3>() -= h.G_minus.transpose() * n + h.F_minus.transpose() * m;
      }
      b.residual.head<3>() += b.A * (h.F.transpose() * n);
      b.residual.tail<3>() += h.G.transpose() * n + h.F.transpose() * m;
    }
  }

  void factorize(double a, double v, double p) {
    const std::size_t last = nodes_.size() - 1;
    for (std::size_t i = 1; i <= last; ++i) {
      Node& node = nodes_[i];
      const Vector3 w = node.rate.tail<3>(), &J = i < last ? inertia_ : tip_inertia_;
      node.diagonal.setZero();
      node.diagonal.topLeftCorner<3, 3>().diagonal().setConstant(a * (i < last ? mass_ : tip_mass_));
      Matrix3 turning = v * (skew(w) * J.asDiagonal().toDenseMatrix() - skew(Vector3(J.cwiseProduct(w))));
      turning.diagonal() += a * J;
      node.diagonal.bottomRightCorner<3, 3>() = turning;
    }
    Node& end = nodes_[last];
    const Vector3 w = end.rate.tail<3>(), c(tip_centre_, 0, 0);
    const Matrix3 arm = tip_mass_ * skew(c);
    end.diagonal.topRightCorner<3, 3>() -=
        end.A * (a * arm + v * tip_mass_ * (skew(Vector3(w.cross(c))) + skew(w) * skew(c)));
    end.diagonal.bottomLeftCorner<3, 3>() += a * arm * end.A.transpose();
    if (p != 0) stiffen();
    for (std::size_t i = last; i > 1; --i) {
      Node &outer = nodes_[i], &inner = nodes_[i - 1];
      outer.diagonal = outer.diagonal.inverse().eval();
      outer.lower.noalias() = inner.outer * outer.diagonal;
      inner.diagonal.noalias() -= outer.lower * inner.outer.transpose();
    }
    nodes_[1].diagonal = nodes_[1].diagonal.inverse().eval();
  }

  /// Pᵀ C P / L of each element: the symmetric part of the tangent.
  void stiffen() {
    for (std::size_t e = 0; e < helices_.size(); ++e) {
      const Helix& h = helices_[e];
      Node &a = nodes_[e], &b = nodes_[e + 1];
      Matrix6 A = Matrix6::Zero(), B = Matrix6::Zero();
      const Matrix3 A_t = a.A.transpose(), B_t = b.A.transpose();
      A.topLeftCorner<3, 3>().noalias() = -h.F_minus * A_t;
      A.topRightCorner<3, 3>() = -h.G_minus, A.bottomRightCorner<3, 3>() = -h.F_minus;
      B.topLeftCorner<3, 3>().noalias() = h.F * B_t;
      B.topRightCorner<3, 3>() = h.G, B.bottomRightCorner<3, 3>() = h.F;
      const Matrix6 CB = stiffness_.asDiagonal() * B;
      if (e > 0) {
        a.diagonal.noalias() += A.transpose() * (stiffness_.asDiagonal() * A);
        a.outer.noalias() = A.transpose() * CB;
      }
      b.diagonal.noalias() += B.transpose() * CB;
    }
  }

  void solve() {
    const std::size_t last = nodes_.size() - 1;
    for (std::size_t i = last; i > 1; --i) nodes_[i - 1].residual.noalias() -= nodes_[i].lower * nodes_[i].residual;
    nodes_[1].correction.noalias() = -(nodes_[1].diagonal * nodes_[1].residual);
    for (std::size_t i = 2; i <= last; ++i) {
      Node& node = nodes_[i];
      node.correction.noalias() = -(node.diagonal * node.residual);
      node.correction.noalias() -= node.lower.transpose() * nodes_[i - 1].correction;
    }
  }

  const AlphaMethod method_;
  std::vector<Node> nodes_;  // the first is clamped
  std::vector<Helix> helices_;
  double length_, mass_, tip_mass_, tip_centre_;
  Vector6 stiffness_;              // over the element's length
  Vector3 inertia_, tip_inertia_;  // of the pieces, about their nodes
};

}  // namespace
}  // namespace lithe::bench

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const int count = arguments.integer("n", 100), repeats = arguments.integer("repeat", 5);
    const double end = arguments.number("T", 1), tolerance = arguments.number("newton", 1e-9);
    const long steps = std::max(1L, std::lround(end / arguments.number("dt", 1e-3)));
    const AlphaMethod method(end / static_cast<double>(steps), arguments.number("rho", 0.9));
    arguments.finish();

    const Cost cost = least_of(repeats, [&] {
      FallingBeam beam(count, method);
      Cost run{.steps = steps, .factorizations = steps};
      const double started = cpu_seconds();
      for (long i = 0; i < steps; ++i) run.newton_iterations += beam.step(tolerance);
      run.seconds = cpu_seconds() - started;
      Eigen::Map<lithe::Vector3>(run.tip) = beam.tip();
      return run;
    });
    JsonLine line;
    line.add("program", "limit_beam").add("n", count);
    line.add("us_per_element_step", cost.microseconds_per_step() / count, 5);
    cost.add_to(line).print();
  });
}
