// Joints, a force, a body and an integrator that throw, each where it is told to; and one that asks for smaller steps.
#include <limits>

#include "engine/plugin.h"

using namespace lithe;

namespace {

struct When {
  bool create = false;
  double evaluate = 1e300;  // from this time on
  bool strange = false;     // throws what is no exception

  void made() const {
    if (create) throw std::runtime_error("it does not want to be made");
  }
  void evaluated(double time) const {
    if (time < evaluate) return;
    if (strange) throw 42;
    throw SceneError("it has had enough", "throwing.cpp", "stop earlier");
  }
};
constexpr Field<When> kFields[] = {
    {"create", &When::create}, {"evaluate", &When::evaluate}, {"strange", &When::strange}};

}  // namespace

class ThrowingJoint final : public Joint<2, 3> {
 public:
  using Parameters = When;
  static constexpr auto& kParameters = kFields;
  explicit ThrowingJoint(When when) : when_(when) { when.made(); }
  void evaluate(double time, std::span<const MarkerView> m, ConstraintRows& rows) const override {
    when_.evaluated(time);
    coincident(m[0], m[1], rows);
  }

 private:
  const When when_;
};

class ThrowingForce final : public Force<1, 0> {
 public:
  using Parameters = When;
  static constexpr auto& kParameters = kFields;
  explicit ThrowingForce(When when) : when_(when) { when.made(); }
  void evaluate(double time, std::span<const MarkerView>, ForceRows&) const override { when_.evaluated(time); }

 private:
  const When when_;
};

class ThrowingBody final : public Body {
 public:
  using Parameters = When;
  static constexpr auto& kParameters = kFields;
  struct Cache : BodyCache {
    explicit Cache(const ThrowingBody&) {}
  };
  explicit ThrowingBody(When when) : when_(when) { when.made(); }
  Coordinates coordinates() const override { return {.frames = 0, .linear = 1}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override { q.setZero(), v.setZero(); }
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState& s, const double* v_dot, const Vector3& gravity, double* r) const override {
    when_.evaluated(-s.q[0]);  // metres fallen
    r[0] += v_dot[0] - gravity[2];
  }
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& w,
                   BodyTangent& S) const override {
    S.linear[0] += w.acceleration;
  }
  void marker_kinematics(const BodyState&, int, Level, MarkerKinematics&) const override {}
  BodyEnergy energy(const BodyState&, const Vector3&) const override { return {}; }

 private:
  const When when_;
};

class ThrowingIntegrator final : public Integrator {
 public:
  using Parameters = When;
  static constexpr auto& kParameters = kFields;
  explicit ThrowingIntegrator(When when) : when_(when) { when.made(); }
  std::string name() const override { return "throwing"; }
  void prepare(EquationsOfMotion&, State&) override {}
  StepResult advance(EquationsOfMotion&, State& state, double t_stop) override {
    when_.evaluated(state.time);
    state.time = t_stop;
    return {StepResult::Outcome::failed, "it would rather not"};
  }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 private:
  const When when_;
  IntegratorStatistics statistics_;
};

/// A force that cannot be evaluated where its marker has moved more than a little since the last step it has seen: as a
/// compiled-in one would, it says so by NaN.
class ShyForce final : public Force<1, 0> {
 public:
  struct Parameters {
    double speed = 1;  // above this, m/s, no value
  };
  static constexpr Field<Parameters> kParameters[] = {{"speed", &Parameters::speed}};
  explicit ShyForce(Parameters p) : speed_(p.speed) {}
  void evaluate(double, std::span<const MarkerView> m, ForceRows& rows) const override {
    rows.add_load(m[0], force(m[0].v.norm() > speed_ ? Vector3::Constant(std::numeric_limits<double>::quiet_NaN())
                                                     : Vector3(-10 * m[0].v)));
  }

 private:
  const double speed_;
};

LITHE_EXPORT_JOINT(ThrowingJoint, "throwing_joint")
LITHE_EXPORT_FORCE(ThrowingForce, "throwing_force")
LITHE_EXPORT_FORCE(ShyForce, "shy_force")
LITHE_EXPORT_BODY(ThrowingBody, "throwing_body")
LITHE_EXPORT_INTEGRATOR(ThrowingIntegrator, "throwing_integrator")
