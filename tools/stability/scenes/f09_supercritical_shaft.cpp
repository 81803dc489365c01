// F09: a shaft with damping of its material that spins freely beyond its first critical speed whirls ever wider (A. L.
// Kimball, Phys. Rev. 21 (1923) 703): damping turns with the shaft. Damping in axes that do not turn, and methods that
// damp, call it stable.
#include "bodies/beam/beam.h"
#include "joints/point_on_line_joint.h"
#include "joints/spherical_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

// Steel, 2 m between its bearings, 20 mm; the time of Kelvin and Voigt.
constexpr double kLength = 2, kRadius = 0.01, kViscous = 1e-3, kWide = 1e-4;  // m, m, s, m
constexpr int kElements = 12;
const Material kSteel{2.1e11, 0.3, 7850};
/// First frequency of bending, π²/L² √(EI/ρA), which is the critical speed, rad/s.
const double kCritical = std::pow(M_PI / kLength, 2) * std::sqrt(kSteel.young / kSteel.density) * kRadius / 2;
/// Of a whirl forwards with internal damping: m z̈ + τ k (ż - i Ω z) + k z = 0, small τ ω.
double expected_rate(double share) { return 0.5 * kViscous * kCritical * kCritical * (share - 1); }
const double kEnd = 1.5 / expected_rate(2);  // s, e^1.5 wider at twice the critical speed

class Shaft : public Bench {
 public:
  explicit Shaft(double share)
      : Bench(Vector3::Zero(), [&](SystemGraph& graph) {
          auto& shaft =
              graph.add<Beam>("shaft", {.axis = BeamAxis::straight({0, 0, 0}, {kLength, 0, 0}, {0, 1, 0}),
                                        .sections = {{0, BeamSection::circle(kRadius, kSteel).damped(kViscous)}},
                                        .elements = kElements,
                                        .angular_velocity = {share * kCritical, 0, 0}});
          const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2);  // z of the line: the shaft's axis
          graph.add<SphericalJoint>("bearing", {graph.ground().marker(), shaft.marker(0)});
          graph.add<PointOnLineJoint>("sliding bearing",
                                      {graph.ground().marker({kLength, 0, 0}, along), shaft.marker(kLength)});
        }) {
    // A whirl forwards, as the first mode.
    for (const auto& body : system.layout().bodies()) {
      if (!body.frame) continue;
      const double wave = M_PI * state.q[body.q] / kLength;
      const double w = kWide * std::sin(wave), slope = kWide * M_PI / kLength * std::cos(wave);
      state.q[body.q + 1] = w;
      state.q.segment<4>(body.q + 3) =
          quaternion_product(quaternion_of(rotation_about({0, 0, 1}, slope)), Vector4(state.q.segment<4>(body.q + 3)));
      state.v[body.v + 2] = kCritical * w;
      state.v[body.v + 4] = -kCritical * slope;
    }
    middle_ = 7 * (kElements / 2);
  }
  double width() const { return std::hypot(state.q[middle_ + 1], state.q[middle_ + 2]); }

 private:
  int middle_;
};

/// Of the width, between the first and the last fifth.
struct Growth {
  double early = 0, late = 0, time = 0;
  void add(double t, double width, double end) {
    if (t < 0.2 * end) early = std::max(early, width);
    if (t > 0.8 * end) late = std::max(late, width);
    time = 0.8 * end;
  }
  double rate() const { return std::log(late / early) / time; }
};

Finding judged_rate(double rate, std::vector<Figure> more = {}) {
  std::vector<Figure> figures{{"rate of growth at twice the critical speed, 1/s", rate},
                              {"closed form", expected_rate(2)}};
  figures.insert(figures.end(), more.begin(), more.end());
  return {judged(rate / expected_rate(2) - 1, 0.1), figures};
}

Finding whirl(Integrator& method) {
  Shaft shaft(2);
  Growth growth;
  const auto course = shaft.run(method, kEnd, [&] { growth.add(shaft.state.time, shaft.width(), kEnd); });
  if (!course.reached) return {Outcome::unstable, {{"stopped at, s", course.end}}, course.why};
  return judged_rate(growth.rate(), {{"steps", static_cast<double>(course.steps)}});
}

/// The first mode alone, in the plane of its section: z̈ = -ω² z - τ ω² ż, as if the damper did not turn.
Finding damper_at_rest() {
  Growth growth;
  VectorX y(4);
  y << kWide, 0, 0, kCritical * kWide;
  const double h = 0.02 / kCritical, squared = kCritical * kCritical;
  const Rates rates = [squared](double, const VectorX& x) {
    VectorX out(4);
    out << x[2], x[3], -squared * (x[0] + kViscous * x[2]), -squared * (x[1] + kViscous * x[3]);
    return out;
  };
  for (double t = 0; t < kEnd; t += h) {
    y = rk4_step(rates, t, y, h);
    growth.add(t, std::hypot(y[0], y[1]), kEnd);
  }
  Finding finding = judged_rate(growth.rate());
  finding.why = "Rayleigh damping of the modes in axes at rest knows no spin";
  return finding;
}

const Registered scene{with_candidates({"F09",
                                        "a shaft beyond its critical speed",
                                        {{"damping in axes at rest", damper_at_rest, Role::also},
                                         {"linearly implicit Euler, 20 steps a turn of the whirl",
                                          [] {
                                            LinearlyImplicit method({.step = 2 * M_PI / kCritical / 20});
                                            Finding finding = whirl(method);
                                            finding.why = "it damps more than the shaft feeds";
                                            return finding;
                                          },
                                          Role::also}}},
                                       {automatic(1e-7), radau(1e-7), alpha(2e-4, 0.9)}, {1e-7, 2e-4}, whirl)};

}  // namespace
}  // namespace lithe::lab
