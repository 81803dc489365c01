#include "engine/analysis/perturbation.h"

#include <algorithm>

#include "engine/motion/projection.h"

namespace lithe {
namespace {

Matrix3 axes_of(const VectorX& q, const Layout::BodySlice& b) { return rotation_matrix(q.segment<4>(b.q + 3)); }

}  // namespace

Perturbation::Perturbation(const System& system, const State& base, PerturbationAxes axes, double step)
    : equations_(system), base_(base), axes_(axes), step_(step) {
  const Layout& layout = equations_.layout();
  still_.setZero(layout.v_count());
  no_load_.setZero(layout.row_count());
  rows_ = no_load_;
  base_.v_dot.resize(layout.v_count());
  base_.lambda.setZero(layout.row_count());
  equations_.recall(base_.quarter_turns);
  Projector(equations_).accelerations(base_.time, base_.q, base_.v, base_.v_dot, base_.lambda);
  near_ = base_;
  kept_ = independent_rows(equations_);

  // Bodies are as large as their markers are far from their origins.
  length_ = 0;
  for (const MarkerKinematics& marker : equations_.workspace().markers) length_ = std::max(length_, marker.r.norm());
  if (!(length_ > 0)) length_ = 1;

  xi_ = to_axes(base_.v);
  xi_dot_ = to_axes(base_.v_dot);
  if (axes_ == PerturbationAxes::body)
    for (const auto& b : layout.bodies())
      if (b.frame) xi_dot_.segment<3>(b.v) -= xi_.segment<3>(b.v + 3).cross(Vector3(xi_.segment<3>(b.v)));
}

VectorX Perturbation::resolved(const VectorX& q, VectorX x, bool to_axes) const {
  for (const auto& b : equations_.layout().bodies()) {
    if (!b.frame) continue;
    const Matrix3 A = axes_of(q, b);
    const int at = axes_ == PerturbationAxes::body ? b.v : b.v + 3;
    const bool transposed = to_axes == (axes_ == PerturbationAxes::body);
    x.segment<3>(at) = transposed ? Vector3(A.transpose() * x.segment<3>(at)) : Vector3(A * x.segment<3>(at));
  }
  return x;
}

VectorX Perturbation::transport(const VectorX& zeta) const {
  VectorX out = VectorX::Zero(zeta.size());
  for (const auto& b : equations_.layout().bodies()) {
    if (!b.frame) continue;
    const Vector3 u = xi_.segment<3>(b.v), omega = xi_.segment<3>(b.v + 3);
    const Vector3 rho = zeta.segment<3>(b.v), phi = zeta.segment<3>(b.v + 3);
    if (axes_ == PerturbationAxes::body) {
      out.segment<3>(b.v) = omega.cross(rho) + u.cross(phi);
      out.segment<3>(b.v + 3) = omega.cross(phi);
    } else {
      out.segment<3>(b.v + 3) = -omega.cross(phi);
    }
  }
  return out;
}

/// near_ = base ⊕ h · direction.
void Perturbation::load(const Direction& d, double h) {
  near_.q = base_.q;
  if (d.position.size() > 0) equations_.layout().retract(base_.q, h * resolved(base_.q, d.position, false), near_.q);
  VectorX xi = xi_, xi_dot = xi_dot_;
  if (d.velocity.size() > 0) xi += h * d.velocity;
  if (d.acceleration.size() > 0) xi_dot += h * d.acceleration;
  if (axes_ == PerturbationAxes::body)
    for (const auto& b : equations_.layout().bodies())
      if (b.frame) xi_dot.segment<3>(b.v) += xi.segment<3>(b.v + 3).cross(Vector3(xi.segment<3>(b.v)));
  near_.lambda = base_.lambda;
  for (Eigen::Index i = 0; i < d.multipliers.size(); ++i)
    near_.lambda[kept_[static_cast<std::size_t>(i)]] += h * d.multipliers[i];
  if (d.input) {
    d.input->release();
    const Motion now = d.input->at(base_.time);
    d.input->force(
        {now.value + h * d.motion.value, now.rate + h * d.motion.rate, now.acceleration + h * d.motion.acceleration});
  }
  near_.v = resolved(near_.q, xi, false);
  near_.v_dot = resolved(near_.q, xi_dot, false);
}

/// A step that moves bodies by step_ of their size, or turns them by as much; velocities are judged likewise, inputs by
/// their range or size.
double Perturbation::step(const Direction& d) const {
  double size = 0;
  for (const VectorX* x : {&d.position, &d.velocity}) {
    if (x->size() == 0) continue;
    VectorX scaled = *x;
    for (const auto& b : equations_.layout().bodies())
      if (b.frame) scaled.segment<3>(b.v) /= length_;
    size = std::max(size, scaled.lpNorm<Eigen::Infinity>());
  }
  if (d.input) {
    const auto& p = d.input->parameters();
    const double range = 0.5 * (p.upper - p.lower);
    const double scale =
        std::isfinite(range) && range > 0 ? range : std::max(1.0, std::abs(d.input->value(base_.time)));
    for (const double change : {d.motion.value, d.motion.rate, d.motion.acceleration})
      size = std::max(size, std::abs(change) / scale);
  }
  return size > 0 ? step_ / size : 1;
}

template <class Read>
VectorX Perturbation::derivative(const Direction& direction, Read&& read) {
  struct Release {
    const Input* input;
    ~Release() {
      if (input) input->release();
    }
  } const release{direction.input};
  const double h = step(direction);
  // In pairs, so that what does not change has the derivative zero, exactly.
  const auto difference = [&](double at) {
    VectorX after, before;
    load(direction, at * h);
    read(after);
    load(direction, -at * h);
    read(before);
    return VectorX(after - before);
  };
  const VectorX near = difference(1);
  return (8 * near - difference(2)) / (12 * h);
}

VectorX Perturbation::residual(const Direction& direction) {
  return derivative(direction, [&](VectorX& out) {
    out.resize(still_.size());
    equations_.evaluate(near_.time, near_.q, near_.v, Level::velocity);
    equations_.residual(near_.v_dot, base_.lambda, out);
    out = resolved(near_.q, out, true);
  });
}

void Perturbation::read_rows(Level level, VectorX& out) {
  equations_.constraint(level, rows_);
  out = rows_(kept_);
}

VectorX Perturbation::position_rows(const Direction& direction) {
  return derivative(direction, [&](VectorX& out) {
    equations_.evaluate(near_.time, near_.q, near_.v, Level::position);
    read_rows(Level::position, out);
  });
}

VectorX Perturbation::velocity_rows(const Direction& direction) {
  return derivative(direction, [&](VectorX& out) {
    equations_.evaluate(near_.time, near_.q, near_.v, Level::velocity);
    read_rows(Level::velocity, out);
  });
}

VectorX Perturbation::acceleration_rows(const Direction& direction) {
  return derivative(direction, [&](VectorX& out) {
    // G v̇ is what ġ would be at velocities v̇, but for ∂g/∂t.
    VectorX rest, gamma;
    equations_.evaluate(near_.time, near_.q, near_.v_dot, Level::velocity);
    read_rows(Level::velocity, out);
    equations_.evaluate(near_.time, near_.q, still_, Level::velocity);
    read_rows(Level::velocity, rest);
    equations_.evaluate(near_.time, near_.q, near_.v, Level::acceleration);
    read_rows(Level::acceleration, gamma);
    out -= rest + gamma;
  });
}

VectorX Perturbation::sensors(const Direction& direction, const std::vector<Sensor>& sensors) {
  if (!snapshot_) snapshot_.emplace(equations_.system());
  Eigen::Index count = 0;
  for (const Sensor& sensor : sensors) count += std::ssize(sensor.columns());
  return derivative(direction, [&](VectorX& out) {
    snapshot_->evaluate(near_);
    out.resize(count);
    Eigen::Index at = 0;
    for (const Sensor& sensor : sensors) {
      const std::size_t columns = sensor.columns().size();
      sensor.evaluate(*snapshot_, std::span<double>(out.data() + at, columns));
      at += static_cast<Eigen::Index>(columns);
    }
  });
}

VectorX Perturbation::mass_times(const VectorX& x) {
  VectorX with(still_.size()), without(still_.size());
  equations_.evaluate(base_.time, base_.q, base_.v, Level::velocity);
  equations_.residual(still_, base_.lambda, without);
  equations_.residual(to_engine(x), base_.lambda, with);
  return to_axes(with - without);
}

MatrixX Perturbation::jacobian() {
  equations_.evaluate(base_.time, base_.q, base_.v, Level::velocity);
  MatrixX G = dense_jacobian(equations_);
  for (int i = 0; i < G.rows(); ++i) G.row(i) = to_axes(G.row(i).transpose()).transpose();
  return G;
}

MatrixX Perturbation::jacobian_rate() {
  const double speed = step({to_axes(base_.v), {}, {}}) / step_;  // 1/s⁻¹: time in which bodies move by their size
  const double h = 1e-5 * (base_.v.isZero(0) ? 1 : speed);
  const auto at = [&](double time) {
    VectorX q = base_.q;
    equations_.layout().retract(base_.q, time * base_.v, q);
    equations_.evaluate(base_.time + time, q, base_.v, Level::velocity);
    MatrixX G = dense_jacobian(equations_);
    for (int i = 0; i < G.rows(); ++i) G.row(i) = resolved(q, G.row(i).transpose(), true).transpose();
    return G;
  };
  const MatrixX after = at(h);
  return (after - at(-h)) / (2 * h);
}

}  // namespace lithe
