#include "engine/model/body_by_energy.h"

#include <gtest/gtest.h>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/support/body_checks.h"
#include "tests/support/joint_checks.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// Bodies written as their energies alone against those written by hand, and against what every body owes.
namespace lithe::test::body_by_energy_test {
namespace {

template <class S>
using Vector = Eigen::Matrix<S, 3, 1>;

/// A number as S, for products of Eigen.
template <class S>
Vector<S> constant(const Vector3& a) {
  return a.cast<S>();
}

const Vector3 kInertia(0.02, 0.05, 0.06);

struct EnergyRigid final : BodyByEnergy<EnergyRigid, /*frames=*/1, /*linear=*/0> {
  struct Parameters {
    double mass = 1;
    Vector3 position{0, 0, 0}, velocity{0, 0, 0}, angular_velocity{0, 0, 0};
  };
  explicit EnergyRigid(Parameters p)
      : BodyByEnergy({p.position, Matrix3::Identity(), {}}, {p.velocity, p.angular_velocity, {}}), mass(p.mass) {}
  template <class S>
  S kinetic(const Configuration<S>&, const Motion<S>& m) const {
    S sum = 0.5 * mass * m.v.squaredNorm();
    for (int i = 0; i < 3; ++i) sum += 0.5 * kInertia[i] * m.w[i] * m.w[i];
    return sum;
  }
  template <class S>
  S potential(const Configuration<S>& q, const Vector3& gravity) const {
    return -mass * constant<S>(gravity).dot(q.p);
  }
  template <class S>
  PoseOf<S> marker_pose(int marker, const Configuration<S>& q) const {
    return {q.p + q.R * constant<S>(places[static_cast<std::size_t>(marker)]), q.R};
  }
  Marker marker(const Vector3& place) {
    places.push_back(place);
    return new_marker();
  }
  double mass;
  std::vector<Vector3> places;
};

/// A tube with a piston on a spring along its x axis; the piston's way is η.
struct Telescope final : BodyByEnergy<Telescope, 1, 1> {
  struct Parameters {
    double tube = 2, piston = 0.7, stiffness = 90, start = 0;
  } p;
  explicit Telescope(Parameters parameters)
      : BodyByEnergy({Vector3::Zero(), Matrix3::Identity(), {parameters.start}}, still()), p(parameters) {}
  template <class S>
  S kinetic(const Configuration<S>& q, const Motion<S>& m) const {
    S sum = 0.5 * p.tube * m.v.squaredNorm();
    for (int i = 0; i < 3; ++i) sum += 0.5 * kInertia[i] * m.w[i] * m.w[i];
    const Vector<S> place(0.5 + q.eta[0], 0.0, 0.0), rate(m.eta_dot[0], 0.0, 0.0);
    const Vector<S> v = m.v + q.R * (m.w.cross(place) + rate);
    return sum + 0.5 * p.piston * v.squaredNorm();
  }
  template <class S>
  S potential(const Configuration<S>& q, const Vector3& gravity) const {
    const Vector<S> g = constant<S>(gravity), place(0.5 + q.eta[0], 0.0, 0.0);
    return 0.5 * p.stiffness * q.eta[0] * q.eta[0] - p.tube * g.dot(q.p) - p.piston * g.dot(q.p + q.R * place);
  }
  template <class S>
  PoseOf<S> marker_pose(int marker, const Configuration<S>& q) const {
    if (marker == 0) return {q.p, q.R};
    const Vector<S> place(0.5 + q.eta[0], 0.1, -0.2);
    return {q.p + q.R * place, q.R};
  }
  Marker tube() { return new_marker(); }    // first
  Marker piston() { return new_marker(); }  // then
};

/// Two arms in the plane xz, by their angles from straight down: one body without frame.
struct TwoArms final : BodyByEnergy<TwoArms, 0, 2> {
  struct Parameters {
    double first, second;
  };
  explicit TwoArms(Parameters p) : BodyByEnergy({Vector3::Zero(), Matrix3::Identity(), {p.first, p.second}}, still()) {}
  template <class S>
  static Vector<S> along(const S& angle) {
    return {sin(angle), 0.0, -cos(angle)};
  }
  template <class S>
  S kinetic(const Configuration<S>& q, const Motion<S>& m) const {
    const S c = cos(q.eta[0] - q.eta[1]);
    const S &u = m.eta_dot[0], &v = m.eta_dot[1];
    // Rods of 1 m and 1 kg, thin.
    return 0.5 * (4.0 / 3 * u * u + 1.0 / 3 * v * v + c * u * v);
  }
  template <class S>
  S potential(const Configuration<S>& q, const Vector3& gravity) const {
    const Vector<S> g = constant<S>(gravity), a = along(q.eta[0]), b = along(q.eta[1]);
    return -g.dot(1.5 * a + 0.5 * b);
  }
  template <class S>
  PoseOf<S> marker_pose(int, const Configuration<S>& q) const {
    const S c = cos(q.eta[1]), s = sin(q.eta[1]);
    PoseOf<S> pose{along(q.eta[0]) + along(q.eta[1]), {}};
    pose.R << c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c;  // turned by -η_2 about y
    return pose;
  }
  Marker tip() { return new_marker(); }
};

/// Points of a reduced body, u = B η, seen from its frame; K^ diagonal.
constexpr int kModes = 3;
struct Reduced {
  Matrix3X nodes;
  VectorX masses;
  MatrixX modes;      // 3 n x kModes
  VectorX stiffness;  // of each mode, mass-orthonormal or not

  Reduced() : nodes(3, 6), masses(6), modes(18, kModes), stiffness(kModes) {
    RandomNumbers random(4);
    for (int i = 0; i < 6; ++i) nodes.col(i) = random.vector(3, 1), masses[i] = 0.3 + 0.1 * i;
    for (int k = 0; k < kModes; ++k) modes.col(k) = random.vector(18, 1), stiffness[k] = 400.0 * (k + 1);
  }
};

struct EnergyReduced final : BodyByEnergy<EnergyReduced, 1, kModes> {
  struct Parameters {
    const Reduced* of = nullptr;
    std::array<double, kModes> bent{};
    Vector3 velocity{0, 0, 0}, angular_velocity{0, 0, 0};
  };
  explicit EnergyReduced(Parameters p)
      : BodyByEnergy({Vector3::Zero(), Matrix3::Identity(), p.bent}, {p.velocity, p.angular_velocity, {}}), of(*p.of) {}
  template <class S>
  Vector<S> place(int node, const std::array<S, kModes>& eta, bool rate) const {
    Vector<S> r = rate ? constant<S>(Vector3::Zero()) : constant<S>(of.nodes.col(node));
    for (int k = 0; k < kModes; ++k)
      for (int i = 0; i < 3; ++i) r[i] += of.modes(3 * node + i, k) * eta[k];
    return r;
  }
  template <class S>
  S kinetic(const Configuration<S>& q, const Motion<S>& m) const {
    S sum = 0.0;
    for (int n = 0; n < of.masses.size(); ++n) {
      const Vector<S> r = place<S>(n, q.eta, false), rate = place<S>(n, m.eta_dot, true);
      sum += 0.5 * of.masses[n] * (m.v + q.R * (m.w.cross(r) + rate)).squaredNorm();
    }
    return sum;
  }
  template <class S>
  S potential(const Configuration<S>& q, const Vector3& gravity) const {
    S sum = 0.0;
    for (int k = 0; k < kModes; ++k) sum += 0.5 * of.stiffness[k] * q.eta[k] * q.eta[k];
    for (int n = 0; n < of.masses.size(); ++n)
      sum -= of.masses[n] * constant<S>(gravity).dot(q.p + q.R * place<S>(n, q.eta, false));
    return sum;
  }
  template <class S>
  PoseOf<S> marker_pose(int, const Configuration<S>& q) const {
    return {q.p + q.R * place<S>(2, q.eta, false), q.R};
  }
  Marker node() { return new_marker(); }
  const Reduced& of;
};

// ---- what every body owes ----

TEST(BodyByEnergy, OwesWhatEveryBodyOwes) {
  const Vector3 gravity(1, 2, -9.81);
  {
    SystemGraph graph{{.gravity = gravity}};
    auto& body = graph.add<EnergyRigid>("rigid", {.mass = 2.5});
    check_body(graph, body, {body.marker({0.3, -0.2, 0.5}), body.marker({0, 0, 0})}, {.mass = 2.5, .speed = 3});
  }
  {
    SystemGraph graph{{.gravity = gravity}};
    auto& body = graph.add<Telescope>("telescope");
    const Marker tube = body.tube(), piston = body.piston();
    check_body(graph, body, {tube, piston}, {.mass = 2.7, .speed = 2, .deformation = 0.2});
  }
  {
    const Reduced reduced;
    SystemGraph graph{{.gravity = gravity}};
    auto& body = graph.add<EnergyReduced>("reduced", {.of = &reduced});
    check_body(graph, body, {body.node()}, {.mass = reduced.masses.sum(), .speed = 2, .deformation = 0.1});
  }
}

// ---- against bodies written by hand ----

template <class Add>
Table path(const Add& add, Method method, double end = 0.5) {
  SystemGraph graph;
  const Marker tip = add(graph);
  const System system = assemble(graph);
  Recorder recorder({position(tip, "tip")});
  Simulation simulation(system, *method);
  simulation.observe(recorder, every(end / 10));
  State state = system.initial_state();
  simulation.run(state, end);
  return recorder.table();
}

double apart(const Table& a, const Table& b) {
  EXPECT_EQ(a.values.size(), b.values.size());
  double most = 0;
  for (std::size_t k = 0; k < a.values.size(); ++k) most = std::max(most, std::abs(a.values[k] - b.values[k]));
  return most;
}

TEST(BodyByEnergy, MovesAsARigidBody) {
  const auto pendulum = [](auto& graph, auto& body) {
    graph.template add<SphericalJoint>("ball", {graph.ground().marker(), body.marker({-0.5, 0, 0})});
    graph.template add<SpringDamper>("spring", {graph.ground().marker({0, 1, 0}), body.marker({0.2, 0.1, 0})},
                                     {.stiffness = 5, .damping = 0.3, .natural_length = 0.5});
    return body.marker({0.5, 0, 0});
  };
  const auto by_energy = [&](SystemGraph& graph) {
    return pendulum(graph,
                    graph.add<EnergyRigid>(
                        "rod", {.position = {0.5, 0, 0}, .velocity = {0, 0.5, 0}, .angular_velocity = {2, 0, 1}}));
  };
  const auto by_hand = [&](SystemGraph& graph) {
    return pendulum(graph, graph.add<RigidBody>("rod", {.mass = 1,
                                                        .inertia = {kInertia[0], kInertia[1], kInertia[2]},
                                                        .position = {0.5, 0, 0},
                                                        .velocity = {0, 0.5, 0},
                                                        .angular_velocity = {2, 0, 1}}));
  };
  expect_below("Runge-Kutta 8",
               apart(path(by_energy, runge_kutta8_fixed(2e-3)), path(by_hand, runge_kutta8_fixed(2e-3))), 1e-12);
  expect_below("generalized-alpha", apart(path(by_energy, index3(2e-3)), path(by_hand, index3(2e-3))), 1e-9);
  expect_below("Radau", apart(path(by_energy, radau_fixed(5e-3)), path(by_hand, radau_fixed(5e-3))), 1e-10);
}

TEST(BodyByEnergy, MovesAsAFloatingReducedBody) {
  const Reduced reduced;
  const Vector3 velocity(0.3, 1, 0.2), spin(1, -2, 3);
  const auto by_energy = [&](SystemGraph& graph) {
    return graph
        .add<EnergyReduced>(
            "body", {.of = &reduced, .bent = {0.02, -0.03, 0.01}, .velocity = velocity, .angular_velocity = spin})
        .node();
  };
  SparseMatrix mass(6, 6);
  for (int i = 0; i < 6; ++i) mass.insert(i, i) = reduced.masses[i];
  SparseMatrix stiffness(kModes, kModes);
  for (int k = 0; k < kModes; ++k) stiffness.insert(k, k) = reduced.stiffness[k];
  const auto basis = basis_from_modes("reduced", reduced.nodes, mass, stiffness, reduced.modes);
  const auto by_hand = [&](SystemGraph& graph) {
    return graph
        .add<FlexibleBody>("body", {.basis = basis,
                                    .velocity = velocity,
                                    .angular_velocity = spin,
                                    .modal_coordinates = Vector3(0.02, -0.03, 0.01)})
        .node(3);
  };
  expect_below("Runge-Kutta 8",
               apart(path(by_energy, runge_kutta8_fixed(0.01), 0.2), path(by_hand, runge_kutta8_fixed(0.01), 0.2)),
               1e-11);
  expect_below("Radau", apart(path(by_energy, radau_fixed(5e-3), 0.2), path(by_hand, radau_fixed(5e-3), 0.2)), 1e-9);
}

/// Two arms as one body of two angles, and as two rods with hinges.
TEST(BodyByEnergy, MinimalCoordinatesMoveAsBodiesWithJoints) {
  const auto by_energy = [](SystemGraph& graph) { return graph.add<TwoArms>("arms", {1.2, 0.4}).tip(); };
  const auto by_hand = [](SystemGraph& graph) {
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    Marker end = graph.ground().marker({0, 0, 0}, along_y);
    Vector3 place(0, 0, 0);
    for (const double angle : {1.2, 0.4}) {
      const Vector3 along(std::sin(angle), 0, -std::cos(angle));
      auto& rod = graph.add<RigidBody>("rod " + std::to_string(angle),
                                       {.mass = 1,
                                        .inertia = {1e-9, 1.0 / 12, 1.0 / 12},
                                        .position = place + 0.5 * along,
                                        .orientation = rotation_about({0, 1, 0}, M_PI / 2 - angle)});
      graph.add<RevoluteJoint>("pin " + std::to_string(angle), {end, rod.marker({-0.5, 0, 0}, along_y)});
      end = rod.marker({0.5, 0, 0}, along_y);
      place += along;
    }
    return end;
  };
  expect_below("Runge-Kutta 8", apart(path(by_energy, runge_kutta8(1e-11), 1), path(by_hand, runge_kutta8(1e-11), 1)),
               1e-8);
  expect_below("Radau", apart(path(by_energy, radau(1e-9), 1), path(by_hand, runge_kutta8(1e-11), 1)), 1e-6);
}

/// Its elastic coordinate carries a joint: a mass hung from the piston.
TEST(BodyByEnergy, CarriesJointsOnItsElasticCoordinates) {
  SystemGraph graph;
  auto& telescope = graph.add<Telescope>("telescope", {.start = 0.05});
  const Marker tube = telescope.tube(), piston = telescope.piston();
  graph.add<SphericalJoint>("ball", {graph.ground().marker(), tube});
  auto& bob = graph.add<RigidBody>("bob", {.mass = 0.5, .inertia = {0.01, 0.02, 0.03}, .position = {0.55, 0.1, -0.6}});
  auto& joint = graph.add<SphericalJoint>("hook", {piston, bob.marker({0, 0, 0.4})});
  check_joint(graph, joint, {.rank = 3, .tolerance = 1e-8});
  const System system = assemble(graph);
  const auto energy = [&](const State& state) {
    Snapshot now(system, state);
    return total_energy().value(now);
  };
  State state = system.initial_state();
  const double before = energy(state);
  Method method = radau(1e-8);
  Simulation simulation(system, *method);
  simulation.run(state, 1);
  expect_below("energy", std::abs(energy(state) - before), 1e-5);
}

}  // namespace
}  // namespace lithe::test::body_by_energy_test
