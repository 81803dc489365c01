#include "bodies/flexible/cut_load.h"

#include "bodies/flexible/elements/meshes.h"
#include "engine/analysis/equilibrium.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/revolute_joint.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"

namespace lithe::test::cut_load_test {
namespace {

constexpr double kLength = 1, kWidth = 0.05, kHeight = 0.04, kDensity = 5000;
const Vector3 kMiddle(0.5, kWidth / 2, kHeight / 2);    // on the axis, where elements meet
const Matrix3 kBack = rotation_about({0, 0, 1}, M_PI);  // axis 1 towards the root: the free end is cut off

FiniteElementModel bar(const std::string& type, int along = 8) {
  return brick_mesh(
      {.size = {kLength, kWidth, kHeight}, .divisions = {along, 1, 1}, .type = type, .material = {2e9, 0.3, kDensity}});
}

/// Held at x = 0.
struct Cantilever {
  FiniteElementModel model;
  SystemGraph graph;
  FlexibleBody& body;
  Cantilever(FiniteElementModel mesh, const Vector3& gravity, int modes = kAllNodal, const Reduction& reduction = {})
      : model(std::move(mesh)),
        graph({.gravity = gravity}),
        body(graph.add<FlexibleBody>(
            "bar", {.basis = make_basis(model, TangentFrame{model.node_set("x_min")}, modes, reduction)})) {
    graph.add<FixedJoint>("clamp",
                          {graph.ground().marker({0, kMiddle[1], kMiddle[2]}), body.average(model.node_set("x_min"))});
  }
};

/// Σ_i Σ_j m_ij a_j over the nodes i for which `counts`, and the moment about a point; mesh axes.
template <class Counts>
Vector6 inertia_of(const ModalBasis& basis, const Matrix3X& accelerations, const Vector3& about, Counts&& counts) {
  const Matrix3X forces = accelerations * basis.nodal_mass;
  Vector6 sum = Vector6::Zero();
  for (int i = 0; i < forces.cols(); ++i) {
    const Vector3 r = basis.rotation * basis.nodes.col(i) + basis.origin;
    if (!counts(r)) continue;
    sum.head<3>() += forces.col(i);
    sum.tail<3>() += (r - about).cross(Vector3(forces.col(i)));
  }
  return sum;
}

/// Of a cut with the axes kBack.
Vector6 in_mesh_axes(const Vector6& load) {
  Vector6 turned;
  turned << kBack * load.head<3>(), kBack * load.tail<3>();
  return turned;
}

double relative(const Vector6& found, const Vector6& wanted) { return (found - wanted).norm() / wanted.norm(); }

/// Both parts of a cut, in the axes of each: of the part at the root they are those of the world.
TEST(CutLoad, IsWhatStaticsSayOfACantileverUnderALoadAtItsEnd) {
  const Vector3 F(0.04, -0.007, 0.003), T(5e-4, 8e-4, -3e-4), arm = Vector3(kLength, kMiddle[1], kMiddle[2]) - kMiddle;
  for (const char* type : {"C3D8I", "C3D10", "C3D20"}) {
    SCOPED_TRACE(type);
    Cantilever scene(bar(type), Vector3::Zero());
    const Marker end = scene.body.average(scene.model.node_set("x_max"));
    scene.graph.add<PointForce>("load", {end}, {.force = F, .torque = T});
    const System system = assemble(scene.graph);
    Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
    const Vector6 root = CutLoad(scene.body, {.point = kMiddle}).load(now);
    Vector6 wanted;
    wanted << F, T + arm.cross(F);
    expect_below("load of the cut", relative(root, wanted), 1e-7);
    const CutLoad other(scene.body, {.point = kMiddle, .axes = kBack});
    expect_below("both parts", relative(-in_mesh_axes(other.load(now)), wanted), 1e-7);
    // The same part by its nodes.
    std::vector<int> ids;
    for (int i = 0; i < scene.model.node_count(); ++i)
      if (scene.model.nodes(0, i) < 0.5 + 1e-9) ids.push_back(scene.model.node_ids[static_cast<std::size_t>(i)]);
    EXPECT_EQ(CutLoad(scene.body, {.point = kMiddle, .nodes = ids}).load(now), root);
    EXPECT_GE(other.nodes().size(), 4u);
  }
}

TEST(CutLoad, CarriesTheWeightBeyond) {
  const Vector3 g(9.81, -2, 4);
  Cantilever scene(bar("C3D20"), g);
  const System system = assemble(scene.graph);
  Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
  const ModalBasis& basis = scene.body.basis();
  const Matrix3X weight = g.replicate(1, basis.nodes.cols());
  const Vector6 with_cut = inertia_of(basis, weight, kMiddle, [](const Vector3& r) { return r[0] > 0.5 - 1e-9; });
  const Vector6 without = inertia_of(basis, weight, kMiddle, [](const Vector3& r) { return r[0] > 0.5 + 1e-9; });
  const Vector6 root = CutLoad(scene.body, {.point = kMiddle}).load(now);
  const Vector6 end = -in_mesh_axes(CutLoad(scene.body, {.point = kMiddle, .axes = kBack}).load(now));
  expect_below("part at the root", relative(root, with_cut), 1e-7);
  expect_below("part at the end", relative(end, without), 1e-7);
  // Their mean: ρ A g (L - s), and ρ A g (L - s)²/2 of the moment, to second order in the elements.
  const Vector6 mean = 0.5 * (root + end);
  const double line = kDensity * kWidth * kHeight;
  expect_below("weight", (mean.head<3>() - line * 0.5 * g).norm() / (line * 0.5 * g.norm()), 1e-7);
  expect_below("bending", std::abs(mean[5] / (line * g[1] * 0.125) - 1), 1e-3);
}

TEST(CutLoad, OfASpinningBarIsTheCentrifugalForce) {
  const double spin = 3;
  Cantilever still(bar("C3D8", 32), Vector3::Zero());
  const auto basis = make_basis(still.model, TangentFrame{still.model.node_set("x_min")}, kAllNodal);
  // η of the centrifugal forces ω² m x; what the stretch adds to them is of second order in ω².
  VectorX load = VectorX::Zero(basis->mode_count());
  const Matrix3X places = (basis->rotation * basis->nodes).colwise() + basis->origin;
  const Matrix3X radii = Vector3(1, 1, 0).asDiagonal() * (places.colwise() - Vector3(0, kMiddle[1], 0));
  const VectorX forces = (spin * spin * radii * basis->nodal_mass).reshaped();
  for (int k = 0; k < load.size(); ++k) load[k] = forces[basis->free_dofs[static_cast<std::size_t>(k)]];
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& body = graph.add<FlexibleBody>(
      "bar",
      {.basis = basis, .angular_velocity = {0, 0, spin}, .modal_coordinates = solve_sparse(basis->stiffness, load)});
  const System system = assemble(graph);
  Snapshot now(system, system.initial_state());
  for (const double s : {0.25, 0.5, 0.75}) {
    const Vector3 point(s, kMiddle[1], kMiddle[2]);
    const double found = 0.5 * (CutLoad(body, {.point = point}).load(now)[0] +
                                CutLoad(body, {.point = point, .axes = kBack}).load(now)[0]);
    const double wanted = 0.5 * kDensity * kWidth * kHeight * spin * spin * (1 - s * s);
    expect_below("N at " + std::to_string(s), std::abs(found / wanted - 1), 1e-3);
  }
}

/// The cut-off end of a swinging bar: the load of the cut is what its mass, moving so, needs beside its weight.
TEST(CutLoad, IsThatOfDAlembertWhileTheBodySwings) {
  const Vector3 g(0, -9.81, 0);
  const FiniteElementModel model = bar("C3D8I", 6);
  SystemGraph graph{{.gravity = g}};
  auto& body = graph.add<FlexibleBody>(
      "bar",
      {.basis = make_basis(model, TangentFrame{model.node_set("x_min")}, kAllNodal), .angular_velocity = {0, 0, -2}});
  graph.add<RevoluteJoint>("hinge",
                           {graph.ground().marker({0, kMiddle[1], kMiddle[2]}), body.average(model.node_set("x_min"))});
  const System system = assemble(graph);
  State state = system.initial_state();
  const Method method = index3(5e-4);
  Simulation(system, *method).run(state, 0.05);
  Snapshot now(system);
  now.evaluate(state, Accelerations::solved);
  const BodyState at = now.body_state(body);
  const auto motion = body.nodal_motion(at, now.accelerations().data() + system.layout().slice(body).v);
  const Matrix3X needed = at.cache->A.transpose() * (motion.acceleration.colwise() - g);
  const Vector6 wanted = inertia_of(body.basis(), needed, kMiddle, [](const Vector3& r) { return r[0] > 0.5 + 1e-9; });
  const Vector6 found = in_mesh_axes(CutLoad(body, {.point = kMiddle, .axes = kBack}).load(now));
  EXPECT_GT(wanted.norm(), 1);
  expect_below("D'Alembert", relative(found, wanted), 1e-6);
}

/// Bent by a tenth of its length: the loads are those of the bent bar, where small strain would see it stretched.
TEST(CutLoad, OfAQuadraticDeflectionHasTheTermsOfSecondOrder) {
  for (const char* type : {"C3D8I", "C3D20"}) {
    const FiniteElementModel mesh = bar(type);
    Cantilever scene(mesh, Vector3::Zero(), 2,
                     {.loaded = {{mesh.node_set("x_max")}}, .deflection = Deflection::quadratic});
    const Marker end = scene.body.average(mesh.node_set("x_max"));
    const Vector3 F(0, 0, 50);
    scene.graph.add<PointForce>("load", {end}, {.force = F});
    const System system = assemble(scene.graph);
    Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
    const double sag = now.marker(end).p[2] - kMiddle[2];
    EXPECT_GT(sag, 0.02);
    const CutLoad cut(scene.body, {.point = kMiddle});
    const Vector6 load = cut.load(now);
    Vector3 place = Vector3::Zero();  // of the cut's nodes
    const auto motion = scene.body.nodal_motion(now.body_state(scene.body), system.initial_state().v_dot.data());
    for (const int id : cut.nodes())
      place += motion.position.col(mesh.node_index(id)) / static_cast<double>(cut.nodes().size());
    const double arm = now.marker(end).p[0] - place[0];
    std::printf("%s: sag %.4f m, n_1 %.3f N, n_3 %.3f N, m_2 %.4f N m, wanted %.4f (undeformed %.4f)\n", type, sag,
                load[0], load[2], load[4], -arm * F[2], -0.5 * F[2]);
    EXPECT_LT(std::abs(load[0]), 0.02 * F[2]) << type;
    EXPECT_NEAR(load[2] / F[2], 1, 5e-3) << type;
    EXPECT_NEAR(load[4] / (-arm * F[2]), 1, 1e-3) << type;
  }
}

TEST(CutLoad, IsASensorAndSaysWhatIsWrong) {
  Cantilever scene(bar("C3D8"), {0, 0, -9.81}, 4);
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  Recorder recorder({cut_load(scene.body, {.point = kMiddle}, "middle")});
  Snapshot now(system, state);
  recorder.observe(now);
  EXPECT_EQ(recorder.table().columns, (std::vector<std::string>{"t", "middle_n_1", "middle_n_2", "middle_n_3",
                                                                "middle_m_1", "middle_m_2", "middle_m_3"}));
  const auto refused = [&](const BodyCut& cut) { return message_of<SceneError>([&] { CutLoad(scene.body, cut); }); };
  expect_says(refused({.point = {2, 0, 0}}), {"a cut of 'bar'", "share none", "cut inside the body"});
  expect_says(refused({.point = kMiddle, .nodes = {1, 9999}}), {"9999"});
  expect_says(refused({.point = kMiddle, .axes = 2 * Matrix3::Identity()}), {"axes"});
  expect_says(refused({.point = {std::nan(""), 0, 0}}), {"point"});

  const CutLoad before(scene.body, {.point = kMiddle});
  scene.body.set_fidelity({.modes = {0, 2}});
  const System reduced = assemble(scene.graph);
  Snapshot later(reduced, reduced.initial_state());
  expect_says(message_of<SceneError>([&] { before.load(later); }), {"other modes", "after set_fidelity()"});
  EXPECT_TRUE(CutLoad(scene.body, {.point = kMiddle}).load(later).allFinite());
}

}  // namespace
}  // namespace lithe::test::cut_load_test
