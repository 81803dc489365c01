// satellite: two wings of flexible solar panels unfold one after the other and lock, and turn the satellite by it.
// Dimensions are typical of a satellite of 0.8 t: panels of 2 m x 1.5 m, sandwich plates 22 mm thick with skins of
// carbon fibre (2.5 kg/m²), as one layer of bricks of the same bending stiffness and mass. A spring and a damper in
// each root hinge, a closed cable that opens the second panel twice as far, latches that lock where the wing is flat.
// Checked: no angular momentum appears; the attitude after either wing is that of rigid wings, which no speed changes.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {

constexpr double kLength = 2, kWidth = 1.5, kThickness = 0.022, kArea = 2.5;  // m, kg/m², of a panel
constexpr double kRootY = 0.65, kRootZ = -1, kGap = 0.05;            // m, hinge of a wing on the bus; between panels
constexpr double kBusMass = 800, kBusInertia = 240, kBracket = 0.5;  // kg, kg m² about the wings' axis, kg
constexpr double kSpring = 2, kDamper = 5, kLatch = 2e4, kRelease = 22, kEnd = 50;  // N m, N m s, N m/rad, s, s
// Skins of 0.2 mm, 70 GPa: D = E t h²/2 = 3388 N m, and a solid plate's is E h³/12.
const Material kSandwich{3388 * 12 / (kThickness * kThickness * kThickness), 0.0, kArea / kThickness};

struct Wing {
  JointCoordinate angle;
  Input *latch, *locked, *torque;
  Marker panel;  // middle of the outer one
};

/// Folded against the bus, in a frame turned by `side` about z: y outwards, z up, hinges along -x.
Wing add_wing(SystemGraph& graph, RigidBody& bus, const std::string& name, double side, bool held) {
  const Matrix3 frame = rotation_about({0, 0, 1}, side), hinge = frame * rotation_about({0, 1, 0}, -M_PI / 2);
  const FiniteElementModel mesh = plate_mesh({kLength, kWidth, kThickness, {8, 6}, "C3D8I", kSandwich});
  const std::vector<int>&inner = mesh.node_set("x_min"), &outer = mesh.node_set("x_max");
  const auto basis =
      make_basis(mesh, MeanAxisFrame{}, 4, {.rigid = {inner, outer}, .interface_modes = InterfaceModes::craig_bampton});
  const auto add_panel = [&](const std::string& which, double up, double out) {
    return &graph.add<FlexibleBody>(name + which, {.basis = basis,
                                                   .damping = {.stiffness_proportional = 0.01},
                                                   .position = frame * Vector3(-up * kWidth / 2, out, up * kRootZ),
                                                   .orientation = frame * Matrix3{{0, up, 0}, {0, 0, 1}, {up, 0, 0}}});
  };
  FlexibleBody &first = *add_panel(" panel 1", 1, kRootY), &second = *add_panel(" panel 2", -1, kRootY + kGap);
  const auto edge = [&](FlexibleBody& panel, const auto& nodes) {
    return panel.rigid(nodes, panel.parameters().orientation.transpose() * hinge);
  };
  const Vector3 foot = frame * Vector3(0, kRootY, kRootZ), head = foot + Vector3(0, 0, kLength);
  auto& bracket =
      graph.add<RigidBody>(name + " bracket", {.mass = kBracket, .inertia = {0.05, 0.05, 1e-3}, .position = head});
  auto& root = graph.add<RevoluteJoint>(name + " root", {bus.marker_at_world(foot, hinge), edge(first, inner)});
  auto& middle = graph.add<RevoluteJoint>(name + " hinge", {edge(first, outer), bracket.marker({}, hinge)});
  graph.add<FixedJoint>(name + " edge", {bracket.marker(frame * Vector3(0, kGap, 0), hinge), edge(second, inner)});
  graph.add<CoordinateCoupling>(name + " cable", {root.angle(), middle.angle()}, {.factors = {2, 1}});
  // Spring and latch. Before its release the latch of a held wing keeps it folded.
  Wing wing{root.angle(), &graph.add<Input>(name + " latch stiffness", {"N m/rad", held ? kLatch : 0}),
            &graph.add<Input>(name + " locked at", {"rad"}),
            &graph.add<Input>(name + " torque", {"N m", held ? 0 : -kSpring}), second.average(mesh.node_set("all"))};
  graph.add<CoordinateSpring>(name + " spring", {wing.angle}, {.damping = kDamper, .preload = *wing.torque});
  graph.add<CoordinateSpring>(name + " latch", {wing.angle}, {.stiffness = *wing.latch, .free_value = *wing.locked});
  return wing;
}

/// Angle of the bus when one and when both rigid wings have opened, for zero angular momentum, in the plane y + iz.
std::array<double, 2> rigid_attitudes() {
  using Complex = std::complex<double>;
  struct Piece {
    double mass, inertia, angle;
    Complex at;
  };
  const double panel = kArea * kLength * kWidth, J = panel * (kLength * kLength + kThickness * kThickness) / 12;
  const auto pieces = [&](double north, double south) {
    std::vector<Piece> all{{kBusMass, kBusInertia, 0, 0}};
    for (const double mirror : {1, -1}) {
      const double phi = mirror > 0 ? north : south;
      const Complex out = std::polar(1.0, M_PI / 2 - phi), root(kRootY, kRootZ), middle = root + kLength * out,
                    edge = middle + kGap * std::polar(1.0, phi);
      for (const Piece& p : {Piece{panel, J, -phi, 0.5 * (root + middle)}, Piece{kBracket, 0.05, phi, middle},
                             Piece{panel, J, phi, edge + 0.5 * kLength * std::conj(out)}})
        all.push_back({p.mass, p.inertia, mirror * p.angle, {mirror * p.at.real(), p.at.imag()}});
    }
    return all;
  };
  const int steps = 1000;
  std::array<double, 2> turned{};
  for (int i = 0; i < 2 * steps; ++i) {
    const double flat = M_PI / 2, from = flat * (i % steps) / steps, to = from + flat / steps;
    const auto before = i < steps ? pieces(from, 0) : pieces(flat, from),
               after = i < steps ? pieces(to, 0) : pieces(flat, to);
    double mass = 0, moved = 0, inertia = 0;  // about the common centre: less the share of the sums
    Complex at = 0, by = 0;
    for (std::size_t k = 0; k < before.size(); ++k) {
      const double m = before[k].mass, J_k = before[k].inertia;
      const Complex mean = 0.5 * (before[k].at + after[k].at), step = after[k].at - before[k].at;
      mass += m, at += m * mean, by += m * step;
      moved += m * (std::conj(mean) * step).imag() + J_k * (after[k].angle - before[k].angle);
      inertia += m * std::norm(mean) + J_k;
    }
    const double turn = -(moved - (std::conj(at) * by).imag() / mass) / (inertia - std::norm(at) / mass);
    for (int wing = i / steps; wing < 2; ++wing) turned[wing] += turn;
  }
  return turned;
}

}  // namespace

int main() {
  // 1. The bus and its wings; no gravity.
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& bus = graph.add<RigidBody>("bus", {.mass = kBusMass, .inertia = {220, kBusInertia, 200}});
  const Wing wings[] = {add_wing(graph, bus, "north", -M_PI / 2, false), add_wing(graph, bus, "south", M_PI / 2, true)};

  // 2. The second is released by time; a latch locks where its wing comes to a right angle, without strain.
  Recorder momentum({machine::angular_momentum(graph)});
  const auto prepare = [&](Simulation& simulation) {
    simulation.observe(momentum, every(0.5));
    wings[1].torque->set(kRelease, -kSpring), wings[1].latch->set(kRelease, 0);
    for (const Wing& wing : wings)
      simulation.on({"latch", watch(coordinate(wing.angle, "angle")), M_PI / 2, Event::Direction::rising,
                     Event::Action::restart,
                     [&wing](State& now) { wing.latch->set(now.time, kLatch), wing.locked->set(now.time, M_PI / 2); }});
  };
  const auto draw = [&](Run& page) { page.draw(bus, visual::box({1.2, 1.5, 2})); };
  const JointCoordinate attitude = -angle_between(graph.ground().marker(), bus.marker(), 1);
  const Sensor panel = position(wings[0].panel, "outer panel");
  const machine::Outcome out =
      machine::run(graph, {.name = "satellite",
                           .title = "A satellite unfolds its solar panels",
                           .duration = kEnd,
                           .interval = 0.1,
                           .tolerance = {1e-6, 1e-8},
                           .sensors = {coordinate(attitude, "attitude"), coordinate(wings[0].angle, "north"),
                                       coordinate(wings[1].angle, "south"), panel},
                           .prepare = prepare,
                           .draw = draw,
                           .wants = {want(panel, percent(2))},
                           .solve_duration = 8});

  // 3. Check.
  const std::array<double, 2> rigid = rigid_attitudes();
  const std::vector<double> L = momentum.table().column("angular_momentum");
  bool good = out.good && *std::max_element(L.begin(), L.end()) < 1e-5;
  for (const int i : {0, 1}) {
    const double turned = machine::at(out.table, "attitude", i ? kEnd : kRelease),
                 angle = machine::at(out.table, i ? "south" : "north", kEnd);
    std::printf("attitude %.5f rad (rigid wings: %.5f), wing locked at %.5f rad\n", turned, rigid[i], angle);
    good &= std::abs(turned - rigid[i]) < 0.01 * rigid[0] && std::abs(angle - M_PI / 2) < 1e-3;
  }
  return good ? 0 : 1;
}
