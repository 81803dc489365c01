#include "bodies/beam/beam_cache_internal.h"
#include "bodies/beam/node_mass_internal.h"
#include "bodies/beam/se3_internal.h"
#include "bodies/beam/span_field_internal.h"

namespace lithe {
namespace {

using Vector12 = BeamSpan::Vector12;
using Matrix12 = BeamSpan::Matrix12;

Eigen::Map<const Vector3> vector(const double* from) { return Eigen::Map<const Vector3>(from); }

/// A wrench in the axes of a node, as generalized forces of its frame.
void add(double* r, const Matrix3& A, const Vector6& f) {
  Eigen::Map<Vector3>(r) += A * f.head<3>();
  Eigen::Map<Vector3>(r + 3) += f.tail<3>();
}

/// The rate of a node's twist (Aᵀ p_dot, ω).
Vector6 twist_rate(const Matrix3& A, const Vector6& twist, const double* v_dot) {
  Vector6 rate;
  rate << A.transpose() * vector(v_dot) - twist.tail<3>().cross(twist.head<3>()), vector(v_dot + 3);
  return rate;
}

/// diag(A, E) K diag(B, E)ᵀ: from twists and wrenches in the nodes' axes to those of frames.
template <class Block>
Matrix6 turned(const Matrix3& A, const Block& K, const Matrix3& B) {
  Matrix6 out = K;
  out.topRows<3>() = A * out.topRows<3>().eval();
  out.leftCols<3>() = out.leftCols<3>().eval() * B.transpose();
  return out;
}

}  // namespace

Vector12 BetweenNodes::at_nodes(const SpanField& field, const Vector3& force_A, const Vector3& torque_A) const {
  const Matrix3 to_section = field.pose().R.transpose();
  Vector6 f;
  f.head<3>() = to_section * force_A;
  f.tail<3>() = to_section * torque_A + offset.cross(Vector3(f.head<3>()));
  return field.shapes().transpose() * f;
}

void BetweenNodes::add_load_stiffness(const Vector3& force, const Vector3& torque, Matrix12& K) const {
  const double turn = 1e-5, shift = turn * span->length();
  const Vector3 force_A = A.transpose() * force, torque_A = A.transpose() * torque;
  const se3::Blocks inverse = se3::blocks(se3::right_inverse_at(d), d);
  // 1. In the nodes' axes, by d: differences. What a turn of the first node does to the wrench in its axes: exact.
  Eigen::Matrix<double, 12, 6> by_d;
  for (int i = 0; i < 6; ++i) {
    const Vector6 step = (i < 3 ? shift : turn) * Vector6::Unit(i);
    by_d.col(i) = (at_nodes(SpanField(share, d + step), force_A, torque_A) -
                   at_nodes(SpanField(share, d - step), force_A, torque_A)) /
                  (2 * step[i]);
  }
  const SpanField field(share, d);
  Matrix12 by_ends;
  for (int i = 0; i < 6; ++i) {
    const Vector6 twist = Vector6::Unit(i);
    by_ends.col(i) = -(by_d * (inverse.turned_back() * twist));
    by_ends.col(6 + i) = by_d * (inverse * twist);
    if (i >= 3)
      by_ends.col(i) += at_nodes(field, force_A.cross(Vector3::Unit(i - 3)), torque_A.cross(Vector3::Unit(i - 3)));
  }
  // 2. Those axes turn.
  const Vector12 load = at_nodes(field, force_A, torque_A);
  by_ends.block<3, 3>(0, 3) -= skew(load.segment<3>(0));
  by_ends.block<3, 3>(6, 9) -= skew(load.segment<3>(6));
  K.topLeftCorner<6, 6>() += turned(A, by_ends.topLeftCorner<6, 6>(), A);
  K.topRightCorner<6, 6>() += turned(A, by_ends.topRightCorner<6, 6>(), B);
  K.bottomLeftCorner<6, 6>() += turned(B, by_ends.bottomLeftCorner<6, 6>(), A);
  K.bottomRightCorner<6, 6>() += turned(B, by_ends.bottomRightCorner<6, 6>(), B);
}

Beam::Cache::Cache(const Beam& beam)
    : axes(beam.poses_.size()), twists(beam.poses_.size()), d(beam.spans_.size()), resultants(beam.spans_.size()) {
  if (!beam.places_.empty()) marker(beam, static_cast<int>(beam.places_.size()) - 1);
}

BetweenNodes& Beam::Cache::marker(const Beam& beam, int index) {
  while (static_cast<int>(between.size()) <= index) {
    const Place& place = beam.places_[between.size()];
    BetweenNodes& fresh = between.emplace_back();
    fresh.span = &beam.spans_[static_cast<std::size_t>(place.element)];
    fresh.share = place.share;
    fresh.offset = place.offset;
    for (int end : {0, 1}) fresh.shares[end].frame = place.element + end;
  }
  return between[static_cast<std::size_t>(index)];
}

std::unique_ptr<BodyCache> Beam::make_cache() const { return std::make_unique<Cache>(*this); }

void Beam::evaluate(const BodyState& state, Level) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const double* v = state.v + 6 * i;
    cache.axes[i] = rotation_matrix(Eigen::Map<const Vector4>(state.q + 7 * i + 3));
    cache.twists[i] << cache.axes[i].transpose() * vector(v), vector(v + 3);
  }
  cache.A = cache.axes.front();
  for (std::size_t e = 0; e < spans_.size(); ++e) {
    const BeamSpan& span = spans_[e];
    cache.d[e] =
        se3::log_between(vector(state.q + 7 * e), cache.axes[e], vector(state.q + 7 * e + 7), cache.axes[e + 1]);
    cache.resultants[e] = span.resultants(cache.d[e], cache.twists[e], cache.twists[e + 1]);
  }
}

Vector6 Beam::strain(const BodyState& state, int element) const {
  const std::size_t e = checked_element(element);
  return spans_[e].strain(static_cast<const Cache&>(*state.cache).d[e]);
}

Vector6 Beam::resultants(const BodyState& state, int element) const {
  return static_cast<const Cache&>(*state.cache).resultants[checked_element(element)];
}

void Beam::add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  for (std::size_t i = 0; i < node_masses_.size(); ++i) {
    const Matrix3& A = cache.axes[i];
    Vector6 rate = twist_rate(A, cache.twists[i], v_dot + 6 * i);
    rate.head<3>() -= A.transpose() * gravity;
    add(r + 6 * i, A, rigid_piece::inertia_force(node_masses_[i], cache.twists[i], rate));
  }
  for (std::size_t e = 0; e < spans_.size(); ++e) {
    const Matrix3 &A = cache.axes[e], &B = cache.axes[e + 1];
    const Vector6 &v_A = cache.twists[e], &v_B = cache.twists[e + 1];
    Vector12 f = spans_[e].internal_forces(cache.d[e], cache.resultants[e]);
    if (node_masses_.empty())
      f += spans_[e].inertia_forces(cache.d[e], v_A, v_B, twist_rate(A, v_A, v_dot + 6 * e),
                                    twist_rate(B, v_B, v_dot + 6 * e + 6), A.transpose() * gravity);
    add(r + 6 * e, A, f.head<6>());
    add(r + 6 * e + 6, B, f.tail<6>());
  }
}

void Beam::add_tangent(const BodyState& state, const double*, const Vector3&, const TangentWeights& weights,
                       BodyTangent& S) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  const bool consistent = node_masses_.empty();
  for (std::size_t i = 0; i < node_masses_.size(); ++i) {
    Matrix6 K = weights.acceleration * node_masses_[i];
    if (weights.velocity != 0) K += weights.velocity * rigid_piece::gyroscopic(node_masses_[i], cache.twists[i]);
    S.frame_block(static_cast<int>(i)) += turned(cache.axes[i], K, cache.axes[i]);
  }
  if (!consistent && weights.position == 0 && weights.velocity == 0) return;
  for (int e = 0; e < element_count(); ++e) {
    const std::size_t at = static_cast<std::size_t>(e);
    const BeamSpan& span = spans_[at];
    const Vector6& d = cache.d[at];
    const Matrix3 &A = cache.axes[at], &B = cache.axes[at + 1];
    Matrix12 K = Matrix12::Zero();
    if (consistent && weights.acceleration != 0) K += weights.acceleration * span.mass(d);
    if (weights.position != 0 || weights.velocity != 0)
      K += span.tangent(d, cache.resultants[at], weights.position, weights.velocity);
    if (consistent && weights.velocity != 0)
      K += weights.velocity * span.gyroscopic(d, cache.twists[at], cache.twists[at + 1]);
    auto first = S.frame_block(e), second = S.frame_block(e + 1);
    first += turned(A, K.topLeftCorner<6, 6>(), A);
    second += turned(B, K.bottomRightCorner<6, 6>(), B);
    S.upper_block(e) += turned(A, K.topRightCorner<6, 6>(), B);
    S.lower_block(e) += turned(B, K.bottomLeftCorner<6, 6>(), A);
    if (weights.position == 0) continue;
    // The forces turn with the axes of the nodes.
    const Vector12 f = span.internal_forces(d, cache.resultants[at]);
    first.topRightCorner<3, 3>() -= weights.position * A * skew(Vector3(f.segment<3>(0)));
    second.topRightCorner<3, 3>() -= weights.position * B * skew(Vector3(f.segment<3>(6)));
  }
}

void Beam::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  const Place& place = places_[static_cast<std::size_t>(marker)];
  k.elastic = nullptr;
  if (const int node = node_of(place); node >= 0) {
    const Matrix3& A = cache.axes[static_cast<std::size_t>(node)];
    k.between = nullptr;
    k.frame = node;
    k.A = &A;
    k.r = place.offset;
    const Vector3 arm = A * k.r;
    k.p = vector(state.q + 7 * node) + arm;
    k.R = A * place.axes;
    if (level == Level::position) return;
    k.w = A * vector(state.v + 6 * node + 3);
    k.v = vector(state.v + 6 * node) + k.w.cross(arm);
    if (level == Level::velocity) return;
    k.bias_v = k.w.cross(k.w.cross(arm));
    k.bias_w.setZero();
    return;
  }
  const std::size_t e = static_cast<std::size_t>(place.element);
  const Matrix3 &A = cache.axes[e], &B = cache.axes[e + 1];
  BetweenNodes& between = cache.marker(*this, marker);
  between.d = cache.d[e], between.A = A, between.B = B;
  const SpanField field(place.share, between.d);
  const se3::Pose& h = field.pose();
  const auto& N = field.shapes();
  const Matrix3 R = A * h.R;
  for (int end : {0, 1}) {
    Matrix6& J = between.shares[end].J;
    J.bottomRows<3>() = R * N.block<3, 6>(3, 6 * end);
    J.topRows<3>() = R * (N.block<3, 6>(0, 6 * end) - skew(place.offset) * N.block<3, 6>(3, 6 * end));
    J.leftCols<3>() = J.leftCols<3>().eval() * (end == 0 ? A : B).transpose();
  }
  k.between = &between;
  k.frame = place.element;
  k.A = &A;
  k.r = h.p + h.R * place.offset;
  k.p = vector(state.q + 7 * e) + A * k.r;
  k.R = R * place.axes;
  if (level == Level::position) return;
  Vector12 ends;
  ends << cache.twists[e], cache.twists[e + 1];
  const Vector6 twist = N * ends;
  const Vector3 v = twist.head<3>(), w = twist.tail<3>(), swing = w.cross(place.offset);
  k.v = R * (v + swing);
  k.w = R * w;
  if (level == Level::velocity) return;
  const double zero[6] = {};
  Vector12 rates;
  rates << twist_rate(A, cache.twists[e], zero), twist_rate(B, cache.twists[e + 1], zero);
  const Vector6 rate = N * rates + field.bias(ends);
  const Vector3 v_rate = rate.head<3>(), w_rate = rate.tail<3>();
  k.bias_v = R * (v_rate + w_rate.cross(place.offset) + w.cross(v + swing));
  k.bias_w = R * w_rate;
}

BodyEnergy Beam::energy(const BodyState& state, const Vector3& gravity) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  BodyEnergy sum;
  for (std::size_t i = 0; i < node_masses_.size(); ++i) {
    const Matrix6& M = node_masses_[i];
    const Vector3 moment(M(5, 1), M(3, 2), M(4, 0));  // the lower left of M is m c~
    sum.kinetic += 0.5 * cache.twists[i].dot(M * cache.twists[i]);
    sum.gravity -= gravity.dot(M(0, 0) * vector(state.q + 7 * i) + cache.axes[i] * moment);
  }
  for (std::size_t e = 0; e < spans_.size(); ++e) {
    const BeamSpan& span = spans_[e];
    const Vector6& d = cache.d[e];
    sum.elastic += span.elastic_energy(span.strain(d));
    if (!node_masses_.empty()) continue;
    sum.kinetic += span.kinetic_energy(d, cache.twists[e], cache.twists[e + 1]);
    sum.gravity -= gravity.dot(span.length() * span.section().mass_per_length() * vector(state.q + 7 * e) +
                               cache.axes[e] * span.first_moment(d));
  }
  return sum;
}

}  // namespace lithe
