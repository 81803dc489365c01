// One body, six models: rigid, linear, stiffened and quadratic modes, geometrically exact beam, bricks in the inertial
// frame; error over cost of the pendulum of example 02, against CalculiX's nonlinear elements, and of the blade of
// example 28 that spins up, against exact elements extrapolated from two fine meshes.  slender_models FOLDER
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

using Draw = std::function<std::vector<Sensor>(SystemGraph&)>;

const StudyMethod& method() {
  static const StudyMethod radau = select_methods(standard_methods(), {"Radau"}).front();
  return radau;
}

// ---- the pendulum: 0.1 x 0.01 x 0.015 m, E = 10 MPa, hinged along its lower edge at x = 0 ----

constexpr double kRod = 0.1, kWidth = 0.01, kHeight = 0.015;
const Material kRubber{1e7, 0.49, 0.26 / (kRod * kWidth * kHeight)};
const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

StudyScene pendulum(const std::string& name, Draw draw) {
  return {.name = name, .duration = 1, .characteristic_length = kRod, .draw = std::move(draw)};
}

StudyScene modal_pendulum(const FiniteElementModel& model, const std::string& name, int modes, Deflection deflection) {
  return pendulum(name, [&model, modes, deflection](SystemGraph& graph) -> std::vector<Sensor> {
    const std::vector<int>& edge = model.node_set("hinge");
    auto& rod = graph.add<FlexibleBody>(
        "rod", {.basis = make_basis(model, HingeFrame{edge}, modes, {.deflection = deflection})});
    graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, kAlongY), rod.average(edge, kAlongY)});
    return {position(rod.node(model.node_set("tip").front()), "tip")};
  });
}

StudyScene beam_pendulum(int elements) {
  return pendulum("beam, " + std::to_string(elements) + " elements", [=](SystemGraph& graph) -> std::vector<Sensor> {
    const Vector3 root(0, kWidth / 2, kHeight / 2);
    auto& rod = graph.add<Beam>("rod", {.axis = BeamAxis::straight(root, root + Vector3(kRod, 0, 0), {0, 1, 0}),
                                        .sections = {{0, BeamSection::rectangle(kWidth, kHeight, kRubber)}},
                                        .elements = elements});
    const Point below(0, 0, -kHeight / 2);  // of the axis, in section axes, which are those of the world
    graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, kAlongY), rod.marker(0, below, kAlongY)});
    return {position(rod.marker(kRod, below), "tip")};
  });
}

StudyScene brick_pendulum(const Registry& registry, const FiniteElementModel& model, const std::string& deck) {
  return pendulum("bricks", [&registry, &model, deck](SystemGraph& graph) -> std::vector<Sensor> {
    auto& rod = graph.add(registry.body("inertial_body"), "rod", {{"mesh_file", deck}});
    const std::vector<int>& edge = model.node_set("hinge");
    graph.add<ThreeNodeFixation>("hinge",
                                 {graph.ground().marker(), rod.node(edge[0]), rod.node(edge[1]), rod.node(edge[2])});
    return {position(rod.node(model.node_set("tip").front()), "tip")};
  });
}

// ---- the blade: aluminium, 8 x 0.1 x 0.2 m, on a hub that turns up to 6 rad/s in 3 s ----

constexpr double kBlade = 8, kChord = 0.1, kDepth = 0.2, kSpeed = 6, kStart = 3, kEnd = 6, kDamping = 1e-4;
const Material kAluminium{7e10, 0.3, 2700};

/// Smooth to full speed, then steady.
Motion turning(double t) {
  if (t >= kStart) return {kSpeed * (t - kStart / 2), kSpeed, 0};
  const double s = t / kStart;
  return {kSpeed * kStart * (s * s * s - s * s * s * s / 2), kSpeed * (3 - 2 * s) * s * s,
          kSpeed / kStart * 6 * (s - s * s)};
}

RigidBody& draw_hub(SystemGraph& graph) {
  auto& hub = graph.add<RigidBody>("hub", {.mass = 10});
  auto& bearing = graph.add<RevoluteJoint>("bearing", {graph.ground().marker(), hub.marker()});
  graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = turning});
  return hub;
}

StudyScene blade(const std::string& name, Draw draw) {
  return {.name = name, .duration = kEnd, .characteristic_length = kBlade, .draw = std::move(draw)};
}

StudyScene slender_blade(const std::string& name, const Fidelity& fidelity) {
  return blade(name, [fidelity](SystemGraph& graph) -> std::vector<Sensor> {
    auto& hub = draw_hub(graph);
    auto& body = graph.add<SlenderBody>(
        "blade", {.beam = {.axis = BeamAxis::straight({0, 0, 0}, {kBlade, 0, 0}, {0, 1, 0}),
                           .sections = {{0, BeamSection::rectangle(kChord, kDepth, kAluminium).damped(kDamping)}},
                           .elements = 20}});
    graph.add<FixedJoint>("root", {hub.marker(), body.marker(0)});
    const Marker tip = body.marker(kBlade);
    body.set_fidelity(fidelity);
    return {position(tip, "tip")};
  });
}

Fidelity modes(int count, Deflection deflection) {
  Fidelity fidelity{.deflection = deflection};
  for (int k = 0; k < count; ++k) fidelity.modes.push_back(k);
  return fidelity;
}
StudyScene exact_blade(int elements) {
  return slender_blade("beam, " + std::to_string(elements) + " elements",
                       {.deflection = Deflection::exact, .elements = elements});
}

StudyScene quadratic_blade(const FiniteElementModel& model, int count) {
  return blade(std::to_string(count) + " modes, quadratic", [&model, count](SystemGraph& graph) -> std::vector<Sensor> {
    auto& hub = draw_hub(graph);
    const auto& root = model.node_set("x_min");
    const auto basis = make_basis(model, TangentFrame{root}, count, {.deflection = Deflection::quadratic});
    // The basis has its origin in the middle of the root.
    auto& body = graph.add<FlexibleBody>("blade", {.basis = basis, .damping = {.stiffness_proportional = kDamping}});
    graph.add<FixedJoint>("root", {hub.marker(), body.frame()});
    return {position(body.average(model.node_set("x_max")), "tip")};
  });
}

/// A block of 8-node bricks with incompatible modes as a CalculiX deck, its root's middle at the origin.
void write_deck(const std::string& path, const std::array<int, 3>& n) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream deck(path);
  const auto id = [&](int i, int j, int k) { return 1 + k + (n[2] + 1) * (j + (n[1] + 1) * i); };
  deck.precision(17);
  deck << "*NODE\n";
  for (int i = 0; i <= n[0]; ++i)
    for (int j = 0; j <= n[1]; ++j)
      for (int k = 0; k <= n[2]; ++k)
        deck << id(i, j, k) << ", " << kBlade * i / n[0] << ", " << kChord * j / n[1] - kChord / 2 << ", "
             << kDepth * k / n[2] - kDepth / 2 << "\n";
  deck << "*ELEMENT, TYPE=C3D8I, ELSET=all\n";
  int element = 0;
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) {
        deck << ++element;
        for (const int up : {0, 1})
          deck << ", " << id(i, j, k + up) << ", " << id(i + 1, j, k + up) << ", " << id(i + 1, j + 1, k + up) << ", "
               << id(i, j + 1, k + up);
        deck << "\n";
      }
  for (const int end : {0, n[0]}) {
    deck << "*NSET, NSET=" << (end ? "tip" : "root") << "\n";
    for (int j = 0; j <= n[1]; ++j)
      for (int k = 0; k <= n[2]; ++k) deck << id(end, j, k) << "\n";
  }
  deck << "*MATERIAL, NAME=aluminium\n*ELASTIC\n"
       << kAluminium.young << ", " << kAluminium.poisson << "\n*DENSITY\n"
       << kAluminium.density << "\n*SOLID SECTION, ELSET=all, MATERIAL=aluminium\n";
}

StudyScene brick_blade(const Registry& registry, const std::string& folder, const std::array<int, 3>& n) {
  const std::string deck = folder + "/blade_" + std::to_string(n[0]) + ".inp";
  write_deck(deck, n);
  return blade(std::to_string(n[0] * n[1] * n[2]) + " bricks", [&registry, deck, n](SystemGraph& graph) {
    auto& hub = draw_hub(graph);
    auto& body =
        graph.add(registry.body("inertial_body"), "blade", {{"mesh_file", deck}, {"stiffness_damping", kDamping}});
    const int count = (n[1] + 1) * (n[2] + 1);
    std::vector<int> root, tip;
    for (int i = 1; i <= count; ++i) root.push_back(i), tip.push_back(n[0] * count + i);
    graph.add<FixedJoint>("root", {hub.marker(), body.average(root)});
    return std::vector<Sensor>{position(body.average(tip), "tip")};
  });
}

/// The tip of the blade with exact elements, without the error of second order.
Table finest_blade() {
  Table samples[2];
  for (const int i : {0, 1}) {
    SystemGraph graph{{.gravity = {0, 0, -9.81}}};
    const StudyScene scene = exact_blade(32 << i);
    const std::vector<Sensor> watched = scene.draw(graph);
    const System system = assemble(graph);
    State state = system.initial_state();
    Recorder recorder{watched};
    Radau radau({.tolerance = {1e-7, 1e-10}});
    Simulation simulation(system, radau);
    simulation.observe(recorder, every(kEnd / 20));
    simulation.run(state, kEnd);
    samples[i] = recorder.table();
  }
  double most = 0;
  for (std::size_t k = 0; k < samples[1].values.size(); ++k) {
    const double correction = (samples[1].values[k] - samples[0].values[k]) / 3;
    most = std::max(most, std::abs(correction)), samples[1].values[k] += correction;
  }
  std::printf("reference of the blade: 64 exact elements, corrected by up to %.1e m\n", most);
  return samples[1];
}

void draw(const WorkPrecision& result, const std::string& path, const std::vector<ChartLine>& more = {}) {
  std::printf("%s\n", result.table().c_str());
  std::fflush(stdout);
  result.write_csv(path + ".csv");
  result.write_chart(path, more);
}

}  // namespace

int main(int count, char** arguments) {
  const std::string folder = count > 1 ? arguments[1] : "docs/charts";
  const std::string data = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/";
  const std::string which = count > 2 ? arguments[2] : "";  // pendulum, blade; both if none is named
  Registry registry;
  registry.load_plugin(LITHE_PLUGIN_DIR "/inertial_body.so");
  const std::vector<double> settings{1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};

  if (which != "blade") {
    const std::string deck = data + "hex8i/calculix/matrices";
    const FiniteElementModel model = read_calculix(deck);
    Table reference = read_csv(data + "hex8i/trajectory.csv");
    reference.columns = {"t", "tip_x", "tip_y", "tip_z", "tip_vx", "tip_vy", "tip_vz"};
    const WorkPrecision result = model_precision(
        "a pendulum in six models against CalculiX",
        {modal_pendulum(model, "rigid", 0, Deflection::linear), modal_pendulum(model, "9 modes", 9, Deflection::linear),
         modal_pendulum(model, "9 modes, stiffened", 9, Deflection::stiffened),
         modal_pendulum(model, "9 modes, quadratic", 9, Deflection::quadratic), beam_pendulum(8), beam_pendulum(16),
         brick_pendulum(registry, model, deck + ".inp")},
        reference, method(), settings, {.time_limit = 60});
    // How far CalculiX itself is off on its better mesh.
    const Table better = read_csv(data + "hex20/trajectory.csv");
    double off = 0;
    for (int row = 0; row < better.row_count(); ++row) {
      double squares = 0;
      for (int k = 1; k <= 3; ++k) squares += std::pow(better.at(row, k) - reference.at(row, k), 2);
      off = std::max(off, std::sqrt(squares));
    }
    std::printf("CalculiX with 20-node bricks is %.3e m from CalculiX with 8-node bricks\n", off);
    double least = 1e300, most = 0;
    for (const WorkPoint& point : result.points) least = std::min(least, point.cpu), most = std::max(most, point.cpu);
    draw(result, folder + "/slender_pendulum",
         {{.title = "CalculiX, 20-node bricks",
           .x = {off / kRod, off / kRod},
           .y = {least / result.duration, most / result.duration},
           .style = LineStyle::dashed}});
  }
  if (which != "pendulum") {
    const FiniteElementModel model = [] {
      FiniteElementModel block = brick_mesh(
          {.size = {kBlade, kChord, kDepth}, .divisions = {20, 1, 1}, .material = kAluminium, .name = "blade"});
      block.nodes.colwise() -= Vector3(0, kChord / 2, kDepth / 2);
      return block;
    }();
    draw(model_precision(
             "a blade that spins up, in six models",
             {slender_blade("rigid", {}), slender_blade("12 modes", modes(12, Deflection::linear)),
              slender_blade("12 modes, stiffened", modes(12, Deflection::stiffened)), quadratic_blade(model, 12),
              exact_blade(5), exact_blade(20), brick_blade(registry, "results/charts", {32, 1, 1})},
             finest_blade(), method(), settings, {.time_limit = 60}),
         folder + "/slender_blade");
  }
}
