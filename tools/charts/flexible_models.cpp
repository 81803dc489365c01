// How to model a flexible body: mass, reduction, deflection and frame against the number of modes, on the flexible
// pendulum (against nonlinear finite elements) and on a slider-crank with a flexible rod.  flexible_models FOLDER
#include <algorithm>
#include <cstdio>
#include <functional>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

using MakeBasis = std::function<std::shared_ptr<const ModalBasis>(const FiniteElementModel&, int modes)>;

/// A point's motion, a row a sample.
using Path = std::vector<Vector3>;
struct Scene {
  std::string name;  // of the files
  std::string watched;
  FiniteElementModel model;
  std::vector<int> counts;
  std::function<Path(std::shared_ptr<const ModalBasis>)> run;
  Path reference;
};

Path path_of(const Table& table) {
  Path path;
  for (int i = 0; i < table.row_count(); ++i) path.emplace_back(table.at(i, 1), table.at(i, 2), table.at(i, 3));
  return path;
}

double deviation(const Path& a, const Path& b) {
  double most = 0;
  for (size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i] - b.at(i)).norm());
  return most;
}

Path run_graph(SystemGraph& graph, const Marker& watched, double interval, double end) {
  const System system = assemble(graph);
  State state = system.initial_state();
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-7, .absolute = 1e-9}});
  Recorder recorder({position(watched, "p")});
  Simulation simulation(system, integrator);
  simulation.observe(recorder, every(interval));
  simulation.run(state, end);
  return path_of(recorder.table());
}

Path swing(std::shared_ptr<const ModalBasis> basis) {
  SystemGraph graph;
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = basis});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  graph.add<RevoluteJoint>(
      "hinge", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(basis->node_set("hinge"), along_y)});
  return run_graph(graph, rod.node(basis->node_set("tip").front()), 1e-3, 1);
}

// The rod of the slider-crank: steel, 300 x 8 x 8 mm; the crank turns at 150 rad/s (as Simeon's, IVP Test Set, 1996).
// It starts suddenly: what rings then is damped, in proportion to stiffness, and the second revolution is watched.
constexpr double kCrank = 0.15, kRod = 0.3, kSide = 0.008, kSpeed = 150, kDamping = 1e-5;

FiniteElementModel rod_model(int along) {
  FiniteElementModel model = brick_mesh({.size = {kRod, kSide, kSide},
                                         .divisions = {along, 2, 1},
                                         .type = "C3D8I",
                                         .material = {2e11, 0.3, 7870},
                                         .name = "connecting rod"});
  const auto line = [&](double x) {
    std::vector<int> ids;
    for (int i = 0; i < model.node_count(); ++i)
      if (std::abs(model.nodes(0, i) - x) < 1e-9 && std::abs(model.nodes(1, i) - kSide / 2) < 1e-9)
        ids.push_back(model.node_ids[i]);
    return ids;
  };
  model.node_sets["hinge"] = line(0);
  model.node_sets["wrist"] = line(kRod);
  model.node_sets["middle"] = line(kRod / 2);
  // Origin at the crank pin, x to the wrist pin.
  model.node_sets["frameA"] = {model.node_sets["hinge"][0], model.node_sets["wrist"][0],
                               model.node_sets["x_min"].back()};
  model.node_sets["root_face"] = model.node_sets["x_min"];
  return model;
}

Path crank(std::shared_ptr<const ModalBasis> basis) {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& crank = graph.add<RigidBody>(
      "crank", {.mass = 0.36, .inertia = {0.002727, 0.002727, 0.002727}, .angular_velocity = {0, 0, kSpeed}});
  FlexibleBody::Parameters of_rod{.basis = basis, .damping = {.stiffness_proportional = kDamping}};
  const Vector3 corner(0, -kSide / 2, -kSide / 2), turn(0, 0, -kCrank * kSpeed / kRod);
  of_rod.position = Vector3(kCrank, 0, 0) + corner;
  of_rod.velocity = Vector3(0, kCrank * kSpeed, 0) + turn.cross(corner);
  of_rod.angular_velocity = turn;
  auto& rod = graph.add<FlexibleBody>("rod", std::move(of_rod));
  auto& slider = graph.add<RigidBody>(
      "slider", {.mass = 0.075552, .inertia = {1e-4, 1e-4, 1e-4}, .position = {kCrank + kRod, 0, 0}});
  const Matrix3 along_x = rotation_about({0, 1, 0}, M_PI / 2);  // a slider's way is the z axis of its markers
  auto& bearing = graph.add<RevoluteJoint>("main bearing", {graph.ground().marker(), crank.marker()});
  graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = ramp(0, kSpeed)});
  graph.add<RevoluteJoint>("crank pin", {crank.marker({kCrank, 0, 0}), rod.average(basis->node_set("hinge"))});
  graph.add<PointOnLineJoint>("wrist", {slider.marker(), rod.average(basis->node_set("wrist"))});
  graph.add<PrismaticJoint>("guide", {graph.ground().marker({0, 0, 0}, along_x), slider.marker({0, 0, 0}, along_x)});
  const Path path = run_graph(graph, rod.average(basis->node_set("middle")), 1e-4, 0.0838);
  return {path.begin() + static_cast<long>(path.size()) / 2, path.end()};
}

/// The same model with the row sums of its mass on the diagonal.
FiniteElementModel lumped(FiniteElementModel model) {
  const VectorX sums = model.mass * VectorX::Ones(model.dof_count());
  model.mass = SparseMatrix(sums.asDiagonal());
  return model;
}

BodyFrame hinge_of(const FiniteElementModel& model) { return HingeFrame{model.node_set("hinge")}; }
BodyFrame three_nodes_of(const FiniteElementModel& model) {
  const auto& n = model.node_set("frameA");
  return ThreeNodeFrame{n.at(0), n.at(1), n.at(2)};
}

MakeBasis hinged(Deflection deflection) {
  return [deflection](const FiniteElementModel& model, int modes) {
    return make_basis(model, hinge_of(model), modes, {.deflection = deflection});
  };
}
MakeBasis in_frame(const std::function<BodyFrame(const FiniteElementModel&)>& frame) {
  return [frame](const FiniteElementModel& model, int modes) {
    return make_basis(model, frame(model), modes, {.deflection = Deflection::stiffened});
  };
}
/// The faces at both ends as interfaces, their static modes counted among the modes; null where they alone are more.
std::shared_ptr<const ModalBasis> craig_bampton(const FiniteElementModel& model, int modes, Deflection deflection) {
  std::vector<int> end;
  const double length = model.nodes.row(0).maxCoeff();
  for (int i = 0; i < model.node_count(); ++i)
    if (std::abs(model.nodes(0, i) - length) < 1e-9) end.push_back(model.node_ids[static_cast<size_t>(i)]);
  const Reduction reduction{.loaded = {{model.node_set("root_face")}, {end}},
                            .interface_modes = InterfaceModes::craig_bampton,
                            .deflection = deflection};
  const int statics = make_basis(model, three_nodes_of(model), 0, reduction)->mode_count();
  return modes < statics ? nullptr : make_basis(model, three_nodes_of(model), modes - statics, reduction);
}

/// Free-free modes with the static shapes of the pins, counted among them; null where they alone are more.
std::shared_ptr<const ModalBasis> mean_axes_with_static_shapes(const FiniteElementModel& model, int modes) {
  Reduction reduction{.loaded = {{model.node_set("hinge")}}, .deflection = Deflection::stiffened};
  if (model.node_sets.contains("wrist")) reduction.loaded.push_back({model.node_set("wrist")});
  const int statics = make_basis(model, MeanAxisFrame{}, 0, reduction)->mode_count();
  return modes < statics ? nullptr : make_basis(model, MeanAxisFrame{}, modes - statics, reduction);
}

class Charts {
 public:
  Charts(std::string folder, const Scene& scene) : folder_(std::move(folder)), scene_(scene) {}

  void begin(const std::string& topic, const std::string& title) {
    topic_ = topic;
    chart_ = Chart{.title = title,
                   .x_label = "modes",
                   .y_label = "largest deviation of " + scene_.watched + ", m",
                   .lines = {},
                   .log_y = true};
  }
  void line(const std::string& title, const MakeBasis& make, const FiniteElementModel& model) {
    ChartLine line{.title = title, .x = {}, .y = {}, .style = LineStyle::marked};
    for (int count : scene_.counts) {
      const auto basis = make(model, count);
      if (!basis) continue;
      line.x.push_back(count);
      line.y.push_back(deviation(scene_.run(basis), scene_.reference));
    }
    std::printf("%s, %s:", scene_.name.c_str(), title.c_str());
    for (size_t i = 0; i < line.x.size(); ++i) std::printf("  %g: %.2e", line.x[i], line.y[i]);
    std::printf("\n");
    std::fflush(stdout);
    if (!line.x.empty()) chart_.lines.push_back(std::move(line));
  }
  void line(const std::string& title, const MakeBasis& make) { line(title, make, scene_.model); }
  void end() const {
    const std::string path = folder_ + "/flexible_" + topic_ + "_" + scene_.name;
    write_chart(chart_, path);
    Table table{.columns = {"modes"}};
    for (const ChartLine& line : chart_.lines) table.columns.push_back(line.title);
    for (int count : scene_.counts) {
      std::vector<double> row{static_cast<double>(count)};
      for (const ChartLine& line : chart_.lines) {
        const auto at = std::ranges::find(line.x, count);
        row.push_back(at == line.x.end() ? NAN : line.y[static_cast<size_t>(at - line.x.begin())]);
      }
      table.add_row(row);
    }
    write_csv(table, path + ".csv");
  }

 private:
  std::string folder_, topic_;
  const Scene& scene_;
  Chart chart_;
};

void draw(const Scene& scene, const std::string& folder, const std::string& name) {
  Charts charts(folder, scene);
  charts.begin("modes", name + ": number of modes, and how they deflect");
  charts.line("linear", hinged(Deflection::linear));
  charts.line("stiffened", hinged(Deflection::stiffened));
  charts.line("quadratic", hinged(Deflection::quadratic));
  charts.line("Craig-Bampton, stiffened", [](const FiniteElementModel& model, int modes) {
    return craig_bampton(model, modes, Deflection::stiffened);
  });
  charts.end();
  charts.begin("frames", name + ": body frames, stiffened");
  charts.line("hinge", hinged(Deflection::stiffened));
  charts.line("three nodes", in_frame(three_nodes_of));
  charts.line("tangent", in_frame([](const auto& model) { return TangentFrame{model.node_set("root_face")}; }));
  charts.line("mean axes", in_frame([](const auto&) { return MeanAxisFrame{}; }));
  charts.line("mean axes, static shapes", mean_axes_with_static_shapes);
  charts.end();
  charts.begin("mass", name + ": consistent and lumped mass, stiffened");
  charts.line("consistent", hinged(Deflection::stiffened));
  charts.line("lumped", hinged(Deflection::stiffened), lumped(scene.model));
  charts.end();
}

}  // namespace

int main(int count, char** arguments) {
  const std::string folder = count > 1 ? arguments[1] : "docs/charts";
  const std::string data = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/";
  draw({.name = "pendulum",
        .watched = "the tip",
        .model = read_calculix(data + "calculix/matrices"),
        .counts = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 20},
        .run = swing,
        .reference = path_of(read_csv(data + "trajectory.csv"))},
       folder, "pendulum against nonlinear elements");
  Scene slider_crank{.name = "slider_crank",
                     .watched = "the rod's middle",
                     .model = rod_model(12),
                     .counts = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14},
                     .run = crank,
                     .reference = {}};
  slider_crank.reference = crank(craig_bampton(slider_crank.model, 18, Deflection::quadratic));
  draw(slider_crank, folder, "slider-crank against 18 Craig-Bampton modes, quadratic");
}
