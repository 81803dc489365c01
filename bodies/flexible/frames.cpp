#include "bodies/flexible/frames.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "bodies/flexible/general_inertia.h"
#include "bodies/flexible/node_sets.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kCollinear = 1e-7;  // sine of the angle, or singular value ratio: above the digits of printed nodes

std::string list(const std::vector<int>& ids) {
  std::string text;
  for (size_t k = 0; k < ids.size() && k < 6; ++k) text += (k == 0 ? "" : ", ") + std::to_string(ids[k]);
  return ids.size() > 6 ? text + ", ... " + std::to_string(ids.size()) + " nodes" : text;
}

std::vector<int> indices_of(const FiniteElementModel& model, const std::vector<int>& ids, const std::string& where) {
  if (ids.empty()) throw SceneError("the frame names no node.", where, "give the labels of its nodes.");
  std::vector<int> indices;
  for (int id : ids) indices.push_back(model.node_index(id));
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  return indices;
}

Vector3 mean_of(const FiniteElementModel& model, const std::vector<int>& indices) {
  Vector3 sum = Vector3::Zero();
  for (int i : indices) sum += model.nodes.col(i);
  return sum / static_cast<double>(indices.size());
}

std::vector<int> translations_of(const std::vector<int>& indices) {
  std::vector<int> dofs;
  for (int i : indices)
    for (int axis = 0; axis < 3; ++axis) dofs.push_back(3 * i + axis);
  return dofs;
}

std::vector<int> rotations_of(const FiniteElementModel& model, const std::vector<int>& indices) {
  std::vector<int> dofs;
  for (size_t k = 0; k < model.rotations.size(); ++k)
    if (std::find(indices.begin(), indices.end(), model.rotations[k].node) != indices.end())
      dofs.push_back(3 * model.node_count() + static_cast<int>(k));
  return dofs;
}

/// The node and all that share an element with it.
std::vector<int> neighbours(const FiniteElementModel& model, int node, const std::string& where) {
  std::vector<int> found;
  for (const ElementBlock& block : model.elements)
    for (const auto& element : block.nodes)
      if (std::find(element.begin(), element.end(), node) != element.end())
        found.insert(found.end(), element.begin(), element.end());
  if (found.empty())
    throw SceneError("a tangent frame at one node needs the elements around it, and the model has none there.", where,
                     "name three or more nodes of the face, or read the model with its elements.");
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

void place(const FiniteElementModel& model, const ThreeNodeFrame& frame, FramePlacement& placed) {
  const int a = model.node_index(frame.origin), b = model.node_index(frame.on_x), c = model.node_index(frame.in_xy);
  const Vector3 ab = model.nodes.col(b) - model.nodes.col(a), ac = model.nodes.col(c) - model.nodes.col(a);
  const Vector3 normal = ab.cross(ac);
  const double sine = normal.norm() / (ab.norm() * ac.norm());
  if (!(sine > kCollinear))
    throw SceneError("the three frame nodes lie on one line, they do not define a frame.", placed.where,
                     "choose a third node off the line through the first two.");
  // Eqs. (65)-(67): e1 from a to b, e3 normal to the plane a, b, c.
  const Vector3 e1 = ab.normalized(), e3 = normal.normalized();
  placed.origin = model.nodes.col(a);
  placed.rotation << e1, e3.cross(e1), e3;
  placed.fixed_dofs = {3 * a, 3 * a + 1, 3 * a + 2, 3 * b + 1, 3 * b + 2, 3 * c + 2};  // (68)
}

void place(const FiniteElementModel& model, const TangentFrame& frame, FramePlacement& placed) {
  std::vector<int> nodes = indices_of(model, frame.nodes, placed.where);
  placed.origin = mean_of(model, nodes);
  // A node of a solid carries no rotation: its elements are held with it.
  if (nodes.size() == 1 && rotations_of(model, nodes).size() < 3)
    nodes = neighbours(model, nodes.front(), placed.where);
  placed.fixed_dofs = translations_of(nodes);
  const std::vector<int> turns = rotations_of(model, nodes);
  placed.fixed_dofs.insert(placed.fixed_dofs.end(), turns.begin(), turns.end());
}

void place(const FiniteElementModel& model, const HingeFrame& frame, FramePlacement& placed) {
  const std::vector<int> nodes = indices_of(model, frame.nodes, placed.where);
  placed.origin = mean_of(model, nodes);
  placed.fixed_dofs = translations_of(nodes);
}

void place(const FiniteElementModel& model, const MeanAxisFrame&, FramePlacement& placed) {
  placed.origin = rigid_mass(model).center;
}

void place(const FiniteElementModel& model, const MeanTangentFrame& frame, FramePlacement& placed) {
  indices_of(model, frame.nodes.ids, placed.where);
  std::vector<int> nodes;
  for (int id : frame.nodes.ids) nodes.push_back(model.node_index(id));
  const NodeAverage average(model.nodes, nodes, frame.nodes.weights, placed.where);
  if (average.on_a_line)
    throw SceneError("the nodes of the frame lie on one line and have no mean rotation about it.", placed.where,
                     "add a node off the line.");
  placed.origin = average.center;
  placed.means = average.unit_loads(model.dof_count());
}

std::string words(const ThreeNodeFrame& f) { return "three-node frame (" + list({f.origin, f.on_x, f.in_xy}) + ")"; }
std::string words(const TangentFrame& f) { return "tangent frame (" + list(f.nodes) + ")"; }
std::string words(const MeanTangentFrame& f) { return "mean tangent frame (" + list(f.nodes.ids) + ")"; }
std::string words(const HingeFrame& f) { return "hinge frame (" + list(f.nodes) + ")"; }
std::string words(const MeanAxisFrame&) { return "mean-axis frame"; }

}  // namespace

MatrixX rigid_motions_left(const Matrix3X& nodes, const std::vector<RotationalDof>& rotations,
                           const std::vector<int>& fixed_dofs) {
  // Rotations about the middle of the nodes, over the size of the body: all six columns are then of order one.
  const Vector3 middle = nodes.rowwise().mean();
  MatrixX R = rigid_motions(nodes, rotations, middle);
  const double size = (nodes.colwise() - middle).colwise().norm().maxCoeff();
  if (size > 0) R.rightCols<3>() /= size;
  if (fixed_dofs.empty()) return R;

  MatrixX held(static_cast<Eigen::Index>(fixed_dofs.size()), 6);
  for (size_t k = 0; k < fixed_dofs.size(); ++k) held.row(static_cast<Eigen::Index>(k)) = R.row(fixed_dofs[k]);
  const Eigen::JacobiSVD<MatrixX> svd(held, Eigen::ComputeFullV);
  const VectorX& values = svd.singularValues();
  int rank = 0;
  while (rank < values.size() && values[rank] > kCollinear * values[0]) ++rank;
  MatrixX left = R * svd.matrixV().rightCols(6 - rank);
  for (int dof : fixed_dofs) left.row(dof).setZero();
  return left;
}

FramePlacement place_frame(const FiniteElementModel& model, const BodyFrame& frame) {
  FramePlacement placed;
  std::visit(
      [&](const auto& kind) {
        placed.where = "model '" + model.name + "', " + words(kind);
        place(model, kind, placed);
      },
      frame);
  std::sort(placed.fixed_dofs.begin(), placed.fixed_dofs.end());
  placed.nodes = placed.rotation.transpose() * (model.nodes.colwise() - placed.origin);
  // Coordinates that are zero by construction, without their rounding.
  if (std::holds_alternative<ThreeNodeFrame>(frame))
    for (int dof : placed.fixed_dofs) placed.nodes(dof % 3, dof / 3) = 0;

  placed.rigid = rigid_motions_left(placed.nodes, model.rotations, placed.fixed_dofs);
  if (std::holds_alternative<TangentFrame>(frame) && placed.rigid.cols() > 0)
    throw SceneError("the clamped nodes lie on one line and leave the body free to turn: a mechanism.", placed.where,
                     "add a node off the line, or use a HingeFrame.");
  return placed;
}

}  // namespace lithe
