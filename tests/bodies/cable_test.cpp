#include "bodies/cable/cable.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "integrators/automatic.h"
#include "integrators/generalized_alpha.h"
#include "joints/distance_joint.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/body_checks.h"
#include "tests/support/dense.h"
#include "tests/support/json_file.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/motion.h"

namespace lithe::test::cable_test {
namespace {

constexpr double kGravity = 9.81;

/// Short, stiff in bending, drawn along a curve that stretches it.
Cable::Parameters wire(double damping = 0) {
  return {.points = {{0, 0, 0}, {0.5, 0.1, 0}, {0.8, -0.1, 0.3}, {1.3, 0.2, 0.1}},
          .length = 1.3,
          .elements = 6,
          .stations = {0.55},
          .mass_per_length = 0.7,
          .axial_stiffness = 900,
          .bending_stiffness = 3,
          .axial_damping = damping};
}

void pin(SystemGraph& graph, Cable& cable) {
  const auto& p = cable.parameters();
  graph.add<SphericalJoint>("first", {graph.ground().marker(p.from), cable.start()});
  graph.add<SphericalJoint>("last", {graph.ground().marker(p.to), cable.end()});
}

TEST(Cable, OwesWhatEveryBodyOwes) {
  for (const double damping : {0.0, 4.0}) {
    SystemGraph graph{{.gravity = {1, 2, -9.81}}};
    auto& cable = graph.add<Cable>("cable", wire(damping));
    check_body(graph, cable, {cable.start(), cable.end(), cable.marker(0.55), cable.marker(0.9)},
               {.mass = 0.7 * 1.3, .deformation = 3e-2, .dissipation = damping});
  }
}

/// ∂r/∂q and ∂r/∂v by differences: bent and stretched the tangent is exact, damping's ∂/∂q left out at rest.
TEST(Cable, HasTheTangentOfItsForce) {
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  graph.add<Cable>("cable", wire(4.0));
  const System system = assemble(graph);
  const Layout& layout = system.layout();
  Evaluator equations(system);
  const int n = layout.v_count();
  RandomNumbers random(3);
  const VectorX still = VectorX::Zero(n), none = VectorX::Zero(0);
  VectorX q = 1.4 * system.initial_state().q + random.vector(n, 0.05);
  const auto residual = [&](const VectorX& at, const VectorX& v) {
    equations.evaluate(0, at, v, Level::velocity);
    VectorX r(n);
    equations.residual(still, none, r);
    return r;
  };
  const MatrixX K = jacobian(
      layout, q, [&](const VectorX& at) { return residual(at, still); }, 1e-4);
  equations.evaluate(0, q, still, Level::velocity);
  equations.factorize({1, 0, 0}, still, none, nullptr);
  EXPECT_LT((dense(equations).S() - K).cwiseAbs().maxCoeff(), 1e-9 * K.cwiseAbs().maxCoeff());
  MatrixX D(n, n);
  for (int j = 0; j < n; ++j)
    D.col(j) = derivative([&](double t) { return residual(q, VectorX(t * VectorX::Unit(n, j))); }, 1e-2);
  equations.evaluate(0, q, still, Level::velocity);
  equations.factorize({0, 1, 0}, still, none, nullptr);
  EXPECT_LT((dense(equations).S() - D).cwiseAbs().maxCoeff(), 1e-9 * D.cwiseAbs().maxCoeff());
}

/// Turned, shifted and moving as a rigid body it has the same energy, tensions and no damping.
TEST(Cable, DoesNotFeelRigidMotion) {
  SystemGraph graph;
  auto& cable = graph.add<Cable>("cable", wire(4.0));
  const System system = assemble(graph);
  State state = system.initial_state();
  Snapshot drawn(system, state);
  const double energy = elastic_energy(cable).value(drawn);
  const VectorX tensions = cable.tensions(drawn.body_state(cable));
  const Matrix3 R = rotation_about({1, 2, -1}, 2.3);
  const Vector3 spin(3, -5, 2);
  for (int i = 0; i < cable.node_count(); ++i) {
    const Vector3 x = R * state.q.segment<3>(3 * i) + Vector3(5, -7, 3);
    state.q.segment<3>(3 * i) = x;
    state.v.segment<3>(3 * i) = Vector3(1, 2, 3) + spin.cross(x);
  }
  Snapshot turned(system, state);
  EXPECT_NEAR(elastic_energy(cable).value(turned), energy, 1e-12 * energy);
  for (int e = 0; e < cable.element_count(); ++e)
    EXPECT_NEAR(tension(cable, e).value(turned), tensions[e], 1e-11 * tensions.cwiseAbs().maxCoeff());
}

// ---- equilibrium ----

struct Catenary {
  double length, stiffness, weight, H;
  Vector3 end;
  std::vector<std::array<double, 3>> table;  // s, x, z
};

Catenary catenary(const std::string& name) {
  const auto c = read_json(LITHE_TEST_DATA "/beams/S03_catenary.json").at("cases").at(name);
  return {c.at("L0"),         c.at("EA"), c.at("weight_per_length"), c.at("H"), Vector3(c.at("dx"), 0, c.at("dz")),
          c.at("table_s_x_z")};
}

struct Hanging {
  double H;         // horizontal force at the start, relative error
  double place;     // worst error of the table's points, of the length
  Matrix3X points;  // these
};

/// Worst distance from the table's points, of the length.
double off(const Catenary& c, const Matrix3X& points) {
  double worst = 0;
  for (std::size_t i = 0; i < c.table.size(); ++i)
    worst =
        std::max(worst, (points.col(static_cast<Eigen::Index>(i)) - Vector3(c.table[i][1], 0, c.table[i][2])).norm());
  return worst / c.length;
}

/// From a slack drawing, or a straight one.
Hanging hang(const Catenary& c, int elements) {
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  auto& cable = graph.add<Cable>("cable", {.to = c.end,
                                           .length = c.length,
                                           .elements = elements,
                                           .mass_per_length = c.weight / kGravity,
                                           .axial_stiffness = c.stiffness});
  pin(graph, cable);
  const System system = assemble(graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  Snapshot now(system, found.state);
  Hanging error{};
  const BodyState state = now.body_state(cable);
  const Vector3 pull =
      lanes::vector(static_cast<const Cable::Cache&>(*state.cache).directions[0]) * cable.tensions(state)[0];
  error.H = pull.x() / c.H - 1;
  const Matrix3X x = cable.positions(state);
  error.points.resize(3, static_cast<Eigen::Index>(c.table.size()));
  for (std::size_t i = 0; i < c.table.size(); ++i)
    error.points.col(static_cast<Eigen::Index>(i)) = x.col(std::lround(c.table[i][0] / c.length * elements));
  error.place = off(c, error.points);
  return error;
}

TEST(Cable, HangsAsAnElasticCatenary) {
  for (const char* name : {"level_slack", "inclined_taut", "soft"}) {
    const Catenary c = catenary(name);
    const Hanging coarse = hang(c, 40), fine = hang(c, 80), finest = hang(c, 160);
    expect_below(std::string(name) + ": H by 160 elements", std::abs(finest.H), 1e-4);
    expect_below(std::string(name) + ": places by 160 elements", finest.place, 1e-4);
    EXPECT_NEAR(std::log2(coarse.place / fine.place), 2, 0.02) << name;
    EXPECT_NEAR(std::log2(fine.H / finest.H), 2, 0.02) << name;
    // The error has even powers of the elements' length: two meshes leave the fourth, three the sixth.
    expect_below(std::string(name) + ": H by two meshes", std::abs((4 * finest.H - fine.H) / 3), 1e-8);
    const Matrix3X two = (4 * fine.points - coarse.points) / 3, next = (4 * finest.points - fine.points) / 3;
    expect_below(std::string(name) + ": places by two meshes", off(c, next), 1e-8);
    expect_below(std::string(name) + ": places by three meshes", off(c, (16 * next - two) / 15), 1e-10);
  }
}

/// Euler's load of a pinned strut that is pressed to λ of its length: EA (1 - λ) λ = π² EI/L². Below it stays straight.
TEST(Cable, BucklesAsAStrutDoes) {
  const double L = 2, EI = 5, EA = 2000;
  const auto lowest = [&](double share) {
    const double pressed = 0.5 + std::sqrt(0.25 - share * kPi * kPi * EI / (L * L * EA));
    SystemGraph graph;
    auto& cable = graph.add<Cable>("strut", {.points = {{0, 0, 0}, {pressed * L, 0, 0}},
                                             .length = L,
                                             .elements = 20,
                                             .mass_per_length = 1,
                                             .axial_stiffness = EA,
                                             .bending_stiffness = EI});
    graph.add<SphericalJoint>("first", {graph.ground().marker(), cable.start()});
    graph.add<SphericalJoint>("last", {graph.ground().marker({pressed * L, 0, 0}), cable.end()});
    const System system = assemble(graph);
    return linearize(system, system.initial_state()).lowest_stiffness();
  };
  EXPECT_GT(lowest(0.99), 0);
  EXPECT_LT(lowest(1.01), 0);
}

// ---- motion ----

/// n c/(2 L) with c = √(T/μ); the consistent mass of the mesh adds (n π/elements)²/24 of it.
TEST(Cable, SoundsAsATautString) {
  const double L = 1.5, EA = 8e3, strain = 0.05, mu = 0.02;
  const int elements = 30;
  SystemGraph graph;
  auto& cable = graph.add<Cable>("string", {.to = {L * (1 + strain), 0, 0},
                                            .length = L,
                                            .elements = elements,
                                            .mass_per_length = mu,
                                            .axial_stiffness = EA});
  pin(graph, cable);
  const System system = assemble(graph);
  const VectorX f = linearize(system, system.initial_state()).undamped_frequencies();
  const double c = std::sqrt(EA * strain * (1 + strain) / mu);  // the stretched string has less mass per length
  for (int n = 1; n <= 3; ++n)
    for (const int plane : {0, 1}) {
      const double exact = n * c / (2 * L * (1 + strain)), mesh = std::pow(n * kPi / elements, 2) / 24;
      EXPECT_NEAR(f[2 * (n - 1) + plane] / exact - 1, mesh, 0.02 * mesh) << "harmonic " << n;
    }
}

TEST(Cable, SwingsWithItsEnergy) {
  Scene scene({0, 0, -kGravity}, [](SystemGraph& graph) {
    auto& cable = graph.add<Cable>(
        "rope",
        {.to = {1, 0, 0}, .elements = 12, .mass_per_length = 0.5, .axial_stiffness = 500, .bending_stiffness = 0.01});
    graph.add<SphericalJoint>("hook", {graph.ground().marker(), cable.start()});
  });
  const double before = scene.energy();
  double worst = 0;
  const Method method = radau(1e-9);
  for (double t = 0.1; t < 1.45; t += 0.1) {
    scene.run(*method, t);
    worst = std::max(worst, std::abs(scene.energy() - before));
  }
  expect_below("energy of a swinging rope over m g L", worst / (0.5 * kGravity), 1e-6);
}

/// Half of it falls, whips and is caught: the load on its end jerks it taut.
template <class T>
void jerk(T&& integrator, double bound) {
  Scene scene({0, 0, -kGravity}, [](SystemGraph& graph) {
    auto& cable = graph.add<Cable>("rope", {.to = {0.3, 0, 0},
                                            .length = 2,
                                            .elements = 24,
                                            .mass_per_length = 0.2,
                                            .axial_stiffness = 5e4,
                                            .bending_stiffness = 1e-3,
                                            .axial_damping = 20});
    auto& load = graph.add<RigidBody>("load", {.mass = 3, .inertia = {0.01, 0.01, 0.01}, .position = {0.3, 0, 0}});
    graph.add<SphericalJoint>("hook", {graph.ground().marker(), cable.start()});
    graph.add<SphericalJoint>("eye", {cable.end(), load.marker()});
  });
  const double before = scene.energy();
  scene.run(integrator, 1.5);
  EXPECT_NEAR(scene.state.time, 1.5, 1e-12);
  EXPECT_LT(scene.energy(), before + bound);
  const double reach = scene.position(1).norm();
  EXPECT_LT(reach, 2.1);
}

TEST(Cable, IsCaughtWhereItJerksTaut) {
  jerk(Automatic{{.tolerance = {.relative = 1e-4, .absolute = 1e-4}}}, 1e-2);
  jerk(GeneralizedAlpha{{.step = 1e-3, .spectral_radius = 0.6}}, 1e-2);
}

// ---- drawing and errors ----

TEST(Cable, IsDrawnSlackWithElementsAsLongAsTheyAre) {
  for (const Vector3& to : {Vector3(3, 1, 0), Vector3(0, 0, -2), Vector3(0, 0, 0)}) {
    SystemGraph graph;
    auto& cable = graph.add<Cable>(
        "rope", {.to = to, .length = 5, .elements = 11, .stations = {1.2}, .mass_per_length = 1, .axial_stiffness = 1});
    const System system = assemble(graph);
    Snapshot now(system, system.initial_state());
    const BodyState state = now.body_state(cable);
    EXPECT_LT(cable.tensions(state).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((cable.positions(state).col(cable.element_count()) - to).norm(), 1e-14);
    EXPECT_EQ(cable.arc(cable.element_at(1.2)), 1.2);
    if (to.x() > 0) {
      EXPECT_LT(cable.positions(state).row(2).minCoeff(), -1) << "hangs";
    }
    const DrawnMesh mesh = cable.drawn_mesh(false);
    Matrix3X points;
    cable.drawn_points(state, mesh, points);
    EXPECT_LT((points - mesh.points).cwiseAbs().maxCoeff(), 1e-14);
    for (Eigen::Index i = 0; i < points.cols(); ++i)
      EXPECT_LE((points.col(i) - cable.positions(state).col(mesh.nodes[static_cast<std::size_t>(i)])).norm(), 0.0101);
  }
}

std::string refusal_of(const std::function<void(SystemGraph&)>& draw) {
  SystemGraph graph;
  try {
    draw(graph);
    assemble(graph);
  } catch (const SceneError& error) {
    EXPECT_NE(error.where().find("cable_test.cpp"), std::string::npos) << error.where();
    EXPECT_FALSE(error.fix().empty());
    return error.problem();
  }
  return "taken";
}

/// Elements of 0.1 mm that turn by 5 % of a radian in a step of 1 ms: accelerations that go on would stretch them, and
/// the tension would spoil the tangent.
TEST(Cable, TakesWholeStepsOnAFineMesh) {
  Scene scene({0, 0, -kGravity}, [](SystemGraph& graph) {
    auto& cable = graph.add<Cable>("rope", {.to = {1, 0, 0},
                                            .elements = 10000,
                                            .mass_per_length = 0.22,
                                            .axial_stiffness = 2000,
                                            .bending_stiffness = 0.0167});
    graph.add<SphericalJoint>("hook", {graph.ground().marker(), cable.start()});
  });
  GeneralizedAlpha method({.step = 1e-3, .spectral_radius = 0.9});
  scene.run(method, 0.04);
  EXPECT_LE(method.statistics().steps, 50);  // 40, of 5 iterations each; halved steps make many more
}

TEST(Cable, SaysWhatItLacks) {
  const Cable::Parameters sound{.to = {1, 0, 0}, .mass_per_length = 1, .axial_stiffness = 1};
  const auto refusal = [&](const std::function<void(Cable::Parameters&)>& change) {
    Cable::Parameters p = sound;
    change(p);
    return refusal_of([&](SystemGraph& graph) { graph.add<Cable>("rope", p); });
  };
  const auto contains = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  EXPECT_EQ(refusal([](Cable::Parameters&) {}), "taken");
  contains(refusal([](Cable::Parameters& p) { p.mass_per_length = 0; }), "mass_per_length");
  contains(refusal([](Cable::Parameters& p) { p.axial_stiffness = -1; }), "axial_stiffness");
  contains(refusal([](Cable::Parameters& p) { p.bending_stiffness = NAN; }), "bending_stiffness");
  contains(refusal([](Cable::Parameters& p) { p.elements = 0; }), "has 0 elements");
  contains(refusal([](Cable::Parameters& p) { p.to = p.from; }), "has no length");
  contains(refusal([](Cable::Parameters& p) { p.length = -2; }), "length");
  contains(refusal([](Cable::Parameters& p) { p.length = 2, p.elements = 1; }), "too few elements");
  contains(refusal([](Cable::Parameters& p) { p.stations = {0.6, 0.4}; }), "has station 2 at 0.4 m");
  contains(refusal([](Cable::Parameters& p) { p.points = {{1, 1, 1}}; }), "without length");
  contains(refusal_of([&](SystemGraph& graph) {
             auto& cable = graph.add<Cable>("rope", sound);
             cable.marker(1.5);
           }),
           "no point at 1.5 m");
  contains(refusal_of([&](SystemGraph& graph) { tension(graph.add<Cable>("rope", sound), 20); }), "no element 20");
}

TEST(Cable, IsHeldAtItsPlaceAlone) {
  const auto draw = [&](auto joint) {
    return refusal_of([&](SystemGraph& graph) {
      auto& cable = graph.add<Cable>("rope", {.to = {1, 0, 0}, .mass_per_length = 1, .axial_stiffness = 1});
      auto& body = graph.add<RigidBody>("body", {.position = {1, 0, 0}});
      joint(graph, body.marker(), cable.end());
    });
  };
  EXPECT_EQ(draw([](SystemGraph& graph, Marker a, Marker b) { graph.add<SphericalJoint>("tie", {a, b}); }), "taken");
  EXPECT_EQ(draw([](SystemGraph& graph, Marker a, Marker b) {
              graph.add<SpringDamper>("tie", {a, b}, {.stiffness = 1});
            }),
            "taken");
  EXPECT_EQ(draw([](SystemGraph& graph, Marker, Marker b) {
              graph.add<DistanceJoint>("tie", {graph.ground().marker({0, 0, 1}), b});
            }),
            "taken");
  EXPECT_NE(draw([](SystemGraph& graph, Marker a, Marker b) {
              graph.add<RevoluteJoint>("tie", {a, b});
            }).find("puts a moment on 'rope'"),
            std::string::npos);
}

}  // namespace
}  // namespace lithe::test::cable_test
