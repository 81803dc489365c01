#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/assembly/evaluator.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/support/dense.h"
#include "tests/support/json_file.h"
#include "tests/support/marker_body.h"

namespace lithe::test::oracle_test {
namespace {

using Json = nlohmann::json;

VectorX vector(const Json& j) {
  VectorX x(static_cast<int>(j.size()));
  for (int i = 0; i < x.size(); ++i) x[i] = j[i].get<double>();
  return x;
}
MatrixX matrix(const Json& j) {
  MatrixX x(static_cast<int>(j.size()), static_cast<int>(j[0].size()));
  for (int i = 0; i < x.rows(); ++i) x.row(i) = vector(j[i]).transpose();
  return x;
}

/// Joints between markers of two flexible bodies in a general state, against node positions that were differentiated at
/// 120 digits (tests/data/oracle): the bodies' markers, the joint's rows and the engine's sums all at once.
class JointOracle : public testing::Test {
 protected:
  JointOracle() { oracle_ = read_json(LITHE_TEST_DATA "/oracle/j01_joints.json"); }

  /// Body `i` of the oracle, drawn undeformed with its marker at `place` and along the world's axes.
  Marker draw(SystemGraph& graph, int i, const Vector3& place) const {
    const Json& m = oracle_["bodies"][i]["marker"];
    const ModalMarker marker{vector(m["c"]), matrix(m["Bm"]), matrix(m["Theta"]), matrix(m["R0"])};
    // The file's rotations are right to the digits it prints; ours must be so to round-off.
    const Matrix3 A = marker.R0.transpose();
    return graph
        .add<MarkerBody>("body " + std::to_string(i), {.markers = {marker},
                                                       .position = place - A * marker.c,
                                                       .orientation = A,
                                                       .eta = VectorX::Zero(marker.Bm.cols())})
        .marker();
  }

  /// q, v of both bodies, one after the other.
  VectorX join(std::initializer_list<const char*> parts) const {
    std::vector<double> all;
    for (const Json& body : oracle_["bodies"])
      for (const char* part : parts)
        for (double x : body["state"][part]) all.push_back(x);
    return Eigen::Map<VectorX>(all.data(), static_cast<int>(all.size()));
  }

  template <class T, class... Parameters>
  void check(const char* kind, const Vector3& gap, const Parameters&... parameters) {
    SCOPED_TRACE(kind);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const Marker A = draw(graph, 0, {0, 0, 0}), B = draw(graph, 1, gap);
    if constexpr (std::same_as<T, CoordinateDrive>)
      graph.add<T>("joint", {displacement_between(A, B)}, parameters...);
    else
      graph.add<T>("joint", {A, B}, parameters...);
    const System system = assemble(graph);
    Evaluator evaluator(system);
    const VectorX q = join({"x0", "quat", "eta"}), v = join({"xdot", "omega", "etadot"}),
                  v_dot = join({"xddot", "omegadot", "etaddot"});
    ASSERT_EQ(q.size(), system.layout().q_count());
    evaluator.evaluate(0, q, v, Level::acceleration);
    evaluator.factorize({0, 0, 1}, VectorX::Zero(v.size()), VectorX::Zero(T::kRows), nullptr);

    const Json& expected = oracle_["joints"][kind];
    VectorX C(T::kRows), C_dot(T::kRows), gamma(T::kRows);
    evaluator.constraint(Level::position, C);
    evaluator.constraint(Level::velocity, C_dot);
    evaluator.constraint(Level::acceleration, gamma);
    EXPECT_LT((C - vector(expected["C"])).norm(), 1e-12 * (1 + C.norm())) << "C";
    const MatrixX G1 = matrix(expected["G1"]), G2 = matrix(expected["G2"]);
    MatrixX G(T::kRows, v.size());
    G << G1, G2;
    EXPECT_LT((dense(evaluator).G() - G).norm(), 1e-12 * G.norm()) << "G";
    EXPECT_LT((C_dot - G * v - vector(expected["velocity_term"])).norm(), 1e-12 * (1 + C_dot.norm())) << "C_dot";
    EXPECT_LT((gamma - vector(expected["gamma"])).norm(), 1e-12 * (1 + gamma.norm())) << "gamma";

    // Reactions -Gᵀ lambda: what the residual M v_dot + Gᵀ lambda - f has of them; here M is the unit matrix, f zero.
    const VectorX lambda = vector(expected["lambda"]);
    VectorX r(v.size()), reactions(v.size());
    evaluator.residual(v_dot, lambda, r);
    reactions << vector(expected["reaction1"]), vector(expected["reaction2"]);
    EXPECT_LT((v_dot - r - reactions).norm(), 1e-12 * reactions.norm()) << "reactions";
    VectorX free_of_load(v.size());
    evaluator.residual(v_dot, VectorX::Zero(T::kRows), free_of_load);
    EXPECT_EQ((free_of_load - v_dot).norm(), 0);
  }

  Json oracle_;
};

TEST_F(JointOracle, EveryJointAgreesWithDifferentiatedPositions) {
  check<SphericalJoint>("spherical", {0, 0, 0});
  check<UniversalJoint>("universal", {0, 0, 0});
  check<CylindricalJoint>("cylindrical", {0, 0, 0.2});
  check<RevoluteJoint>("revolute", {0, 0, 0});
  check<PrismaticJoint>("prismatic", {0, 0, 0.2});
  check<FixedJoint>("fixed", {0, 0, 0});
}

TEST_F(JointOracle, DrivenJointsAgreeWithDifferentiatedPositions) {
  const VectorX drive = vector(oracle_["drive"]);
  const MotionLaw law = [drive](double) { return Motion{drive[0], drive[1], drive[2]}; };
  check<DistanceJoint>("distance", {drive[0], 0, 0}, DistanceJoint::Parameters{.length_law = law});
  check<CoordinateDrive>("translational_driver", {0, 0, drive[0]}, CoordinateDrive::Parameters{law});
}

}  // namespace
}  // namespace lithe::test::oracle_test
