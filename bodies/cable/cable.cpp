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

std::string number_text(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

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
    : directions(Matrix3X::Zero(3, cable.element_count())),
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
  set_mass();
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

/// μ L/6 [2 1; 1 2] of each element.
void Cable::set_mass() {
  mass_beside_ = parameters_.mass_per_length / 6 * rest_lengths_;
  mass_diagonal_.setZero(node_count());
  mass_diagonal_.head(element_count()) += 2 * mass_beside_;
  mass_diagonal_.tail(element_count()) += 2 * mass_beside_;
  nodal_mass_ = 1.5 * mass_diagonal_;
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
  cache.force.setZero();
  cache.strain_energy = 0;
  for (int e = 0; e < element_count(); ++e) {
    const Vector3 d = at(state.q, e + 1) - at(state.q, e);
    const double l = d.norm(), strain = l / rest_lengths_[e] - 1;
    const Vector3 t = l > 0 ? Vector3(d / l) : Vector3(0, 0, 0);
    double N = EA * strain;
    cache.strain_energy += 0.5 * N * strain * rest_lengths_[e];
    if (c > 0) N += c * t.dot(at(state.v, e + 1) - at(state.v, e)) / rest_lengths_[e];
    cache.directions.col(e) = t;
    cache.lengths[e] = l;
    cache.tensions[e] = N;
    to(cache.force.data(), e) -= N * t;
    to(cache.force.data(), e + 1) += N * t;
  }
  if (parameters_.bending_stiffness > 0) add_bending(cache);
}

double Cable::bend_stiffness(int node) const {
  return 2 * parameters_.bending_stiffness / (rest_lengths_[node - 1] + rest_lengths_[node]);
}

/// Of ½ k |b|², b = t₂ - t₁, by the elements' vectors d: ∂/∂d₁ = -k (b - t₁ (t₁·b))/l₁, ∂/∂d₂ = k (b - t₂ (t₂·b))/l₂.
void Cable::add_bending(Cache& cache) const {
  for (int i = 1; i < element_count(); ++i) {
    const Vector3 t1 = cache.directions.col(i - 1), t2 = cache.directions.col(i), b = t2 - t1;
    const double k = bend_stiffness(i);
    const Vector3 f1 = -k / cache.lengths[i - 1] * (b - t1 * t1.dot(b));
    const Vector3 f2 = k / cache.lengths[i] * (b - t2 * t2.dot(b));
    cache.strain_energy += 0.5 * k * b.squaredNorm();
    to(cache.force.data(), i - 1) -= f1;
    to(cache.force.data(), i) += f1 - f2;
    to(cache.force.data(), i + 1) += f2;
  }
}

void Cable::add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  Eigen::Map<VectorX>(r, cache.force.size()) += cache.force;
  for (int i = 0; i < node_count(); ++i) to(r, i) += mass_diagonal_[i] * at(v_dot, i) - nodal_mass_[i] * gravity;
  for (int e = 0; e < element_count(); ++e) {
    to(r, e) += mass_beside_[e] * at(v_dot, e + 1);
    to(r, e + 1) += mass_beside_[e] * at(v_dot, e);
  }
}

void Cable::add_tangent(const BodyState& state, const double*, const Vector3&, const TangentWeights& weights,
                        BodyTangent& S) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  Cache::Blocks* blocks = cache.blocks.data();
  for (int i = 0; i < node_count(); ++i) {
    blocks[i].own.setZero(), blocks[i].second.setZero();
    blocks[i].own.diagonal().setConstant(weights.acceleration * mass_diagonal_[i]);
  }
  const double EA = parameters_.axial_stiffness, c = parameters_.axial_damping;
  for (int e = 0; e < element_count(); ++e) {
    const Vector3 t = cache.directions.col(e);
    const double L = rest_lengths_[e], N = cache.tensions[e];
    // Tension stiffens across the element; what compression softens is left out.
    const double across = N > 0 ? weights.position * N / cache.lengths[e] : 0;
    const double axial = weights.position * EA / L + weights.velocity * c / L - across;
    Matrix3 K = (axial * t) * t.transpose();
    K.diagonal().array() += across;
    blocks[e].own += K;
    blocks[e + 1].own += K;
    blocks[e].next = -K;
    blocks[e].next.diagonal().array() += weights.acceleration * mass_beside_[e];
  }
  if (parameters_.bending_stiffness > 0 && weights.position != 0) add_bending_stiffness(cache, weights.position);
  // The rows of a column follow each other in the pattern.
  for (int i = 0; i < node_count(); ++i) {
    const int behind = std::min(reach_, element_count() - i);
    for (int j = 0; j < 3; ++j) {
      double* entry = S.linear.data() + columns_[static_cast<std::size_t>(3 * i + j)];
      for (int row = j; row < 3; ++row) *entry++ += blocks[i].own(row, j);
      if (behind > 0)
        for (int row = 0; row < 3; ++row) *entry++ += blocks[i].next(row, j);
      if (behind > 1)
        for (int row = 0; row < 3; ++row) *entry++ += blocks[i].second(row, j);
    }
  }
}

/// Second derivatives of k (1 - c), c = t₁·t₂, with P = 1 - t tᵀ and g = ∂c/∂d:
///   H₁₁ = k (t₁ g₁ᵀ + g₁ t₁ᵀ + c P₁/l₁)/l₁,   H₁₂ = -k P₁ P₂/(l₁ l₂),   H₂₂ as H₁₁
void Cable::add_bending_stiffness(Cache& cache, double weight) const {
  for (int i = 1; i < element_count(); ++i) {
    const Vector3 t1 = cache.directions.col(i - 1), t2 = cache.directions.col(i), b = t2 - t1;
    const double k = weight * bend_stiffness(i), l1 = cache.lengths[i - 1], l2 = cache.lengths[i];
    const double cosine = 1 - 0.5 * b.squaredNorm();
    const Matrix3 P1 = Matrix3::Identity() - t1 * t1.transpose(), P2 = Matrix3::Identity() - t2 * t2.transpose();
    const Vector3 g1 = P1 * b / l1, g2 = -P2 * b / l2;
    const Matrix3 H11 = k / l1 * (t1 * g1.transpose() + g1 * t1.transpose() + cosine / l1 * P1);
    const Matrix3 H22 = k / l2 * (t2 * g2.transpose() + g2 * t2.transpose() + cosine / l2 * P2);
    const Matrix3 H21 = -k / (l1 * l2) * (P2 * P1);
    // d₁ = x_i - x_{i-1}, d₂ = x_{i+1} - x_i
    Cache::Blocks* at = cache.blocks.data() + i;
    at[-1].own += H11;
    at[-1].next += H21 - H11;
    at[-1].second -= H21;
    at[0].own += H11 - H21 - H21.transpose() + H22;
    at[0].next += H21 - H22;
    at[1].own += H22;
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
