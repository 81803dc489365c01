#include "engine/base/dense.h"
#include "engine/study/doctor_internal.h"

namespace lithe::doctor {
namespace {

/// G of a joint's rows by all frames, turns over `reach`, and by the modes of one body, each at the same energy.
struct RowsOfJoint {
  MatrixX frames, modes;
  const Body* body = nullptr;
  double motion = 0;  // of the mode that moves most, root mean square over the body's mass
};

/// `mass`, `stiffness`: the blocks of the equations with these.
RowsOfJoint rows_of(const System& system, const std::vector<double>& mass, const std::vector<double>& stiffness,
                    int rows, double reach) {
  const BlockStructure& blocks = system.blocks();
  const int count = blocks.rows[static_cast<std::size_t>(rows)].count;
  RowsOfJoint out;
  out.frames.setZero(count, 0);
  for (const BlockStructure::Jacobian& G : blocks.jacobians) {
    if (G.rows != rows) continue;
    if (G.frame >= 0) {
      const auto columns = out.frames.cols();
      out.frames.conservativeResize(count, columns + 6);
      out.frames.rightCols(6) = Eigen::Map<const MatrixX>(mass.data() + G.values, count, 6);
      out.frames.rightCols(3) /= reach;
    }
    if (G.linear < 0) continue;
    const BlockStructure::Linear& linear = blocks.linears[static_cast<std::size_t>(G.linear)];
    if (linear.pattern || linear.frame < 0 || out.body) return {};  // its nodes are free, or two bodies bend
    for (const Layout::BodySlice& slice : system.layout().bodies())
      if (slice.frame && slice.v + 6 == linear.v) out.body = slice.body;
    const Eigen::Map<const VectorX> M(mass.data() + linear.values, linear.size),
        K(stiffness.data() + linear.values, linear.size);
    if (!(K.minCoeff() > 0)) return {};
    const double body_mass = mass[static_cast<std::size_t>(blocks.frames[linear.frame].values)];
    out.motion = std::sqrt((M.array() / K.array()).maxCoeff() / body_mass);
    out.modes = Eigen::Map<const MatrixX>(mass.data() + G.linear_values, count, linear.size) *
                K.cwiseSqrt().cwiseInverse().asDiagonal();
  }
  return out;
}

/// What the modes do that no motion of the frames does, in the rows of a joint, beside the motion of the body: the
/// singular values. Of three nodes: how much they strain the triangle.
VectorX strains(const RowsOfJoint& rows) {
  constexpr double kRigid = 1e-9;
  const Eigen::JacobiSVD<MatrixX> of_frames(rows.frames, Eigen::ComputeFullU);
  const VectorX& s = of_frames.singularValues();
  const Eigen::Index rank = (s.array() > kRigid * s[0]).count(), beyond = rows.frames.rows() - rank;
  if (beyond == 0) return {};
  const MatrixX beyond_rigid = of_frames.matrixU().rightCols(beyond).transpose() * rows.modes;
  return Eigen::JacobiSVD<MatrixX>(beyond_rigid).singularValues() / rows.motion;
}

}  // namespace

/// Rows that no rigid motion can fill hold modes. Where these strain what the rows keep by very little, that is hardly
/// meant: the body is stiffer by whole modes.
void look_for_locked_modes(const System& system, const State& start, std::vector<Finding>& out) {
  constexpr double kNone = 1e-6, kLittle = 0.1;  // of the motion
  const auto equations = factorized(system, start);
  const std::vector<double> mass = equations->workspace().values;
  const VectorX still = VectorX::Zero(system.layout().v_count()), no_load = VectorX::Zero(system.layout().row_count());
  equations->write_tangent({1, 0, 0}, still, no_load, nullptr);
  const std::vector<double>& stiffness = equations->workspace().values;
  const double reach = reach_of(system, start);
  for (std::size_t k = 0; k < system.blocks().rows.size(); ++k) {
    const BlockStructure::Rows& rows = system.blocks().rows[k];
    if (rows.compliant >= 0) continue;
    const RowsOfJoint of = rows_of(system, mass, stiffness, static_cast<int>(k), reach);
    if (!of.body || of.frames.cols() == 0) continue;
    const VectorX all = strains(of);
    const auto locked = (all.array() > kNone && all.array() < kLittle).count();
    if (locked == 0) continue;
    std::string joint;
    for (const Layout::RowSlice& slice : system.layout().rows())
      if (slice.count > 0 && slice.first == rows.first) joint = slice.name;
    const double most = (all.array() < kLittle).select(all, 0).maxCoeff();
    out.push_back(
        {Cause::locked, 2 * locked >= of.modes.cols(), 0.7,
         doctor::quoted(joint) + " locks " + std::to_string(locked) + " of the " + std::to_string(of.modes.cols()) +
             " modes of " + doctor::quoted(of.body->name()) + ", which strain what it holds by no more than " +
             number(most) + " of the body's motion",
         "hold nodes that the body's frame holds (a TangentFrame of these nodes), or their mean: a FixedJoint "
         "at FlexibleBody::average()"});
  }
}

}  // namespace lithe::doctor
