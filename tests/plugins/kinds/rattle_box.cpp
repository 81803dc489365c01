#include "engine/plugin.h"

using namespace lithe;

/// A rigid box (m, J about its centre, the body frame) with a bead μ on a spring k along its x axis, at r = (a + η)
/// e_x:
///   a_μ = p̈ + A (ω̇ × r + ω × (ω × r) + 2 ω × ṙ + r̈),   v = (ṗ, ω, η̇)
///   m (p̈ - g) + μ (a_μ - g) = 0,   J ω̇ + ω × J ω + r × Aᵀ μ (a_μ - g) = 0,   e_x · Aᵀ μ (a_μ - g) + k η = 0
class RattleBox final : public Body {
 public:
  struct Parameters {
    double mass = 1, bead_mass = 0.5;  // m, μ, kg
    Vector3 inertia{0.1, 0.2, 0.15};   // J, principal, kg m²
    double stiffness = 50, arm = 0.3;  // k, N/m; a, m
    Vector3 position{0, 0, 0}, angular_velocity{0, 0, 0};
  };
  static constexpr Field<Parameters> kParameters[] = {{"mass", &Parameters::mass},
                                                      {"bead_mass", &Parameters::bead_mass},
                                                      {"inertia", &Parameters::inertia},
                                                      {"stiffness", &Parameters::stiffness},
                                                      {"arm", &Parameters::arm},
                                                      {"position", &Parameters::position},
                                                      {"angular_velocity", &Parameters::angular_velocity}};
  struct Cache : BodyCache {
    double bead_motion[6] = {1, 0, 0, 0, 0, 0};  // of the bead's marker: along e_x, no rotation
    explicit Cache(const RattleBox&) {}
  };

  explicit RattleBox(Parameters parameters) : parameters_(parameters) {
    require::positive(parameters_.mass, "mass");
    require::positive(parameters_.bead_mass, "bead_mass");
  }

  Marker marker(const Point& position = {}, const Matrix3& orientation = Matrix3::Identity()) {
    markers_.push_back({position.at, orientation, false});
    return new_marker();
  }
  Marker node(int number, const Matrix3& orientation = Matrix3::Identity()) {
    if (number != 1) throw SceneError("there is no node " + std::to_string(number), "", "the bead is node 1");
    markers_.push_back({{0, 0, 0}, orientation, true});
    return new_marker();
  }

  Coordinates coordinates() const override { return {.frames = 1, .linear = 1}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override {
    q << parameters_.position, 1, 0, 0, 0, 0;
    v << 0, 0, 0, parameters_.angular_velocity, 0;
  }
  void evaluate(const BodyState& s, Level) const override {
    s.cache->A = rotation_matrix(Eigen::Map<const Vector4>(s.q + 3));
  }
  void add_residual(const BodyState& s, const double* v_dot, const Vector3& gravity, double* r) const override {
    const auto& p = parameters_;
    const Matrix3& A = s.cache->A;
    const Eigen::Map<const Vector3> p_ddot(v_dot), omega_dot(v_dot + 3), omega(s.v + 3);
    const Vector3 at = bead(s), rate(s.v[6], 0, 0);
    const Vector3 pull = p.bead_mass * (A.transpose() * (p_ddot - gravity) + omega_dot.cross(at) +
                                        omega.cross(omega.cross(at)) + 2 * omega.cross(rate) + Vector3(v_dot[6], 0, 0));
    Eigen::Map<Vector3>(r, 3) += p.mass * (p_ddot - gravity) + A * pull;
    Eigen::Map<Vector3>(r + 3, 3) +=
        p.inertia.cwiseProduct(omega_dot) + omega.cross(p.inertia.cwiseProduct(omega)) + at.cross(pull);
    r[6] += pull[0] + p.stiffness * s.q[7];
  }
  void add_tangent(const BodyState& s, const double*, const Vector3&, const TangentWeights& w,
                   BodyTangent& S) const override {
    const auto& p = parameters_;
    const double mu = w.acceleration * p.bead_mass;
    const Matrix3& A = s.cache->A;
    const Vector3 omega = Eigen::Map<const Vector3>(s.v + 3), Jw = p.inertia.cwiseProduct(omega), at = bead(s);
    const Matrix3 arm = skew(at), J = p.inertia.asDiagonal();
    S.frame.topLeftCorner<3, 3>().diagonal().array() += w.acceleration * p.mass + mu;
    S.frame.topRightCorner<3, 3>() -= mu * A * arm;
    S.frame.bottomLeftCorner<3, 3>() += mu * arm * A.transpose();
    S.frame.bottomRightCorner<3, 3>() += w.acceleration * J - mu * arm * arm;
    S.frame_linear.topRows<3>() += mu * A.col(0);
    S.linear_frame.leftCols<3>() += mu * A.col(0).transpose();
    S.linear[0] += mu + w.position * p.stiffness;
    // Velocity part: gyroscopic terms of the box, and of the bead  μ (ω × (ω × r) + 2 ω × ṙ).
    const Vector3 rate(s.v[6], 0, 0), along = omega.cross(Vector3::UnitX());
    const Matrix3 turn = -skew(omega.cross(at)) - skew(omega) * arm - 2 * skew(rate);
    const double b = w.velocity * p.bead_mass;
    S.frame.topRightCorner<3, 3>() += b * A * turn;
    S.frame.bottomRightCorner<3, 3>() += w.velocity * (skew(omega) * J - skew(Jw)) + b * arm * turn;
    S.frame_linear.topRows<3>() += 2 * b * A * along;
    S.frame_linear.bottomRows<3>() += 2 * b * at.cross(along);
    S.linear_frame.rightCols<3>() += b * turn.row(0);
  }
  void marker_kinematics(const BodyState& s, int marker, Level level, MarkerKinematics& k) const override {
    const Pose& pose = markers_[marker];
    const auto& cache = static_cast<const Cache&>(*s.cache);
    k.r = pose.on_bead ? bead(s) : pose.position;
    k.A = &cache.A;
    k.elastic = pose.on_bead ? cache.bead_motion : nullptr;
    k.p = Eigen::Map<const Vector3>(s.q) + cache.A * k.r;
    k.R = cache.A * pose.orientation;
    if (level == Level::position) return;
    const Eigen::Map<const Vector3> omega(s.v + 3);
    const Vector3 rate(pose.on_bead ? s.v[6] : 0, 0, 0);
    k.v = Eigen::Map<const Vector3>(s.v) + cache.A * (omega.cross(k.r) + rate);
    k.w = cache.A * omega;
    if (level == Level::velocity) return;
    k.bias_v = cache.A * (omega.cross(omega.cross(k.r)) + 2 * omega.cross(rate));
    k.bias_w.setZero();
  }
  BodyEnergy energy(const BodyState& s, const Vector3& gravity) const override {
    const auto& p = parameters_;
    const Eigen::Map<const Vector3> at(s.q), v(s.v), omega(s.v + 3);
    const Vector3 bead_v = v + s.cache->A * (omega.cross(bead(s)) + Vector3(s.v[6], 0, 0));
    return {.kinetic = 0.5 * (p.mass * v.squaredNorm() + p.inertia.dot(omega.cwiseAbs2()) +
                              p.bead_mass * bead_v.squaredNorm()),
            .elastic = 0.5 * p.stiffness * s.q[7] * s.q[7],
            .gravity = -gravity.dot(p.mass * at + p.bead_mass * (at + s.cache->A * bead(s)))};
  }

 private:
  struct Pose {
    Vector3 position;
    Matrix3 orientation;
    bool on_bead;
  };
  Vector3 bead(const BodyState& s) const { return {parameters_.arm + s.q[7], 0, 0}; }

  const Parameters parameters_;
  std::vector<Pose> markers_;
};

LITHE_EXPORT_BODY(RattleBox, "rattle_box")
