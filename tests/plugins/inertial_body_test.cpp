// The solid of bricks against what is known of solids: rigid motion, patch test, energy, the matrices, frequencies and
// motion of CalculiX' C3D8I, the elastica; and what every body and every joint owes.
#include "plugins/inertial_body/inertial_body.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/assembly/batch_of.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/base/error.h"
#include "engine/output/csv.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/radau.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/three_node_fixation.h"
#include "tests/support/body_checks.h"
#include "tests/support/joint_checks.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/motion.h"

namespace lithe::test::inertial_body_test {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

const std::string kPendulum = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/";

BrickMesh pendulum_mesh(const std::string& body) {
  return read_brick_mesh(kPendulum + body + "/calculix/matrices.inp");
}
std::shared_ptr<const BrickMesh> shared(BrickMesh mesh) { return std::make_shared<const BrickMesh>(std::move(mesh)); }

/// A block whose nodes are shaken, so that no brick is a cuboid.
BrickMesh distorted_block(const std::array<int, 3>& divisions, const Solid& material, double shake = 0.15,
                          BrickType type = BrickType::incompatible_modes) {
  const Vector3 size(divisions[0], divisions[1], divisions[2]);
  BrickMesh mesh = brick_block(size, divisions, material, type);
  RandomNumbers random(3);
  mesh.nodes += random.matrix3x(mesh.node_count(), shake);
  return mesh;
}

/// A body on its own, without an engine around it.
struct Alone {
  InertialBody body;
  std::unique_ptr<BodyCache> cache;
  VectorX q, v;
  explicit Alone(InertialBody::Parameters parameters) : body(std::move(parameters)), cache(body.make_cache()) {
    q.setZero(3 * body.node_count()), v = q;
    body.initial_state(q, v);
  }
  int size() const { return static_cast<int>(q.size()); }
  BodyState at(const VectorX& position, const VectorX& velocity) {
    const BodyState state{position.data(), velocity.data(), cache.get()};
    body.evaluate(state, Level::velocity);
    return state;
  }
  BodyState at(const VectorX& position) { return at(position, v); }
  VectorX force(const VectorX& position, const VectorX& velocity) {  // internal, on the left-hand side
    const BodyState state = at(position, velocity);
    VectorX r = VectorX::Zero(size());
    const VectorX still = r;
    body.add_residual(state, still.data(), Vector3::Zero(), r.data());
    return r;
  }
  VectorX force(const VectorX& position) { return force(position, VectorX::Zero(size())); }
  double energy(const VectorX& position) { return body.energy(at(position), Vector3::Zero()).elastic; }
  SparseMatrix tangent(const VectorX& position, const TangentWeights& weights) {
    const BodyState state = at(position);
    const LinearPattern& pattern = *body.coordinates().pattern;
    VectorX values = VectorX::Zero(pattern.rows.size());
    BodyTangent S{Eigen::Map<Matrix6>(nullptr), Eigen::Map<Matrix6X>(nullptr, 6, 0), Eigen::Map<MatrixX>(nullptr, 0, 6),
                  Eigen::Map<VectorX>(values.data(), values.size())};
    body.add_tangent(state, v.data(), Vector3::Zero(), weights, S);
    std::vector<Eigen::Triplet<double>> entries;
    for (int k = 0; k < values.size(); ++k) {
      entries.emplace_back(pattern.rows[k], pattern.columns[k], values[k]);
      if (pattern.rows[k] != pattern.columns[k]) entries.emplace_back(pattern.columns[k], pattern.rows[k], values[k]);
    }
    SparseMatrix full(size(), size());
    full.setFromTriplets(entries.begin(), entries.end());
    return full;
  }
  SparseMatrix stiffness(const VectorX& position) { return tangent(position, {1, 0, 0}); }
  SparseMatrix mass() { return tangent(q, {0, 0, 1}); }
};

/// Positions of all nodes at rest, some held where they are, under the weight and dead loads on nodes.
VectorX at_rest(const std::shared_ptr<const BrickMesh>& mesh, const std::vector<int>& held, const Vector3& gravity,
                const std::vector<int>& loaded, const Vector3& load, int most_iterations) {
  SystemGraph graph{{.gravity = gravity}};
  auto& solid = graph.add<InertialBody>("solid", {.mesh = mesh});
  for (int id : held)
    graph.add<SphericalJoint>("held " + std::to_string(id),
                              {graph.ground().marker(mesh->nodes.col(mesh->node_index(id))), solid.node(id)});
  for (int id : loaded) graph.add<PointForce>("load " + std::to_string(id), {solid.node(id)}, {.force = load});
  const System system = assemble(graph);
  const Equilibrium rest = find_equilibrium(system, system.initial_state());
  EXPECT_LE(rest.iterations, most_iterations);
  return rest.state.q;
}

MatrixX read_mtx(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  while (std::getline(in, line) && line.starts_with('%')) {
  }
  int rows, columns, count, i, j;
  std::istringstream(line) >> rows >> columns >> count;
  MatrixX A = MatrixX::Zero(rows, columns);
  for (double value; in >> i >> j >> value;) A(i - 1, j - 1) = A(j - 1, i - 1) = value;
  return A;
}

double relative(const MatrixX& got, const MatrixX& want) {
  return (got - want).cwiseAbs().maxCoeff() / want.cwiseAbs().maxCoeff();
}

VectorX moved(const VectorX& q, const Matrix3& A, const Vector3& by) {
  VectorX x = q;
  for (int i = 0; i < q.size() / 3; ++i) x.segment<3>(3 * i) = by + A * q.segment<3>(3 * i);
  return x;
}

const Solid kSoft{.young = 1e5, .poisson = 0.3, .density = 1000};

TEST(InertialBody, rigid_motion_however_large_strains_nothing) {
  Alone solid({.mesh = shared(distorted_block({2, 2, 1}, kSoft))});
  RandomNumbers random(5);
  for (int k = 0; k < 5; ++k) {
    const VectorX x = moved(solid.q, random.rotation(), random.vector3(100));
    const double stiff = kSoft.young;  // times metres: the scale of its forces
    EXPECT_LT(solid.force(x).cwiseAbs().maxCoeff(), 1e-12 * 100 * stiff);
    EXPECT_LT(solid.energy(x), 1e-24 * 1e4 * stiff);
  }
}

TEST(InertialBody, distorted_bricks_pass_the_patch_test_at_large_strain) {
  for (const BrickType type : {BrickType::incompatible_modes, BrickType::plain}) {
    Alone solid({.mesh = shared(distorted_block({2, 2, 2}, kSoft, 0.2, type))});
    RandomNumbers random(11);
    Matrix3 F = random.rotation();
    F *= Matrix3::Identity() + 0.15 * Matrix3(random.matrix3x(3));
    const VectorX x = moved(solid.q, F, random.vector3(1));
    const Matrix3 E = 0.5 * (F.transpose() * F - Matrix3::Identity());
    const Matrix3 S = kSoft.lambda() * E.trace() * Matrix3::Identity() + 2 * kSoft.mu() * E;
    const Matrix3 sigma = F * S * F.transpose() / F.determinant();
    const BodyState state = solid.at(x);
    const auto matrix = [](const Vector6& s) {
      Matrix3 A;
      A << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
      return A;
    };
    for (const auto& field : {solid.body.stress(state), solid.body.nodal_stress(state)})
      for (int i = 0; i < field.cauchy.cols(); ++i) {
        ASSERT_LT(relative(matrix(field.cauchy.col(i)), sigma), 1e-12);
        ASSERT_LT(relative(matrix(field.second_piola_kirchhoff.col(i)), S), 1e-12);
        ASSERT_LT(relative(matrix(field.strain.col(i)), E), 1e-12);
      }
    // The node in the middle carries no load.
    const int middle = 13;
    const VectorX f = solid.force(x);
    EXPECT_LT(f.segment<3>(3 * middle).norm(), 1e-12 * f.cwiseAbs().maxCoeff());
  }
}

TEST(InertialBody, force_is_the_gradient_of_strain_energy_and_stiffness_the_gradient_of_force) {
  for (const BrickType type : {BrickType::incompatible_modes, BrickType::plain}) {
    Alone solid({.mesh = shared(distorted_block({2, 1, 1}, kSoft, 0.15, type))});
    RandomNumbers random(2);
    VectorX x = moved(solid.q, random.rotation(), random.vector3(1));
    x += random.vector(solid.size(), 0.12);
    const VectorX f = solid.force(x);
    const MatrixX K = solid.stiffness(x);
    VectorX slope(solid.size());
    MatrixX differenced(solid.size(), solid.size());
    for (int i = 0; i < solid.size(); ++i) {
      const VectorX e = VectorX::Unit(solid.size(), i);
      slope[i] = derivative([&](double t) { return solid.energy(x + t * e); });
      differenced.col(i) = derivative([&](double t) -> VectorX { return solid.force(x + t * e); });
    }
    EXPECT_LT(relative(f, slope), 1e-9);
    EXPECT_LT(relative(K, differenced), 1e-9);
  }
}

TEST(InertialBody, stiffness_damping_is_blind_to_rigid_motion_and_takes_energy) {
  const double beta = 0.02;
  Alone solid({.mesh = shared(distorted_block({2, 1, 1}, kSoft)), .stiffness_damping = beta});
  Alone elastic({.mesh = shared(distorted_block({2, 1, 1}, kSoft))});
  RandomNumbers random(4);
  const int n = solid.size();
  const VectorX v = random.vector(n);
  // At rest it is β K.
  EXPECT_LT(relative(solid.force(solid.q, v), beta * (elastic.stiffness(solid.q) * v)), 1e-10);
  for (int k = 0; k < 3; ++k) {
    VectorX x = moved(solid.q, random.rotation(), random.vector3(1)) + random.vector(n, 0.1);
    const VectorX damping = solid.force(x, v) - solid.force(x);
    EXPECT_GT(damping.dot(v), 0);
    // The tangent's velocity part.
    const MatrixX D = solid.tangent(x, {0, 1, 0});
    EXPECT_LT(relative(damping, D * v), 1e-10);
    const Vector3 drift = random.vector3(1), spin = random.vector3(1);
    VectorX rigid(n);
    for (int i = 0; i < n / 3; ++i) rigid.segment<3>(3 * i) = drift + spin.cross(Vector3(x.segment<3>(3 * i)));
    EXPECT_LT((solid.force(x, rigid) - solid.force(x)).norm(), 1e-11 * damping.norm());
  }
}

TEST(InertialBody, has_the_matrices_of_calculix_at_rest) {
  for (const std::string name : {"hex8i", "stiff", "paper"}) {
    Alone solid({.mesh = shared(pendulum_mesh(name))});
    EXPECT_LT(relative(solid.stiffness(solid.q), read_mtx(kPendulum + name + "/K.mtx")), 1e-10) << name;
    EXPECT_LT(relative(solid.mass(), read_mtx(kPendulum + name + "/M.mtx")), 1e-10) << name;
    EXPECT_NEAR(solid.body.mass(), 0.26, 1e-7);
  }
}

TEST(InertialBody, rings_at_the_frequencies_of_its_supports) {
  // frequencies.csv: mode, then Hz for the supports free, hinged, clamped ...; 0 for rigid modes, blank past the last.
  std::vector<std::array<double, 3>> table;
  std::ifstream in(kPendulum + "hex8i/frequencies.csv");
  std::string line;
  std::getline(in, line);
  ASSERT_TRUE(line.starts_with("mode,free,hinged,clamped,"));
  while (std::getline(in, line) && table.size() < 12) {
    auto& row = table.emplace_back();
    ASSERT_EQ(std::sscanf(line.c_str(), "%*d,%lf,%lf,%lf", &row[0], &row[1], &row[2]), 3);
  }
  const BrickMesh mesh = pendulum_mesh("hex8i");
  Alone solid({.mesh = shared(mesh)});
  const char* sets[] = {"", "hinge", "root_face"};
  for (int support = 0; support < 3; ++support) {
    const std::string set = sets[support];
    std::vector<char> held(solid.size(), 0);
    if (!set.empty())
      for (int id : mesh.node_set(set))
        for (int i = 0; i < 3; ++i) held[3 * mesh.node_index(id) + i] = 1;
    std::vector<int> free;
    for (int i = 0; i < solid.size(); ++i)
      if (!held[i]) free.push_back(i);
    const MatrixX K = MatrixX(solid.stiffness(solid.q))(free, free), M = MatrixX(solid.mass())(free, free);
    const VectorX squares = symmetric_eigenvalues(K, M);  // ω²
    int elastic = 0;
    for (std::size_t k = 0; k < table.size(); ++k) {
      const double hertz = table[k][support];
      if (hertz == 0) continue;
      ++elastic;
      EXPECT_NEAR(std::sqrt(squares[k]) / (2 * M_PI) / hertz, 1, 1e-8) << "'" << set << "' mode " << k + 1;
    }
    EXPECT_GE(elastic, 6);
  }
}

TEST(InertialBody, hangs_from_a_clamp_as_nonlinear_finite_elements_do) {
  const BrickMesh mesh = pendulum_mesh("hex8i");
  Alone solid({.mesh = shared(mesh)});
  const VectorX x = at_rest(shared(mesh), mesh.node_set("root_face"), {0, 0, -9.81}, {}, {}, 8);
  const int tip = 3 * mesh.node_index(mesh.node_set("tip").front());
  const int middle = 3 * mesh.node_index(mesh.node_set("mid").front());
  // statics.csv of the reference: clamped, -z, nlgeom; CalculiX confirms seven digits.
  EXPECT_NEAR(x[tip] - solid.q[tip], -1.648300075311775e-03, 1e-12);
  EXPECT_NEAR(x[tip + 2] - solid.q[tip + 2], -1.023116418221747e-02, 1e-12);
  EXPECT_NEAR(x[middle + 2] - solid.q[middle + 2], -3.561845790931027e-03, 1e-12);
}

TEST(InertialBody, a_slender_cantilever_is_the_elastica) {
  // 100 bricks in a row, L/h = 100, no lateral contraction; dead transverse load at the tip (F09, Bisshopp & Drucker).
  const double L = 1, h = 0.01;
  const Solid steel{.young = 2e11, .poisson = 0, .density = 7800};
  const BrickMesh mesh = brick_block({L, h, h}, {100, 1, 1}, steel);
  const double EI = steel.young * h * h * h * h / 12;
  const struct {
    double load, angle, deflection, shortening;
  } table[] = {{1, 0.46135194971187896071, 0.30172077379981352954, 0.056433236283376883091},
               {5, 1.2153681176116810959, 0.71379152361191272809, 0.38762836072442987186},
               {10, 1.4302855388038575290, 0.81060902488029645323, 0.55499559775375126957}};
  for (const auto& row : table) {
    const auto& end = mesh.node_set("x1");
    const Vector3 load(0, 0, row.load * EI / (L * L) / static_cast<double>(end.size()));
    const VectorX x = at_rest(shared(mesh), mesh.node_set("x0"), {0, 0, 0}, end, load, 20);
    Vector3 tip(-L, -h / 2, -h / 2);
    for (int id : end) tip += x.segment<3>(3 * mesh.node_index(id)) / static_cast<double>(end.size());
    EXPECT_NEAR(tip.z() / L / row.deflection, 1, 3e-4) << row.load;
    EXPECT_NEAR(-tip.x() / L / row.shortening, 1, 3e-4) << row.load;
    const int low = 3 * mesh.node_index(mesh.node_set("x1").front()), high = 3 * mesh.node_index(end.back());
    const Vector3 across = x.segment<3>(high) - x.segment<3>(low);  // bottom to top
    EXPECT_NEAR(std::atan2(-across.x(), across.z()) / row.angle, 1, 3e-4) << row.load;
  }
}

/// A rod of L/h = 200, held at one end, under a sudden millinewton at the other.
struct SlenderRod {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  Marker end;
  explicit SlenderRod(double stiffness_damping) {
    const BrickMesh mesh = brick_block({1, 0.005, 0.005}, {100, 1, 1}, {.young = 2e11, .poisson = 0, .density = 7800});
    auto& rod = graph.add<InertialBody>("rod", {.mesh = shared(mesh), .stiffness_damping = stiffness_damping});
    for (int id : mesh.node_set("x0"))
      graph.add<SphericalJoint>("held " + std::to_string(id),
                                {graph.ground().marker(mesh.nodes.col(mesh.node_index(id))), rod.node(id)});
    for (int id : mesh.node_set("x1"))
      graph.add<PointForce>("load " + std::to_string(id), {rod.node(id)}, {.force = {0, 0, 0.25e-3}});
    end = rod.average(mesh.node_set("x1"));
  }
  /// How far the end has moved.
  double run(Integrator& method, double time) {
    const System system = assemble(graph);
    Evaluator equations(system);
    State state = system.initial_state();
    method.start(equations, state);
    while (state.time < time) {
      const StepResult result = method.step(equations, state, time);
      EXPECT_TRUE(result.ok()) << result.why;
      if (!result.ok()) break;
    }
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    return marker_kinematics(equations, end, Level::position).p.z() - 0.0025;
  }
};

TEST(InertialBody, loaded_at_once_takes_the_steps_that_it_is_given) {
  // What its stiff modes would make of the start is no motion.
  double tip[2];
  for (const int finer : {0, 1}) {
    const int steps = finer ? 200 : 20;
    GeneralizedAlpha integrator({.step = 0.02 / steps});
    tip[finer] = SlenderRod(0).run(integrator, 0.02);
    EXPECT_EQ(integrator.statistics().steps, steps);
    EXPECT_EQ(integrator.statistics().rejected, 0);
    EXPECT_LE(integrator.statistics().newton_iterations, 3 * steps);
  }
  EXPECT_NEAR(tip[1], 5.82e-6, 0.01e-6);  // Radau at 1e-6: 5.8215e-6
  EXPECT_NEAR(tip[0] / tip[1], 1, 0.03);
}

TEST(InertialBody, loaded_at_once_takes_the_steps_that_accuracy_asks_whatever_its_damping) {
  // 35, 21 and 8 steps when written.
  for (const double damping : {0.0, 1e-4, 1e-2}) {
    Radau radau({.tolerance = {.relative = 1e-4, .absolute = 1e-6}});
    const double tip = SlenderRod(damping).run(radau, 0.1);
    EXPECT_LE(radau.statistics().steps, 100) << damping;
    if (damping < 1e-3) {
      EXPECT_NEAR(tip, 58.7e-6, 0.3e-6) << damping;  // generalized-alpha, 1 ms: 58.75, 58.63
    }
  }
}

TEST(InertialBody, in_free_flight_keeps_momenta_and_energy) {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& solid = graph.add<InertialBody>(
      "solid",
      {.mesh = shared(distorted_block({2, 1, 1}, kSoft)), .velocity = {1, 2, 3}, .angular_velocity = {1.5, -2, 2.5}});
  const System system = assemble(graph);
  Evaluator equations(system);
  State state = system.initial_state();
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-10, .absolute = 1e-10}});
  integrator.start(equations, state);
  const auto look = [&] {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    return body_state(equations, solid);
  };
  const Vector3 push = solid.linear_momentum(look()), turn = solid.angular_momentum(look());
  const double energy = equations.energy().total();
  double strained = 0;
  for (int k = 1; k <= 10; ++k) {
    while (state.time < 0.1 * k) ASSERT_TRUE(integrator.step(equations, state, 0.1 * k).ok());
    const BodyState now = look();
    EXPECT_LT((solid.linear_momentum(now) - push).norm(), 1e-11 * push.norm());
    EXPECT_LT((solid.angular_momentum(now) - turn).norm(), 1e-8 * turn.norm());
    EXPECT_NEAR(equations.energy().total() / energy, 1, 1e-8);
    strained = std::max(strained, equations.energy().elastic);
  }
  EXPECT_GT(strained, 1e-3 * energy);  // it did stretch
}

TEST(InertialBody, owes_what_every_body_owes) {
  SystemGraph graph;
  const BrickMesh mesh = distorted_block({2, 1, 1}, kSoft);
  auto& solid = graph.add<InertialBody>(
      "solid", {.mesh = shared(mesh), .position = {1, 2, 3}, .orientation = RandomNumbers(1).rotation()});
  const Matrix3 turned = RandomNumbers(6).rotation();
  const std::vector<Marker> markers = {
      solid.node(5),         solid.node(12, turned), solid.average(mesh.node_set("x1"), turned),
      solid.average({1, 2}), solid.average({3}),     solid.average({1, 4, 8, 12})};
  check_body(graph, solid, markers, {.mass = solid.mass(), .deformation = 0.02});
}

TEST(InertialBody, with_damping_loses_energy) {
  SystemGraph graph;
  auto& solid = graph.add<InertialBody>(
      "solid", {.mesh = shared(distorted_block({2, 1, 1}, kSoft)), .mass_damping = 0.5, .stiffness_damping = 0.01});
  check_body(graph, solid, {}, {.mass = solid.mass(), .deformation = 0.02, .dissipation = 1});
}

/// Elements so large that the random states of the checks do not turn them inside out.
BrickMesh large_block() { return brick_block({10, 5, 5}, {2, 1, 1}, {.young = 1, .poisson = 0.2, .density = 1}); }

TEST(InertialBody, is_tied_by_joints_at_nodes_and_averages) {
  const BrickMesh mesh = large_block();
  const Matrix3 turned = RandomNumbers(8).rotation();
  {
    SystemGraph graph;
    auto& solid = graph.add<InertialBody>("solid", {.mesh = shared(mesh)});
    const Vector3 middle(10, 2.5, 2.5);
    auto& joint = graph.add<RevoluteJoint>(
        "hinge", {graph.ground().marker(middle, turned), solid.average(mesh.node_set("x1"), turned)});
    check_joint(graph, joint, {.rank = 5});
  }
  {
    SystemGraph graph;
    auto& solid = graph.add<InertialBody>("solid", {.mesh = shared(mesh)});
    auto& joint = graph.add<SphericalJoint>("ball", {graph.ground().marker(), solid.node(1)});
    check_joint(graph, joint, {.rank = 3});
  }
  {
    SystemGraph graph;
    auto& solid = graph.add<InertialBody>("solid", {.mesh = shared(mesh)});
    auto& joint = graph.add<ThreeNodeFixation>("fixation",
                                               {graph.ground().marker(), solid.node(1), solid.node(4), solid.node(7)});
    check_joint(graph, joint, {.rank = 9});
  }
  {  // two solids, face to face
    SystemGraph graph;
    auto& one = graph.add<InertialBody>("one", {.mesh = shared(mesh)});
    auto& two = graph.add<InertialBody>("two", {.mesh = shared(mesh), .position = {10, 0, 0}});
    auto& joint = graph.add<FixedJoint>("weld", {one.average(mesh.node_set("x1")), two.average(mesh.node_set("x0"))});
    check_joint(graph, joint, {.rank = 6});
  }
}

TEST(InertialBody, swings_as_the_large_deflection_pendulum_of_calculix) {
  const BrickMesh mesh = pendulum_mesh("hex8i");
  SystemGraph graph;
  auto& rod = graph.add<InertialBody>("rod", {.mesh = shared(mesh)});
  const auto& edge = mesh.node_set("hinge");
  graph.add<ThreeNodeFixation>("hinge",
                               {graph.ground().marker(), rod.node(edge[0]), rod.node(edge[1]), rod.node(edge[2])});
  const Marker tip = rod.node(mesh.node_set("tip").front());
  const System system = assemble(graph);
  EXPECT_EQ(system.rank(), 9);
  Evaluator equations(system);
  State state = system.initial_state();
  GeneralizedAlpha integrator({.step = 1e-4, .spectral_radius = 0.9});
  integrator.start(equations, state);
  const Table reference = read_csv(kPendulum + "hex8i/trajectory.csv");
  double off = 0;
  for (int ms = 1; ms <= 1000; ++ms) {
    while (state.time < ms * 1e-3) ASSERT_TRUE(integrator.step(equations, state, ms * 1e-3).ok());
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    const MarkerKinematics k = marker_kinematics(equations, tip, Level::velocity);
    for (int i = 0; i < 3; ++i) off = std::max(off, std::abs(k.p[i] - reference.at(ms, 1 + i)));
  }
  EXPECT_LT(off, 1e-5);
}

TEST(InertialBody, flies_free_with_a_rigid_body_welded_to_its_end) {
  const BrickMesh mesh = brick_block({4, 1, 1}, {4, 1, 1}, kSoft);
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& solid = graph.add<InertialBody>("solid", {.mesh = shared(mesh), .angular_velocity = {0, 0, 2}});
  auto& ball = graph.add<RigidBody>("ball", {.mass = 500,
                                             .inertia = {50, 50, 50},
                                             .position = {5, 0.5, 0.5},
                                             .velocity = {-1, 10, 0},
                                             .angular_velocity = {0, 0, 2}});
  graph.add<FixedJoint>("weld", {solid.average(mesh.node_set("x1")), ball.marker({-1, 0, 0})});
  const System system = assemble(graph);
  EXPECT_EQ(system.rank(), 6);
  Evaluator equations(system);
  State state = system.initial_state();
  GeneralizedAlpha integrator({.step = 1e-3, .spectral_radius = 0.95});
  integrator.start(equations, state);
  const auto momenta = [&] {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    const BodyState s = body_state(equations, solid), b = body_state(equations, ball);
    const Eigen::Map<const Vector3> x(b.q), u(b.v), w(b.v + 3);
    Vector6 both;
    both << solid.linear_momentum(s) + 500 * u,
        solid.angular_momentum(s) + 500 * Vector3(x).cross(Vector3(u)) + 50 * (b.cache->A * w);
    return both;
  };
  const Vector6 start = momenta();
  const double energy = equations.energy().total();
  while (state.time < 1) ASSERT_TRUE(integrator.step(equations, state, 1).ok());
  const Vector6 end = momenta();
  EXPECT_LT((end - start).head<3>().norm(), 1e-9 * start.norm());
  EXPECT_LT((end - start).tail<3>().norm(), 1e-4 * start.norm());  // second order in the step
  EXPECT_NEAR(equations.energy().total() / energy, 1, 1e-3);
}

TEST(InertialBody, names_what_is_wrong_with_a_mesh) {
  const auto fix_of = [](const BrickMesh& mesh) -> std::string {
    try {
      SystemGraph graph;
      graph.add<InertialBody>("solid", {.mesh = shared(mesh)});
    } catch (const SceneError& error) {
      return error.problem();
    }
    return "";
  };
  BrickMesh mesh = large_block();
  std::swap(mesh.elements[1][0], mesh.elements[1][1]);
  EXPECT_NE(fix_of(mesh).find("element 2 is inside out"), std::string::npos);
  mesh = large_block();
  mesh.elements[0][3] = mesh.elements[0][2];
  EXPECT_NE(fix_of(mesh).find("element 1 has a node twice"), std::string::npos);
  mesh = large_block();
  mesh.material.poisson = 0.5;
  EXPECT_NE(fix_of(mesh).find("Poisson"), std::string::npos);
  EXPECT_THROW(large_block().node_set("nowhere"), SceneError);
  EXPECT_THROW(read_brick_mesh("no/such/deck.inp"), FileError);
  EXPECT_THROW(read_brick_mesh(kPendulum + "hex20/calculix/matrices.inp"), FileError);
  SystemGraph graph;
  EXPECT_THROW(graph.add<InertialBody>("empty"), SceneError);
}

}  // namespace
}  // namespace lithe::test::inertial_body_test
