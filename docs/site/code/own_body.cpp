// own_body: a particle, three coordinates and no rotation, circles on a thread as a conical pendulum.
#include <cmath>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

/// A point with mass: m (p̈ − g) = f, q = p, v = ṗ.
class Particle final : public Body {
 public:
  struct Parameters {
    double mass = 1;                               // kg
    Vector3 position{0, 0, 0}, velocity{0, 0, 0};  // m, m/s, world axes
  };
  struct Cache : BodyCache {
    explicit Cache(const Particle&) {}
  };
  /// Throws SceneError for a mass that is not above zero.
  explicit Particle(Parameters parameters) : parameters_(parameters) { require::positive(parameters_.mass, "mass"); }

  Marker marker() { return new_marker(); }

  // What it has: no frame, three linear coordinates.
  Coordinates coordinates() const override { return {.frames = 0, .linear = 3}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override { q = parameters_.position, v = parameters_.velocity; }

  // Its equations: r = M v̇ − f, and the derivative of r.
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override {
    Eigen::Map<Vector3>(r, 3) += parameters_.mass * (Eigen::Map<const Vector3>(v_dot) - gravity);
  }
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                   BodyTangent& S) const override {
    S.linear.array() += weights.acceleration * parameters_.mass;
  }
  BodyEnergy energy(const BodyState& s, const Vector3& gravity) const override {
    const Eigen::Map<const Vector3> p(s.q), v(s.v);
    return {.kinetic = parameters_.mass / 2 * v.squaredNorm(), .gravity = -parameters_.mass * gravity.dot(p)};
  }

  // Its marker: where it is, how it moves, and the columns of its motion (6 x 3: translation above rotation).
  void marker_kinematics(const BodyState& s, int, Level, MarkerKinematics& k) const override {
    static constexpr double kColumns[18] = {1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0};
    k.p = k.r = Eigen::Map<const Vector3>(s.q);
    k.v = Eigen::Map<const Vector3>(s.v);
    k.R = Matrix3::Identity();
    k.w = k.bias_v = k.bias_w = Vector3::Zero();
    k.A = &s.cache->A;
    k.elastic = kColumns;
  }

 private:
  const Parameters parameters_;
};

int main() {
  // 1. A cone of 30 degrees: the speed is what keeps it there.
  const double length = 0.5, angle = M_PI / 6, g = 9.81;
  const double rate = std::sqrt(g / (length * std::cos(angle))), radius = length * std::sin(angle);
  SystemGraph graph{{.gravity = {0, 0, -g}}};
  auto& bob = graph.add<Particle>(
      "bob", {.mass = 2, .position = {radius, 0, -length * std::cos(angle)}, .velocity = {0, rate * radius, 0}});
  graph.add<DistanceJoint>("thread", {graph.ground().marker(), bob.marker()}, {.length = length});

  // 2. Once round, by an explicit and by an implicit method.
  const System system = assemble(graph);
  const State start = system.initial_state();
  ExplicitRungeKutta explicit_method{{.tolerance = {.relative = 1e-9, .absolute = 1e-9}}};
  Radau implicit_method{{.tolerance = {.relative = 1e-8, .absolute = 1e-8}}};
  double worst = 0;
  for (Integrator* method : {static_cast<Integrator*>(&explicit_method), static_cast<Integrator*>(&implicit_method)}) {
    State state = start;
    Simulation{system, *method}.run(state, 2 * M_PI / rate);
    // Check the answer: it comes back to where it began.
    const double gap = (state.q - start.q).norm();
    std::printf("%s: back within %.1e m\n", method->name().c_str(), gap);
    worst = std::max(worst, gap);
  }
  return worst < 1e-6 ? 0 : 1;
}
