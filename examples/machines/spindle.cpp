// spindle: a milling spindle on four angular-contact ball bearings runs up to 12,000 rpm; a cutter starts to push at
// its nose.
//
// Dimensions are typical of a motor spindle with bearings 7014 C (bore 70 mm, 15 degrees, two in front, two behind,
// back to back). The shaft is a beam; each ball is loaded by itself, so the nose also shakes at the ball-pass
// frequency. Shows: the Campbell diagram, results/machines/spindle_campbell.svg: linearized where the preload holds the
// shaft. Checked: the nose rings forward and backward with the frequencies of the diagram's first pair of bending
// modes, and the force
//          that the bearings carry is that of the cutter.
#include <cmath>
#include <complex>
#include <cstdio>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {

constexpr double kSpeed = 12000 * 2 * M_PI / 60, kRunUp = 0.05;  // rad/s, s
constexpr double kCut = 400, kFirst = kRunUp + 0.004;            // N, s: the cutter's push

struct Spindle {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  Marker nose;
  std::vector<const BallBearing*> bearings;

  /// At `speed` without a cut; or from rest, run up to it, with a cut.
  Spindle(double speed, bool from_rest) {
    // 1. A hollow shaft along z with the motor's rotor in its middle and a cutter of 100 mm at its nose.
    const Vector3 spin(0, 0, from_rest ? 0 : speed);
    const BeamAxis axis = BeamAxis::straight({0, 0, 0}, {0, 0, 0.56}, {1, 0, 0});
    const Matrix3 upright = axis.pose(0).axes.transpose();  // markers like the world
    auto& shaft =
        graph.add<Beam>("shaft", {.axis = axis,
                                  .sections = {{0, BeamSection::tube(0.014, 0.035, {2.1e11, 0.3, 7850}).damped(2e-6)}},
                                  .elements = 14,
                                  .stations = {0.06, 0.1, 0.28, 0.46, 0.5},
                                  .angular_velocity = spin});
    const auto mount = [&](const char* name, const MassProperties& m, double at) -> RigidBody& {
      auto& body = graph.add<RigidBody>(
          name, {.mass = m.mass, .inertia = m.inertia, .position = {0, 0, at}, .angular_velocity = spin});
      graph.add<FixedJoint>(std::string(name) + " fit", {shaft.marker(at, {}, upright), body.marker()});
      return body;
    };
    auto& cutter = mount("cutter", cylinder(0.05, 0.04, 7850), 0);
    mount("rotor", cylinder(0.055, 0.12, 5000), 0.28);
    nose = cutter.marker();

    // 2. The bearings, preloaded against each other, in a rigid housing.
    for (double at : {0.06, 0.1, 0.46, 0.5}) {
      const double sense = at < 0.3 ? -1 : 1;
      bearings.push_back(
          &graph.add<BallBearing>("bearing at " + std::to_string(static_cast<int>(1000 * at)) + " mm",
                                  {shaft.marker(at, {}, upright), graph.ground().marker({0, 0, at})},
                                  {.balls = 19,
                                   .ball_diameter = 12.7e-3,
                                   .pitch_diameter = 90e-3,
                                   .inner_groove_radius = 0.525 * 12.7e-3,
                                   .outer_groove_radius = 0.525 * 12.7e-3,
                                   .contact_angle = sense * 15 * M_PI / 180,
                                   .preload = 500,
                                   .losses = {.damping_time = 1e-5, .load_factor = 3e-4, .speed_factor = 1}}));
    }

    // 3. The motor; the cutter pushes from `kFirst` on.
    graph.add<CoordinateDrive>("motor", {angle_between(graph.ground().marker(), nose)},
                               {.motion = from_rest ? run_up(speed, 0, kRunUp) : ramp(0, speed)});
    graph.add<UserForce>("cut", {nose}, {.law = [push = from_rest ? kCut : 0](double t, const MarkerView&) {
                           const double s = std::clamp((t - kFirst) / 2e-4, 0.0, 1.0);
                           return force({push * s * s * (3 - 2 * s), 0, 0});
                         }});
  }
};

/// Hz near `about` at which x + i y of the table, after the push, has most of its motion. Hann's window: other modes
/// hardly move its peak.
double ringing(const Table& table, double about) {
  const auto t = table.column("t"), x = table.column("nose_x"), y = table.column("nose_y");
  std::complex<double> mean = 0;
  std::size_t first = 0;
  while (t[first] < kFirst + 1e-3) ++first;
  for (std::size_t i = first; i < t.size(); ++i) mean += std::complex(x[i], y[i]) / double(t.size() - first);
  double best = 0, largest = -1;
  for (double f = 0.85 * about; std::abs(f) < 1.15 * std::abs(about); f += 5e-4 * about) {
    std::complex<double> sum = 0;
    for (std::size_t i = first; i < t.size(); ++i) {
      const double window = std::pow(std::sin(M_PI * double(i - first) / double(t.size() - first)), 2);
      sum += window * (std::complex(x[i], y[i]) - mean) * std::polar(1.0, -2 * M_PI * f * t[i]);
    }
    if (std::abs(sum) > largest) largest = std::abs(sum), best = f;
  }
  return best;
}

}  // namespace

int main() {
  // 4. The diagram: world axes, for bodies of revolution that spin.
  std::vector<double> speeds;
  for (double speed = 10; speed < kSpeed; speed += kSpeed / 12) speeds.push_back(speed);
  speeds.push_back(kSpeed);
  const Campbell diagram =
      campbell(speeds,
               [](double speed) {
                 Spindle spindle(speed, false);
                 const System system = assemble(spindle.graph);
                 return linearize(system, system.initial_state(), {.axes = PerturbationAxes::world, .step = 1e-6});
               },
               {.mode_count = 6,
                .lowest_frequency = 10,
                .orders = {1, 2, 19 * 0.5 * (1 - 12.7 / 90 * std::cos(15 * M_PI / 180))}});
  diagram.write_chart("results/machines/spindle_campbell", "Spindle on angular-contact bearings");
  for (const auto& branch : diagram.branches)
    std::printf("%7.1f Hz at rest, %7.1f Hz at 12,000 rpm, damped by %.1f %%\n", branch.frequency.front(),
                branch.frequency.back(), 100 * branch.damping_ratio.back());

  // 5. The run, from rest.
  Spindle spindle(kSpeed, true);
  const machine::Outcome out =
      machine::run(spindle.graph,
                   {.name = "spindle",
                    .title = "A milling spindle on ball bearings",
                    .duration = kRunUp + 0.03,
                    .interval = 1e-4,
                    .tolerance = {1e-6, 1e-9},
                    .sensors = {position(spindle.nose, "nose"), rolling_element_loads(*spindle.bearings[0], "ball")}});

  // 6. Check. A pair of bending modes is split by the speed: one whirls backward and falls, the other forward and
  // rises.
  double off = 0;
  for (const double sense : {-1, 1}) {
    const auto branch = std::find_if(diagram.branches.begin(), diagram.branches.end(), [&](const auto& b) {
      return sense * (b.frequency.back() / b.frequency.front() - 1) > 1e-3;
    });
    const double expected = sense * branch->frequency.back(), found = ringing(out.table, expected);
    std::printf("nose rings %s with %.1f Hz (diagram: %.1f Hz)\n", sense < 0 ? "backward" : "forward", std::abs(found),
                std::abs(expected));
    off = std::max(off, std::abs(found / expected - 1));
  }
  return out.good && off < 0.003 ? 0 : 1;
}
