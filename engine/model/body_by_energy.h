#pragma once

#include <vector>

#include "engine/base/dual.h"
#include "engine/base/rotations.h"
#include "engine/model/body.h"
#include "engine/model/joint_by_residual.h"

namespace lithe {

/// Where a body is, as a function of S: place and axes of its frame (bodies without frame have none), and η.
template <class S, int Linear>
struct ConfigurationOf {
  Eigen::Matrix<S, 3, 1> p;  // m, world axes
  Eigen::Matrix<S, 3, 3> R;  // body axes to world axes
  std::array<S, Linear> eta{};
};
/// How it moves.
template <class S, int Linear>
struct MotionOf {
  Eigen::Matrix<S, 3, 1> v;  // ṗ, m/s, world axes
  Eigen::Matrix<S, 3, 1> w;  // ω, rad/s, body axes
  std::array<S, Linear> eta_dot{};
};

/// A body from its energies alone, written once over the scalar: mass matrix, quadratic velocity force, internal force,
/// gravity, their tangents and the Jacobians of its markers are derived.
///   struct Telescope final : BodyByEnergy<Telescope, /*frames=*/0, /*linear=*/1> {
///     template <class S> S kinetic(const Configuration<S>& q, const Motion<S>& v) const;
///     template <class S> S potential(const Configuration<S>& q, const Vector3& gravity) const;  // J
///     template <class S> PoseOf<S> marker_pose(int marker, const Configuration<S>& q) const;    // world axes
///   };
/// With π = ∂T/∂v, L = T - V (Lagrange; for a frame's turn Euler & Poincaré, Holm, Schmah & Stoica, Geometric Mechanics
/// and Symmetry, 2009, 7.2):
///   π̇_p = ∂L/∂p,   π̇_ω + ω × π_ω = ∂L/∂θ (R exp(θ~)),   π̇_η = ∂L/∂η
/// T is quadratic in v. Costs grow with the square of the number of velocities, those of a tangent with its cube: for
/// bodies of few coordinates. There is no damping: give it by forces.
template <class Derived, int Frames, int Linear>
class BodyByEnergy : public Body {
  static_assert(Frames == 0 || Frames == 1, "a body by its energies has one frame or none");

 public:
  static constexpr int kVelocities = 6 * Frames + Linear;
  template <class S>
  using Configuration = ConfigurationOf<S, Linear>;
  template <class S>
  using Motion = MotionOf<S, Linear>;
  struct Cache : BodyCache {
    explicit Cache(const Body& body)
        : elastic(static_cast<std::size_t>(body.marker_count()), Matrix6X::Zero(6, Linear)) {}
    std::vector<Matrix6X> elastic;  // a marker each
  };

  Coordinates coordinates() const override {
    return {.frames = Frames, .linear = Linear, .pattern = Linear > 1 ? &pattern() : nullptr};
  }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override {
    if constexpr (Frames > 0) {
      q.template head<7>() << start_.p, quaternion_of(start_.R);
      v.template head<6>() << start_motion_.v, start_motion_.w;
    }
    for (int i = 0; i < Linear; ++i) q[7 * Frames + i] = start_.eta[i], v[6 * Frames + i] = start_motion_.eta_dot[i];
  }
  void evaluate(const BodyState& state, Level) const override {
    if constexpr (Frames > 0) state.cache->A = rotation_matrix(Eigen::Map<const Vector4>(state.q + 3));
  }

  void add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const override {
    const auto out = residual<double>(at<double>(state), moving<double>(state), numbers<double>(v_dot), gravity);
    for (int i = 0; i < kVelocities; ++i) r[i] += out[i];
  }

  /// Exact, but for the velocity part of the linear-linear block, and the half of that block that is not symmetric.
  void add_tangent(const BodyState& state, const double* v_dot, const Vector3& gravity, const TangentWeights& weights,
                   BodyTangent& S) const override {
    using D = Dual<kVelocities>;
    Eigen::Matrix<double, kVelocities, kVelocities> whole, elastic;  // of all, and without the velocity part
    whole.setZero(), elastic.setZero();
    const auto add = [&](double weight, const std::array<D, kVelocities>& r, bool of_velocity) {
      for (int i = 0; i < kVelocities; ++i)
        for (int j = 0; j < kVelocities; ++j) {
          whole(i, j) += weight * r[i].d[j];
          if (!of_velocity) elastic(i, j) += weight * r[i].d[j];
        }
    };
    Configuration<D> q = at<D>(state);
    Motion<D> v = moving<D>(state);
    std::array<D, kVelocities> a = numbers<D>(v_dot);
    if (weights.position != 0) {
      Configuration<D> moved = q;
      seed(moved);
      add(weights.position, residual<D>(moved, v, a, gravity), false);
    }
    if (weights.velocity != 0) {
      Motion<D> faster = v;
      seed(faster);
      add(weights.velocity, residual<D>(q, faster, a, gravity), true);
    }
    if (weights.acceleration != 0) {
      for (int i = 0; i < kVelocities; ++i) a[i].d[i] = 1;
      add(weights.acceleration, residual<D>(q, v, a, gravity), false);
    }
    if constexpr (Frames > 0) {
      S.frame += whole.template topLeftCorner<6, 6>();
      if constexpr (Linear > 0) {
        S.frame_linear += whole.template topRightCorner<6, Linear>();
        S.linear_frame += whole.template bottomLeftCorner<Linear, 6>();
      }
    }
    int entry = 0;
    for (int j = 0; j < Linear; ++j)
      for (int i = j; i < (Linear > 1 ? Linear : j + 1); ++i)
        S.linear[entry++] += 0.5 * (elastic(6 * Frames + i, 6 * Frames + j) + elastic(6 * Frames + j, 6 * Frames + i));
  }

  void marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const override {
    using D = Dual<Linear>;
    auto& cache = static_cast<Cache&>(*state.cache);
    const Matrix3& A = cache.A;
    Configuration<D> bent = at<D>(state);
    for (int i = 0; i < Linear; ++i) bent.eta[i].d[i] = 1;
    const PoseOf<D> pose = derived().template marker_pose<D>(marker, bent);
    auto& columns = cache.elastic[static_cast<std::size_t>(marker)];
    for (int r = 0; r < 3; ++r) {
      k.p[r] = pose.p[r].value;
      for (int c = 0; c < 3; ++c) k.R(r, c) = pose.R(r, c).value;
    }
    for (int i = 0; i < Linear; ++i) {
      Vector3 shift;
      Matrix3 turn;
      for (int r = 0; r < 3; ++r) {
        shift[r] = pose.p[r].d[i];
        for (int c = 0; c < 3; ++c) turn(r, c) = pose.R(r, c).d[i];
      }
      columns.col(i) << A.transpose() * shift, A.transpose() * axis_of(turn * k.R.transpose());
    }
    k.A = &A;
    k.r = k.p;
    if constexpr (Frames > 0) k.r = A.transpose() * (k.p - Eigen::Map<const Vector3>(state.q));
    k.elastic = Linear > 0 ? columns.data() : nullptr;
    k.deflected = nullptr;  // what changes its columns is left out of Newton's matrix
    if (level == Level::position) return;

    const PoseOf<InTime> path = derived().template marker_pose<InTime>(marker, in_time(state));
    Matrix3 R_dot, R_dotdot;
    for (int r = 0; r < 3; ++r) {
      k.v[r] = path.p[r].rate, k.bias_v[r] = path.p[r].acceleration;
      for (int c = 0; c < 3; ++c) R_dot(r, c) = path.R(r, c).rate, R_dotdot(r, c) = path.R(r, c).acceleration;
    }
    k.w = axis_of(R_dot * k.R.transpose());
    k.bias_w = axis_of(R_dotdot * k.R.transpose() + R_dot * R_dot.transpose());
  }

  BodyEnergy energy(const BodyState& state, const Vector3& gravity) const override {
    const Configuration<double> q = at<double>(state);
    BodyEnergy e;
    e.kinetic = derived().template kinetic<double>(q, moving<double>(state));
    e.elastic = derived().template potential<double>(q, Vector3::Zero());
    e.gravity = derived().template potential<double>(q, gravity) - e.elastic;
    return e;
  }

 protected:
  explicit BodyByEnergy(const Configuration<double>& start = resting(), const Motion<double>& motion = still())
      : start_(start), start_motion_(motion) {}
  /// At the origin, along the world's axes, η = 0; and no motion: to be changed from.
  static Configuration<double> resting() { return {Vector3::Zero(), Matrix3::Identity(), {}}; }
  static Motion<double> still() { return {Vector3::Zero(), Vector3::Zero(), {}}; }

 private:
  const Derived& derived() const { return static_cast<const Derived&>(*this); }

  /// The lower triangle.
  static const LinearPattern& pattern() {
    static const LinearPattern whole = [] {
      LinearPattern p;
      p.rows.resize(Linear * (Linear + 1) / 2), p.columns.resize(Linear * (Linear + 1) / 2);
      int entry = 0;
      for (int j = 0; j < Linear; ++j)
        for (int i = j; i < Linear; ++i) p.rows[entry] = i, p.columns[entry++] = j;
      return p;
    }();
    return whole;
  }
  static Vector3 axis_of(const Matrix3& skewed) {
    return 0.5 * Vector3(skewed(2, 1) - skewed(1, 2), skewed(0, 2) - skewed(2, 0), skewed(1, 0) - skewed(0, 1));
  }

  // ---- configurations, motions and accelerations as numbers of S ----

  template <class S>
  static std::array<S, kVelocities> numbers(const double* from) {
    std::array<S, kVelocities> out;
    for (int i = 0; i < kVelocities; ++i) out[i] = from[i];
    return out;
  }
  template <class S>
  static Configuration<S> at(const BodyState& state) {
    Configuration<S> q;
    if constexpr (Frames > 0) {
      q.p = Eigen::Map<const Vector3>(state.q).template cast<S>();
      q.R = state.cache->A.template cast<S>();
    }
    for (int i = 0; i < Linear; ++i) q.eta[i] = state.q[7 * Frames + i];
    return q;
  }
  template <class S>
  static Motion<S> moving(const BodyState& state) {
    Motion<S> v;
    if constexpr (Frames > 0) {
      v.v = Eigen::Map<const Vector3>(state.v).template cast<S>();
      v.w = Eigen::Map<const Vector3>(state.v + 3).template cast<S>();
    }
    for (int i = 0; i < Linear; ++i) v.eta_dot[i] = state.v[6 * Frames + i];
    return v;
  }
  static Configuration<InTime> in_time(const BodyState& state) {
    Configuration<InTime> q;
    if constexpr (Frames > 0) {
      const Matrix3& A = state.cache->A;
      const Matrix3 w = skew(Vector3(Eigen::Map<const Vector3>(state.v + 3))), rate = A * w, turn = rate * w;
      for (int r = 0; r < 3; ++r) {
        q.p[r] = {state.q[r], state.v[r], 0};
        for (int c = 0; c < 3; ++c) q.R(r, c) = {A(r, c), rate(r, c), turn(r, c)};
      }
    }
    for (int i = 0; i < Linear; ++i) q.eta[i] = {state.q[7 * Frames + i], state.v[6 * Frames + i], 0};
    return q;
  }

  /// d[first + i] = 1 in the i-th motion: translations in world axes, turns R exp(θ~), η.
  template <class S>
  static void seed(Configuration<S>& q) {
    if constexpr (Frames > 0) {
      const Eigen::Matrix<S, 3, 3> R = q.R;
      for (int i = 0; i < 3; ++i) {
        q.p[i].d[i] += 1.0;
        const int next = (i + 1) % 3, last = (i + 2) % 3;  // e_i × e_next = e_last, e_i × e_last = -e_next
        for (int r = 0; r < 3; ++r) {
          q.R(r, next).d[3 + i] += R(r, last).value;
          q.R(r, last).d[3 + i] -= R(r, next).value;
        }
      }
    }
    for (int i = 0; i < Linear; ++i) q.eta[i].d[6 * Frames + i] += 1.0;
  }
  template <class S>
  static void seed(Motion<S>& v) {
    if constexpr (Frames > 0)
      for (int i = 0; i < 3; ++i) v.v[i].d[i] += 1.0, v.w[i].d[3 + i] += 1.0;
    for (int i = 0; i < Linear; ++i) v.eta_dot[i].d[6 * Frames + i] += 1.0;
  }

  /// π̇ and what stands against it, for coordinates, velocities and accelerations that may carry derivatives themselves.
  template <class B>
  std::array<B, kVelocities> residual(const Configuration<B>& q, const Motion<B>& v,
                                      const std::array<B, kVelocities>& a, const Vector3& gravity) const {
    using Rate = Dual<1, B>;
    using Momentum = Dual<kVelocities, Rate>;
    // 1. Momenta along the motion.
    const auto along = [](const B& x, const B& x_dot) {
      Momentum out;
      out.value.value = x, out.value.d[0] = x_dot;
      return out;
    };
    Configuration<Momentum> path;
    Motion<Momentum> speed;
    if constexpr (Frames > 0) {
      for (int r = 0; r < 3; ++r) {
        path.p[r] = along(q.p[r], v.v[r]);
        speed.v[r] = along(v.v[r], a[r]), speed.w[r] = along(v.w[r], a[3 + r]);
        for (int c = 0; c < 3; ++c) {
          const int next = (c + 1) % 3, last = (c + 2) % 3;  // R ω~ e_c = R (ω × e_c)
          path.R(r, c) = along(q.R(r, c), q.R(r, next) * v.w[last] - q.R(r, last) * v.w[next]);
        }
      }
    }
    for (int i = 0; i < Linear; ++i) {
      path.eta[i] = along(q.eta[i], v.eta_dot[i]);
      speed.eta_dot[i] = along(v.eta_dot[i], a[6 * Frames + i]);
    }
    seed(speed);
    const Momentum T = derived().template kinetic<Momentum>(path, speed);

    // 2. L by the configuration.
    using Slope = Dual<kVelocities, B>;
    Configuration<Slope> moved;
    Motion<Slope> same;
    if constexpr (Frames > 0) {
      for (int r = 0; r < 3; ++r) {
        moved.p[r].value = q.p[r], same.v[r].value = v.v[r], same.w[r].value = v.w[r];
        for (int c = 0; c < 3; ++c) moved.R(r, c).value = q.R(r, c);
      }
    }
    for (int i = 0; i < Linear; ++i) moved.eta[i].value = q.eta[i], same.eta_dot[i].value = v.eta_dot[i];
    seed(moved);
    const Slope L =
        derived().template kinetic<Slope>(moved, same) - derived().template potential<Slope>(moved, gravity);

    std::array<B, kVelocities> r;
    for (int i = 0; i < kVelocities; ++i) r[i] = T.d[i].d[0] - L.d[i];
    if constexpr (Frames > 0)
      for (int i = 0; i < 3; ++i) {
        const int next = (i + 1) % 3, last = (i + 2) % 3;
        r[3 + i] += v.w[next] * T.d[3 + last].value - v.w[last] * T.d[3 + next].value;
      }
    return r;
  }

  const Configuration<double> start_;
  const Motion<double> start_motion_;
};

}  // namespace lithe
