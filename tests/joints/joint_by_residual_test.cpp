#include "engine/model/joint_by_residual.h"

#include <gtest/gtest.h>

#include "bodies/beam/beam.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/radau.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/spring_damper.h"
#include "joints/parallel_axes_joint.h"
#include "joints/perpendicular_axes_joint.h"
#include "joints/planar_joint.h"
#include "joints/planar_pin_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/revolute_spherical_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/support/joint_checks.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// Joints and forces written by one function over the scalar: what is derived from it against what is written by hand.
namespace lithe::test::joint_by_residual_test {
namespace {

template <class S>
using Poses = std::span<const PoseOf<S>>;
template <class S>
using Vector = Eigen::Matrix<S, 3, 1>;

// ---- rows of the catalogue, in its order ----

template <class S>
S* coincide(Poses<S> m, S* g) {
  const Vector<S> d = m[1].p - m[0].p;
  for (int i = 0; i < 3; ++i) *g++ = d[i];
  return g;
}

#define LITHE_DERIVED(Name, rows)                      \
  struct Name final : JointByResidual<Name, 2, rows> { \
    struct Parameters {};                              \
    explicit Name(Parameters = {}) {}                  \
    template <class S>                                 \
    void residual(Poses<S> m, S* g) const;             \
  };                                                   \
  template <class S>                                   \
  void Name::residual([[maybe_unused]] Poses<S> m, S* g) const

LITHE_DERIVED(Ball, 3) { coincide(m, g); }
LITHE_DERIVED(Hinge, 5) {
  g = coincide(m, g);
  *g++ = m[0].x().dot(m[1].z());
  *g++ = m[0].y().dot(m[1].z());
}
LITHE_DERIVED(Cardan, 4) { *coincide(m, g) = m[0].x().dot(m[1].y()); }
LITHE_DERIVED(OnLine, 2) {
  const Vector<S> d = m[1].p - m[0].p;
  g[0] = m[0].x().dot(d), g[1] = m[0].y().dot(d);
}
LITHE_DERIVED(OnPlane, 1) { g[0] = m[0].z().dot(m[1].p - m[0].p); }
LITHE_DERIVED(Parallel, 2) { g[0] = m[0].x().dot(m[1].z()), g[1] = m[0].y().dot(m[1].z()); }
LITHE_DERIVED(Perpendicular, 1) { g[0] = m[0].z().dot(m[1].z()); }

struct Rod final : JointByResidual<Rod, 2, 1> {
  struct Parameters {
    double length;
  };
  explicit Rod(Parameters p) : length(p.length) {}
  template <class S>
  void residual(Poses<S> m, S* g) const {
    g[0] = 0.5 * ((m[1].p - m[0].p).squaredNorm() - length * length);
  }
  double length;
};

/// Explicit in time: B moves along z of A.
struct Moved final : JointByResidual<Moved, 2, 1> {
  template <class S>
  void residual(const S& t, Poses<S> m, S* g) const {
    g[0] = m[0].z().dot(m[1].p - m[0].p) - 0.3 * sin(2.0 * t) * t;
  }
};

/// Three markers, and roots: a rope over a small pulley.
struct Pulley final : JointByResidual<Pulley, 3, 1> {
  struct Parameters {
    double length;
  };
  explicit Pulley(Parameters p) : length(p.length) {}
  template <class S>
  void residual(Poses<S> m, S* g) const {
    g[0] = (m[0].p - m[1].p).norm() + (m[2].p - m[1].p).norm() - length;
  }
  double length;
};

// ---- derived against written ----

struct RandomMarkers {
  MarkerKinematics kinematics[2];
  explicit RandomMarkers(RandomNumbers& random) {
    for (MarkerKinematics& k : kinematics) {
      k.p = random.vector(3, 1), k.v = random.vector(3, 2), k.w = random.vector(3, 3);
      k.R = rotation_exp(Vector3(random.vector(3, 2)));
    }
  }
};

/// `order`: of the written joint's rows, for the derived one's.
void expect_the_same(const std::string& name, const Constraint& derived, const Constraint& written,
                     bool exact_stiffness = true) {
  RandomNumbers random(3);
  double worst[5] = {};
  for (int i = 0; i < 200; ++i) {
    const RandomMarkers m(random);
    double multipliers[kMaxRows];
    for (double& l : multipliers) l = random.number(2);
    ConstraintRows rows[2] = {ConstraintRows(2), ConstraintRows(2)};
    ConstraintRows::Stiffness K[2];
    for (int k : {0, 1}) {
      K[k].setZero(12, 12);
      rows[k].collect_stiffness(multipliers, &K[k]);
      (k == 0 ? derived : written).evaluate(0.4, connector::Views(m.kinematics, 2), rows[k]);
    }
    ASSERT_EQ(rows[0].count(), rows[1].count()) << name;
    for (int r = 0; r < rows[0].count(); ++r) {
      worst[0] = std::max(worst[0], std::abs(rows[0].residual(r) - rows[1].residual(r)));
      worst[1] = std::max(worst[1], std::abs(rows[0].bias(r) - rows[1].bias(r)));
      worst[2] = std::max(worst[2], std::abs(rows[0].rate(r) - rows[1].rate(r)));
      for (int k : {0, 1})
        worst[3] = std::max(worst[3], (rows[0].wrench(r, k).force - rows[1].wrench(r, k).force).norm() +
                                          (rows[0].wrench(r, k).torque - rows[1].wrench(r, k).torque).norm());
    }
    if (exact_stiffness) worst[4] = std::max(worst[4], (K[0] - K[1]).norm());
  }
  const char* what[] = {"g", "bias", "rate", "wrench", "stiffness"};
  const double size[] = {1, 30, 1, 3, 10};
  for (int k = 0; k < 5; ++k) expect_below(name + ": " + what[k], worst[k] / size[k], 1e-13);
}

TEST(JointByResidual, HasTheRowsWrittenByHand) {
  expect_the_same("ball", Ball(), SphericalJoint());
  expect_the_same("hinge", Hinge(), RevoluteJoint());
  expect_the_same("universal", Cardan(), UniversalJoint());
  expect_the_same("point on line", OnLine(), PointOnLineJoint());
  expect_the_same("point on plane", OnPlane(), PointOnPlaneJoint());
  expect_the_same("parallel axes", Parallel(), ParallelAxesJoint());
  expect_the_same("perpendicular axes", Perpendicular(), PerpendicularAxesJoint());
}

/// Against differences of what the residual itself says, for every joint: tests/support/joint_checks.h.
TEST(JointByResidual, OwesWhatEveryJointOwes) {
  const auto two = [](const auto& add, const JointExpectation& expected) {
    SystemGraph graph;
    auto& a = graph.add<RigidBody>("a", {.inertia = {0.1, 0.2, 0.3}, .angular_velocity = {0.3, 0.2, 0.1}});
    auto& b = graph.add<RigidBody>("b", {.inertia = {0.1, 0.2, 0.3}, .position = {1, 0.2, 0.1}});
    check_joint(graph, add(graph, a.marker({0.1, 0.2, 0.3}), b.marker({-0.4, 0.1, 0.2})), expected);
  };
  two(
      [](auto& g, Marker a, Marker b) -> Constraint& {
        return g.template add<Rod>("rod", {a, b}, {.length = 0.8});
      },
      {.rank = 1});
  two([](auto& g, Marker a, Marker b) -> Constraint& { return g.template add<Moved>("moved", {a, b}); }, {.rank = 1});
  two([](auto& g, Marker a, Marker b) -> Constraint& { return g.template add<Hinge>("hinge", {a, b}); }, {.rank = 5});
  SystemGraph graph;
  auto& a = graph.add<RigidBody>("a", {.inertia = {0.1, 0.2, 0.3}, .position = {0.4, 0, -1}});
  auto& b = graph.add<RigidBody>("b", {.inertia = {0.1, 0.2, 0.3}, .position = {-0.3, 0.2, -1.4}});
  check_joint(graph, graph.add<Pulley>("rope", {a.marker({0.1, 0, 0}), graph.ground().marker(), b.marker()}, {2.6}),
              {.rank = 1, .tolerance = 1e-8, .difference = 3e-4});
}

TEST(JointByResidual, KnowsWhetherItDependsOnTime) {
  EXPECT_FALSE(Rod({1}).depends_on_time());
  EXPECT_TRUE(Moved().depends_on_time());
}

/// A double pendulum in space, and a beam between its joints: the same motion as with the joints of the catalogue.
template <class Pin, class BallJoint>
Table swing(Method method, bool beam) {
  SystemGraph graph;
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  auto& first = graph.add<RigidBody>("first", {.mass = 1, .inertia = {0.01, 0.1, 0.1}, .position = {0.5, 0, 0}});
  auto& second = graph.add<RigidBody>(
      "second", {.mass = 0.7, .inertia = {0.01, 0.06, 0.06}, .position = {1, 0.4, 0}, .angular_velocity = {0, 0, 0}});
  graph.add<Pin>("pin", {graph.ground().marker({0, 0, 0}, along_y), first.marker({-0.5, 0, 0}, along_y)});
  graph.add<BallJoint>("ball", {first.marker({0.5, 0, 0}), second.marker({0, -0.4, 0})});
  Marker tip = second.marker({0, 0.4, 0});
  if (beam) {
    const BeamSection section = BeamSection::diagonal({1e4, 1e4, 1e4, 5, 8, 8}, 0.3, {2e-4, 1e-4, 1e-4});
    auto& whip = graph.add<Beam>(
        "whip",
        {.axis = BeamAxis::straight({1, 0.8, 0}, {1.5, 0.8, 0}, {0, 1, 0}), .sections = {{0, section}}, .elements = 4});
    graph.add<BallJoint>("tie", {tip, whip.marker(0)});
    tip = whip.marker(0.5);
  }
  const System system = assemble(graph);
  Recorder recorder({position(tip, "tip")});
  Simulation simulation(system, *method);
  simulation.observe(recorder, every(0.1));
  State state = system.initial_state();
  simulation.run(state, 0.5);
  return recorder.table();
}

double apart(const Table& a, const Table& b) {
  double most = 0;
  for (std::size_t k = 0; k < a.values.size(); ++k) most = std::max(most, std::abs(a.values[k] - b.values[k]));
  return most;
}

TEST(JointByResidual, MovesAsTheCataloguesJoints) {
  expect_below("Runge-Kutta 8",
               apart(swing<Hinge, Ball>(runge_kutta8_fixed(1e-3), false),
                     swing<RevoluteJoint, SphericalJoint>(runge_kutta8_fixed(1e-3), false)),
               1e-11);
  // Corrections down to 1e-9: below round-off of the beam's forces rounding would choose the steps that are repeated.
  const auto method = [] { return std::make_unique<Radau>(Radau::Parameters{.step = 2e-3, .newton_tolerance = 1e-9}); };
  for (const bool beam : {false, true})
    expect_below("Radau",
                 apart(swing<Hinge, Ball>(method(), beam), swing<RevoluteJoint, SphericalJoint>(method(), beam)),
                 1e-11);
}

// ---- forces ----

struct Spring final : ForceByPotential<Spring, 2> {
  struct Parameters {
    double stiffness, length;
  } p;
  explicit Spring(Parameters parameters) : p(parameters) {}
  template <class S>
  S potential(Poses<S> m) const {
    return 0.5 * p.stiffness * pow((m[1].p - m[0].p).norm() - p.length, 2);
  }
};

struct StiffSpring final : ForceByStretch<StiffSpring, 2> {
  struct Parameters {
    double stiffness, damping, length;
  } p;
  explicit StiffSpring(Parameters parameters) : p(parameters) {}
  template <class S>
  S stretch(Poses<S> m) const {
    return (m[1].p - m[0].p).norm() - p.length;
  }
  Tension tension(double x, double speed) const {
    return {p.stiffness * x + p.damping * speed, p.stiffness, p.damping, 0.5 * p.stiffness * x * x};
  }
};

/// Two magnets: energy of dipoles along z, turning each other.
struct Magnets final : ForceByPotential<Magnets, 2> {
  struct Parameters {};
  explicit Magnets(Parameters = {}) {}
  template <class S>
  S potential(Poses<S> m) const {
    const Vector<S> d = m[1].p - m[0].p;
    const S r = d.norm();
    return 0.2 * (m[0].z().dot(m[1].z()) / pow(r, 3) - 3.0 * m[0].z().dot(d) * m[1].z().dot(d) / pow(r, 5));
  }
};

TEST(ForceByPotential, IsTheSpringWrittenByHand) {
  RandomNumbers random(8);
  const Spring derived({.stiffness = 30, .length = 0.7});
  const StiffSpring row({.stiffness = 30, .damping = 4, .length = 0.7});
  for (int i = 0; i < 100; ++i) {
    const RandomMarkers m(random);
    ForceRows rows(2), stiff(2);
    derived.evaluate(0, connector::Views(m.kinematics, 2), rows);
    stiff.set_reaction({Vector3::Zero(), Vector3::Zero()});
    row.evaluate(0, connector::Views(m.kinematics, 2), stiff);
    const Vector3 d = m.kinematics[1].p - m.kinematics[0].p, u = d.normalized();
    const double x = d.norm() - 0.7, speed = u.dot(m.kinematics[1].v - m.kinematics[0].v);
    expect_below("force", (rows.load(1).force + 30 * x * u).norm(), 1e-12);
    expect_below("against it", (rows.load(0).force - 30 * x * u).norm(), 1e-12);
    expect_below("torque", rows.load(0).torque.norm(), 1e-14);
    EXPECT_NEAR(rows.energy(), 15 * x * x, 1e-12);
    EXPECT_NEAR(stiff.tension(0), 30 * x + 4 * speed, 1e-12);
    expect_below("row", (stiff.wrench(0, 1).force - u).norm(), 1e-14);
  }
}

TEST(ForceByPotential, OwesWhatEveryForceOwes) {
  const auto two = [](const auto& add, const ForceExpectation& expected) {
    SystemGraph graph;
    auto& a = graph.add<RigidBody>("a", {.inertia = {0.1, 0.2, 0.3}});
    auto& b = graph.add<RigidBody>("b", {.inertia = {0.1, 0.2, 0.3}, .position = {1, 0.2, 0.1}});
    check_force(graph, add(graph, a.marker({0.1, 0.2, 0.3}), b.marker({0.4, 0.1, 0.2})), expected);
  };
  two([](auto& g, Marker a, Marker b) -> ForceElement& { return g.template add<Spring>("s", {a, b}, {30, 0.7}); }, {});
  two(
      [](auto& g, Marker a, Marker b) -> ForceElement& {
        return g.template add<StiffSpring>("s", {a, b}, {30, 4, 0.7});
      },
      {});
  two(
      [](auto& g, Marker a, Marker b) -> ForceElement& {
        return g.template add<Magnets>("m", {a, b});
      },
      {.tolerance = 1e-7});
}

}  // namespace
}  // namespace lithe::test::joint_by_residual_test
