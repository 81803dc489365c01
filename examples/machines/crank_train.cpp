// crank_train: a motorcycle's flat twin runs up to 6,000 rpm under its gas: crankshaft (gmsh meshes with fillets of 4
// mm) and rods (bricks) bend, a drive at the flywheel holds the speed. Checked: forces of pistons, and of the bearings
// along the cylinders, against rigid slider-cranks, whose masses balance; the most damage is in a fillet of a pin.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {
constexpr double kCrank = 0.043, kRod = 0.143, kBore = 0.086, kPiston = 0.45;                  // m, kg
constexpr double kSpeed = 6000 * 2 * M_PI / 60, kRunUp = 0.04, kCycle = 0.02, kSample = 2e-4;  // rad/s, s
const Material steel{2.1e11, 0.3, 7850};
const MotionLaw turning = run_up(kSpeed, 0, kRunUp);

/// N on a piston at half load, by the crank's angle from rest: the first fires after a turn, the second after two.
double gas(int cylinder, double angle) {
  static const CubicSpline pressure(
      {0, 8, 15, 25, 40, 60, 90, 120, 150, 180, 240, 360, 480, 540, 600, 640, 670, 690, 705, 720},
      {48, 67, 75, 63, 36, 18, 8.5, 5, 3, 1.8, 1.1, 1.05, 0.9, 0.95, 1.6, 3.3, 8, 17, 30, 48},
      "pressure");  // degrees, bar
  const double since = std::max(0.0, angle - 2 * M_PI * cylinder), degrees = std::fmod(since * 180 / M_PI + 360, 720);
  return 0.5 * (pressure(degrees).value - 1) * 1e5 * M_PI / 4 * kBore * kBore;
}

/// Acceleration of a rigid piston at constant speed, m/s², away from the crank.
double piston_acceleration(double angle) {
  const double s = kCrank * std::sin(angle), c = kCrank * std::cos(angle), w = std::sqrt(kRod * kRod - s * s);
  return kSpeed * kSpeed * (-c - (c * c - s * s) / w - s * s * c * c / (w * w * w));
}
}  // namespace

int main() {
  // 1. Crankshaft: axis along z, pins at x = 43 mm and -43 mm; front journal with pulley, middle one and rear one
  // with flywheel run in bearings and hold the ends of both throws.
  SystemGraph graph{{.gravity = {0, -9.81, 0}}};
  const FlexibleBodyFile file =
      read_flexible_body(LITHE_EXAMPLE_DATA "/crankshaft/crankshaft.msh", {.materials = {{"crankshaft", steel}}});
  const FiniteElementModel& mesh = *file.model;
  const std::vector<int>&front = mesh.node_set("front"), &pin = mesh.node_set("pin"), &rear = mesh.node_set("rear");
  const auto throw_basis = make_basis(mesh, MeanAxisFrame{}, 1,
                                      {.rigid = {front, pin, rear}, .interface_modes = InterfaceModes::craig_bampton});
  const FiniteElementModel shank = brick_mesh(
      {.size = {kRod, 0.028, 0.016}, .divisions = {12, 2, 2}, .type = "C3D8I", .material = steel, .name = "rod"});
  const std::vector<int>&big = shank.node_set("x_min"), &small = shank.node_set("x_max");
  const auto rod_basis =
      make_basis(shank, MeanAxisFrame{}, 2, {.rigid = {big, small}, .interface_modes = InterfaceModes::craig_bampton});
  const std::tuple<const char*, double, double, double> kinds[] = {
      {"front", -0.045, 1.5, 3.675e-3}, {"middle", 0.06, 0.45, 2e-4}, {"rear", 0.165, 8, 0.0784}};
  std::vector<RigidBody*> journals;
  std::vector<Sensor> sensors;
  for (const auto& [name, z, mass, J] : kinds) {
    auto& body = graph.add<RigidBody>(name, {.mass = mass, .inertia = {0.6 * J, 0.6 * J, J}, .position = {0, 0, z}});
    const std::vector<Marker> ends = {graph.ground().marker({0, 0, z}), body.marker()};
    const std::string bearing = std::string(name) + " bearing";
    sensors.push_back(journals.empty() ? reaction(graph.add<RevoluteJoint>(bearing, ends), 1, kWorldAxes, name)
                                       : reaction(graph.add<PointOnLineJoint>(bearing, ends), 1, kWorldAxes, name));
    journals.push_back(&body);
  }
  graph.add<CoordinateDrive>("drive", {angle_between(graph.ground().marker(), journals[2]->marker())}, {turning});

  // 2. Of each cylinder a throw, a rod, a piston and its gas; the second is the first, turned by half a turn.
  const Matrix3 bore = rotation_about({0, 1, 0}, M_PI / 2);
  FlexibleBody* throws[2];
  RigidBody* pistons[2];
  for (int k = 0; k < 2; ++k) {
    const std::string of = k == 0 ? " 1" : " 2";
    const Matrix3 turn = rotation_about({0, 0, 1}, M_PI * k);
    const auto at = [&](const Vector3& place) { return Vector3(turn * place + Vector3(0, 0, 0.12 * k)); };
    auto& crank = graph.add<FlexibleBody>(
        "throw" + of,
        {.basis = throw_basis, .damping = {.modal_ratios = {0.02}}, .position = at({0, 0, 0}), .orientation = turn});
    auto& shell = graph.add<RigidBody>(
        "shell" + of, {.mass = 0.05, .inertia = {9.36e-6, 9.36e-6, 1.56e-5}, .position = at({kCrank, 0, 0})});
    const auto hold = [&](const std::vector<int>& nodes, RigidBody& body) {
      Vector3 mean = Vector3::Zero();
      for (int id : nodes) mean += mesh.nodes.col(mesh.node_index(id)) / static_cast<double>(nodes.size());
      graph.add<FixedJoint>(body.name() + " on throw" + of,
                            {crank.rigid(nodes, turn.transpose()), body.marker_at_world(at(mean))});
    };
    hold(front, *journals[k]), hold(pin, shell), hold(rear, *journals[k + 1]);
    const Vector3 corner = at({kCrank, -0.014, -0.008}), top = at({kCrank + kRod, 0, 0});
    auto& rod = graph.add<FlexibleBody>(
        "rod" + of, {.basis = rod_basis, .damping = {.modal_ratios = {0.02}}, .position = corner, .orientation = turn});
    auto& piston =
        graph.add<RigidBody>("piston" + of, {.mass = kPiston, .inertia = {4e-4, 4e-4, 4e-4}, .position = top});
    graph.add<RevoluteJoint>("big end" + of, {shell.marker(), rod.rigid(big)});
    auto& small_end = graph.add<PointOnLineJoint>("small end" + of, {rod.rigid(small), piston.marker()});
    graph.add<PrismaticJoint>("cylinder" + of, {graph.ground().marker(top, bore), piston.marker({}, bore)});
    graph.add<UserForce>("gas" + of, {piston.marker()}, {[k, turn](double t, const MarkerView&) {
                           return force(turn * Vector3(-gas(k, turning(t).value), 0, 0));
                         }});
    sensors.push_back(position(piston.marker(), "piston" + of.substr(1)));
    sensors.push_back(reaction(small_end, 1, kWorldAxes, "small" + of.substr(1)));
    throws[k] = &crank, pistons[k] = &piston;
  }

  // 3. From rest; two cycles at speed; the stresses meanwhile.
  StressObserver stress[] = {StressObserver(*throws[0]), StressObserver(*throws[1])};
  FatigueRecorder fatigue[] = {FatigueRecorder(*throws[0]), FatigueRecorder(*throws[1])};
  const auto observe = [&](Simulation& run) {
    for (int k : {0, 1}) run.observe(stress[k], every(kSample)), run.observe(fatigue[k], every(kSample));
  };
  const auto draw = [&](Run& page) {
    for (RigidBody* piston : pistons) page.draw(*piston, visual::cylinder(kBore / 2, 0.05).at({}, bore));
  };
  const machine::Outcome out =
      machine::run(graph, {.name = "crank_train",
                           .title = "A flat twin's crank train at 6,000 rpm",
                           .duration = kRunUp + 2 * kCycle,
                           .interval = 2 * kSample,
                           .tolerance = {1e-5, 1e-8},
                           .sensors = sensors,
                           .prepare = observe,
                           .draw = draw,
                           .wants = {want(position(pistons[0]->marker(), "piston"), percent(1))},
                           .solve_duration = 0.04});

  // 4. Check, over the last two cycles: the force on each piston, and that of all bearings along the cylinders.
  double off[2] = {}, largest[2] = {}, rows = 0;  // root of the mean square, and the largest
  for (int row = static_cast<int>(std::lround(kRunUp / (2 * kSample))); row < out.table.row_count(); ++row, ++rows) {
    const double t = out.table.at(row, 0), phi = turning(t).value;
    const auto value = [&](const std::string& column) { return machine::at(out.table, column, t); };
    const auto compare = [&](int k, double seen, double rigid) {
      off[k] += std::pow(seen - rigid, 2), largest[k] = std::max(largest[k], std::abs(rigid));
    };
    compare(0, value("small1_force_x"), kPiston * piston_acceleration(phi) + gas(0, phi));
    compare(0, -value("small2_force_x"), kPiston * piston_acceleration(phi) + gas(1, phi));
    compare(1, value("front_force_x") + value("middle_force_x") + value("rear_force_x"), gas(0, phi) - gas(1, phi));
  }
  off[0] = std::sqrt(off[0] / (2 * rows)), off[1] = std::sqrt(off[1] / rows);
  std::printf("off the rigid slider-crank, rms: pistons %.0f of %.0f N, bearings %.0f of %.0f N\n", off[0], largest[0],
              off[1], largest[1]);
  bool good = out.good && off[0] < 0.01 * largest[0] && off[1] < 0.03 * largest[1];
  for (int k : {0, 1}) {
    std::fputs(stress[k].report(1).c_str(), stdout);
    const Table cycles = fatigue[k].table(  // 42CrMo4, ground; the mean by Goodman's line
        {.curve = {.range = 6e8, .exponent = 8, .exponent_below = 15, .tensile_strength = 1e9}});
    const std::vector<double> damage = cycles.column("damage");
    const int worst = static_cast<int>(std::max_element(damage.begin(), damage.end()) - damage.begin());
    std::printf("most damage: %.2g a run-up with two cycles, by a range of %.0f MPa; life %.0f h of such\n",
                cycles.at(worst, 3), 1e-6 * cycles.at(worst, 2), cycles.at(worst, 4) / 3600);
    const Vector3 at = mesh.nodes.col(mesh.node_index(static_cast<int>(cycles.at(worst, 0))));
    good = good && std::abs(std::abs(at.z()) - 0.009) < 0.0025 &&
           std::abs(std::hypot(at.x() - kCrank, at.y()) - 0.025) < 0.002;
  }
  return good ? 0 : 1;
}
