// tower_crane: a flat-top tower crane slews by 45 degrees while its reeved rope hoists a load, which then swings.
//
// Dimensions are typical of a crane with a jib of 50 m (2.3 t at its tip, 10 t at most). Tower and jib are lattices,
// drawn as beams of equal stiffness; the rope runs from the drum over the trolley, under the hook's block, over the
// trolley again and to the jib's tip.
// Checked: the period of the swing against a double pendulum (falls, load below the hook) whose support gives way as
//          mast does; the hook's rise against half of what the drum winds up.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {

constexpr double kGravity = 9.81;

/// A square or triangular lattice as a beam: chords of steel far from the axis carry bending, diagonals shear and
/// torsion. EA, GA, GJ, EI about axes 2 and 3 (N, N m²), kg/m with the bracing.
BeamSection lattice(double EA, double GA, double GJ, double EI_2, double EI_3, double mass, double radius) {
  const double inertia = mass * radius * radius;  // of a section about axes 2 and 3
  return BeamSection::diagonal((Vector6() << EA, GA, GA, GJ, EI_2, EI_3).finished(), mass,
                               {2 * inertia, inertia, inertia})
      .damped(3e-3);
}

}  // namespace

int main() {
  // 1. Mast: 2 m square, chords of 4.9e-3 m² each (L 160x16), diagonals of 3e-3 m². Jib: a triangle 1.5 m high, chords
  //    of 16e-3 m² in all.
  const double mast_height = 40, reach = 50, at_trolley = 30, jib_height = mast_height + 1;  // m
  const double mast_EI = 4.1e9;                                                              // N m²
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  auto& ground = graph.ground();
  const BeamAxis mast_axis = BeamAxis::straight({0, 0, 0}, {0, 0, mast_height}, {1, 0, 0}),
                 jib_axis = BeamAxis::straight({0, 0, jib_height}, {reach, 0, jib_height}, {0, 1, 0});
  auto& mast = graph.add<SlenderBody>(
      "mast", {.beam = {.axis = mast_axis,
                        .sections = {{0, lattice(4.1e9, 4.4e8, 8.8e8, mast_EI, mast_EI, 250, 1)}},
                        .elements = 8}});
  auto& jib =
      graph.add<SlenderBody>("jib", {.beam = {.axis = jib_axis,
                                              .sections = {{0, lattice(3.4e9, 1.5e8, 6e7, 1.9e9, 6e8, 150, 0.5)}},
                                              .elements = 10,
                                              .stations = {at_trolley}}});
  graph.add<FixedJoint>("foundation", {ground.marker({}, mast_axis.pose(0).axes), mast.marker(0)});

  // 2. The slewing platform on the mast carries the jib, the counterweight on its arm, and the drum.
  const MassProperties platform_mass = box({16, 2, 1.5}, 60), weight = box({2, 3, 2}, 1400);
  auto& platform = graph.add<RigidBody>(
      "platform", {.mass = platform_mass.mass, .inertia = platform_mass.inertia, .position = {-6, 0, jib_height}});
  auto& counterweight = graph.add<RigidBody>(
      "counterweight", {.mass = weight.mass, .inertia = weight.inertia, .position = {-12.5, 0, jib_height - 1}});
  auto& slewing =
      graph.add<RevoluteJoint>("slewing", {mast.marker(mast_height, mast_axis.pose(mast_height).axes.transpose()),
                                           platform.marker_at_world({0, 0, mast_height})});
  graph.add<FixedJoint>("root", {platform.marker_at_world({0, 0, jib_height}, jib_axis.pose(0).axes), jib.marker(0)});
  graph.add<FixedJoint>("arm", {platform.marker_at_world({-12.5, 0, jib_height - 1}), counterweight.marker()});
  const Vector3 at_drum(-4, 0, jib_height);
  const double radius = 0.3;
  auto& drum = graph.add<RigidBody>("drum", {.mass = 600, .inertia = {60, 60, 30}, .position = at_drum});
  const Matrix3 axle = rotation_about({1, 0, 0}, M_PI / 2);  // along -y
  auto& drum_pin =
      graph.add<RevoluteJoint>("drum pin", {platform.marker_at_world(at_drum, axle), drum.marker({}, axle)});

  // 3. Trolley, hook with its load, and the rope: 20 mm, EA = 2e7 N, 1.6 kg/m.
  const double load = 4000, trolley_mass = 400, fall = 20, hung = 1.5, load_inertia = 700;
  const Vector3 at(at_trolley, 0, jib_height - 0.2);
  auto& trolley = graph.add<RigidBody>("trolley", {.mass = trolley_mass, .inertia = {80, 80, 80}, .position = at});
  graph.add<FixedJoint>(
      "brake", {jib.marker(at_trolley, jib_axis.pose(at_trolley).axes.transpose()), trolley.marker({0, 0, 0.2})});
  auto& hook = graph.add<RigidBody>(
      "load",
      {.mass = load, .inertia = Vector3(Vector3::Constant(load_inertia)), .position = at - Vector3(0, 0, fall + hung)});
  const Rope rope = reeve(
      graph, "rope", {{drum_pin.markers()[1], radius, -1}, {jib.marker(reach, jib_axis.pose(reach).axes.transpose())}},
      {.pulleys = {{trolley.marker({-0.7, 0, 0}, axle), 0.2, -1},
                   {hook.marker({0, 0, hung}, axle), 0.5, 1},
                   {trolley.marker({0.7, 0, 0}, axle), 0.2, -1}},
       .axial_stiffness = 2e7,
       .axial_damping = 4e5,
       .mass_per_length = 1.6,
       .pretension = 0.5 * load * kGravity});

  // 4. Slew by 45 degrees in 20 s, hoist 6 m meanwhile, then swing.
  const double stop = 21, end = 45, wound = 12;
  graph.add<CoordinateDrive>("slewing gear", {slewing.angle()}, {.motion = smooth_step(0, M_PI / 4, 1, stop)});
  graph.add<CoordinateDrive>("hoist", {drum_pin.angle()}, {.motion = smooth_step(0, wound / radius, 1, stop)});
  const Marker tip = jib.marker(reach);
  const machine::Outcome out = machine::run(
      graph,
      {.name = "tower_crane",
       .title = "A tower crane slews and hoists",
       .duration = end,
       .interval = 0.1,
       .tolerance = {1e-5, 1e-6},
       .sensors = {position(hook.marker(), "load"),
                   coordinate(displacement_between(trolley.marker(), hook.marker(), 0), "swing"),
                   coordinate({JointCoordinate::Kind::distance, trolley.marker(), hook.marker({0, 0, hung})}, "fall"),
                   height(tip, "tip"), tension(rope, 1, "rope")},
       .start = [](const System& system) { return find_equilibrium(system, system.initial_state()).state; },
       .draw =
           [&](Run& page) {
             page.draw(platform, visual::box({16, 1.6, 0.6}));
             page.draw(counterweight, visual::box({2, 3, 2}));
             page.draw(drum, visual::cylinder(radius, 1.5).at({}, axle));
             page.draw(trolley, visual::box({1.6, 1.2, 0.3}));
             page.draw(hook, visual::box({1.2, 1.2, 1.2}).at({0, 0, -0.9}));
           },
       .wants = {want(height(tip, "tip"), percent(5))},
       .solve_duration = 4});

  // 5. Check. The falls stay parallel and swing with the hook below them: a double pendulum. Under its pull the mast's
  //    top moves aside by h³/3EI, which lengthens the swing.
  const std::vector<double> t = out.table.column("t"), swing = out.table.column("swing");
  const std::size_t first = static_cast<std::size_t>(stop / (end / static_cast<double>(t.size() - 1))) + 1;
  const auto [low, high] = std::minmax_element(swing.begin() + static_cast<long>(first), swing.end());
  const double middle = 0.5 * (*low + *high);
  std::vector<double> crossings;
  for (std::size_t i = first; i < t.size(); ++i)
    if ((swing[i - 1] - middle) * (swing[i] - middle) < 0)
      crossings.push_back(t[i - 1] + (t[i] - t[i - 1]) * (swing[i - 1] - middle) / (swing[i - 1] - swing[i]));
  const double period = 2 * (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  const double length = machine::at(out.table, "fall", end), rise = machine::at(out.table, "fall", 0) - length;
  // 1/ω² of K⁻¹M, K = m g diag(l, d), M = m [l², l d; l d, d² + J/m]: half of its trace and its determinant.
  const double half = 0.5 * (length + hung + load_inertia / (load * hung)) / kGravity,
               product = load_inertia * length / (load * hung) / (kGravity * kGravity),
               squared = half + std::sqrt(half * half - product);
  const double pendulum = 2 * M_PI * std::sqrt(squared + load * std::pow(jib_height, 3) / (3 * mast_EI));
  std::printf(
      "swing every %.3f s (double pendulum on the mast: %.3f s); hook rises by %.3f m (half the rope: %.3f m)\n",
      period, pendulum, rise, wound / 2);
  return out.good && std::abs(period / pendulum - 1) < 0.01 && std::abs(rise - wound / 2) < 0.02 ? 0 : 1;
}
