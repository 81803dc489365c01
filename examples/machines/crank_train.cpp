// crank_train: one cylinder of a typical engine for cars runs up to 6,000 rpm under the gas of a four-stroke cycle;
// crankshaft (a gmsh mesh with fillets of 4 mm) and rod (bricks) bend, a drive at the flywheel holds the speed.
// Checked: piston and bearing forces against the rigid slider-crank; the most damage is in a fillet of the pin.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {
constexpr double kCrank = 0.043, kRod = 0.143, kBore = 0.086, kPiston = 0.45, kGravity = 9.81;  // m, kg
constexpr double kSpeed = 6000 * 2 * M_PI / 60, kRunUp = 0.04, kCycle = 0.02, kSample = 2.5e-4,
                 kEnd = kRunUp + 2 * kCycle;  // rad/s, s

Motion turning(double t) {  // smooth to full speed, full turns from then on
  if (t >= kRunUp) return {kSpeed * (t - kRunUp / 2), kSpeed, 0};
  const double s = t / kRunUp;
  return {kSpeed * kRunUp * (s * s * s - s * s * s * s / 2), kSpeed * (3 - 2 * s) * s * s,
          kSpeed / kRunUp * 6 * (s - s * s)};
}

/// N on the piston towards the crank, by the crank's angle from rest, a turn before it fires.
double gas(double angle) {
  static const CubicSpline pressure(
      {0, 8, 15, 25, 40, 60, 90, 120, 150, 180, 240, 360, 480, 540, 600, 640, 670, 690, 705, 720},
      {48, 67, 75, 63, 36, 18, 8.5, 5, 3, 1.8, 1.1, 1.05, 0.9, 0.95, 1.6, 3.3, 8, 17, 30, 48},
      "pressure");  // degrees, bar
  const double degrees = std::fmod(angle * 180 / M_PI + 360, 720);
  return (pressure(degrees).value - 1) * 1e5 * M_PI / 4 * kBore * kBore;
}

/// Acceleration of the rigid piston at constant speed, m/s².
double piston_acceleration(double angle) {
  const double s = kCrank * std::sin(angle), c = kCrank * std::cos(angle), w = std::sqrt(kRod * kRod - s * s);
  return kSpeed * kSpeed * (-c - (c * c - s * s) / w - s * s * c * c / (w * w * w));
}
}  // namespace

int main() {
  // 1. Crankshaft: axis along z, pin at x = 43 mm; pulley, bearing shell and flywheel hold its stiff sets.
  SystemGraph graph{{.gravity = {-kGravity, 0, 0}}};
  const FlexibleBodyFile file = read_flexible_body(LITHE_EXAMPLE_DATA "/crankshaft/crankshaft.msh",
                                                   {.materials = {{"crankshaft", {2.1e11, 0.3, 7850}}}});
  const FiniteElementModel& mesh = *file.model;
  const std::vector<int>&front = mesh.node_set("front"), &pin = mesh.node_set("pin"), &rear = mesh.node_set("rear");
  auto& crank = graph.add<FlexibleBody>(
      "crankshaft",
      {.basis = make_basis(mesh, MeanAxisFrame{}, 1,
                           {.rigid = {front, pin, rear}, .interface_modes = InterfaceModes::craig_bampton}),
       .damping = {.modal_ratios = {0.02}}});
  const auto hold = [&](const std::string& name, const std::vector<int>& nodes, const Vector3& at, double mass,
                        double inertia) {
    Vector3 middle = Vector3::Zero();
    for (int id : nodes) middle += mesh.nodes.col(mesh.node_index(id)) / static_cast<double>(nodes.size());
    auto& body =
        graph.add<RigidBody>(name, {.mass = mass, .inertia = {0.6 * inertia, 0.6 * inertia, inertia}, .position = at});
    graph.add<FixedJoint>(name + " fit", {crank.rigid(nodes), body.marker_at_world(middle)});
    return &body;
  };
  auto& pulley = *hold("pulley", front, {0, 0, -0.045}, 1.5, 3.675e-3);
  auto& shell = *hold("bearing shell", pin, {kCrank, 0, 0}, 0.05, 1.56e-5);
  auto& flywheel = *hold("flywheel", rear, {0, 0, 0.045}, 8, 0.0784);
  auto& front_bearing =
      graph.add<RevoluteJoint>("front bearing", {graph.ground().marker({0, 0, -0.045}), pulley.marker()});
  const Marker rear_axis = graph.ground().marker({0, 0, 0.045});
  auto& rear_bearing = graph.add<PointOnLineJoint>("rear bearing", {rear_axis, flywheel.marker()});
  graph.add<CoordinateDrive>("drive", {angle_between(rear_axis, flywheel.marker())}, {.motion = turning});

  // 2. Rod and piston; the gas.
  const FiniteElementModel shank = brick_mesh({.size = {kRod, 0.028, 0.016},
                                               .divisions = {12, 2, 2},
                                               .type = "C3D8I",
                                               .material = {2.1e11, 0.3, 7850},
                                               .name = "rod"});
  const std::vector<int>&big = shank.node_set("x_min"), &small = shank.node_set("x_max");
  auto& rod = graph.add<FlexibleBody>(
      "rod", {.basis = make_basis(shank, MeanAxisFrame{}, 2,
                                  {.rigid = {big, small}, .interface_modes = InterfaceModes::craig_bampton}),
              .damping = {.modal_ratios = {0.02}},
              .position = {kCrank, -0.014, -0.008}});
  const Vector3 top(kCrank + kRod, 0, 0);
  auto& piston = graph.add<RigidBody>("piston", {.mass = kPiston, .inertia = {4e-4, 4e-4, 4e-4}, .position = top});
  const Matrix3 bore = rotation_about({0, 1, 0}, M_PI / 2);
  graph.add<RevoluteJoint>("big end", {shell.marker(), rod.rigid(big)});
  auto& small_end = graph.add<PointOnLineJoint>("small end", {rod.rigid(small), piston.marker()});
  graph.add<PrismaticJoint>("cylinder", {graph.ground().marker(top, bore), piston.marker({}, bore)});
  const auto push = [](double t, const MarkerView&) { return force({-gas(turning(t).value), 0, 0}); };
  graph.add<UserForce>("gas", {piston.marker()}, {push});

  // 3. From rest; two cycles at speed; the stresses meanwhile.
  StressObserver stress(crank);
  FatigueRecorder fatigue(crank);
  const auto observe = [&](Simulation& run) {
    run.observe(stress, every(kSample)), run.observe(fatigue, every(kSample));
  };
  const auto draw = [&](Run& page) {  // flanges, which hide nothing, instead of pulley and flywheel
    page.draw(piston, visual::cylinder(kBore / 2, 0.05).at({}, bore)), page.draw(shell, visual::cylinder(0.025, 0.018));
    page.draw(flywheel, visual::cylinder(0.035, 0.02).at({0, 0, 0.03}));
    page.draw(pulley, visual::cylinder(0.035, 0.02).at({0, 0, -0.03}));
  };
  const machine::Outcome out = machine::run(
      graph,
      {.name = "crank_train",
       .title = "A crank train at 6,000 rpm",
       .duration = kEnd,
       .interval = kSample,
       .tolerance = {1e-5, 1e-8},
       .sensors = {position(piston.marker(), "piston"), reaction(small_end, 1, kWorldAxes, "small"),
                   reaction(front_bearing, 1, kWorldAxes, "front"), reaction(rear_bearing, 1, kWorldAxes, "rear")},
       .prepare = observe,
       .draw = draw,
       .wants = {want(position(piston.marker(), "piston"), percent(1))},
       .solve_duration = 0.04});

  // 4. Check: over the last two cycles the force on the piston and that of both bearings along the cylinder.
  const ModelCheck shaft = check(mesh, Definiteness::not_looked_at), link = check(shank, Definiteness::not_looked_at);
  const double unbalance = shaft.mass * shaft.center.x() + 0.05 * kCrank;  // kg m, with the shell
  const double weight = kGravity * (shaft.mass + 0.05 + link.mass + kPiston + 9.5);
  double off[3] = {}, largest[3] = {}, rows = 0;  // root of the mean square, and the largest
  for (int row = static_cast<int>(std::lround(kRunUp / kSample)); row < out.table.row_count(); ++row, ++rows) {
    const double t = out.table.at(row, 0);
    const auto value = [&](const char* column) { return machine::at(out.table, column, t); };
    const double phi = turning(t).value, s = kCrank * std::sin(phi), a = piston_acceleration(phi),
                 pin_acceleration = -kSpeed * kSpeed * kCrank * std::cos(phi);
    const double rigid[] = {kCrank * std::cos(phi) + std::sqrt(kRod * kRod - s * s),
                            kPiston * (a + kGravity) + gas(phi),
                            gas(phi) + weight + kPiston * a + 0.5 * link.mass * (a + pin_acceleration) +
                                unbalance * pin_acceleration / kCrank};
    const double seen[] = {value("piston_x"), value("small_force_x"), value("front_force_x") + value("rear_force_x")};
    for (int k = 0; k < 3; ++k)
      off[k] += std::pow(seen[k] - rigid[k], 2), largest[k] = std::max(largest[k], std::abs(rigid[k]));
  }
  for (double& sum : off) sum = std::sqrt(sum / rows);
  std::printf("off the rigid slider-crank, rms: piston %.3f mm, its force %.0f of %.0f N, bearings %.0f of %.0f N\n",
              1e3 * off[0], off[1], largest[1], off[2], largest[2]);
  std::fputs(stress.report(1).c_str(), stdout);
  const Table cycles = fatigue.table(  // 42CrMo4, ground; the mean by Goodman's line
      {.curve = {.range = 6e8, .exponent = 8, .exponent_below = 15, .tensile_strength = 1e9}});
  const std::vector<double> damage = cycles.column("damage");
  const int worst = static_cast<int>(std::max_element(damage.begin(), damage.end()) - damage.begin());
  std::printf("most damage: %.2g a run-up with two cycles, by a range of %.0f MPa; life %.0f h of such\n",
              cycles.at(worst, 3), 1e-6 * cycles.at(worst, 2), cycles.at(worst, 4) / 3600);
  const Vector3 at = mesh.nodes.col(mesh.node_index(static_cast<int>(cycles.at(worst, 0))));
  const bool in_fillet =
      std::abs(std::abs(at.z()) - 0.011) < 0.002 && std::abs(std::hypot(at.x() - kCrank, at.y()) - 0.025) < 0.002;
  return out.good && off[0] < 1e-4 && off[1] < 0.01 * largest[1] && off[2] < 0.03 * largest[2] && in_fillet ? 0 : 1;
}
