#pragma once

#include <array>
#include <memory>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "engine/plugin.h"
#include "tests/bodies/bar_model.h"

namespace lithe::test {

/// Two elastic bars on the x axis, drawn end to start, as one body: a frame each, then the modes of both as its linear
/// coordinates. A spring of no length between a node of one and a node of the other couples frames and modes:
///   V = V_1 + V_2 + ½ k |p_1 - p_2|²
class SprungBars final : public Body {
 public:
  static constexpr int kModes = 3;  // of each bar
  struct Parameters {
    double stiffness = 3e4;             // k, N/m
    Vector3 velocity{0, 0, 0};          // m/s
    Vector3 angular_velocity{0, 0, 0};  // of both, about the start of the first, rad/s
  };
  static constexpr Field<Parameters> kParameters[] = {{"stiffness", &Parameters::stiffness},
                                                      {"velocity", &Parameters::velocity},
                                                      {"angular_velocity", &Parameters::angular_velocity}};
  static constexpr double kLength = 0.6;

  static const FiniteElementModel& mesh() {
    static const FiniteElementModel model =
        bar_model({.size = {kLength, 0.02, 0.03}, .bricks = {4, 1, 1}, .young = 2e9, .poisson = 0.3, .density = 1500});
    return model;
  }
  /// Bar 0 or 1 by itself.
  static FlexibleBody::Parameters bar(int which, const Parameters& p) {
    static const std::shared_ptr<const ModalBasis> basis = make_basis(mesh(), MeanAxisFrame{}, kModes);
    const Vector3 at{kLength * which, 0, 0};
    return {.basis = basis,
            .position = at,
            .velocity = p.velocity + p.angular_velocity.cross(at),
            .angular_velocity = p.angular_velocity};
  }
  /// The nodes that the spring ties.
  static int sprung_node(int which) { return mesh().node_set(which == 0 ? "end" : "start").front(); }

  struct Cache : BodyCache {
    struct Bar {
      FlexibleBody::Cache of;
      VectorX q = VectorX::Zero(7 + kModes), v = VectorX::Zero(6 + kModes);
      BodyState state() { return {q.data(), v.data(), &of}; }
    };
    std::array<Bar, 2> bars;
    std::vector<Matrix6X> columns;  // of each marker, by the modes of both
    explicit Cache(const SprungBars& body)
        : bars{{{FlexibleBody::Cache(*body.bars_[0])}, {FlexibleBody::Cache(*body.bars_[1])}}},
          columns(body.markers_.size(), Matrix6X::Zero(6, 2 * kModes)) {}
  };

  explicit SprungBars(Parameters parameters) : parameters_(parameters) {
    for (int i = 0; i < 2; ++i) {
      bars_[i] = std::make_unique<FlexibleBody>(bar(i, parameters));
      ends_[i] = bars_[i]->node(sprung_node(i));
    }
    pattern_.rows.resize(kModes * (2 * kModes + 1)), pattern_.columns.resize(kModes * (2 * kModes + 1));
    for (int j = 0, entry = 0; j < 2 * kModes; ++j)
      for (int i = j; i < 2 * kModes; ++i) pattern_.rows[entry] = i, pattern_.columns[entry++] = j;
  }

  double mass() const { return bars_[0]->mass() + bars_[1]->mass(); }
  /// A node of one of the bars: 1000 · bar + its label.
  Marker node(int number, const Matrix3& orientation = Matrix3::Identity()) {
    const int which = number / 1000;
    markers_.push_back({which, bars_.at(static_cast<std::size_t>(which))->node(number % 1000, orientation)});
    return new_marker();
  }

  Coordinates coordinates() const override {
    return {.frames = 2, .linear = 2 * kModes, .pattern = &pattern_, .pairs = pairs_};
  }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override {
    VectorX of_q(7 + kModes), of_v(6 + kModes);
    for (int i = 0; i < 2; ++i) {
      bars_[i]->initial_state(of_q, of_v);
      q.segment<7>(7 * i) = of_q.head<7>(), q.segment<kModes>(14 + kModes * i) = of_q.tail<kModes>();
      v.segment<6>(6 * i) = of_v.head<6>(), v.segment<kModes>(12 + kModes * i) = of_v.tail<kModes>();
    }
  }
  void evaluate(const BodyState& state, Level level) const override {
    auto& cache = static_cast<Cache&>(*state.cache);
    for (int i = 0; i < 2; ++i) {
      Cache::Bar& b = cache.bars[i];
      b.q << Eigen::Map<const VectorX>(state.q + 7 * i, 7),
          Eigen::Map<const VectorX>(state.q + 14 + kModes * i, kModes);
      b.v = gathered(state.v, i);
      bars_[i]->evaluate(b.state(), level);
    }
    cache.A = cache.bars[0].of.A;
  }
  void add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const override {
    auto& cache = static_cast<Cache&>(*state.cache);
    Eigen::Map<VectorX>(r, 12 + 2 * kModes) += columns(cache).transpose() * (parameters_.stiffness * stretch(cache));
    for (int i = 0; i < 2; ++i) {
      VectorX own = VectorX::Zero(6 + kModes);
      bars_[i]->add_residual(cache.bars[i].state(), gathered(v_dot, i).data(), gravity, own.data());
      Eigen::Map<Vector6>(r + 6 * i) += own.head<6>();
      Eigen::Map<VectorX>(r + 12 + kModes * i, kModes) += own.tail<kModes>();
    }
  }
  void add_tangent(const BodyState& state, const double* v_dot, const Vector3& gravity, const TangentWeights& weights,
                   BodyTangent& S) const override {
    auto& cache = static_cast<Cache&>(*state.cache);
    MatrixX eta = MatrixX::Zero(2 * kModes, 2 * kModes);
    for (int i = 0; i < 2; ++i) {
      Matrix6 frame = Matrix6::Zero();
      Matrix6X upper = Matrix6X::Zero(6, kModes);
      MatrixX lower = MatrixX::Zero(kModes, 6);
      VectorX linear = VectorX::Zero(kModes);
      BodyTangent own{Eigen::Map<Matrix6>(frame.data()), Eigen::Map<Matrix6X>(upper.data(), 6, kModes),
                      Eigen::Map<MatrixX>(lower.data(), kModes, 6), Eigen::Map<VectorX>(linear.data(), kModes)};
      bars_[i]->add_tangent(cache.bars[i].state(), gathered(v_dot, i).data(), gravity, weights, own);
      S.frame_block(i) += frame;
      S.frame_linear_block(i).middleCols<kModes>(kModes * i) += upper;
      S.linear_frame_block(i).middleRows<kModes>(kModes * i) += lower;
      eta.diagonal().segment<kModes>(kModes * i) += linear;
    }
    // The spring: k Gᵀ G, and what its force owes to the turning of its arms.
    const MatrixX G = columns(cache), K = weights.position * parameters_.stiffness * G.transpose() * G;
    const Vector3 force = weights.position * parameters_.stiffness * stretch(cache);
    for (int i = 0; i < 2; ++i) {
      const MarkerKinematics k = end(cache, i);
      const Matrix3 f = skew(k.A->transpose() * (i == 0 ? force : Vector3(-force)));
      const auto B = Eigen::Map<const Matrix6X>(k.elastic, 6, kModes).topRows<3>();
      S.frame_block(i) += K.block<6, 6>(6 * i, 6 * i);
      S.frame_block(i).bottomRightCorner<3, 3>() += skew(k.r) * f;
      S.frame_linear_block(i) += K.block<6, 2 * kModes>(6 * i, 12);
      S.frame_linear_block(i).block<3, kModes>(3, kModes * i) -= f * B;
      S.linear_frame_block(i) += K.block<2 * kModes, 6>(12, 6 * i);
      S.linear_frame_block(i).block<kModes, 3>(kModes * i, 3) += B.transpose() * f;
    }
    S.upper_block(0) += K.block<6, 6>(0, 6);
    S.lower_block(0) += K.block<6, 6>(6, 0);
    eta += K.bottomRightCorner<2 * kModes, 2 * kModes>();
    for (int entry = 0; entry < pattern_.rows.size(); ++entry)
      S.linear[entry] += eta(pattern_.rows[entry], pattern_.columns[entry]);
  }
  void marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const override {
    auto& cache = static_cast<Cache&>(*state.cache);
    const auto& [which, inner] = markers_[static_cast<std::size_t>(marker)];
    bars_[which]->marker_kinematics(cache.bars[which].state(), inner.index, level, k);
    k.frame = which;
    Matrix6X& all = cache.columns[static_cast<std::size_t>(marker)];
    all.middleCols<kModes>(kModes * which) = Eigen::Map<const Matrix6X>(k.elastic, 6, kModes);
    k.elastic = all.data();
  }
  BodyEnergy energy(const BodyState& state, const Vector3& gravity) const override {
    auto& cache = static_cast<Cache&>(*state.cache);
    BodyEnergy sum;
    for (int i = 0; i < 2; ++i) {
      const BodyEnergy own = bars_[i]->energy(cache.bars[i].state(), gravity);
      sum.kinetic += own.kinetic, sum.elastic += own.elastic, sum.gravity += own.gravity;
    }
    sum.elastic += 0.5 * parameters_.stiffness * stretch(cache).squaredNorm();
    return sum;
  }

 private:
  static VectorX gathered(const double* velocities, int which) {
    VectorX own(6 + kModes);
    own << Eigen::Map<const VectorX>(velocities + 6 * which, 6),
        Eigen::Map<const VectorX>(velocities + 12 + kModes * which, kModes);
    return own;
  }
  MarkerKinematics end(Cache& cache, int which) const {
    MarkerKinematics k;
    bars_[which]->marker_kinematics(cache.bars[which].state(), ends_[which].index, Level::position, k);
    return k;
  }
  Vector3 stretch(Cache& cache) const { return end(cache, 0).p - end(cache, 1).p; }
  /// ∂(stretch)/∂(velocities), 3 x (12 + modes).
  MatrixX columns(Cache& cache) const {
    MatrixX G = MatrixX::Zero(3, 12 + 2 * kModes);
    for (int i = 0; i < 2; ++i) {
      const MarkerKinematics k = end(cache, i);
      const double sign = i == 0 ? 1 : -1;
      G.middleCols<3>(6 * i) = sign * Matrix3::Identity();
      G.middleCols<3>(6 * i + 3) = -sign * *k.A * skew(k.r);
      G.middleCols<kModes>(12 + kModes * i) =
          sign * *k.A * Eigen::Map<const Matrix6X>(k.elastic, 6, kModes).topRows<3>();
    }
    return G;
  }

  Parameters parameters_;
  std::array<std::unique_ptr<FlexibleBody>, 2> bars_;
  std::array<Marker, 2> ends_;
  std::vector<std::pair<int, Marker>> markers_;  // which bar's, and its own
  LinearPattern pattern_;
  std::vector<FramePair> pairs_{{0, 1}};
};

}  // namespace lithe::test
