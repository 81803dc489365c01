#include "tests/support/body_checks.h"

#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/motion/projection.h"
#include "tests/support/dense.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/motion.h"

namespace lithe::test {
namespace {

double relative(const MatrixX& got, const MatrixX& want, double scale = 0) {
  return (got - want).cwiseAbs().maxCoeff() / std::max({want.cwiseAbs().maxCoeff(), scale, 1e-300});
}

/// J v of a marker as documented, and J v_dot + bias, without the engine's joints; `frame`: velocities of frames.
Vector6 twist(const MarkerKinematics& k, const VectorX& v, int frame) {
  Vector6 V = Vector6::Zero();
  if (k.between) {
    for (const MarkerBetween::Share& share : k.between->shares) V += share.J * v.segment<6>(6 * share.frame);
    return V;
  }
  if (frame) {
    const int at = 6 * k.frame;
    V.head<3>() = v.segment<3>(at) + *k.A * Vector3(v.segment<3>(at + 3)).cross(k.r);
    V.tail<3>() = *k.A * v.segment<3>(at + 3);
  }
  const int n = static_cast<int>(v.size()) - frame;
  if (k.elastic) {
    const Vector6 E = Eigen::Map<const Matrix6X>(k.elastic, 6, n) * v.tail(n);
    V.head<3>() += *k.A * E.head<3>();
    V.tail<3>() += *k.A * E.tail<3>();
  }
  return V;
}

}  // namespace

void check_body(SystemGraph& graph, const Body& body, const std::vector<Marker>& markers,
                const BodyExpectation& expected) {
  const System system = assemble(graph);
  const Layout& layout = system.layout();
  Evaluator equations(system);
  const int n = layout.v_count(), frame = 6 * body.coordinates().frames;
  const VectorX no_rows = VectorX::Zero(layout.row_count()), still = VectorX::Zero(n);
  RandomNumbers random(7);

  const auto residual = [&](const VectorX& q, const VectorX& v, const VectorX& v_dot) {
    equations.evaluate(0, q, v, Level::velocity);
    VectorX r(n);
    equations.residual(v_dot, no_rows, r);
    return r;
  };
  const auto energy = [&](const VectorX& q, const VectorX& v) {
    equations.evaluate(0, q, v, Level::velocity);
    return equations.energy();
  };

  for (int trial = 0; trial < 2; ++trial) {
    VectorX d(n);
    d.head(frame) = random.vector(frame);
    d.tail(n - frame) = random.vector(n - frame, expected.deformation);
    VectorX q(layout.q_count()), v = random.vector(n, expected.speed);
    v.tail(n - frame) *= expected.deformation * 50;
    layout.retract(system.initial_state().q, d, q);

    equations.evaluate(0, q, v, Level::acceleration);
    equations.factorize({0, 0, 1}, still, no_rows, nullptr);
    const MatrixX M = dense(equations).S();
    EXPECT_LT(relative(M, M.transpose()), 1e-13);
    EXPECT_GT(symmetric_eigenvalues(M, MatrixX::Identity(n, n))[0], 0);
    EXPECT_NEAR(energy(q, v).kinetic / (0.5 * v.dot(M * v)), 1, 1e-11);

    // Weight and virtual work at rest.
    const VectorX force = -residual(q, still, still);
    const auto potential = [&](const VectorX& at) {
      const BodyEnergy e = energy(at, still);
      return VectorX::Constant(1, e.gravity + e.elastic);
    };
    const VectorX work = -jacobian(layout, q, potential).transpose();
    EXPECT_LT(relative(force, work), expected.tolerance);
    if (frame) {
      Vector3 weight = Vector3::Zero();
      for (int i = 0; i < frame; i += 6) weight += force.segment<3>(i);
      EXPECT_LT(relative(weight, expected.mass * system.gravity()), 1e-11);
    }

    // The body's own motion: its energy changes by damping alone.
    VectorX a(n), none = no_rows;
    Projector(equations).accelerations(0, q, v, a, none);
    EXPECT_LT(residual(q, v, a).cwiseAbs().maxCoeff(), 1e-9 * residual(q, v, still).cwiseAbs().maxCoeff());
    const SmoothMotion motion{layout, q, v, a};
    const double stretch = std::min(1e-3, 3e-4 / std::sqrt(1 + a.cwiseAbs().maxCoeff()));
    const double power =
        derivative([&](double t) { return energy(motion.position(t), motion.velocity(t)).total(); }, stretch);
    const double traffic = v.cwiseProduct(M * a).cwiseAbs().sum();
    if (expected.dissipation > 0) {
      EXPECT_LT(power, 0);
    } else {
      EXPECT_LT(std::abs(power), 1e-7 * traffic);
    }

    // Markers.
    for (const Marker& m : markers) {
      const auto at = [&](double t) {
        equations.evaluate(0, motion.position(t), motion.velocity(t), Level::acceleration);
        return marker_kinematics(equations, m, Level::acceleration);
      };
      const MarkerKinematics k = at(0);
      Vector6 velocity, acceleration;
      velocity << derivative([&](double t) -> Vector3 { return at(t).p; }, stretch), Vector3::Zero();
      const Matrix3 spin = derivative([&](double t) -> Matrix3 { return at(t).R; }, stretch) * k.R.transpose();
      velocity.tail<3>() << spin(2, 1), spin(0, 2), spin(1, 0);
      acceleration << derivative([&](double t) -> Vector3 { return at(t).v; }, stretch),
          derivative([&](double t) -> Vector3 { return at(t).w; }, stretch);
      const MarkerKinematics now = at(0);
      Vector6 stated, bias;
      stated << now.v, now.w;
      bias << now.bias_v, now.bias_w;
      EXPECT_LT(relative(stated, velocity, 1), 1e-8) << "marker " << m.index;
      EXPECT_LT(relative(twist(now, v, frame), stated, 1e-3), 1e-12) << "marker " << m.index;
      EXPECT_LT(relative(twist(now, a, frame) + bias, acceleration, 1), 1e-7) << "marker " << m.index;
    }

    // ∂r/∂v, exact but for what it knows nothing of.
    equations.evaluate(0, q, v, Level::velocity);
    equations.factorize({0, 1, 0}, a, no_rows, nullptr);
    MatrixX D = dense(equations).S(), exact(n, n);
    for (int j = 0; j < n; ++j)
      exact.col(j) = derivative([&](double t) -> VectorX { return residual(q, v + t * VectorX::Unit(n, j), a); }, 1e-2);
    D.bottomRightCorner(n - frame, n - frame).setZero();
    exact.bottomRightCorner(n - frame, n - frame).setZero();
    if (D.topRightCorner(frame, n - frame).isZero(0)) exact.topRightCorner(frame, n - frame).setZero();
    if (frame) {
      EXPECT_LT((D - exact).cwiseAbs().maxCoeff(), 1e-8 * (1 + exact.cwiseAbs().maxCoeff()));
    }
  }
}

void check_position_tangent(SystemGraph& graph, const Body& body, double speed, double deformation) {
  const System system = assemble(graph);
  const Layout& layout = system.layout();
  Evaluator equations(system);
  const int n = layout.v_count(), frame = 6 * body.coordinates().frames, linear = n - frame;
  const VectorX no_rows = VectorX::Zero(layout.row_count());
  RandomNumbers random(11);
  VectorX d(n), q(layout.q_count()), v = random.vector(n, speed), a = random.vector(n, 10 * speed);
  d.head(frame) = random.vector(frame);
  d.tail(linear) = random.vector(linear, deformation);
  v.tail(linear).setZero();
  a.tail(linear).setZero();
  layout.retract(system.initial_state().q, d, q);
  MatrixX exact = jacobian(
      layout, q,
      [&](const VectorX& at) {
        equations.evaluate(0, at, v, Level::velocity);
        VectorX r(n);
        equations.residual(a, no_rows, r);
        return r;
      },
      deformation);
  equations.evaluate(0, q, v, Level::velocity);
  equations.factorize({1, 0, 0}, a, no_rows, nullptr);
  MatrixX K = dense(equations).S();
  // The stiffness of the modes, many times larger than the rest, is left out of both.
  K.bottomRightCorner(linear, linear).setZero();
  exact.bottomRightCorner(linear, linear).setZero();
  EXPECT_LT(relative(K, exact), 1e-8);
}

}  // namespace lithe::test
