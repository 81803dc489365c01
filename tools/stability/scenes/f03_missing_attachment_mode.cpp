// F03: a joint on a reduced body whose modes do not know it: with eigenmodes alone the place yields too little, and
// more of them hardly help; the static modes of the interface make it exact.
#include <Eigen/SparseCholesky>
#include <numeric>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/prismatic_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr int kBays = 12;
constexpr double kSide = 0.1, kBar = 2e6, kMass = 0.05;  // m, EA of each bar (N), kg a node

/// A girder of pin-jointed bars along x: cubes with all their edges and the diagonals of their faces.
FiniteElementModel girder() {
  FiniteElementModel model;
  model.name = "girder of bars";
  const int count = 4 * (kBays + 1);
  model.nodes.resize(3, count);
  model.node_ids.resize(count);
  std::iota(model.node_ids.begin(), model.node_ids.end(), 1);
  for (int i = 0; i < count; ++i) model.nodes.col(i) = kSide * Vector3(i / 4, i % 2 - 0.5, i / 2 % 2 - 0.5);
  model.node_sets["root"] = {1, 2, 3, 4};
  model.node_sets["tip"] = {count - 3, count - 2, count - 1, count};
  std::vector<Eigen::Triplet<double>> K, M;
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count; ++b) {
      const Vector3 d = model.nodes.col(b) - model.nodes.col(a);
      if (d.norm() > 1.45 * kSide) continue;  // edges and face diagonals, no space diagonals
      const Matrix3 k = kBar / d.norm() * d.normalized() * d.normalized().transpose();
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          K.emplace_back(3 * a + i, 3 * a + j, k(i, j)), K.emplace_back(3 * b + i, 3 * b + j, k(i, j));
          K.emplace_back(3 * a + i, 3 * b + j, -k(i, j)), K.emplace_back(3 * b + i, 3 * a + j, -k(i, j));
        }
    }
  for (int i = 0; i < 3 * count; ++i) M.emplace_back(i, i, kMass);
  model.stiffness.resize(3 * count, 3 * count), model.mass.resize(3 * count, 3 * count);
  model.stiffness.setFromTriplets(K.begin(), K.end());
  model.mass.setFromTriplets(M.begin(), M.end());
  return model;
}

/// What the tip yields along x to a unit force spread over its nodes, m/N, of the mesh itself with its root held.
double exact_compliance() {
  const FiniteElementModel model = girder();
  const int n = 3 * model.node_count() - 12;
  const SparseMatrix K = model.stiffness.bottomRightCorner(n, n);
  VectorX f = VectorX::Zero(n);
  for (int k = 0; k < 4; ++k) f[n - 3 * (k + 1)] = 0.25;
  return f.dot(Eigen::SimplicialLDLT<SparseMatrix>(K).solve(f));
}

/// The girder welded to the ground by its root, its tip tied by a ball to a slide along x that a force pulls.
double compliance(int modes, const Reduction& interfaces) {
  constexpr double kForce = 1, kTie = 1e6;  // N: small deflections; N/m, of the tie itself
  const FiniteElementModel model = girder();
  const auto tip = model.node_set("tip");
  Bench scene(Vector3::Zero(), [&](SystemGraph& graph) {
    const Matrix3 along_x = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), Vector3::UnitX()).matrix();
    auto& body = graph.add<FlexibleBody>(
        "girder", {.basis = make_basis(model, TangentFrame{model.node_set("root")}, modes, interfaces)});
    graph.add<FixedJoint>("weld", {graph.ground().marker(), body.frame()});
    const Vector3 place(kBays * kSide, 0, 0);
    auto& slide = graph.add<RigidBody>("slide", {.mass = 1, .inertia = {1, 1, 1}, .position = place});
    graph.add<PrismaticJoint>("guide", {graph.ground().marker(place, along_x), slide.marker({0, 0, 0}, along_x)});
    graph.add<SpringDamper>("tie", {body.average(tip), slide.marker({1, 0, 0})},
                            {.stiffness = kTie, .natural_length = 1});
    graph.add<PointForce>("pull", {slide.marker()}, {.force = {kForce, 0, 0}});
  });
  const State end = find_equilibrium(scene.system, scene.state).state;
  return (end.q[scene.system.layout().bodies()[1].q] - kBays * kSide) / kForce - 1 / kTie;
}

Finding finding(int modes, const Reduction& interfaces, const std::string& why) {
  const double measured = compliance(modes, interfaces), exact = exact_compliance();
  return {judged(measured / exact - 1, 0.01),
          {{"compliance along the girder over the mesh's", measured / exact}, {"of the mesh, m/N", exact}},
          why};
}

const Registered scene{
    {"F03",
     "joint at a place that the modes do not know",
     {{"4 lowest modes of the held body", [] { return finding(4, {}, "they bend: along its axis the body is rigid"); },
       Role::also},
      {"10 lowest modes", [] { return finding(10, {}, "the first stretching modes only"); }, Role::also},
      {"30 lowest modes", [] { return finding(30, {}, "converges as one over the number of stretching modes"); },
       Role::also},
      {"4 lowest modes and the interface's six static ones",
       [] { return finding(4, {.loaded = {{girder().node_set("tip")}}}, "exact at rest by construction"); },
       Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
