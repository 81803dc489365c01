#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "engine/factor/block_kernels.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/three_node_fixation.h"
#include "joints/universal_joint.h"
#include "tests/support/dense.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/marker_body.h"
#include "tests/support/motion.h"

namespace lithe::test::block_factor_test {
namespace {

/// A body with one marker at each given place of the world, rigid or with modes that move the markers.
class Part {
 public:
  Part(SystemGraph& graph, RandomNumbers& random, const std::vector<Vector3>& places, int modes = 0) {
    const std::string name = "body " + std::to_string(graph.bodies().size());
    const Vector3 position = random.vector3();
    const Matrix3 A = random.rotation();
    if (modes == 0) {
      auto& body = graph.add<RigidBody>(name, {.mass = 2 + random.number(),
                                               .inertia = Vector3(Vector3(1, 1.1, 1.2) + 0.2 * random.vector3()),
                                               .position = position,
                                               .orientation = A});
      for (const Vector3& place : places)
        markers_.push_back(body.marker(A.transpose() * (place - position), A.transpose()));
      return;
    }
    MarkerBody::Parameters parameters{.position = position, .orientation = A, .eta = VectorX::Zero(modes)};
    for (const Vector3& place : places)
      parameters.markers.push_back({A.transpose() * (place - position), random.matrix3x(modes, 0.5),
                                    random.matrix3x(modes, 0.5), A.transpose()});
    auto& body = graph.add<MarkerBody>(name, parameters);
    for (std::size_t i = 0; i < places.size(); ++i) markers_.push_back(body.marker(static_cast<int>(i)));
  }
  Marker operator[](int i) const { return markers_[i]; }

 private:
  std::vector<Marker> markers_;
};

/// Solves random right-hand sides at random states by the block factor and by dense elimination. `distance` of the
/// states from the drawing, in metres and radians.
void expect_same_as_dense(SystemGraph& graph, double distance = 0.2) {
  const System system = assemble(graph);
  ASSERT_TRUE(system.redundant_rows().empty());
  Evaluator evaluator(system);
  RandomNumbers random(3);
  const int n = system.layout().v_count(), rows = system.layout().row_count();
  for (int k = 0; k < 4; ++k) {
    VectorX q(system.layout().q_count());
    system.layout().retract(system.initial_state().q, random.vector(n, distance), q);
    const VectorX increment = random.vector(n, 0.1), v_dot = random.vector(n), lambda = random.vector(rows);
    evaluator.evaluate(0, q, random.vector(n), Level::acceleration);
    for (const TangentWeights weights : {TangentWeights{0, 0, 1}, TangentWeights{1, 20, 400}}) {
      evaluator.factorize(weights, v_dot, lambda, weights.position > 0 ? &increment : nullptr);
      const DenseMatrix matrix = dense(evaluator);
      MatrixX all = matrix.all.topLeftCorner(n + rows, n + rows);
      all.topLeftCorner(n, n) = matrix.condensed_S();
      const VectorX right = random.vector(n + rows), expected = solve(all, right);
      VectorX x = right.head(n), y = right.tail(rows);
      evaluator.solve(x, y);
      EXPECT_LT((x - expected.head(n)).norm(), 1e-9 * expected.head(n).norm());
      EXPECT_LT((y - expected.tail(rows)).norm(), 1e-9 * (1e-12 + expected.tail(rows).norm()));
    }
  }
}

std::string joint_name(const SystemGraph& graph) {
  return "tie " + std::to_string(graph.constraints().size() + graph.forces().size());
}

/// A point on the way, off any line and plane.
Vector3 place(int i) { return {std::cos(1.3 * i), 0.4 * i, std::sin(2.1 * i)}; }

class BlockFactor : public testing::TestWithParam<int> {  // modes of every second body
 protected:
  Part part(const std::vector<Vector3>& places) {
    return Part(graph_, random_, places, graph_.bodies().size() % 2 == 0 ? GetParam() : 0);
  }
  template <class T, class... Parameters>
  void tie(std::vector<Marker> markers, Parameters... parameters) {
    graph_.add<T>(joint_name(graph_), std::move(markers), parameters...);
  }
  Marker ground(const Vector3& at) { return graph_.ground().marker(at); }

  SystemGraph graph_;
  RandomNumbers random_{5};
};

TEST_P(BlockFactor, SolvesAFreeBodyAndAChainFromGround) {
  Part free = part({place(9)});
  tie<PointForce>({free[0]}, PointForce::Parameters{.force = {1, 2, 3}});
  Marker last = ground(place(0));
  for (int i = 0; i < 5; ++i) {
    const Part link = part({place(i), place(i + 1)});
    if (i % 2 == 0)
      tie<RevoluteJoint>({last, link[0]});
    else
      tie<SphericalJoint>({link[0], last});
    last = link[1];
  }
  expect_same_as_dense(graph_);
}

TEST_P(BlockFactor, SolvesATreeThatFloats) {
  const Part root = part({place(0), place(1), place(2)});
  for (int i = 0; i < 3; ++i) {
    const Part branch = part({place(i), place(i + 5), place(i + 6)});
    tie<UniversalJoint>({root[i], branch[0]});
    const Part leaf = part({place(i + 5)}), other = part({place(i + 6)});
    tie<FixedJoint>({branch[1], leaf[0]});
    tie<RevoluteJoint>({other[0], branch[2]});
  }
  expect_same_as_dense(graph_);
}

TEST_P(BlockFactor, SolvesALoop) {
  std::vector<Part> ring;
  for (int i = 0; i < 5; ++i) ring.push_back(part({place(i), place((i + 1) % 5)}));
  for (int i = 0; i < 5; ++i) tie<SphericalJoint>({ring[i][1], ring[(i + 1) % 5][0]});
  tie<DistanceJoint>({ring[0][0], ground({0, -2, 0})});
  expect_same_as_dense(graph_);
}

TEST_P(BlockFactor, SolvesAChainPinnedAtBothEnds) {
  Marker last = ground(place(0));
  for (int i = 0; i < 6; ++i) {
    const Part link = part({place(i), place(i + 1)});
    tie<SphericalJoint>({last, link[0]});
    last = link[1];
  }
  tie<SphericalJoint>({last, ground(place(6))});
  expect_same_as_dense(graph_);
}

/// Two loops that share a body, and a body that hangs on both by nothing but joints of one row.
TEST_P(BlockFactor, SolvesLoopsThatShareABody) {
  const Part hub = part({place(0), place(1), place(2), place(3)});
  const Part a = part({place(0), place(4)}), b = part({place(1), place(4)}), c = part({place(2), place(5)}),
             d = part({place(3), place(5)});
  tie<SphericalJoint>({hub[0], a[0]});
  tie<SphericalJoint>({hub[1], b[0]});
  tie<SphericalJoint>({hub[2], c[0]});
  tie<SphericalJoint>({hub[3], d[0]});
  tie<RevoluteJoint>({a[1], b[1]});
  tie<UniversalJoint>({c[1], d[1]});
  const Part bob = part({place(7)});
  for (const Marker& m : {a[1], c[1], hub[0]}) tie<DistanceJoint>({m, bob[0]});
  expect_same_as_dense(graph_);
}

TEST_P(BlockFactor, SolvesAHubOfManySpokes) {
  std::vector<Vector3> rim;
  for (int i = 0; i < 12; ++i) rim.push_back(place(i));
  const Part hub = part(rim);
  for (int i = 0; i < 12; ++i) {
    const Part spoke = part({place(i), place(i) + Vector3(1, 0, 0.3)});
    tie<RevoluteJoint>({hub[i], spoke[0]});
    if (i % 3 == 0) tie<DistanceJoint>({spoke[1], ground({0.3 * i, 0, 5})});
  }
  expect_same_as_dense(graph_);
}

/// Near their natural length, as stiff springs are: far from it their pull alone would make the matrix indefinite.
TEST_P(BlockFactor, SolvesBodiesCoupledBySprings) {
  const SpringDamper::Parameters soft{.stiffness = 30, .damping = 2, .natural_length = 0.8}, stiff{.stiffness = 1e7},
      constant{.preload = 5};
  std::vector<Part> parts;
  for (int i = 0; i < 5; ++i) parts.push_back(part({place(i), place(i + 6)}));
  for (int i = 0; i < 5; ++i)
    for (int k = 0; k < i; ++k) tie<SpringDamper>({parts[k][1], parts[i][0]}, (i + k) % 2 ? soft : stiff);
  tie<SphericalJoint>({ground(place(0)), parts[0][0]});
  tie<SpringDamper>({ground({0, 0, 0}), parts[4][1]}, constant);
  tie<PointForce>({parts[2][0]}, PointForce::Parameters{.force = {1, 2, 3}, .axes = PointForce::Axes::marker});
  expect_same_as_dense(graph_, 1e-5);
}

/// A joint of four markers, three of them on one body; and two joints that see each other through its modes.
class BlockFactorOfClamps : public BlockFactor {};
TEST_P(BlockFactorOfClamps, SolvesJointsOfSeveralMarkersOnOneBody) {
  const Part hub = part({place(0)}), link = part({place(1), place(2), place(3), place(4)}), end = part({place(4)});
  tie<SphericalJoint>({ground(place(0)), hub[0]});
  tie<ThreeNodeFixation>({hub[0], link[0], link[1], link[2]});
  tie<SphericalJoint>({link[3], end[0]});
  expect_same_as_dense(graph_);
}

std::string modes_of(const testing::TestParamInfo<int>& modes) { return std::to_string(modes.param) + "Modes"; }
INSTANTIATE_TEST_SUITE_P(RigidAndModal, BlockFactor, testing::Values(0, 1, 4), modes_of);
INSTANTIATE_TEST_SUITE_P(Modal, BlockFactorOfClamps, testing::Values(3, 6), modes_of);  // fewer leave rows dependent

/// A block as the kernels lay it out: columns apart, rows at their places.
std::vector<double> laid_out(const MatrixX& A) {
  const int m = static_cast<int>(A.rows());
  std::vector<double> block(static_cast<std::size_t>(kernels::stride<double>(m) * A.cols()));
  for (int j = 0; j < A.cols(); ++j)
    for (int i = 0; i < m; ++i)
      block[static_cast<std::size_t>(kernels::place<double>(i, m) + kernels::stride<double>(m) * j)] = A(i, j);
  return block;
}

TEST(BlockKernels, OfAnySizeAreProductsOfMatrices) {
  RandomNumbers random(8);
  const auto expect_near = [](const std::vector<double>& block, const MatrixX& expected) {
    const std::vector<double> all = laid_out(expected);
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_NEAR(block[i], all[i], 1e-12) << i;
  };
  const auto matrix = [&](int rows, int columns) {
    return MatrixX(random.vector(rows * columns).reshaped(rows, columns));
  };
  for (const int m : {1, 3, 5, 7, 9, 13, 20})
    for (const int k : {2, 6, 8, 20})
      for (const int n : {1, 4, 6, 11}) {
        const MatrixX A = matrix(m, k), B = matrix(k, n), C = matrix(m, n), P = matrix(k, k);
        std::vector<double> into = laid_out(C), applied = laid_out(B);
        kernels::product_any<double, false>(into.data(), laid_out(A).data(), laid_out(B).data(), m, k, n);
        expect_near(into, C - A * B);
        kernels::product_any<double, true>(into.data(), laid_out(A).data(), laid_out(B).data(), m, k, n);
        expect_near(into, -A * B);
        kernels::apply_any<double>(laid_out(P).data(), applied.data(), k, n);
        expect_near(applied, P * B);
        const VectorX x = B.col(0);
        VectorX y = C.col(0), px = x;
        kernels::multiply_vector_any<double>(y.data(), laid_out(A).data(), x.data(), m, k);
        EXPECT_LT((y - (C.col(0) - A * x)).norm(), 1e-12);
        kernels::apply_vector_any<double>(laid_out(P).data(), px.data(), k);
        EXPECT_LT((px - P * x).norm(), 1e-12);
      }
}

}  // namespace
}  // namespace lithe::test::block_factor_test
