// wind_turbine: three beams as blades, a beam as tower, a planetary gear, pitch control, a gust: the NREL 5 MW
// reference turbine (Jonkman et al., NREL/TP-500-38060, 2009; tables 3-1, 6-1, chapters 4 to 7) without tilt and cone;
// two stages, one polar, a fixed induction. From rest, motored up to speed. Checked: power of air and generator, foot's
// moment by thrust and weights.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {
constexpr double kGravity = 9.81, kHeight = 90, kTowerTop = 87.6, kHubX = -5, kNacelleX = 1.9;  // m/s², m
constexpr double kHubMass = 56780, kNacelleMass = 240000, kHubRadius = 1.5;                     // kg, m
constexpr double kRatio = 97, kRated = 12.1 * 2 * M_PI / 60, kPower = 5.2966e6;                 // rad/s, W
constexpr double kWind = 13, kInduction = 0.14, kPitch = 0.115;                                 // m/s, rad
constexpr double kUp = 20, kStart = 40, kEnd = kStart + 2 * M_PI / kRated;  // s: at speed; mean values over a turn

/// At the rotor, m/s: a gust of 1 m/s, less what the rotor takes out.
Vector3 wind(const Vector3&, double t) {
  const double gust = smooth_step_at(0, 1, 25, 28, t).value - smooth_step_at(0, 1, 29, 32, t).value;
  return {(1 - kInduction) * (kWind + gust), 0, 0};
}
AirfoilCoefficients polar(double attack) {  // of a thin airfoil with stall
  return {.lift = std::clamp(6.3 * (attack + 0.075), -1.0, 1.4), .drag = 0.01 + 1.3 * std::pow(std::sin(attack), 2)};
}
}  // namespace

int main() {
  // 1. Tower and nacelle.
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  const Vector3 yaw(0, 0, kTowerTop);
  const BeamAxis line = BeamAxis::straight({0, 0, 0}, yaw, {1, 0, 0});
  const Material steel{2.1e11, 0.3, 8500};
  auto& tower = graph.add<SlenderBody>(
      "tower", {.beam = {.axis = line,
                         .sections = {{0, BeamSection::tube(3 - 0.0351, 3, steel).damped(5e-3)},
                                      {kTowerTop, BeamSection::tube(1.935 - 0.0247, 1.935, steel).damped(5e-3)}},
                         .elements = 8}});
  auto& foundation =
      graph.add<FixedJoint>("foundation", {graph.ground().marker({}, line.pose(0).axes), tower.marker(0)});
  auto& nacelle = graph.add<RigidBody>(
      "nacelle", {.mass = kNacelleMass, .inertia = {8e5, 2.6e6, 2.6e6}, .position = {kNacelleX, 0, kHeight}});
  graph.add<FixedJoint>("yaw bearing", {tower.marker_at_world(yaw), nacelle.marker_at_world(yaw)});

  // 2. Drive train: hub, shaft, planetary stage, generator.
  const Matrix3 shaft = rotation_about({0, 1, 0}, M_PI / 2);  // z along world x
  const auto turning = [&](const std::string& name, double mass, const Vector3& inertia, double x) {
    auto& body = graph.add<RigidBody>(name, {.mass = mass, .inertia = inertia, .position = {x, 0, kHeight}});
    auto& bearing = graph.add<RevoluteJoint>(name + " bearing",
                                             {nacelle.marker_at_world({x, 0, kHeight}, shaft), body.marker({}, shaft)});
    return std::pair<RigidBody&, RevoluteJoint&>(body, bearing);
  };
  const double sun_radius = 0.19, ring_radius = 0.9, planet_radius = (ring_radius - sun_radius) / 2,
               arm = sun_radius + planet_radius, stage = 1 + ring_radius / sun_radius;
  const auto [hub, rotor] = turning("hub", kHubMass, {115926, 80000, 80000}, kHubX);
  const auto [carrier, low] = turning("carrier", 4000, {1500, 1000, 1000}, 0);
  const auto [sun, middle] = turning("sun", 310, {5.6, 6, 6}, 0);
  const auto [generator, fast] = turning("generator", 2000, {534.116, 300, 300}, 3);
  const JointCoordinate twist = angle_between(hub.marker({}, shaft), carrier.marker({}, shaft));
  graph.add<CoordinateSpring>("shaft", {twist}, {.stiffness = 8.67637e8, .damping = 6.215e6});
  graph.add<CoordinateCoupling>("parallel stage", {middle.angle(), fast.angle()}, {.factors = {kRatio / stage, -1}});
  for (int k = 0; k < 3; ++k) {
    const std::string number = std::to_string(k + 1);
    const Vector3 centre = rotation_about({1, 0, 0}, 2 * M_PI * k / 3) * Vector3(0, 0, arm), top(0, 0, kHeight);
    auto& planet =
        graph.add<RigidBody>("planet " + number, {.mass = 1080, .inertia = {68, 45, 45}, .position = centre + top});
    graph.add<RevoluteJoint>("pin " + number, {carrier.marker(centre, shaft), planet.marker({}, shaft)});
    graph.add<GearPair>("sun mesh " + number, {sun.marker({}, shaft), planet.marker({}, shaft)},
                        {.radius_A = sun_radius, .radius_B = planet_radius});
    graph.add<GearPair>("ring mesh " + number, {nacelle.marker_at_world(top, shaft), planet.marker({}, shaft)},
                        {.radius_A = ring_radius, .radius_B = -planet_radius});
  }
  const MotionLaw reference = smooth_step(0, kRated, 0, kUp);
  const auto torque = [&](double t, double, double speed) {  // regions 2, 2 1/2 and 3, after the start by the grid
    const double starts = 1 - smooth_step_at(0, 1, kUp, kUp + 2, t).value;
    return starts * 1e5 * (kRatio * reference(t).value - speed) -
           std::min(kPower / std::max(speed, 100.0), std::max(2.332 * speed * speed, 33.02e3 + 3950 * (speed - 119)));
  };
  auto& load = graph.add<CoordinateMotor>("load", {fast.angle()}, {.effort = torque});

  // 3. Blades on pitch bearings, drawn at their pitch, and the air on them. A section's axis 2 is its upper side.
  const Table table = read_csv(LITHE_EXAMPLE_DATA "/nrel5mw_strips.csv");
  const double gain = kRatio / (1 + kPitch / 0.11);  // table 7-2, at this pitch; the report controls the generator
  AirfoilLoad load_of_air{.from = table.at(0, 0) - kHubRadius - 2.05, .wind = wind};
  for (int i : {0, 4, 8, 11, 13})
    load_of_air.stations.push_back({table.at(i, 0) - kHubRadius, table.at(i, 1), -M_PI / 2, 0, polar});
  std::vector<AirfoilStrip*> air;
  std::vector<Sensor> sensors{coordinate_rate(rotor.angle(), "rotor"), power(load, "generator"),
                              position(nacelle.marker(), "nacelle"), reaction(foundation, 1, kWorldAxes, "foot")};
  // Weights about the foot: kg m as drawn; kg that move with the nacelle (of a tower bent at its top 3/8).
  double head = kHubMass * kHubX + kNacelleMass * kNacelleX,
         mass = kHubMass + kNacelleMass + 0.375 * tower.beam()->mass();
  for (int k = 0; k < 3; ++k) {
    const std::string name = "blade " + std::to_string(k + 1);
    const Matrix3 flip = Vector3(1, -1, -1).asDiagonal(), straight = rotation_about({1, 0, 0}, 2 * M_PI * k / 3) * flip,
                  pitched = straight * rotation_about({0, 0, 1}, kPitch);  // z towards the hub: its turn feathers
    const Vector3 root = straight * Vector3(0, 0, -kHubRadius), at = root + Vector3(kHubX, 0, kHeight);
    Beam::Parameters drawn = beam_table(LITHE_EXAMPLE_DATA "/blade/nrel5mw.inp", {.root = {at, pitched * flip}});
    drawn.elements = 8;
    auto& blade = graph.add<Beam>(name, drawn);
    auto& bearing =
        graph.add<RevoluteJoint>(name + " pitch", {hub.marker(root, straight), blade.marker_at_world(at, pitched)});
    ControlDiagram servo;  // PI control of the rotor's speed; a stiff actuator
    const ControlSignal too_fast = servo.rate(rotor.angle()) - servo.law(reference), ahead = servo.integral(too_fast),
                        off = gain * (0.01882681 * too_fast + 0.008068634 * ahead) + kPitch -
                              servo.value(bearing.angle());
    servo.push(bearing.angle(), 2.57e7 * off - 1.4e6 * servo.rate(bearing.angle()));
    const auto& states = graph.add<FirstOrderStates>(name + " states", {.start = servo.start()});
    graph.add<ControlForce>(name + " servo", servo.markers(states), {servo});
    for (AirfoilStrip* strip : add_airfoil_load(graph, name + " air", blade, load_of_air)) air.push_back(strip);
    head += blade.mass() * kHubX, mass += blade.mass();
    if (k == 0) sensors.push_back(coordinate(bearing.angle(), "pitch"));
  }
  const auto sum = [&](Snapshot& now, std::span<double> out) {
    out[0] = out[1] = 0;
    for (const AirfoilStrip* a : air) out[0] += applied_force(*a, 0).value(now, 0), out[1] += power(*a).value(now);
  };
  sensors.push_back({"air", {"thrust", "air_power"}, sum, {"N", "W"}});

  // 4. A gust, and the mean values of a turn behind it.
  const auto draw = [&](Run& page) { page.draw(nacelle, visual::box({12, 3.5, 3.5})); };
  const machine::Outcome out = machine::run(graph, {.name = "wind_turbine",
                                                    .title = "NREL 5 MW wind turbine starts and meets a gust",
                                                    .duration = kEnd,
                                                    .interval = 0.2,
                                                    .tolerance = {1e-4, 1e-5},
                                                    .sensors = sensors,
                                                    .compared = 32,
                                                    .draw = draw,
                                                    .wants = {want(sensors[2], percent(5))},
                                                    .solve_duration = 2});
  const auto mean = [&](const char* column) {
    const std::vector<double> t = out.table.column("t"), x = out.table.column(column);
    const auto first = std::lower_bound(t.begin(), t.end(), kStart) - t.begin();
    return std::accumulate(x.begin() + first, x.end(), 0.0) / static_cast<double>(x.end() - x.begin() - first);
  };
  const double bent = mean("nacelle_x") - kNacelleX, thrust = mean("thrust"), moment = -mean("foot_moment_y"),
               expected = thrust * kHeight + kGravity * (head + mass * bent);
  std::printf("air %.4f MW, generator %.4f MW at %.4f rad/s, pitch %.4f rad\n", 1e-6 * mean("air_power"),
              -1e-6 * mean("generator"), mean("rotor"), mean("pitch"));
  std::printf("thrust %.1f kN; moment at the foot %.3f MN m (thrust and weights: %.3f MN m); nacelle %.3f m off\n",
              1e-3 * thrust, 1e-6 * moment, 1e-6 * expected, bent);
  const double power_off = mean("air_power") / mean("generator") + 1, moment_off = moment / expected - 1;
  return out.good && std::abs(power_off) < 0.01 && std::abs(moment_off) < 0.02 ? 0 : 1;
}
