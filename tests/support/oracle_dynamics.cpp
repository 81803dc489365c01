#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bodies/flexible/flexible_body.h"
#include "engine/assembly/evaluator.h"
#include "engine/motion/projection.h"
#include "integrators/explicit_runge_kutta.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/support/oracle.h"
#include "tests/support/oracle_body.h"

namespace lithe::oracle {
namespace {

using Json = nlohmann::json;

/// A body that has a marker and modes, and no inertia worth comparing.
FlexibleBody& add_marker_body(SystemGraph& graph, const char* name, const Json& data, Marker& marker) {
  const auto& m = data.at("marker");
  const MatrixX Bm = matrix(m.at("Bm"));
  const int nm = static_cast<int>(Bm.cols());
  InertiaIntegrals I;
  I.mass = 1;
  I.J0 << 1, 1, 1, 0, 0, 0;
  I.Ct = I.C0 = Matrix3X::Zero(3, nm);
  I.J1 = Matrix6X::Zero(6, nm);
  I.J2 = MatrixX::Zero(6 * nm, nm);
  I.C1 = MatrixX::Zero(3 * nm, nm);
  I.Mff = MatrixX::Identity(nm, nm);
  auto basis = std::make_shared<ModalBasis>();
  basis->modal_mass = basis->stiffness = I.Mff.sparseView();
  basis->diagonal = true;
  auto& body = graph.add<FlexibleBody>(name, {.basis = basis}, I);
  marker = body.modal_marker(matrix(m.at("c")), Bm, matrix(m.at("Theta")), matrix(m.at("R0")));
  return body;
}

/// A joint of the file between two markers; the drive's value, rate and acceleration are those of the file.
const Constraint& add_joint(SystemGraph& graph, const std::string& kind, const std::vector<Marker>& markers,
                            const Json& drive) {
  const lithe::Motion motion{drive[0], drive[1], drive[2]};
  const auto law = [motion](double) { return motion; };
  if (kind == "spherical") return graph.add<SphericalJoint>("joint", markers);
  if (kind == "revolute") return graph.add<RevoluteJoint>("joint", markers);
  if (kind == "universal") return graph.add<UniversalJoint>("joint", markers);
  if (kind == "cylindrical") return graph.add<CylindricalJoint>("joint", markers);
  if (kind == "prismatic") return graph.add<PrismaticJoint>("joint", markers);
  if (kind == "fixed") return graph.add<FixedJoint>("joint", markers);
  if (kind == "distance") return graph.add<DistanceJoint>("joint", markers, {.length_law = law});
  if (kind == "translational_driver")
    return graph.add<CoordinateDrive>("joint", {displacement_between(markers[0], markers[1])}, {.motion = law});
  throw std::runtime_error("unknown joint '" + kind + "'");
}

}  // namespace

Findings check_joints(const Json& data) {
  Findings f;
  for (const auto& [kind, want] : data.at("joints").items()) {
    if (kind == "angle_driver") continue;  // the sine of an angle: CoordinateDrive prescribes the angle itself
    // The joint's rows at the states of the file, which lie anywhere: no assembly, only evaluation.
    SystemGraph graph;
    Marker markers[2];
    add_marker_body(graph, "first", data.at("bodies")[0], markers[0]);
    add_marker_body(graph, "second", data.at("bodies")[1], markers[1]);
    const Constraint& joint = add_joint(graph, kind, {markers[0], markers[1]}, data.at("drive"));
    const System system = assemble(graph, {.start = AssembleOptions::Start::as_drawn});
    const Motion first(data.at("bodies")[0].at("state")), second(data.at("bodies")[1].at("state"));
    VectorX q(first.q.size() + second.q.size()), v(first.v.size() + second.v.size());
    q << first.q, second.q;
    v << first.v, second.v;
    Evaluator equations(system);
    equations.evaluate(0, q, v, Level::acceleration);
    const int rows = joint.row_count(), n1 = static_cast<int>(first.v.size());
    VectorX C(rows), C_dot(rows), gamma(rows);
    equations.constraint(Level::position, C);
    equations.constraint(Level::velocity, C_dot);
    equations.constraint(Level::acceleration, gamma);
    MatrixX G = MatrixX::Zero(rows, v.size());
    equations.visit_blocks([&](int row, int column, ConstMatrixRef block) {
      if (row >= v.size() && column < v.size()) G.block(row - v.size(), column, block.rows(), block.cols()) = block;
    });
    const VectorX lambda = matrix(want.at("lambda")), reaction = -G.transpose() * lambda;
    const MatrixX velocity_term = matrix3(want.at("velocity_term"));
    f.compare(kind + " C", C, matrix(want.at("C")));
    f.compare(kind + " G1", G.leftCols(n1), matrix(want.at("G1")));
    f.compare(kind + " G2", G.rightCols(v.size() - n1), matrix(want.at("G2")));
    f.compare(kind + " gamma", gamma, matrix(want.at("gamma")));
    const VectorX term = velocity_term.size() == 1 ? VectorX::Constant(rows, velocity_term(0))
                                                   : VectorX(Eigen::Map<const VectorX>(velocity_term.data(), rows));
    f.compare(kind + " velocity_term", C_dot - G * v, term, (G * v).cwiseAbs().maxCoeff());
    f.compare(kind + " reaction1", reaction.head(n1), matrix(want.at("reaction1")));
    f.compare(kind + " reaction2", reaction.tail(v.size() - n1), matrix(want.at("reaction2")));
  }
  return f;
}

Findings check_trajectory(const Json& data) {
  Findings f;
  const auto basis = basis_from_modes(data.at("name"), matrix(data.at("nodes")).transpose(),
                                      matrix(data.at("mass_scalar")).sparseView(),
                                      matrix(data.at("K_modal")).sparseView(), matrix(data.at("B")));
  SystemGraph graph({.gravity = matrix(data.at("gravity"))});
  auto& body = graph.add<FlexibleBody>("body", {.basis = basis});
  const std::string type = data.at("joint").at("type");
  if (type == "spherical") {
    const auto& m = data.at("joint").at("marker");
    const Marker marker = body.modal_marker(matrix(m.at("c")), matrix(m.at("Bm")), Matrix3X(3, 0), Matrix3::Identity());
    graph.add<SphericalJoint>("pin", {graph.ground().marker(matrix(data.at("joint").at("anchor"))), marker});
  } else if (type != "none") {
    throw std::runtime_error("unknown joint '" + type + "'");
  }
  const System system = assemble(graph, {.start = AssembleOptions::Start::as_drawn});
  Evaluator equations(system);
  const auto& solution = data.at("solution");
  const Motion start(solution[0]);
  State state{0, start.q, start.v, start.v_dot, VectorX::Zero(system.layout().row_count())};
  ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-12, .absolute = 1e-13}});
  integrator.start(equations, state);
  for (const auto& entry : solution) {
    const double t = entry.at("t");
    while (state.time < t)
      if (const StepResult r = integrator.step(equations, state, t); !r.ok()) throw std::runtime_error(r.why);
    const Motion want(entry);
    VectorX q = state.q;
    if (q.segment<4>(3).dot(want.q.segment<4>(3)) < 0) q.segment<4>(3) *= -1;  // e and -e are one attitude
    f.compare("x0", q.head<3>(), want.q.head<3>(), 1);
    f.compare("quaternion", q.segment<4>(3), want.q.segment<4>(3));
    f.compare("eta", q.tail(q.size() - 7), want.q.tail(q.size() - 7), start.q.tail(q.size() - 7).cwiseAbs().maxCoeff());
    f.compare("velocity", state.v.head<6>(), want.v.head<6>(), 1);
    f.compare("eta rate", state.v.tail(q.size() - 7), want.v.tail(q.size() - 7),
              start.v_dot.tail(q.size() - 7).cwiseAbs().maxCoeff() * 1e-2);
    f.compare("acceleration", state.v_dot, want.v_dot, start.v_dot.cwiseAbs().maxCoeff());
    if (state.lambda.size() > 0) f.compare("multipliers", state.lambda, matrix(entry.at("lambda")));
  }
  return f;
}

}  // namespace lithe::oracle
