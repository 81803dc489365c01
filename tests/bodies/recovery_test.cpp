#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Cholesky>
#include <array>
#include <cstdio>

#include "bodies/flexible/deformation_writer.h"
#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/nodal_loads.h"
#include "bodies/flexible/result_writer.h"
#include "bodies/flexible/stress_observer.h"
#include "engine/observe/recorder.h"
#include "engine/output/hdf5_file.h"
#include "engine/output/hdf5_table.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/bodies/fe_models.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::recovery_test {
namespace {

const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

/// The swinging pendulum of examples/data/pendulum, from rest.
struct Pendulum {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  FlexibleBody& rod;

  Pendulum(const FiniteElementModel& model, const BodyFrame& frame, int modes, const Reduction& reduction = {})
      : rod(graph.add<FlexibleBody>("rod", {.basis = make_basis(model, frame, modes, reduction)})) {
    const std::vector<int>& edge = model.node_set("hinge");
    graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, kAlongY), rod.average(edge, kAlongY)});
  }
};

/// The largest von Mises stress at the sixteen integration points of elements 1 and 2, at the hinge.
double root_stress(const FlexibleBody& rod, Snapshot& now) {
  const ModalBasis& basis = rod.basis();
  const VectorX xi = rod.field_coordinates(now.body_state(rod));
  const VectorX u =
      basis.modes * xi.head(basis.mode_count()) + basis.deflection->fields * xi.tail(xi.size() - basis.mode_count());
  double largest = 0;
  for (int e : {0, 1}) {
    const ElementBlock& block = basis.elements.at(0);
    const SolidElement element =
        make_solid_element(block.type, block.nodes.at(static_cast<size_t>(e)), basis.nodes, block.material);
    largest = std::max(largest, von_mises(point_stress(element, u, StrainMeasure::green_lagrange).stress).maxCoeff());
  }
  return largest;
}

/// Through VTK's own reader: tests/engine/output/read_vtu.py prints points, cells, and sums of the fields.
std::string vtk_text(const std::string& path) {
  const std::string reader = LITHE_SOURCE_DIR "/tests/engine/output/read_vtu.py";
  const std::string command = "/usr/bin/python3 '" + reader + "' '" + path + "' 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> part;
  while (const std::size_t size = fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), size);
  EXPECT_EQ(pclose(pipe), 0) << text << "\nVTK is needed: apt-get install python3-vtk9, used by /usr/bin/python3.";
  return text;
}
/// "name: 6 components, sum 1.5, weighted 3": the number after `word`.
double vtk_figure(const std::string& text, const std::string& field, const std::string& word) {
  const size_t at = text.find("\n" + field + ": ");
  EXPECT_NE(at, std::string::npos) << field << " in\n" << text;
  return at == std::string::npos ? std::nan("") : std::stod(text.substr(text.find(word + " ", at) + word.size() + 1));
}
/// Sum of values, each weighted by its place in memory from 1.
double weighted(const MatrixX& values) {
  return VectorX::LinSpaced(values.size(), 1, static_cast<double>(values.size())).dot(values.reshaped());
}

TEST(Recovery, StressAtTheHingeRootOfThePendulumIsThatOfCalculiXToThreePercent) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  struct Case {
    int modes;
    Deflection deflection;
    double bound;
  };
  for (const auto& [modes, deflection, bound] :
       {Case{9, Deflection::stiffened, 0.03}, {12, Deflection::stiffened, 0.01}, {12, Deflection::quadratic, 0.01}}) {
    Pendulum scene(model, HingeFrame{model.node_set("hinge")}, modes, {.deflection = deflection});
    const System system = assemble(scene.graph);
    State state = system.initial_state();
    GeneralizedAlpha integrator({.step = 5e-5, .spectral_radius = 0.9});
    Simulation simulation(system, integrator);
    std::printf("%d modes, %s:", modes, deflection == Deflection::stiffened ? "stiffened" : "quadratic");
    // Nonlinear finite elements: tests/data/stress/README.md.
    for (const auto& [t, calculix] : {std::pair{0.1, 74457.0}, {0.15, 105664.0}, {0.2, 84790.0}}) {
      simulation.run(state, t);
      Snapshot now(system, state);
      const double found = root_stress(scene.rod, now);
      std::printf("  %.2f s %.0f Pa (%+.2f %%)", t, found, 100 * (found / calculix - 1));
      EXPECT_NEAR(found / calculix, 1, bound) << t;
    }
    std::printf("\n");
  }
}

/// A bar of 0.2 m hangs along gravity (+x), clamped at x = 0: exact to the mesh of quadratic elements.
struct HangingBar {
  static constexpr double kLength = 0.2, kDensity = 5000, kYoung = 2e8, kGravity = 9.81;
  FiniteElementModel model =
      brick_mesh({.size = {kLength, 0.02, 0.03}, .divisions = {4, 1, 1}, .material = {kYoung, 0, kDensity}});
  SystemGraph graph{{.gravity = {kGravity, 0, 0}}};
  FlexibleBody* bar;

  /// Stretched to `share` of its equilibrium.
  explicit HangingBar(double share = 1) {
    const auto basis = make_basis(model, TangentFrame{model.node_set("x_min")}, kAllNodal);
    VectorX weight(basis->mode_count());
    const VectorX mass = basis->nodal_mass * VectorX::Ones(model.node_count());
    for (int k = 0; k < weight.size(); ++k) {
      const int dof = basis->free_dofs[static_cast<size_t>(k)];
      weight[k] = dof % 3 == 0 ? kGravity * mass[dof / 3] : 0;
    }
    const VectorX eta = share * test::solve_positive(basis->stiffness, weight);
    bar = &graph.add<FlexibleBody>("bar", {.basis = basis, .modal_coordinates = eta});
    const Vector3 foot(0, 0.01, 0.015);
    graph.add<FixedJoint>("clamp", {graph.ground().marker(foot), bar->average(model.node_set("x_min"))});
  }
};

TEST(Recovery, AHangingBarIsPulledByItsWeightBelowAndTheObserverRemembersWhenMost) {
  HangingBar scene;
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  StressObserver observer(*scene.bar);
  EXPECT_NE(message_of<SceneError>([&] { observer.report(); }).find("before any state"), std::string::npos);
  const VectorX hanging = state.q.tail(scene.bar->mode_count());
  for (const auto& [time, share] : {std::pair{0.0, 0.5}, {0.1, 1.0}, {0.2, 0.25}}) {
    state.time = time;
    state.q.tail(scene.bar->mode_count()) = share * hanging;
    Snapshot now(system, state);
    observer.observe(now);
  }
  const double root = scene.kDensity * scene.kGravity * scene.kLength;
  EXPECT_NEAR(observer.extrema().value / root, 1, 1e-9);
  EXPECT_EQ(observer.extrema().time, 0.1);
  const Matrix3X& nodes = scene.model.nodes;
  EXPECT_NEAR(nodes(0, observer.extrema().node), 0, 1e-12);
  for (int i = 0; i < nodes.cols(); ++i)
    EXPECT_NEAR(observer.extrema().largest[i], root * (1 - nodes(0, i) / scene.kLength), 1e-8 * root);
  const std::string report = observer.report(3);
  EXPECT_NE(report.find("'bar' over 3 states, t = 0 to 0.2 s: at most 9.8100e+03 Pa"), std::string::npos) << report;
  EXPECT_NE(report.find("9.8100e+03 Pa at t = 0.1 s"), std::string::npos) << report;
  EXPECT_EQ(std::count(report.begin(), report.end(), '\n'), 4) << report;

  const ScratchFolder folder;
  observer.write_vtu(folder.path("largest.vtu"));
  const std::string text = vtk_text(folder.path("largest.vtu"));
  EXPECT_NEAR(vtk_figure(text, "largest_von_mises", "sum"), observer.extrema().largest.sum(), 1e-6 * root);
  EXPECT_NEAR(vtk_figure(text, "time_of_largest", "sum"), observer.extrema().times.sum(), 1e-9);
}

TEST(Recovery, TheAnimationCarriesStressInTheOrderOfVtkAndInTheAxesOfTheMesh) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  Pendulum scene(model, ThreeNodeFrame{1, 53, 3}, 5);  // x axis slanted: body axes are not those of the mesh
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  state.q.tail(5) = 1e-5 * VectorX::LinSpaced(5, 1, 2);
  Snapshot now(system, state);
  const ScratchFolder folder;
  DeformationWriter writer(scene.rod, folder.path("rod"), {.stress = true, .strain = true});
  writer.observe(now);

  const ModalBasis& basis = scene.rod.basis();
  ASSERT_GT((basis.rotation - Matrix3::Identity()).norm(), 0.01);
  const MatrixX u = basis.rotation * (basis.modes * state.q.tail(5)).reshaped(3, model.node_count());
  const StressRecovery in_mesh_axes(model, u.reshaped());
  Matrix6X stress = in_mesh_axes.stress(VectorX::Ones(1)), strain = in_mesh_axes.strain(VectorX::Ones(1));
  const std::string text = vtk_text(folder.path("rod_0000.vtu"));
  EXPECT_NEAR(vtk_figure(text, "von_mises", "sum") / von_mises(stress).sum(), 1, 1e-8);
  strain.bottomRows<3>() /= 2;
  for (const auto& [name, tensor] : {std::pair{"stress", &stress}, {"strain", &strain}}) {
    tensor->row(4).swap(tensor->row(5));
    EXPECT_EQ(vtk_figure(text, name, std::string(name) + ":"), 6);
    EXPECT_NEAR(vtk_figure(text, name, "weighted") / weighted(*tensor), 1, 1e-7) << name;
  }
  EXPECT_EQ(vtk_figure(text, "displacement", "sum"), 0);  // from the first state
}

TEST(Recovery, AQuadraticBodyIsReadByGreenLagrangeStrainAndForeignRecoveriesAreMatched) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  Pendulum scene(model, HingeFrame{model.node_set("hinge")}, 3, {.deflection = Deflection::stiffened});
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  state.q.tail(3) << 2e-4, 0, 0;
  Snapshot now(system, state);
  const auto finite = std::make_shared<StressRecovery>(scene.rod.basis(), StrainMeasure::green_lagrange);
  const auto small = std::make_shared<StressRecovery>(scene.rod.basis());
  const VectorX usual = von_mises(BodyStress(scene.rod).stress(now));
  EXPECT_EQ(usual, von_mises(BodyStress(scene.rod, finite).stress(now)));
  EXPECT_GT((usual - von_mises(BodyStress(scene.rod, small).stress(now))).norm(), 1e-3 * usual.norm());
  expect_error<SceneError>([&] { BodyStress(scene.rod, std::make_shared<StressRecovery>(MatrixX::Ones(12, 3))); },
                           {"2 nodes", "3 fields"});
}

/// K u = f with the six degrees of freedom of `held` (a statically determinate support) held.
VectorX static_solution(const FiniteElementModel& model, const MatrixX& forces, const std::vector<int>& held) {
  MatrixX K = model.stiffness;
  VectorX f = forces.reshaped();
  for (int dof : held) K.row(dof).setZero(), K.col(dof).setZero(), K(dof, dof) = 1e7, f[dof] = 0;
  return K.ldlt().solve(f);
}

/// The rod in a three-node frame, hung at its hinge edge or by a ball at node 1, with a force beside gravity at its far
/// end and perhaps a torque.
struct LoadedRod {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  FlexibleBody& rod;

  LoadedRod(const FiniteElementModel& model, int modes, bool ball, const Vector3& torque = Vector3::Zero())
      : rod(graph.add<FlexibleBody>("rod", {.basis = make_basis(model, ThreeNodeFrame{1, 13, 2}, modes)})) {
    const std::vector<int>& edge = model.node_set("hinge");
    if (ball)
      graph.add<SphericalJoint>("ball", {graph.ground().marker(), rod.node(1)});
    else
      graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, kAlongY), rod.average(edge, kAlongY)});
    graph.add<PointForce>("push", {rod.node(53)}, {.force = {0.01, 0.02, -0.03}});
    if (!torque.isZero()) graph.add<PointForce>("twist", {rod.node(50)}, {.torque = torque});
  }
};
const std::vector<int> kHeld = {0, 1, 2, 5, 37, 38};  // by the frame: node 1; z of node 2; y, z of node 13

State swung(const System& system, double end) {
  State state = system.initial_state();
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-8, .absolute = 1e-10}});
  Simulation(system, integrator).run(state, end);
  return state;
}

TEST(Recovery, LoadsBackAreInEquilibriumAndTheirStaticSolutionHasTheModalCoordinatesOfTheMotion) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  const Vector3 twist(1e-4, 0, 2e-4);
  for (const auto& [ball, torque] : {std::pair{true, false}, {false, false}, {false, true}})
    for (LoadGeometry geometry : {LoadGeometry::undeformed, LoadGeometry::deformed}) {
      LoadedRod scene(model, 9, ball, torque ? twist : Vector3(0, 0, 0));
      const System system = assemble(scene.graph);
      Snapshot now(system, swung(system, 0.02));
      const NodalLoads loads = nodal_loads(scene.rod, now, geometry);
      const bool deformed = geometry == LoadGeometry::deformed;
      const Matrix3X at = deformed ? Matrix3X(model.nodes + loads.displacements) : model.nodes;
      Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
      for (int i = 0; i < at.cols(); ++i) {
        force += loads.forces.col(i);
        moment += at.col(i).cross(loads.forces.col(i));
      }
      const double scale = loads.forces.cwiseAbs().sum(), moment_scale = 0.1 * scale;
      EXPECT_LT(force.norm(), 1e-12 * scale);
      EXPECT_LT(moment.norm(), 1e-12 * moment_scale);

      // What had to be spread: nothing where forces act on nodes alone and are looked at where these are; of a hinge's
      // torque what the strain of its edge changes; the torque at a single node.
      EXPECT_LT(loads.spread_force.norm(), 1e-10 * scale);
      if (deformed && ball) {
        EXPECT_LT(loads.spread_moment.norm(), 1e-10 * moment_scale);
      }
      if (deformed && !ball) {
        const Matrix3& A = now.body_state(scene.rod).cache->A;
        const Vector3 wanted = A.transpose() * (torque ? twist : Vector3(0, 0, 0));
        EXPECT_LT((loads.spread_moment - wanted).norm(), 1e-5) << loads.spread_moment.transpose();
      }

      const ModalBasis& basis = scene.rod.basis();
      const VectorX u = static_solution(model, loads.forces, kHeld);
      const VectorX eta = scene.rod.field_coordinates(now.body_state(scene.rod));
      const VectorX found = basis.modes.transpose() * (model.mass * u);
      EXPECT_LT((found - eta).norm(), 1e-9 * eta.norm()) << (found - eta).transpose();
      EXPECT_LT((loads.displacements.reshaped() - basis.modes * eta).norm(), 1e-12 * eta.norm());
    }
}

TEST(Recovery, LoadsBackGiveTheDisplacementsOfABodyThatHasAllItsModes) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  LoadedRod scene(model, kAllNodal, false);
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator({.step = 2e-4, .spectral_radius = 0.5});
  Simulation(system, integrator).run(state, 0.02);
  Snapshot now(system, state);
  const NodalLoads loads = nodal_loads(scene.rod, now);
  const VectorX moved = loads.displacements.reshaped();
  EXPECT_LT((static_solution(model, loads.forces, kHeld) - moved).norm(), 1e-9 * moved.norm());
}

TEST(Recovery, LoadsBackOfTwoModesGiveTheStaticDisplacementsOfAllByModeAcceleration) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  const Vector3 gravity(0, 1e-3, -2e-3);  // small: so is the moment of the load on the deformed rod
  const auto basis = make_basis(model, ThreeNodeFrame{1, 13, 2}, 2);
  Matrix3X weight = Matrix3X::Zero(3, model.node_count());
  weight = gravity * (basis->nodal_mass * VectorX::Ones(model.node_count())).transpose();
  const VectorX eta = (basis->modes.transpose() * weight.reshaped()).cwiseQuotient(basis->stiffness.diagonal());
  SystemGraph graph{{.gravity = gravity}};
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = basis, .modal_coordinates = eta});
  graph.add<FixedJoint>("clamp", {graph.ground().marker(), rod.frame()});  // borne where the frame holds nodes
  const System system = assemble(graph);
  Snapshot now(system, system.initial_state());
  const NodalLoads loads = nodal_loads(rod, now);
  const VectorX exact = static_solution(model, weight, kHeld);
  const double with = (static_solution(model, loads.forces, kHeld) - exact).norm() / exact.norm();
  const double without = (loads.displacements.reshaped() - exact).norm() / exact.norm();
  std::printf("two modes: displacements %.2g off, those of the loads %.1e\n", without, with);
  EXPECT_LT(with, 1e-4);
  EXPECT_GT(without, 1e-2);
}

TEST(Recovery, LoadsBackOfRigidAndOfStronglyBentBodiesAreInEquilibriumToo) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  const auto basis = make_basis(model, HingeFrame{model.node_set("hinge")}, 6, {.deflection = Deflection::quadratic});
  for (int modes : {0, 2, 6})
    for (LoadGeometry geometry : {LoadGeometry::undeformed, LoadGeometry::deformed}) {
      SystemGraph graph;
      auto& rod = graph.add<FlexibleBody>("rod", {.basis = basis, .mode_count = modes, .damping = {1, 1e-4}});
      const Marker edge = rod.average(model.node_set("hinge"), kAlongY);
      graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, kAlongY), edge});
      const System system = assemble(graph);
      Snapshot now(system, swung(system, 0.03));
      const NodalLoads loads = nodal_loads(rod, now, geometry);
      const bool deformed = geometry == LoadGeometry::deformed;
      const Matrix3X at = deformed ? Matrix3X(model.nodes + loads.displacements) : model.nodes;
      Vector3 moment = Vector3::Zero();
      for (int i = 0; i < at.cols(); ++i) moment += at.col(i).cross(loads.forces.col(i));
      const double scale = loads.forces.cwiseAbs().sum();
      EXPECT_LT(loads.forces.rowwise().sum().norm(), 1e-12 * scale) << modes;
      EXPECT_LT(moment.norm(), 1e-12 * 0.1 * scale) << modes;
      const VectorX eta = now.state().q.tail(modes);
      if (!deformed && modes > 0) {
        const MatrixX B = basis->modes.leftCols(modes);
        const VectorX work = B.transpose() * loads.forces.reshaped();
        EXPECT_LT((work - VectorX(basis->stiffness.diagonal().head(modes)).cwiseProduct(eta)).norm(),
                  1e-12 * scale * B.cwiseAbs().maxCoeff());
      }
      EXPECT_EQ(BodyStress(rod).stress(now).norm() > 0, modes > 0);  // the modes that are not used rest
    }
}

TEST(Recovery, ACalculixDeckOfLoadsHoldsWhatTwentyColumnsCanAndASupportThatIsDeterminate) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  LoadedRod scene(model, 9, false);
  const System system = assemble(scene.graph);
  Snapshot now(system, swung(system, 0.02));
  const NodalLoads loads = nodal_loads(scene.rod, now);
  const ScratchFolder folder;
  write_calculix_loads(folder.path("loads.inp"), model, loads);

  std::istringstream deck(file_text(folder.path("loads.inp")));
  std::string line;
  std::vector<int> held;
  Matrix3X read = Matrix3X::Zero(3, model.node_count());
  while (std::getline(deck, line)) {
    int node, axis, same;
    if (std::sscanf(line.c_str(), "** %d,%d,%d", &node, &axis, &same) == 3) {
      held.push_back(3 * model.node_index(node) + axis - 1);
    } else if (std::sscanf(line.c_str(), "%d,%d", &node, &axis) == 2) {
      const std::string number = line.substr(line.find(',', line.find(',') + 1) + 1);
      EXPECT_LE(number.size(), 20u);
      read(axis - 1, model.node_index(node)) = std::stod(number);
    }
  }
  EXPECT_EQ(held, kHeld);
  EXPECT_LT((read - loads.forces).cwiseAbs().maxCoeff(), 1e-13 * loads.forces.cwiseAbs().maxCoeff());
  FiniteElementModel other = model;
  other.nodes.conservativeResize(3, 50);
  expect_error<SceneError>([&] { write_calculix_loads(folder.path("other.inp"), other, loads); }, {"54 nodes", "50"});
}

TEST(Recovery, ResultsOfAKilledRunAreCompleteUpToItsLastState) {
  HangingBar scene(0.3);
  const System system = assemble(scene.graph);
  const State start = system.initial_state();
  const ScratchFolder folder;
  const std::string path = folder.path("bar.h5");
  const std::vector<int> root = {scene.model.node_set("x_min").front(), scene.model.node_set("x_max").front()};
  const auto observe = [&](ResultWriter& results, int k) {
    State state = start;
    state.time = 0.1 * k;
    state.q.tail(scene.bar->mode_count()) *= k;
    Snapshot now(system, state);
    results.observe(now);
  };
  const pid_t child = fork();
  if (child == 0) {
    ResultWriter results(*scene.bar, path, {.positions = true, .stress = true, .stress_nodes = root});
    for (int k = 0; k < 3; ++k) observe(results, k);
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << "the writer ended by itself";
  for (bool killed : {true, false}) {
    if (!killed) {
      ResultWriter results(*scene.bar, path, {.positions = true, .stress = true, .stress_nodes = root});
      for (int k = 0; k < 3; ++k) observe(results, k);
    }
    const Hdf5Reader file(path);
    const MatrixX time = file.matrix("/time", 1), stress = file.matrix("/stress", 12, 3);
    EXPECT_EQ(time, MatrixX(Eigen::RowVector3d(0, 0.1, 0.2)));
    const double full = 0.3 * scene.kDensity * scene.kGravity * scene.kLength;
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(stress(0, k), k * full, 1e-8 * full);
      EXPECT_NEAR(stress(6, k), 0, 1e-8 * full);  // the free end
      EXPECT_EQ(file.matrix("/eta").col(k), k * start.q.tail(scene.bar->mode_count()));
    }
    EXPECT_EQ(file.integers("/stress_node_ids"), root);
    const MatrixX position = file.matrix("/position", 3 * scene.model.node_count(), 3);
    EXPECT_LT((position.col(0) - scene.model.nodes.reshaped()).norm(), 1e-12);
    EXPECT_EQ(file.matrix("/frame", 7, 3)(3, 1), 1);
    EXPECT_EQ(file.matrix("/von_mises", 2, 3).cols(), 3);
  }
  EXPECT_EQ(folder.file_count(), 1);
  expect_error<SceneError>(
      [&] { ResultWriter(*scene.bar, folder.path("no.h5"), {.stress = true, .stress_nodes = {99999}}); }, {"99999"});
  EXPECT_EQ(folder.file_count(), 1);
  expect_error<FileError>([&] { ResultWriter(*scene.bar, path + "/no.h5"); }, {"bar.h5/no.h5"});
}

TEST(Recovery, TablesGoToHdf5AndBackBitByBit) {
  const ScratchFolder folder;
  Table table{.columns = {"t", "tip, z", "ψ"}};
  table.add_row({0, 1.0 / 3, -1e-300});
  table.add_row({0.1, M_PI, 1e300});
  write_hdf5(table, folder.path("table.h5"));
  const Table back = read_hdf5_table(folder.path("table.h5"));
  EXPECT_EQ(back.columns, table.columns);
  EXPECT_EQ(back.values, table.values);
  write_hdf5({.columns = {"t"}}, folder.path("empty.h5"));
  EXPECT_EQ(read_hdf5_table(folder.path("empty.h5")).row_count(), 0);
  expect_error<SceneError>([&] { write_hdf5({}, folder.path("none.h5")); }, {"no columns"});
  const std::string text = file_text(folder.path("table.h5"));
  write_text(folder.path("cut.h5"), text.substr(0, text.size() / 2));
  expect_error<FileError>([&] { read_hdf5_table(folder.path("cut.h5")); }, {"cut.h5"});
  std::string damaged = text;
  const double pi = M_PI;
  damaged[damaged.find(std::string(reinterpret_cast<const char*>(&pi), sizeof pi))] ^= 1;
  write_text(folder.path("damaged.h5"), damaged);
  expect_error<FileError>([&] { read_hdf5_table(folder.path("damaged.h5")); }, {"damaged.h5", "/values", "checksum"});
}

}  // namespace
}  // namespace lithe::test::recovery_test
