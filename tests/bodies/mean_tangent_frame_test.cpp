// A frame held by the mean of a face: what the face keeps and what it may do.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/base/error.h"
#include "engine/observe/snapshot.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::mean_tangent_frame_test {
namespace {

/// A block 1 x 0.2 x 0.2 m of 8-node bricks, one across: the four nodes of a face bear a uniform stress alike.
struct Block {
  static constexpr double length = 1, height = 0.2, young = 2e11, poisson = 0.3;
  FiniteElementModel model = brick_mesh(
      {.size = {length, height, height}, .divisions = {5, 1, 1}, .type = "C3D8", .material = {young, poisson, 7800}});
  const std::vector<int>& root() const { return model.node_set("x_min"); }
  const std::vector<int>& end() const { return model.node_set("x_max"); }
  Vector3 drawn(int id) const { return model.nodes.col(model.node_index(id)); }
};

struct Pulled {
  Matrix3X displacements;  // of all nodes
  Vector3 mean_root, mean_end;
};

/// Welded to ground by the mean of its root, pulled at its end.
Pulled pull(const Block& block, const BodyFrame& frame, double force, int modes = 4) {
  const auto basis = make_basis(block.model, frame, modes, {.loaded = {{block.end()}}});
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& body = graph.add<FlexibleBody>("block", {.basis = basis});
  const Marker root = body.average(block.root()), end = body.average(block.end());
  Vector3 middle = Vector3::Zero();
  for (int id : block.root()) middle += block.drawn(id) / static_cast<double>(block.root().size());
  graph.add<FixedJoint>("weld", {graph.ground().marker(middle), root});
  graph.add<PointForce>("pull", {end}, {.force = {force, 0, 0}});
  std::vector<Marker> nodes;
  for (int id : block.model.node_ids) nodes.push_back(body.node(id));
  const System system = assemble(graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  Snapshot now(system, found.state);
  Pulled result{Matrix3X(3, static_cast<Eigen::Index>(nodes.size())), Vector3::Zero(), Vector3::Zero()};
  for (std::size_t i = 0; i < nodes.size(); ++i)
    result.displacements.col(static_cast<Eigen::Index>(i)) =
        now.marker(nodes[i]).p - block.model.nodes.col(static_cast<Eigen::Index>(i));
  for (int id : block.root()) result.mean_root += result.displacements.col(block.model.node_index(id)) / 4;
  for (int id : block.end()) result.mean_end += result.displacements.col(block.model.node_index(id)) / 4;
  return result;
}

/// By how much a face grows across, relative: the mean over y and z of its nodes.
double strain_across(const Block& block, const Pulled& pulled, const std::vector<int>& face) {
  Vector3 middle = Vector3::Zero(), moved = Vector3::Zero();
  for (int id : face) middle += block.drawn(id) / 4, moved += pulled.displacements.col(block.model.node_index(id)) / 4;
  double up = 0, down = 0;
  for (int id : face) {
    const Vector3 arm = block.drawn(id) - middle, u = pulled.displacements.col(block.model.node_index(id)) - moved;
    up += arm.tail<2>().dot(u.tail<2>()), down += arm.tail<2>().squaredNorm();
  }
  return up / down;
}

/// Uniform stress: ε_x = σ/E, ε_y = ε_z = -ν σ/E everywhere, at the held face too, as if it were a plane of symmetry.
TEST(MeanTangentFrame, LetsAPulledFaceShrinkAsPoissonSays) {
  const Block block;
  constexpr double stress = 1e6, force = stress * Block::height * Block::height;
  const Pulled free = pull(block, MeanTangentFrame{{block.root()}}, force);
  for (const auto* face : {&block.root(), &block.end()})
    EXPECT_NEAR(strain_across(block, free, *face) / (-Block::poisson * stress / Block::young), 1, 1e-7);
  EXPECT_NEAR(free.mean_end.x() / (stress / Block::young * Block::length), 1, 1e-7);
  EXPECT_LT(free.mean_root.norm(), 1e-9 * free.mean_end.norm());
  for (Eigen::Index i = 0; i < free.displacements.cols(); ++i)
    EXPECT_NEAR(free.displacements(0, i),
                stress / Block::young * (block.model.nodes(0, i) - block.drawn(block.root()[0]).x()),
                1e-7 * free.mean_end.x());

  // A tangent frame holds the root, which makes the block stiffer along.
  const Pulled held = pull(block, TangentFrame{block.root()}, force);
  EXPECT_LT(std::abs(strain_across(block, held, block.root())), 1e-9 * stress / Block::young);
  EXPECT_LT(held.mean_end.x(), 0.995 * free.mean_end.x());
}

/// Of K and M by dense elimination, Z a basis of the displacements whose mean motion over the face is zero.
TEST(MeanTangentFrame, HasTheEigenfrequenciesOfTheMeshHeldByThatMean) {
  const Block block;
  Vector3 middle = Vector3::Zero();
  for (int id : block.root()) middle += block.drawn(id) / 4;
  MatrixX F = MatrixX::Zero(block.model.dof_count(), 6);
  for (int id : block.root()) {
    const int i = 3 * block.model.node_index(id);
    F.block<3, 3>(i, 0).setIdentity();
    F.block<3, 3>(i, 3) = skew(block.drawn(id) - middle).transpose();
  }
  const MatrixX Z = complement(F);
  const VectorX all = symmetric_eigenvalues(congruence(Z, block.model.stiffness), congruence(Z, block.model.mass));
  const auto basis = make_basis(block.model, MeanTangentFrame{{block.root()}}, 6);
  ASSERT_EQ(basis->mode_count(), 6);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(basis->frequencies[k] / (std::sqrt(all[k]) / (2 * M_PI)), 1, 1e-8) << k;
}

TEST(MeanTangentFrame, LeavesTheMeanMotionOfItsNodesZeroInEveryMode) {
  const Block block;
  const std::vector<double> weights = {1, 2, 3, 4};
  for (const InterfaceModes kind : {InterfaceModes::attachment, InterfaceModes::craig_bampton, InterfaceModes::krylov})
    for (const Deflection deflection : {Deflection::linear, Deflection::quadratic}) {
      const auto basis = make_basis(block.model, MeanTangentFrame{{block.root(), weights}}, 5,
                                    {.loaded = {{block.end()}},
                                     .interface_modes = kind,
                                     .given_modes = MatrixX::Random(3 * block.model.node_count(), 1),
                                     .deflection = deflection});
      ASSERT_GE(basis->mode_count(), 6);  // one fixed interface has no constraint modes but rigid motions
      MatrixX shapes = basis->modes;
      if (basis->deflection) {
        shapes.conservativeResize(Eigen::NoChange, shapes.cols() + basis->deflection->fields.cols());
        shapes.rightCols(basis->deflection->fields.cols()) = basis->deflection->fields;
      }
      for (Eigen::Index m = 0; m < shapes.cols(); ++m) {
        Vector3 translation = Vector3::Zero(), turn = Vector3::Zero();
        for (int k = 0; k < 4; ++k) {
          const int i = block.model.node_index(block.root()[k]);
          const Vector3 u = shapes.col(m).segment<3>(3 * i), arm = basis->nodes.col(i);
          translation += weights[k] / 10 * u;
          turn += weights[k] / 10 * arm.cross(u);
        }
        const double size = shapes.col(m).lpNorm<Eigen::Infinity>();
        EXPECT_LT(translation.norm(), 1e-9 * size) << m;
        EXPECT_LT(turn.norm(), 1e-9 * size * Block::height) << m;
      }
    }
}

TEST(MeanTangentFrame, RefusesNodesOnALineAndAllNodalCoordinates) {
  const Block block;
  EXPECT_THROW(make_basis(block.model, MeanTangentFrame{{{block.root()[0], block.root()[1]}}}, 3), SceneError);
  EXPECT_THROW(make_basis(block.model, MeanTangentFrame{{{}}}, 3), SceneError);
  EXPECT_THROW(make_basis(block.model, MeanTangentFrame{{block.root()}}, kAllNodal), SceneError);
}

}  // namespace
}  // namespace lithe::test::mean_tangent_frame_test
