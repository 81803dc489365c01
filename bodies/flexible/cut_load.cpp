#include "bodies/flexible/cut_load.h"

#include <algorithm>
#include <set>

#include "bodies/flexible/elements/solid_element.h"
#include "bodies/resultant_sensor.h"
#include "engine/base/checks.h"
#include "engine/observe/snapshot.h"

namespace lithe {
namespace {

/// The elements of the part that touch the rest, and the nodes that both share.
struct Interface {
  std::vector<SolidElement> elements;
  std::vector<int> nodes;  // indices, rising
};

Interface find_interface(const ModalBasis& basis, const BodyCut& cut, const Vector3& point, const Vector3& normal,
                         const std::string& where) {
  FiniteElementModel mesh;  // in body axes
  mesh.name = basis.name;
  mesh.node_ids = basis.node_ids;
  mesh.nodes = basis.nodes;
  std::vector<char> chosen(static_cast<std::size_t>(basis.nodes.cols()), 0);
  for (const int id : cut.nodes) chosen[static_cast<std::size_t>(basis.node_index(id))] = 1;
  const auto in_part = [&](const std::vector<int>& nodes) {
    if (!cut.nodes.empty())
      return std::all_of(nodes.begin(), nodes.end(), [&](int i) { return chosen[static_cast<std::size_t>(i)] != 0; });
    return (basis.nodes(Eigen::all, nodes).rowwise().mean() - point).dot(normal) < 0;
  };
  std::set<int> of_part, of_rest;
  for (const ElementBlock& block : basis.elements) {
    mesh.elements.push_back({block.type, {}, block.material});
    for (const auto& nodes : block.nodes) {
      const bool part = in_part(nodes);
      (part ? of_part : of_rest).insert(nodes.begin(), nodes.end());
      if (part) mesh.elements.back().nodes.push_back(nodes);
    }
  }
  Interface found;
  std::set_intersection(of_part.begin(), of_part.end(), of_rest.begin(), of_rest.end(),
                        std::back_inserter(found.nodes));
  if (found.nodes.empty())
    throw SceneError("the part that is cut off has " + std::to_string(of_part.size()) + " nodes, the rest " +
                         std::to_string(of_rest.size()) + ", and they share none",
                     where,
                     basis.elements.empty() ? "import the elements with the matrices"
                                            : "cut inside the body: at its ends the reactions of joints are the loads");
  for (ElementBlock& block : mesh.elements)
    std::erase_if(block.nodes, [&](const std::vector<int>& nodes) {
      return std::none_of(nodes.begin(), nodes.end(),
                          [&](int i) { return std::binary_search(found.nodes.begin(), found.nodes.end(), i); });
    });
  found.elements = make_solid_elements(mesh);
  return found;
}

/// Nodal forces of second order, 3 x nodes, the symmetric bilinear form G(u, v) with f_2(u) = G(u, u):
///   ∫ (½ (H_u σ(v) + H_v σ(u)) + ½ C : sym(H_uᵀ H_v)) ∇N,   σ(u) = C : sym H_u,
/// internal coordinates in equilibrium. u, v: of all nodes.
Matrix3X second_order_forces(const SolidElement& element, ConstVectorRef u, ConstVectorRef v) {
  const auto count = static_cast<Eigen::Index>(element.nodes.size());
  const VectorX all_u = element.coordinates_of(u), all_v = element.coordinates_of(v);
  const Eigen::Map<const Matrix3X> at_u(all_u.data(), 3, count + element.internal),
      at_v(all_v.data(), 3, count + element.internal);
  const auto symmetric = [](const Matrix3& H) -> Matrix3 { return 0.5 * (H + H.transpose()); };
  VectorX forces = VectorX::Zero(all_u.size());
  Eigen::Map<Matrix3X> f(forces.data(), 3, count + element.internal);
  for (const SolidPoint& point : element.points) {
    const Matrix3 H_u = at_u * point.gradients, H_v = at_v * point.gradients;
    const Matrix3 stress =
        0.5 * (H_u * hooke(symmetric(H_v), element.material) + H_v * hooke(symmetric(H_u), element.material) +
               hooke(symmetric(H_u.transpose() * H_v), element.material));
    f += point.volume * stress * point.gradients.transpose();
  }
  VectorX nodal = forces.head(3 * count);
  if (element.internal > 0) nodal += element.internal_from_nodal.transpose() * forces.tail(3 * element.internal);
  return nodal.reshaped(3, count);
}

}  // namespace

CutLoad::CutLoad(const FlexibleBody& body, const BodyCut& cut) : body_(&body), basis_(body.parameters().basis) {
  const std::string where = "a cut of '" + body.name() + "' of " + body.where();
  require::at(where, [&] {
    require::finite(cut.point, "point");
    require::rotation(cut.axes, "axes");
  });
  const ModalBasis& basis = *basis_;
  const Vector3 point = basis.rotation.transpose() * (cut.point - basis.origin);
  const Matrix3 axes = basis.rotation.transpose() * cut.axes;
  const auto [elements, nodes] = find_interface(basis, cut, point, axes.col(0), where);
  for (const int i : nodes) nodes_.push_back(basis.node_ids[static_cast<std::size_t>(i)]);
  std::sort(nodes_.begin(), nodes_.end());

  // sum += what nodal forces f (3 x nodes of an element) do at the cut, with arms from arm(node).
  const auto add = [&](const SolidElement& element, const auto& f, const auto& arm, auto&& sum) {
    for (std::size_t a = 0; a < element.nodes.size(); ++a) {
      const int node = element.nodes[a];
      if (!std::binary_search(nodes.begin(), nodes.end(), node)) continue;
      const Vector3 force = f.col(static_cast<Eigen::Index>(a));
      sum.template head<3>() += axes.transpose() * force;
      sum.template tail<3>() += axes.transpose() * arm(node).cross(force);
    }
  };
  const auto drawn = [&](int node) -> Vector3 { return basis.nodes.col(node) - point; };

  // K of the part's elements at the cut: 6 x dofs, then on the fields.
  Matrix6X on_dofs = Matrix6X::Zero(6, 3 * basis.nodes.cols());
  for (const SolidElement& element : elements) {
    const MatrixX K = stiffness(element);
    for (Eigen::Index column = 0; column < K.cols(); ++column) {
      const int dof = 3 * element.nodes[static_cast<std::size_t>(column / 3)] + static_cast<int>(column % 3);
      add(element, K.col(column).reshaped(3, K.rows() / 3), drawn, on_dofs.col(dof));
    }
  }
  if (basis.nodal) {
    linear_ = on_dofs(Eigen::all, basis.free_dofs);
    return;
  }
  const int modes = basis.mode_count();
  linear_ = on_dofs * basis.modes.topRows(on_dofs.cols());
  if (!basis.deflection) return;
  linear_.conservativeResize(6, modes + basis.deflection->field_count());
  linear_.rightCols(basis.deflection->field_count()) = on_dofs * basis.deflection->fields.topRows(on_dofs.cols());

  // η_k η_l (G_kl + G_lk) = 2 G_kl w_kl; ½ η_k² likewise.
  pairs_ = MatrixX::Zero(6, modes * (modes + 1) / 2);
  const auto& B = basis.modes;
  std::vector<Matrix3X> arms;  // displacements less the mean of the cut's nodes, of each mode
  for (int k = 0; k < modes; ++k) {
    Matrix3X u = B.col(k).head(on_dofs.cols()).reshaped(3, basis.nodes.cols());
    u.colwise() -= Vector3(u(Eigen::all, nodes).rowwise().mean());
    arms.push_back(std::move(u));
  }
  for (const SolidElement& element : elements) {
    const MatrixX K = stiffness(element);
    const auto first_order = [&](int k) -> Matrix3X {
      VectorX u(K.cols());
      for (std::size_t a = 0; a < element.nodes.size(); ++a)
        u.segment<3>(3 * static_cast<Eigen::Index>(a)) = B.col(k).segment<3>(3 * element.nodes[a]);
      return (K * u).reshaped(3, K.rows() / 3);
    };
    std::vector<Matrix3X> forces;
    forces.reserve(static_cast<std::size_t>(modes));
    for (int k = 0; k < modes; ++k) forces.push_back(first_order(k));
    Eigen::Index pair = 0;
    for (int l = 0; l < modes; ++l)
      for (int k = 0; k <= l; ++k, ++pair) {
        auto column = pairs_.col(pair);
        add(element, 2 * second_order_forces(element, B.col(k), B.col(l)), drawn, column);
        for (const auto& [moved, loaded] : {std::pair(k, l), std::pair(l, k)}) {
          Vector6 turned = Vector6::Zero();
          add(
              element, forces[static_cast<std::size_t>(loaded)],
              [&arms, bent = moved](int node) -> Vector3 { return arms[static_cast<std::size_t>(bent)].col(node); },
              turned);
          column.tail<3>() += turned.tail<3>();
        }
      }
  }
}

Vector6 CutLoad::load(Snapshot& snapshot) const {
  if (body_->parameters().basis != basis_)
    throw SceneError("a cut of '" + body_->name() + "' was made for other modes than it has now", body_->where(),
                     "make the cut after set_fidelity()");
  const BodyState state = snapshot.body_state(*body_);
  const VectorX fields = body_->field_coordinates(state);
  Vector6 load = linear_.leftCols(fields.size()) * fields;
  if (pairs_.cols() == 0) return load;
  // A w = ½ A (∂w/∂η) η, of the modes in use.
  const int modes = body_->mode_count();
  MatrixX rates = MatrixX::Zero(6, modes);
  add_pair_columns(pairs_, state.q + 7, rates);
  return load + 0.5 * rates * Eigen::Map<const VectorX>(state.q + 7, modes);
}

Sensor cut_load(const FlexibleBody& body, const BodyCut& cut, Located name) {
  if (name.text.empty()) name.text = body.name() + ".cut";
  return resultant_sensor(std::move(name), [load = CutLoad(body, cut)](Snapshot& now) { return load.load(now); });
}

}  // namespace lithe
