#include "joints/bearings/spinning_ball.h"

#include <Eigen/LU>
#include <cmath>

namespace lithe {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d;

/// V(|x| - L) and its derivatives.
struct GrooveContact {
  double energy = 0, load = 0;
  Vector2d force = Vector2d::Zero();
  Matrix2d stiffness = Matrix2d::Zero();

  GrooveContact(const SpinningBall::Contact& c, const Vector2d& x) {
    const double length = x.norm(), depth = length - c.length;
    if (depth <= 0) return;
    const double root = std::sqrt(depth);
    const Vector2d n = x / length;
    load = c.stiffness * depth * root;
    energy = 0.4 * load * depth;
    force = load * n;
    stiffness =
        1.5 * c.stiffness * root * n * n.transpose() + load / length * (Matrix2d::Identity() - n * n.transpose());
  }
};

}  // namespace

SpinningBall::SpinningBall(Contact inner, Contact outer, double centrifugal)
    : inner_(inner), outer_(outer), centrifugal_(centrifugal) {
  const double depth = std::pow(centrifugal / outer.stiffness, 2.0 / 3);
  thrown_ = {0, outer.length + depth};
  thrown_energy_ = 0.4 * centrifugal * depth - centrifugal * thrown_[1];
}

/// U is convex in b: Newton's method, steps halved until the energy sinks. From the outer groove, where it has a
/// stiffness in all directions.
SpinningBall::Balance SpinningBall::at(const Vector2d& d) const {
  constexpr int kMost = 100;
  constexpr double kRoundOff = 1e-12;  // of the loads: depths are small differences of lengths
  const Vector2d thrown(0, centrifugal_);
  Balance balance;
  Vector2d b = thrown_;
  GrooveContact outer(outer_, b), inner(inner_, d - b);
  const auto put = [&](const Vector2d& at) {
    b = at, outer = GrooveContact(outer_, b), inner = GrooveContact(inner_, d - b);
  };
  const auto energy_at = [&] { return outer.energy + inner.energy - centrifugal_ * b[1]; };
  if (inner.load > 0) {
    // On the line of the grooves' centres: as far out as thrown, or as both contacts in series, where less is stored.
    const Vector2d n = d.normalized();
    put(thrown_[1] * n);
    const double energy = energy_at(), both = d.norm() - inner_.length - outer_.length,
                 in_series = both / (1 + std::pow(outer_.stiffness / inner_.stiffness, 2.0 / 3));
    if (in_series > 0) put((outer_.length + in_series) * n);
    if (energy_at() > energy) put(thrown_[1] * n);
  }
  for (int i = 0; i < kMost; ++i) {
    const Vector2d lack = thrown + inner.force - outer.force;
    if (lack.norm() <= kRoundOff * (outer.load + inner.load)) break;
    Vector2d by = (outer.stiffness + inner.stiffness).inverse() * lack;
    const double energy = energy_at();
    bool sinks = false;
    for (int half = 0; half < 40 && !sinks; ++half, by /= 2) {
      const Vector2d next = b + by;
      const GrooveContact o(outer_, next), in(inner_, d - next);
      // Near the end round-off hides how the energy changes; the lack of balance tells.
      sinks = o.load > 0 && (o.energy + in.energy - centrifugal_ * next[1] < energy ||
                             (thrown + in.force - o.force).norm() < lack.norm());
      if (sinks) b = next, outer = o, inner = in;
    }
    if (!sinks) break;
  }
  const Vector2d to = d - b;
  balance.inner_angle = std::atan2(to[0], to[1]), balance.outer_angle = std::atan2(b[0], b[1]);
  balance.outer_load = outer.load;
  if (inner.load == 0) return balance;
  balance.energy = energy_at() - thrown_energy_;
  balance.force = inner.force;
  balance.stiffness =
      inner.stiffness - inner.stiffness * (outer.stiffness + inner.stiffness).inverse() * inner.stiffness;
  return balance;
}

}  // namespace lithe
