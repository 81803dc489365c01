#include "bodies/cable/cable.h"

#include <algorithm>
#include <cmath>

#include "bodies/cable/cable_drawing.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/base/number_text.h"

namespace lithe {
namespace {

using ConstVector3 = Eigen::Map<const Vector3>;

Vector3 at(const double* values, int node) { return ConstVector3(values + 3 * node); }
Eigen::Map<Vector3> to(double* values, int node) { return Eigen::Map<Vector3>(values + 3 * node); }

/// Two at a time, then one.
void add(const Lanes& a, double* to) {
  const auto* from = reinterpret_cast<const double*>(&a);
  Eigen::Map<Eigen::Vector2d>{to} += Eigen::Map<const Eigen::Vector2d>(from);
  to[2] += from[2];
}

Lanes unit(int axis) { return lanes::of(axis == 0, axis == 1, axis == 2); }

double drawn_length(const Cable::Parameters& p) {
  return p.points.empty() ? (p.to - p.from).norm() : cable_drawing::length(p.points);
}

double checked_length(const Cable::Parameters& p) {
  require::finite(p.from, "from");
  require::finite(p.to, "to");
  require::finite(p.sag, "sag");
  for (const Vector3& point : p.points) require::finite(point, "a point");
  const double drawn = drawn_length(p);
  if (!p.points.empty() && !(drawn > 0))
    throw SceneError("is drawn along points without length", "", "give two or more different .points");
  if (!(drawn > 0) && !p.length)
    throw SceneError("has no length", "", "give .from and .to, or .points, or .length of a slack cable");
  const double length = p.length.value_or(drawn);
  require::positive(length, "length");
  if (!(p.sag.norm() > 0)) throw SceneError("has no direction to hang in", "", "give .sag, any direction but zero");
  return length;
}

}  // namespace

Cable::Cache::Cache(const Cable& cable)
    : directions(static_cast<std::size_t>(cable.element_count()), lanes::none()),
      lengths(VectorX::Zero(cable.element_count())),
      tensions(lengths),
      force(VectorX::Zero(3 * cable.node_count())),
      blocks(static_cast<std::size_t>(cable.node_count())) {}

Cable::Cable(Parameters parameters) : parameters_(std::move(parameters)) {
  const Parameters& p = parameters_;
  const double length = checked_length(p);
  require::positive(p.mass_per_length, "mass_per_length");
  require::positive(p.axial_stiffness, "axial_stiffness");
  require::not_negative(p.bending_stiffness, "bending_stiffness");
  require::not_negative(p.axial_damping, "axial_damping");
  require::not_negative(p.radius, "radius");
  require::finite(p.velocity, "velocity");
  if (p.elements < 1)
    throw SceneError("has " + std::to_string(p.elements) + " elements", "", "give .elements of 1 or more; 20 is usual");
  set_lengths(length);
  if (!p.points.empty())
    drawn_ = cable_drawing::along(p.points, arc_ / length);
  else if (length > (1 + 1e-12) * drawn_length(p))
    drawn_ = cable_drawing::hanging(p.from, p.to, p.sag, rest_lengths_);
  else
    drawn_ = cable_drawing::along({p.from, p.to}, arc_ / length);
  set_constants();
  set_pattern();
}

/// Between two stations elements are alike, their number by their share of the length.
void Cable::set_lengths(double length) {
  std::vector<double> ends{0};
  for (const double station : parameters_.stations) {
    if (!(station > ends.back() && station < length))
      throw SceneError("has station " + std::to_string(ends.size()) + " at " + number_text(station) +
                           " m, which is not between " + number_text(ends.back()) + " and " + number_text(length),
                       "", "give .stations that rise, without the ends: unstretched lengths from the first end");
    ends.push_back(station);
  }
  ends.push_back(length);
  std::vector<double> arc{0};
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const double own = ends[i] - ends[i - 1];
    const int count = std::max(1, static_cast<int>(std::lround(parameters_.elements * own / length)));
    for (int k = 1; k < count; ++k) arc.push_back(ends[i - 1] + own * k / count);
    arc.push_back(ends[i]);
  }
  arc_ = Eigen::Map<const VectorX>(arc.data(), static_cast<Eigen::Index>(arc.size()));
  rest_lengths_ = arc_.tail(arc_.size() - 1) - arc_.head(arc_.size() - 1);
}

/// μ L/6 [2 1; 1 2] of each element; EI/L_i of each inner node.
void Cable::set_constants() {
  mass_beside_ = parameters_.mass_per_length / 6 * rest_lengths_;
  mass_diagonal_.setZero(node_count());
  mass_diagonal_.head(element_count()) += 2 * mass_beside_;
  mass_diagonal_.tail(element_count()) += 2 * mass_beside_;
  nodal_mass_ = 1.5 * mass_diagonal_;
  bend_stiffness_.setZero(node_count());
  for (int i = 1; i < element_count(); ++i)
    bend_stiffness_[i] = 2 * parameters_.bending_stiffness / (rest_lengths_[i - 1] + rest_lengths_[i]);
}

/// Blocks of 3 x 3: tridiagonal by mass and tension, pentadiagonal by bending.
void Cable::set_pattern() {
  reach_ = parameters_.bending_stiffness > 0 && element_count() > 1 ? 2 : 1;
  std::vector<int> rows, columns;
  for (int column = 0; column < 3 * node_count(); ++column) {
    columns_.push_back(static_cast<int>(rows.size()));
    const int last = std::min(column / 3 + reach_, element_count());
    for (int row = column; row < 3 * (last + 1); ++row) {
      rows.push_back(row);
      columns.push_back(column);
    }
  }
  pattern_.rows = Eigen::Map<const Eigen::VectorXi>(rows.data(), static_cast<Eigen::Index>(rows.size()));
  pattern_.columns = Eigen::Map<const Eigen::VectorXi>(columns.data(), static_cast<Eigen::Index>(columns.size()));
}

int Cable::element_at(double arc_length) const {
  const auto* after = std::upper_bound(arc_.data(), arc_.data() + arc_.size(), arc_length);
  return std::clamp(static_cast<int>(after - arc_.data()) - 1, 0, element_count() - 1);
}

Marker Cable::marker(double arc_length, const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(), [&] { require::rotation(orientation, "marker orientation"); });
  const double slack = 1e-12 * length();
  if (!(arc_length >= -slack && arc_length <= length() + slack))
    throw SceneError("'" + name() + "' has no point at " + number_text(arc_length) + " m", where(),
                     "give an unstretched length from its first end, 0 to " + number_text(length()) + " m");
  Place place{element_at(arc_length), 0, orientation, Matrix6X::Zero(6, 3 * node_count())};
  place.share = std::clamp((arc_length - arc_[place.element]) / rest_lengths_[place.element], 0.0, 1.0);
  place.columns.block<3, 3>(0, 3 * place.element).diagonal().setConstant(1 - place.share);
  place.columns.block<3, 3>(0, 3 * place.element + 3).diagonal().setConstant(place.share);
  places_.push_back(std::move(place));
  return new_marker();
}

void Cable::initial_state(VectorRef q, VectorRef v) const {
  q = drawn_.reshaped();
  for (int i = 0; i < node_count(); ++i) v.segment<3>(3 * i) = parameters_.velocity;
}

void Cable::evaluate(const BodyState& state, Level level) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  const double EA = parameters_.axial_stiffness, c = level == Level::position ? 0 : parameters_.axial_damping;
  cache.strain_energy = 0;
  Vector3 before(0, 0, 0);  // pull of the element before
  for (int e = 0; e < element_count(); ++e) {
    const Vector3 d = at(state.q, e + 1) - at(state.q, e);
    const double l = d.norm(), strain = l / rest_lengths_[e] - 1;
    const Vector3 t = l > 0 ? Vector3(d / l) : Vector3(0, 0, 0);
    double N = EA * strain;
    cache.strain_energy += 0.5 * N * strain * rest_lengths_[e];
    if (c > 0) N += c * t.dot(at(state.v, e + 1) - at(state.v, e)) / rest_lengths_[e];
    for (int k = 0; k < 3; ++k) cache.directions[static_cast<std::size_t>(e)][k] = t[k];
    cache.lengths[e] = l;
    cache.tensions[e] = N;
    const Vector3 pull = N * t;
    to(cache.force.data(), e) = before - pull;
    before = pull;
  }
  to(cache.force.data(), element_count()) = before;
  if (parameters_.bending_stiffness > 0) add_bending(cache);
}

/// Of ½ k |b|², b = t₂ - t₁, by the elements' vectors d: ∂/∂d₁ = -k (b - t₁ (t₁·b))/l₁, ∂/∂d₂ = k (b - t₂ (t₂·b))/l₂,
/// where t₂·b = -t₁·b = ½ |b|².
void Cable::add_bending(Cache& cache) const {
  for (int i = 1; i < element_count(); ++i) {
    const Lanes* t = cache.directions.data() + i;
    const Lanes t1 = t[-1], t2 = t[0], b = t2 - t1;
    const double k = bend_stiffness_[i], s = 0.5 * lanes::dot(b, b);
    const Lanes f1 = (-k / cache.lengths[i - 1]) * (b + s * t1), f2 = (k / cache.lengths[i]) * (b - s * t2);
    cache.strain_energy += k * s;
    double* force = cache.force.data() + 3 * i;
    add(-f1, force - 3);
    add(f1 - f2, force);
    add(f2, force + 3);
  }
}

void Cable::add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  Vector3 before(0, 0, 0), here = at(v_dot, 0);
  for (int i = 0; i < element_count(); ++i) {
    const Vector3 after = at(v_dot, i + 1);
    to(r, i) += at(cache.force.data(), i) + mass_diagonal_[i] * here + before + mass_beside_[i] * after -
                nodal_mass_[i] * gravity;
    before = mass_beside_[i] * here;
    here = after;
  }
  const int last = element_count();
  to(r, last) += at(cache.force.data(), last) + mass_diagonal_[last] * here + before - nodal_mass_[last] * gravity;
}

void Cable::add_tangent(const BodyState& state, const double*, const Vector3&, const TangentWeights& weights,
                        BodyTangent& S) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  Cache::Blocks* blocks = cache.blocks.data();
  for (int j = 0; j < 3; ++j) blocks[0].own[j] = weights.acceleration * mass_diagonal_[0] * unit(j);
  const double EA = parameters_.axial_stiffness, c = parameters_.axial_damping;
  const double stretch = weights.position * EA + weights.velocity * c;
  for (int e = 0; e < element_count(); ++e) {
    const Lanes t = cache.directions[static_cast<std::size_t>(e)];
    const double N = cache.tensions[e];
    // Tension stiffens across the element; what compression softens is left out.
    const double across = N > 0 ? weights.position * N / cache.lengths[e] : 0;
    const Lanes axial = (stretch / rest_lengths_[e] - across) * t;
    for (int j = 0; j < 3; ++j) {
      const Lanes K = axial * t[j] + across * unit(j);
      blocks[e].own[j] += K;
      blocks[e + 1].own[j] = weights.acceleration * mass_diagonal_[e + 1] * unit(j) + K;
      blocks[e].next[j] = weights.acceleration * mass_beside_[e] * unit(j) - K;
      blocks[e].second[j] = lanes::none();
    }
  }
  if (parameters_.bending_stiffness > 0 && weights.position != 0) add_bending_stiffness(cache, weights.position);
  // The rows of a column follow each other in the pattern.
  for (int i = 0; i < node_count(); ++i) {
    const int behind = std::min(reach_, element_count() - i);
    for (int j = 0; j < 3; ++j) {
      double* entry = S.linear.data() + columns_[static_cast<std::size_t>(3 * i + j)];
      for (int row = j; row < 3; ++row) *entry++ += blocks[i].own[j][row];
      if (behind > 0) add(blocks[i].next[j], entry);
      if (behind > 1) add(blocks[i].second[j], entry + 3);
    }
  }
}

/// Second derivatives of k (1 - c), c = t₁·t₂, by the elements' vectors d₁ = x_i - x_{i-1}, d₂ = x_{i+1} - x_i, with
/// P = 1 - t tᵀ and p₁ = P₁ t₂, p₂ = P₂ t₁:
///   H₁₁ = k (t₁ p₁ᵀ + p₁ t₁ᵀ + c P₁)/l₁²,   H₂₁ = -k P₂ P₁/(l₁ l₂) = -k (1 - t₁ t₁ᵀ - t₂ p₁ᵀ)/(l₁ l₂),   H₂₂ as H₁₁
void Cable::add_bending_stiffness(Cache& cache, double weight) const {
  for (int i = 1; i < element_count(); ++i) {
    const Lanes* t = cache.directions.data() + i;
    const Lanes t1 = t[-1], t2 = t[0], b = t2 - t1;
    const double s = 0.5 * lanes::dot(b, b), c = 1 - s;
    const double of_1 = 1 / cache.lengths[i - 1], of_2 = 1 / cache.lengths[i], k = weight * bend_stiffness_[i];
    const Lanes p1 = b + s * t1, p2 = s * t2 - b, q1 = p1 - 0.5 * c * t1, q2 = p2 - 0.5 * c * t2;
    Cache::Blocks* at = cache.blocks.data() + i;
    for (int j = 0; j < 3; ++j) {
      const Lanes H11 = (k * of_1 * of_1) * (t1 * q1[j] + q1 * t1[j] + c * unit(j));
      const Lanes H22 = (k * of_2 * of_2) * (t2 * q2[j] + q2 * t2[j] + c * unit(j));
      const Lanes H21 = (-k * of_1 * of_2) * (unit(j) - t1 * t1[j] - t2 * p1[j]);
      const Lanes H12 = (-k * of_1 * of_2) * (unit(j) - t1 * t1[j] - p1 * t2[j]);
      at[-1].own[j] += H11;
      at[-1].next[j] += H21 - H11;
      at[-1].second[j] -= H21;
      at[0].own[j] += H11 + H22 - (H21 + H12);
      at[0].next[j] += H21 - H22;
      at[1].own[j] += H22;
    }
  }
}

void Cable::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  const Place& place = places_[static_cast<std::size_t>(marker)];
  const double a = 1 - place.share, b = place.share;
  k.p = k.r = a * at(state.q, place.element) + b * at(state.q, place.element + 1);
  k.R = place.axes;
  k.A = &state.cache->A;
  k.elastic = place.columns.data();
  k.deflected = nullptr;
  if (level == Level::position) return;
  k.v = a * at(state.v, place.element) + b * at(state.v, place.element + 1);
  k.w.setZero();
  if (level == Level::velocity) return;
  k.bias_v.setZero();
  k.bias_w.setZero();
}

BodyEnergy Cable::energy(const BodyState& state, const Vector3& gravity) const {
  BodyEnergy e;
  e.elastic = static_cast<const Cache&>(*state.cache).strain_energy;
  for (int i = 0; i < node_count(); ++i) {
    e.kinetic += 0.5 * mass_diagonal_[i] * at(state.v, i).squaredNorm();
    e.gravity -= nodal_mass_[i] * gravity.dot(at(state.q, i));
  }
  for (int i = 0; i < element_count(); ++i) e.kinetic += mass_beside_[i] * at(state.v, i).dot(at(state.v, i + 1));
  return e;
}

Sensor tension(const Cable& cable, int element, Located name) {
  if (element < 0 || element >= cable.element_count())
    throw SceneError("'" + cable.name() + "' has no element " + std::to_string(element), to_string(name.where),
                     "give 0 to " + std::to_string(cable.element_count() - 1) + "; element_at(arc_length) finds one");
  if (name.text.empty()) name.text = cable.name() + "_tension_" + std::to_string(element);
  const std::string column = name.text;
  return Sensor(std::move(name), {column},
                [&cable, element](Snapshot& now, std::span<double> values) {
                  values[0] = cable.tensions(now.body_state(cable))[element];
                },
                {"N"});
}

template std::unique_ptr<BodyBatch> make_body_batch<Cable>();

}  // namespace lithe
