// 25_rotor: the rotor of a wind turbine starts turning; its blades as exact beams, as modes with stiffening, and rigid.
//
// Shows: blades from a BeamDyn file; a beam's modes from the same drawing; a shaft on a drive; frequencies at rest and
//        at speed; forces of the sections for ParaView; one page of all three rotors.
// Expect: each blade weighs 16.8 t and first swings with 0.69 Hz, out of the plane, turning with 0.74 Hz; its weight
//         bends it by ±0.45 m in the plane, once a turn, and modes with stiffening follow to 1 %; results/rotor/rotor.html.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

enum class Blades { exact, modal, rigid };
constexpr int kElements = 24;
constexpr double kHubRadius = 1.5, kSpeed = 12.1 * 2 * M_PI / 60;  // m, rad/s
constexpr double kStart = 20, kEnd = 30;                           // s: at speed; the end

Beam::Parameters blade_at(const FramePose& root) {
  // 1. The blade of the NREL 5 MW reference turbine, drawn where the root has its place and axes.
  Beam::Parameters blade = beam_table(LITHE_EXAMPLE_DATA "/blade/nrel5mw.inp", {.root = root});
  blade.elements = kElements;
  return blade;
}

/// Smooth to full speed, then steady.
Motion turning(double t) {
  if (t >= kStart) return {kSpeed * (t - kStart / 2), kSpeed, 0};
  const double s = t / kStart;
  return {kSpeed * kStart * (s * s * s - s * s * s * s / 2), kSpeed * (3 - 2 * s) * s * s,
          kSpeed / kStart * 6 * (s - s * s)};
}

struct Rotor {
  SystemGraph graph;
  const Beam* first = nullptr;  // of exact blades
  std::vector<Sensor> sensors;

  explicit Rotor(Blades kind) {
    // 2. Three blades on a hub that a drive turns about world x. Flap and edge: the way of the first tip along and
    //    across the shaft, in the axes of its blade.
    const Matrix3 shaft = rotation_about({0, 1, 0}, M_PI / 2);  // its z along x
    auto& hub = graph.add<RigidBody>("hub", {.mass = 56780, .inertia = {115926, 80000, 80000}});
    auto& bearing = graph.add<RevoluteJoint>("bearing", {graph.ground().marker({}, shaft), hub.marker({}, shaft)});
    graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = turning});
    for (int k = 0; k < 3; ++k) {
      const Matrix3 axes = rotation_about({1, 0, 0}, 2 * M_PI * k / 3);
      const Beam::Parameters drawn = blade_at({axes * Vector3(0, 0, kHubRadius), axes});
      const FramePose root = drawn.axis.pose(0), end = drawn.axis.pose(drawn.axis.length);
      const std::string name = "blade " + std::to_string(k + 1);
      Marker start, tip;
      if (kind == Blades::exact) {
        auto& blade = graph.add<Beam>(name, drawn);
        start = blade.marker(0), tip = blade.marker(blade.length());
        if (k == 0) first = &blade;
      } else {
        const Beam beam(drawn);
        auto& blade = graph.add<FlexibleBody>(
            name, {.basis = make_basis(beam, TangentFrame{{1}}, 8, {.deflection = Deflection::stiffened}),
                   .mode_count = kind == Blades::modal ? FlexibleBody::kAll : 0});
        start = blade.node(1, root.axes), tip = blade.node(beam.node_count(), end.axes);
      }
      auto& bolts = graph.add<FixedJoint>(name + " root", {hub.marker(root.position, root.axes), start});
      if (k > 0) continue;
      const Marker drawn_tip = hub.marker(end.position, axes);
      sensors = {coordinate(displacement_between(drawn_tip, tip, 0), "flap"),
                 coordinate(displacement_between(drawn_tip, tip, 1), "edge"),
                 reaction(bolts, 1, hub.marker(root.position, axes), "root")};
    }
  }
};

Run turn(Blades kind, const std::string& name) {
  Rotor rotor(kind);
  const System system = assemble(rotor.graph);
  State state = system.initial_state();
  if (kind != Blades::rigid) state = find_equilibrium(system, state).state;
  GeneralizedAlpha integrator({.step = 0.02});
  Simulation simulation(system, integrator);
  Run run(system, rotor.sensors, {.name = name});
  simulation.observe(run, every(0.1));
  std::optional<SurfaceWriter> surface;
  if (rotor.first) {
    surface.emplace(*rotor.first, "results/rotor/blade", section_fields(*rotor.first));
    simulation.observe(*surface, every(1));
  }
  simulation.run(state, kEnd);
  return run;
}

/// Of a clamped blade that turns about world x, Hz.
double first_frequency(double speed) {
  // 3. Linearized about its steady motion.
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  Beam::Parameters drawn = blade_at({{0, 0, kHubRadius}, Matrix3::Identity()});
  drawn.velocity = Vector3(speed, 0, 0).cross(Vector3(0, 0, kHubRadius));
  drawn.angular_velocity = {speed, 0, 0};
  const Matrix3 shaft = rotation_about({0, 1, 0}, M_PI / 2);
  auto& blade = graph.add<Beam>("blade", drawn);
  auto& hub = graph.add<RigidBody>("hub", {.angular_velocity = {speed, 0, 0}});
  auto& bearing = graph.add<RevoluteJoint>("bearing", {graph.ground().marker({}, shaft), hub.marker({}, shaft)});
  graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = ramp(0, speed)});
  const FramePose root = drawn.axis.pose(0);
  graph.add<FixedJoint>("root", {hub.marker(root.position, root.axes), blade.marker(0)});
  const System system = assemble(graph);
  // Pulled straight by its own mass: a short run lets it find its length.
  State state = system.initial_state();
  Radau damped({.tolerance = {1e-6, 1e-6}});
  Simulation(system, damped).run(state, 2);
  for (const Mode& mode : linearize(system, state, {.mode_count = 6}).modes)
    if (mode.frequency() > 0.1) return mode.frequency();
  return 0;
}

/// Half the way between largest and smallest at full speed.
double swing(const Run& run, const std::string& channel) {
  const std::vector<double> t = run.channel("t"), y = run.channel(channel);
  double low = 1e300, high = -1e300;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (t[i] >= kStart) low = std::min(low, y[i]), high = std::max(high, y[i]);
  return (high - low) / 2;
}

}  // namespace

int main() {
  const Beam blade(blade_at({}));
  const double still = first_frequency(0), at_speed = first_frequency(kSpeed);
  const auto basis = make_basis(blade, TangentFrame{{1}}, 3);
  std::printf("blade: %.0f kg, %.1f m; first frequency %.3f Hz, turning %.3f Hz; of its modes %.3f, %.3f, %.3f Hz\n",
              blade.mass(), blade.length(), still, at_speed, basis->frequencies[0], basis->frequencies[1],
              basis->frequencies[2]);

  // 4. All three, on one page.
  const Run exact = turn(Blades::exact, "exact"), modal = turn(Blades::modal, "modal"),
            rigid = turn(Blades::rigid, "rigid");
  write_page({exact, modal, rigid}, "results/rotor/rotor.html", {.title = "A rotor: exact, modal and rigid blades"});
  const double edge = swing(exact, "edge"), edge_modal = swing(modal, "edge");
  const double moment = swing(exact, "root_moment_x"), moment_rigid = swing(rigid, "root_moment_x");
  std::printf("tip in the plane: ±%.3f m (modes ±%.3f m); moment at the root: ±%.2f MN m (rigid ±%.2f MN m)\n", edge,
              edge_modal, 1e-6 * moment, 1e-6 * moment_rigid);

  // 5. Check the answer.
  const bool stiffens = at_speed > 1.02 * still && at_speed < 1.10 * still;
  const bool modes_follow =
      std::abs(edge_modal / edge - 1) < 0.01 && std::abs(basis->frequencies[0] / still - 1) < 1e-3;
  return stiffens && modes_follow && std::abs(moment / moment_rigid - 1) < 0.2 ? 0 : 1;
}
