#include <array>

#include "engine/plugin.h"

using namespace lithe;

/// Three rigid blocks in a row as one body with three frames: frame i + 1 is tied to frame i by a spring, and carries
/// half of a bead μ in the middle between their origins, which couples their masses:
///   T = Σ ½ m |ṗ_i|² + ½ ω_i·J ω_i + Σ ½ μ |½ (ṗ_i + ṗ_i+1)|²
///   V = Σ ½ k |s|² + ½ c |θ|²,   s = A_iᵀ (p_i+1 - p_i) - l e_x,   θ = log(A_iᵀ A_i+1)
class FrameChain final : public Body {
 public:
  static constexpr int kFrames = 3;
  struct Parameters {
    double mass = 1, bead_mass = 0.4;              // m, μ, kg
    Vector3 inertia{0.1, 0.2, 0.15};               // J, principal, kg m²
    double stiffness = 200, turn_stiffness = 8;    // k, N/m; c, N m/rad
    double length = 0.5;                           // l, m
    Vector3 position{0, 0, 0}, velocity{0, 0, 0};  // of the first, as drawn; all have that velocity
  };
  static constexpr Field<Parameters> kParameters[] = {{"mass", &Parameters::mass},
                                                      {"bead_mass", &Parameters::bead_mass},
                                                      {"inertia", &Parameters::inertia},
                                                      {"stiffness", &Parameters::stiffness},
                                                      {"turn_stiffness", &Parameters::turn_stiffness},
                                                      {"length", &Parameters::length},
                                                      {"position", &Parameters::position},
                                                      {"velocity", &Parameters::velocity}};
  struct Cache : BodyCache {
    /// In the middle between two origins, with the axes of the first frame.
    struct Middle final : MarkerBetween {
      Matrix3 A;
      void add_load_stiffness(const Vector3&, const Vector3& torque, Eigen::Matrix<double, 12, 12>& K) const override {
        K.block<3, 3>(3, 3) += skew(A.transpose() * torque);
      }
    };
    std::array<Matrix3, kFrames> axes;
    std::array<Middle, kFrames - 1> middles;
    explicit Cache(const FrameChain&) {}
  };

  explicit FrameChain(Parameters parameters) : parameters_(parameters) { require::positive(parameters_.mass, "mass"); }

  /// At the origin of frame `number`, from 0.
  Marker node(int number, const Matrix3& orientation = Matrix3::Identity()) {
    if (number < 0 || number >= kFrames)
      throw SceneError("there is no frame " + std::to_string(number), "", "give 0, 1 or 2");
    markers_.push_back({number, {0, 0, 0}, orientation});
    return new_marker();
  }
  /// The first frame's own.
  Marker marker(const Point& position = {}, const Matrix3& orientation = Matrix3::Identity()) {
    return marker_in(0, position, orientation);
  }
  Marker marker_in(int frame, const Point& position, const Matrix3& orientation = Matrix3::Identity()) {
    markers_.push_back({frame, position.at, orientation});
    return new_marker();
  }

  /// Where bead `number` is, from 0, with the axes of the frame before it.
  Marker bead(int number) {
    markers_.push_back({number, {0, 0, 0}, Matrix3::Identity(), true});
    return new_marker();
  }

  Coordinates coordinates() const override { return {.frames = kFrames, .linear = 0, .pairs = kPairs}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override {
    v.setZero();
    for (int i = 0; i < kFrames; ++i) {
      q.segment<7>(7 * i) << parameters_.position + Vector3(i * parameters_.length, 0, 0), 1, 0, 0, 0;
      v.segment<3>(6 * i) = parameters_.velocity;
    }
  }
  void evaluate(const BodyState& s, Level) const override {
    auto& cache = static_cast<Cache&>(*s.cache);
    for (int i = 0; i < kFrames; ++i) cache.axes[i] = rotation_matrix(Eigen::Map<const Vector4>(s.q + 7 * i + 3));
    cache.A = cache.axes[0];
    for (int i = 0; i + 1 < kFrames; ++i) {
      Cache::Middle& middle = cache.middles[i];
      middle.A = cache.axes[i];
      for (int k : {0, 1}) {
        middle.shares[k].frame = i + k;
        middle.shares[k].J.setZero();
        middle.shares[k].J.topLeftCorner<3, 3>().diagonal().setConstant(0.5);
      }
      middle.shares[0].J.bottomRightCorner<3, 3>() = middle.A;
    }
  }
  void add_residual(const BodyState& s, const double* v_dot, const Vector3& gravity, double* r) const override {
    const auto& p = parameters_;
    const auto acceleration = [&](int i) -> Vector3 { return Eigen::Map<const Vector3>(v_dot + 6 * i) - gravity; };
    for (int i = 0; i < kFrames; ++i) {
      const Eigen::Map<const Vector3> omega(s.v + 6 * i + 3), omega_dot(v_dot + 6 * i + 3);
      Eigen::Map<Vector3>(r + 6 * i) += p.mass * acceleration(i);
      Eigen::Map<Vector3>(r + 6 * i + 3) +=
          p.inertia.cwiseProduct(omega_dot) + omega.cross(p.inertia.cwiseProduct(omega));
    }
    for (int i = 0; i + 1 < kFrames; ++i) {
      const Vector3 half = p.bead_mass / 4 * (acceleration(i) + acceleration(i + 1));
      Eigen::Map<Vector3>(r + 6 * i) += half;
      Eigen::Map<Vector3>(r + 6 * i + 6) += half;
      Eigen::Map<Vector12>(r + 6 * i) += spring(pose(s.q + 7 * i), pose(s.q + 7 * i + 7));
    }
  }
  void add_tangent(const BodyState& s, const double*, const Vector3&, const TangentWeights& w,
                   BodyTangent& S) const override {
    const auto& p = parameters_;
    const Matrix3 J = p.inertia.asDiagonal();
    const double bead = w.acceleration * p.bead_mass / 4;
    for (int i = 0; i < kFrames; ++i) {
      auto block = S.frame_block(i);
      const int beads = i > 0 && i + 1 < kFrames ? 2 : 1;
      block.topLeftCorner<3, 3>().diagonal().array() += w.acceleration * p.mass + beads * bead;
      const Vector3 omega = Eigen::Map<const Vector3>(s.v + 6 * i + 3);
      block.bottomRightCorner<3, 3>() +=
          w.acceleration * J + w.velocity * (skew(omega) * J - skew(p.inertia.cwiseProduct(omega)));
    }
    for (int i = 0; i + 1 < kFrames; ++i) {
      S.upper_block(i).topLeftCorner<3, 3>().diagonal().array() += bead;
      S.lower_block(i).topLeftCorner<3, 3>().diagonal().array() += bead;
      if (w.position == 0) continue;
      const Matrix12 K = w.position * stiffness(pose(s.q + 7 * i), pose(s.q + 7 * i + 7));
      S.frame_block(i) += K.topLeftCorner<6, 6>();
      S.frame_block(i + 1) += K.bottomRightCorner<6, 6>();
      S.upper_block(i) += K.topRightCorner<6, 6>();
      S.lower_block(i) += K.bottomLeftCorner<6, 6>();
    }
  }
  void marker_kinematics(const BodyState& s, int marker, Level level, MarkerKinematics& k) const override {
    const Place& place = markers_[marker];
    const Matrix3& A = static_cast<const Cache&>(*s.cache).axes[place.frame];
    const double *q = s.q + 7 * place.frame, *v = s.v + 6 * place.frame;
    if (place.on_bead) return bead_kinematics(s, place.frame, level, k);
    k.between = nullptr;
    k.frame = place.frame;
    k.r = place.position;
    k.A = &A;
    k.elastic = nullptr;
    k.p = Eigen::Map<const Vector3>(q) + A * k.r;
    k.R = A * place.orientation;
    if (level == Level::position) return;
    const Eigen::Map<const Vector3> omega(v + 3);
    k.v = Eigen::Map<const Vector3>(v) + A * omega.cross(k.r);
    k.w = A * omega;
    if (level == Level::velocity) return;
    k.bias_v = A * omega.cross(omega.cross(k.r));
    k.bias_w.setZero();
  }
  BodyEnergy energy(const BodyState& s, const Vector3& gravity) const override {
    const auto& p = parameters_;
    BodyEnergy e;
    for (int i = 0; i < kFrames; ++i) {
      const Eigen::Map<const Vector3> at(s.q + 7 * i), v(s.v + 6 * i), omega(s.v + 6 * i + 3);
      e.kinetic += 0.5 * (p.mass * v.squaredNorm() + p.inertia.dot(omega.cwiseAbs2()));
      e.gravity -= p.mass * gravity.dot(at);
      if (i + 1 == kFrames) break;
      const Eigen::Map<const Vector3> next(s.q + 7 * i + 7), next_v(s.v + 6 * i + 6);
      e.kinetic += 0.5 * p.bead_mass * (0.5 * (v + next_v)).squaredNorm();
      e.gravity -= p.bead_mass * gravity.dot(0.5 * (at + next));
      const Stretch x = stretch(pose(s.q + 7 * i), pose(s.q + 7 * i + 7));
      e.elastic += 0.5 * p.stiffness * x.shift.squaredNorm() + 0.5 * p.turn_stiffness * x.turn.squaredNorm();
    }
    return e;
  }

  using Vector12 = Eigen::Matrix<double, 12, 1>;
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  struct Pose {
    Vector3 p;
    Vector4 e;
  };
  struct Stretch {
    Vector3 shift, turn;
  };
  Stretch stretch(const Pose& a, const Pose& b) const {
    const Matrix3 A = rotation_matrix(a.e);
    Vector4 turn = quaternion_product(Vector4(a.e[0], -a.e[1], -a.e[2], -a.e[3]), b.e);
    if (turn[0] < 0) turn = -turn;
    const double s = turn.tail<3>().norm();
    return {A.transpose() * (b.p - a.p) - Vector3(parameters_.length, 0, 0),
            (s > 0 ? 2 * std::atan2(s, turn[0]) / s : 2.0) * turn.tail<3>()};
  }
  /// ∂V/∂(p_a, turn of a, p_b, turn of b), turns in the axes of the frames.
  Vector12 spring(const Pose& a, const Pose& b) const {
    const Matrix3 A = rotation_matrix(a.e);
    const Stretch x = stretch(a, b);
    const Vector3 pull = parameters_.stiffness * x.shift, twist = parameters_.turn_stiffness * x.turn;
    Vector12 r;
    r << -(A * pull), -(A.transpose() * (b.p - a.p)).cross(pull) - twist, A * pull, twist;
    return r;
  }

 private:
  struct Place {
    int frame;
    Vector3 position;
    Matrix3 orientation;
    bool on_bead = false;
  };
  static void bead_kinematics(const BodyState& s, int i, Level level, MarkerKinematics& k) {
    const auto vector = [](const double* from) { return Eigen::Map<const Vector3>(from); };
    const auto& cache = static_cast<const Cache&>(*s.cache);
    k.between = &cache.middles[i];
    k.frame = i;
    k.A = &cache.axes[i];
    k.elastic = nullptr;
    k.r.setZero();
    k.p = 0.5 * (vector(s.q + 7 * i) + vector(s.q + 7 * i + 7));
    k.R = cache.axes[i];
    if (level == Level::position) return;
    k.v = 0.5 * (vector(s.v + 6 * i) + vector(s.v + 6 * i + 6));
    k.w = cache.axes[i] * vector(s.v + 6 * i + 3);
    if (level == Level::velocity) return;
    k.bias_v.setZero();
    k.bias_w.setZero();
  }
  static constexpr FramePair kPairs[] = {{0, 1}, {1, 2}};

  static Pose pose(const double* q) { return {Eigen::Map<const Vector3>(q), Eigen::Map<const Vector4>(q + 3)}; }
  static void move(Pose& pose, int i, double d) {
    if (i < 3)
      pose.p[i] += d;
    else
      pose.e = rotated(pose.e, d * Vector3::Unit(i - 3));
  }
  /// By central differences: 1e-9 of it is enough for Newton.
  Matrix12 stiffness(const Pose& a, const Pose& b) const {
    constexpr double kStep = 1e-5;
    Matrix12 K;
    for (int i = 0; i < 12; ++i) {
      Vector12 ends[2];
      for (int side : {0, 1}) {
        Pose from = a, to = b;
        move(i < 6 ? from : to, i % 6, side == 0 ? -kStep : kStep);
        ends[side] = spring(from, to);
      }
      K.col(i) = (ends[1] - ends[0]) / (2 * kStep);
    }
    return K;
  }

  const Parameters parameters_;
  std::vector<Place> markers_;
};

LITHE_EXPORT_BODY(FrameChain, "frame_chain")
