#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/assembly/evaluator.h"
#include "joints/fixed_joint.h"
#include "joints/forces/spring_damper.h"
#include "joints/orientation_joint.h"
#include "joints/parallel_axes_joint.h"
#include "joints/perpendicular_axes_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/support/dense.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// Rigid bodies between joints that hold a point and axes have short ways: blocks straight from the poses, a scalar and
/// a 3 x 3 in the factor. Beside the same joints without their RigidRows, which take the general ones.
namespace lithe::test::plain_frames_test {
namespace {

/// The rows of a joint of the catalogue, of which the engine knows nothing.
template <class T>
class General final : public Joint<T::kMarkers, T::kRows> {
 public:
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    joint_.evaluate(time, markers, rows);
  }

 private:
  T joint_;
};

struct Scene {
  SystemGraph graph{{.gravity = {0.3, -9.81, 0.2}}};
  int plain = 0;  // frames

  /// Bodies in a row between joints of a type, from ground on; `branches`: each second body carries a further one.
  /// `closed`: the last is held by a ball too.
  template <class T>
  Scene& chain(bool branches, bool closed) {
    RandomNumbers random(7);
    RigidBody* last = nullptr;
    for (int i = 0; i < 5; ++i) {
      RigidBody& body = add_body(random);
      tie<T>(last, body, random);
      last = &body;
      if (branches && i % 2 == 1) tie<T>(&body, add_body(random), random);
    }
    const Vector3 end(1, 2, 0.5);
    if (closed) graph.add<SphericalJoint>("closing", {last->marker_at_world(end), graph.ground().marker(end)});
    return *this;
  }

 private:
  RigidBody& add_body(RandomNumbers& random) {
    const Matrix3 turn = random.rotation();
    return graph.add<RigidBody>(
        "body " + std::to_string(graph.bodies().size()),
        {.mass = 2 + random.number(),
         .inertia = Matrix3(turn * Vector3(1.1 + 0.2 * random.number(), 1.3, 1.5).asDiagonal() * turn.transpose()),
         .position = random.vector3(),
         .orientation = random.rotation(),
         .velocity = random.vector3(),
         .angular_velocity = random.vector3()});
  }
  /// Closed as drawn: there the rows are independent of each other.
  template <class T>
  void tie(RigidBody* A, RigidBody& B, RandomNumbers& random) {
    const Vector3 place = random.vector3();
    const Matrix3 axes = random.rotation();
    graph.add<T>("joint " + std::to_string(graph.constraints().size()),
                 {A ? A->marker_at_world(place, axes) : graph.ground().marker(place, axes),
                  B.marker_at_world(place, axes * crossed<T>())});
  }
  /// The joint of one row holds z axes at right angles.
  template <class T>
  static Matrix3 crossed() {
    return std::is_same_v<T, PerpendicularAxesJoint> || std::is_same_v<T, General<PerpendicularAxesJoint>>
               ? rotation_about({1, 0, 0}, M_PI / 2)
               : Matrix3(Matrix3::Identity());
  }
};

/// All that the equations tell at random states near the drawing, where the rows are off by a tenth.
struct Told {
  VectorX residual, gap, rate, bias, x, y;
  MatrixX matrix;
};
Told tell(const System& system, int seed) {
  Evaluator evaluator(system);
  RandomNumbers random(static_cast<unsigned>(seed));
  const Layout& layout = system.layout();
  const int n = layout.v_count(), rows = layout.row_count();
  VectorX q(layout.q_count());
  layout.retract(system.initial_state().q, random.vector(n, 0.1), q);
  const VectorX v = random.vector(n, 3), v_dot = random.vector(n, 5), lambda = random.vector(rows, 20),
                increment = random.vector(n, 0.3);
  Told told{VectorX(n), VectorX(rows), VectorX(rows), VectorX(rows), random.vector(n), random.vector(rows), {}};
  evaluator.evaluate(0, q, v, Level::acceleration);
  evaluator.constraint(Level::acceleration, told.bias);
  evaluator.evaluate(0, q, v, Level::velocity);
  evaluator.residual(v_dot, lambda, told.residual);
  evaluator.constraint(Level::position, told.gap);
  evaluator.constraint(Level::velocity, told.rate);
  evaluator.factorize({1, 20, 400}, v_dot, lambda, &increment);
  told.matrix = dense(evaluator).all;
  evaluator.solve(told.x, told.y);
  return told;
}

double apart(const MatrixX& a, const MatrixX& b) { return (a - b).norm() / (1e-3 + b.norm()); }

void expect_equal(const Told& fast, const Told& general, const std::string& what) {
  const auto expect = [&](const char* part, const MatrixX& a, const MatrixX& b, double bound) {
    expect_below(what + ", " + part, apart(a, b), bound);
  };
  expect("gap", fast.gap, general.gap, 1e-14);
  expect("rate", fast.rate, general.rate, 1e-14);
  expect("bias", fast.bias, general.bias, 1e-14);
  expect("residual", fast.residual, general.residual, 1e-14);
  expect("matrix", fast.matrix, general.matrix, 1e-14);
  expect("x", fast.x, general.x, 1e-12);
  expect("y", fast.y, general.y, 1e-12);
}

int plain_count(const System& system) {
  int count = 0;
  for (const auto& frame : system.blocks().frames) count += frame.plain;
  return count;
}

template <class T>
class PlainFrames : public testing::Test {};
using Joints = testing::Types<SphericalJoint, RevoluteJoint, UniversalJoint, FixedJoint, ParallelAxesJoint,
                              PerpendicularAxesJoint, OrientationJoint>;
TYPED_TEST_SUITE(PlainFrames, Joints);

TYPED_TEST(PlainFrames, TellWhatTheGeneralOnesDo) {
  const AssembleOptions as_drawn{.start = AssembleOptions::Start::as_drawn};
  for (const bool branches : {false, true})
    for (const bool closed : {false, true}) {
      if (closed && 5 * TypeParam::kRows + 3 > 30) continue;  // more rows than velocities
      Scene fast, general;
      const System system = assemble(fast.chain<TypeParam>(branches, closed).graph, as_drawn),
                   other = assemble(general.chain<General<TypeParam>>(branches, closed).graph, as_drawn);
      EXPECT_EQ(plain_count(system), 5) << "of bodies with two joints at most";
      EXPECT_EQ(plain_count(other), 0);
      for (int seed = 1; seed < 4; ++seed)
        expect_equal(tell(system, seed), tell(other, seed),
                     std::string(branches ? "tree" : "chain") + (closed ? ", closed" : ""));
    }
}

/// What else acts on a body makes its block a full one.
TEST(PlainFramesOf, BodiesUnderForcesAreNone) {
  SystemGraph graph{{}};
  auto& a = graph.add<RigidBody>("a", {});
  auto& b = graph.add<RigidBody>("b", {.position = {2, 0, 0}});
  graph.add<SphericalJoint>("pin", {graph.ground().marker({-1, 0, 0}), a.marker({-1, 0, 0})});
  graph.add<SphericalJoint>("ball", {a.marker({1, 0, 0}), b.marker({-1, 0, 0})});
  EXPECT_EQ(plain_count(assemble(graph)), 2);
  graph.add<SpringDamper>("spring", {graph.ground().marker({3, 1, 0}), b.marker({1, 0, 0})}, {.stiffness = 10});
  const System system = assemble(graph);
  EXPECT_TRUE(system.blocks().frames[0].plain);
  EXPECT_FALSE(system.blocks().frames[1].plain);
}

/// A joint between two markers of one body: what it does to the one it undoes to the other.
TEST(PlainFramesOf, ABodyTiedToItselfIsNone) {
  SystemGraph graph{{}};
  auto& a = graph.add<RigidBody>("a", {});
  graph.add<SphericalJoint>("pin", {graph.ground().marker({-1, 0, 0}), a.marker({-1, 0, 0})});
  graph.add<ParallelAxesJoint>("itself", {a.marker({0, 0, 0}), a.marker({0, 1, 0})});
  const System system = assemble(graph, {.start = AssembleOptions::Start::as_drawn});
  EXPECT_FALSE(system.blocks().frames[0].plain);
}

}  // namespace
}  // namespace lithe::test::plain_frames_test
