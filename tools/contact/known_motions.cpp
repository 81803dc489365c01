#include "tools/contact/known_motions.h"

#include <cmath>

#include "bodies/rigid_body.h"

namespace lithe::contact_bench {
namespace {

constexpr double kGravity = 9.81;

/// A ball of 1 kg thrown at 5 m/s over level ground, friction 0.2: it rolls after 2 v / (7 μ g), then at 5/7 v.
KnownMotion thrown_ball() {
  constexpr double radius = 0.1, speed = 5, friction = 0.2, end = 2;
  const double rolls = 2 * speed / (7 * friction * kGravity);
  const double way = speed * rolls - 0.5 * friction * kGravity * rolls * rolls + 5 * speed / 7 * (end - rolls);
  return {"thrown_ball",
          "A ball slides, then rolls: position after 2 s",
          end,
          [=](SystemGraph& graph, const auto& law) {
            auto& ball = graph.add<RigidBody>("body", {.mass = 1,
                                                       .inertia = Vector3(Vector3::Constant(0.4 * radius * radius)),
                                                       .position = {0, 0, radius},
                                                       .velocity = {speed, 0, 0}});
            graph.add<Contact>("floor",
                               {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(radius)}},
                               {.law = law, .friction = {.coefficient = friction}});
          },
          0,
          [=](const State& state) { return (state.q.head<3>() - Vector3(way, 0, radius)).norm(); }};
}

/// Dropped by 1 m with restitution 0.8.
KnownMotion bouncing_ball() {
  constexpr double radius = 0.1, drop = 1, restitution = 0.8, end = 3;
  double time = std::sqrt(2 * drop / kGravity), speed = restitution * kGravity * time;
  while (time + 2 * speed / kGravity < end) time += 2 * speed / kGravity, speed *= restitution;
  const double left = end - time, height = speed * left - 0.5 * kGravity * left * left;
  return {"bouncing_ball",
          "A ball bounces: height after 3 s",
          end,
          [=](SystemGraph& graph, const auto& law) {
            auto& ball = graph.add<RigidBody>("body", {.mass = 1,
                                                       .inertia = Vector3(Vector3::Constant(0.4 * radius * radius)),
                                                       .position = {0, 0, radius + drop}});
            graph.add<Contact>("floor",
                               {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(radius)}},
                               {.law = law});
          },
          restitution,
          [=](const State& state) { return std::abs(state.q[2] - radius - height); }};
}

/// Tilt of a block that rocks about one corner and the other:  θ̈ = -p² sin(α - θ), and at θ = 0 the angular momentum
/// about the new corner stays: ω' = (1 - 3/2 sin² α) ω. Runge-Kutta's classical method, the last step before an impact
/// shortened by Newton's to end on it.
double rocked(double alpha, double p2, double theta, double end) {
  double omega = 0, time = 0, sign = 1;
  const auto advance = [&](double h, double& th, double& om) {
    const auto f = [&](double x) { return -p2 * std::sin(alpha - x); };
    const double k1 = om, l1 = f(th), k2 = om + h / 2 * l1, l2 = f(th + h / 2 * k1), k3 = om + h / 2 * l2,
                 l3 = f(th + h / 2 * k2), k4 = om + h * l3, l4 = f(th + h * k3);
    th += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    om += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
  };
  while (time < end) {
    double h = std::min(1e-4, end - time), th = theta, om = omega;
    advance(h, th, om);
    if (th < 0) {
      for (int i = 0; i < 20; ++i) {
        h -= th / om;
        th = theta, om = omega;
        advance(h, th, om);
      }
      om *= -(1 - 1.5 * std::sin(alpha) * std::sin(alpha));
      th = 0, sign = -sign;
    }
    theta = th, omega = om, time += h;
  }
  return sign * theta;
}

/// A block, 0.2 m by 0.6 m, let go at half the angle at which it would fall over.
KnownMotion rocking_block() {
  constexpr double half_width = 0.1, half_height = 0.3, end = 1.5;
  const double alpha = std::atan(half_width / half_height), R = std::hypot(half_width, half_height);
  const double angle = rocked(alpha, 3 * kGravity / (4 * R), alpha / 2, end);
  return {"rocking_block",
          "A block rocks on its corners (Housner): place of its top after 1.5 s",
          end,
          [=](SystemGraph& graph, const auto& law) {
            // Tilted about the corner at +x.
            const Matrix3 tilt = rotation_about({0, 1, 0}, alpha / 2);
            const Vector3 corner(half_width, 0, -half_height);
            const double across = R * R / 3;
            auto& block = graph.add<RigidBody>(
                "body",
                {.mass = 1,
                 .inertia = {(half_height * half_height + 0.01) / 3, across, (half_width * half_width + 0.01) / 3},
                 .position = Vector3(corner + Vector3(0, 0, half_height) - tilt * corner),
                 .orientation = tilt});
            graph.add<Contact>("floor",
                               {{graph.ground().marker(), shape::half_space()},
                                {block.marker(), shape::box({2 * half_width, 0.2, 2 * half_height})}},
                               {.law = law, .friction = {.coefficient = 1}});
          },
          0,
          [=](const State& state) {
            const Vector3 up = rotation_matrix(state.q.segment<4>(3)).col(2);
            return 2 * half_height * std::abs(std::atan2(up[0], up[2]) - angle);
          }};
}

}  // namespace

std::vector<KnownMotion> known_motions() { return {thrown_ball(), bouncing_ball(), rocking_block()}; }

}  // namespace lithe::contact_bench
