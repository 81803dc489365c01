#include "bodies/beam/beam_model.h"

#include <array>
#include <vector>

#include "bodies/beam/se3_internal.h"

namespace lithe {
namespace {

using Vector12 = BeamSpan::Vector12;
using Matrix12 = BeamSpan::Matrix12;

/// A span between two nodes of the drawing.
struct DrawnSpan {
  BeamSpan span;
  int first;
  std::array<Matrix3, 2> axes;
  Vector6 d;
  se3::Analytic inverse = se3::right_inverse_at(d);
  se3::Blocks T = se3::blocks(inverse, d);  // T⁻¹(d)
};

std::vector<DrawnSpan> drawn_spans(const Beam& beam) {
  std::vector<DrawnSpan> spans;
  for (int e = 0; e < beam.element_count(); ++e) {
    const FramePose &a = beam.pose(e), &b = beam.pose(e + 1);
    spans.push_back({beam.element(e), e, {a.axes, b.axes}, se3::log_between(a.position, a.axes, b.position, b.axes)});
  }
  return spans;
}

/// From vectors in the axes of the ends to those of the mesh.
Matrix12 turn_of(const DrawnSpan& drawn) {
  Matrix12 A = Matrix12::Zero();
  for (int k = 0; k < 4; ++k) A.block<3, 3>(3 * k, 3 * k) = drawn.axes[static_cast<std::size_t>(k / 2)];
  return A;
}

/// The degrees of freedom of a span: displacements of all nodes come before the rotations.
std::array<int, 12> dofs_of(const DrawnSpan& drawn, int node_count) {
  std::array<int, 12> dofs{};
  for (int i = 0; i < 12; ++i)
    dofs[static_cast<std::size_t>(i)] = 3 * (drawn.first + i / 6) + i % 3 + (i % 6 < 3 ? 0 : 3 * node_count);
  return dofs;
}

/// ∂²d/∂η_k∂η_l for motions k and l of the ends (12-vectors in their axes: displacement, rotation vector): the
/// derivative along l of  d_k = T⁻¹(d) v_B - T⁻¹(-d) v_A.  Where the end has turned by φ_l, the displacement k is
/// exp(-φ_l~) u_k in its axes and the rotation Jr(φ_l) φ_k.
Vector6 second_derivative(const DrawnSpan& drawn, const Vector12& k, const Vector12& l) {
  const se3::Blocks &forwards = drawn.T, backwards = forwards.turned_back();
  const auto change = [&](int end) -> Vector6 {  // of the motion k in the axes of the end
    const Vector6 x = k.segment<6>(6 * end);
    const Vector3 turn = l.segment<3>(6 * end + 3);
    Vector6 rate;
    rate << -turn.cross(x.head<3>()), -0.5 * turn.cross(x.tail<3>());
    return rate;
  };
  const Vector6 d_l = forwards * l.tail<6>() - backwards * l.head<6>();
  return se3::rates(drawn.inverse, drawn.d, k.tail<6>()) * d_l +
         se3::rates(drawn.inverse, -drawn.d, k.head<6>()) * d_l + forwards * change(1) - backwards * change(0);
}

/// FiniteElementModel::second_order_forces.
MatrixX second_order_forces(const std::vector<DrawnSpan>& spans, int node_count, const MatrixX& modes) {
  const Eigen::Index nm = modes.cols();
  MatrixX forces = MatrixX::Zero(modes.rows(), nm * (nm + 1) / 2);
  for (const DrawnSpan& drawn : spans) {
    const auto dofs = dofs_of(drawn, node_count);
    const Matrix12 A = turn_of(drawn);
    const MatrixX motion = A.transpose() * modes(dofs, Eigen::all);
    Eigen::Index pair = 0;
    for (Eigen::Index l = 0; l < nm; ++l)
      for (Eigen::Index k = 0; k <= l; ++k) {
        const Vector6 bent = second_derivative(drawn, motion.col(k), motion.col(l)) / drawn.span.length();
        const Vector12 f = A * drawn.span.internal_forces(drawn.d, drawn.span.section().stiffness * bent);
        forces(dofs, pair++) += f;
      }
  }
  return forces;
}

}  // namespace

FiniteElementModel finite_element_model(const Beam& beam) {
  const int n = beam.node_count();
  FiniteElementModel model;
  model.name = beam.name().empty() ? "beam" : beam.name();
  model.nodes.resize(3, n);
  for (int i = 0; i < n; ++i) {
    model.node_ids.push_back(i + 1);
    model.nodes.col(i) = beam.pose(i).position;
    for (const int axis : {0, 1, 2}) model.rotations.push_back({i, axis});
  }

  using Entries = std::vector<Eigen::Triplet<double>>;
  Entries stiffness, mass, damping;
  const auto add = [](Entries& entries, const auto& dofs, const auto& block) {
    for (Eigen::Index r = 0; r < block.rows(); ++r)
      for (Eigen::Index c = 0; c < block.cols(); ++c)
        entries.emplace_back(dofs[static_cast<std::size_t>(r)], dofs[static_cast<std::size_t>(c)],
                             0.5 * (block(r, c) + block(c, r)));
  };
  const std::vector<DrawnSpan> spans = drawn_spans(beam);
  ElementBlock lines{.type = "B31", .nodes = {}};
  bool damped = false;
  for (const DrawnSpan& drawn : spans) {
    const auto dofs = dofs_of(drawn, n);
    const Matrix12 A = turn_of(drawn), back = A.transpose();
    lines.nodes.push_back({drawn.first, drawn.first + 1});
    add(stiffness, dofs, Matrix12(A * drawn.span.tangent(drawn.d, Vector6::Zero(), 1, 0) * back));
    if (beam.parameters().mass == Beam::Mass::consistent)
      add(mass, dofs, Matrix12(A * drawn.span.mass(drawn.d) * back));
    if (drawn.span.section().damping.isZero(0)) continue;
    damped = true;
    add(damping, dofs, Matrix12(A * drawn.span.tangent(drawn.d, Vector6::Zero(), 0, 1) * back));
  }
  if (beam.parameters().mass == Beam::Mass::lumped)
    for (int i = 0; i < n; ++i) {
      Matrix6 A = Matrix6::Zero();
      A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = beam.pose(i).axes;
      const std::array<int, 6> dofs{3 * i, 3 * i + 1, 3 * i + 2, 3 * (n + i), 3 * (n + i) + 1, 3 * (n + i) + 2};
      add(mass, dofs, Matrix6(A * beam.lumped_mass(i) * A.transpose()));
    }
  const auto filled = [&](const Entries& entries) {
    SparseMatrix matrix(model.dof_count(), model.dof_count());
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
  };
  model.stiffness = filled(stiffness);
  model.mass = filled(mass);
  if (damped) model.damping = filled(damping);
  model.elements.push_back(std::move(lines));
  model.skin = std::make_shared<DrawnSkin>(drawn_skin(beam));
  model.second_order_forces = [spans, n](const MatrixX& modes) { return second_order_forces(spans, n, modes); };
  return model;
}

std::shared_ptr<const ModalBasis> make_basis(const Beam& beam, const BodyFrame& frame, int mode_count,
                                             const Reduction& reduction) {
  return make_basis(finite_element_model(beam), frame, mode_count, reduction);
}

}  // namespace lithe
