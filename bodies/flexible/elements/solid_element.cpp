#include "bodies/flexible/elements/solid_element.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "bodies/flexible/elements/shape_functions.h"
#include "engine/base/dense_inverse.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kFlatElement = 1e-12;  // Jacobian over the cube of the element's size: no volume

/// What CalculiX makes of a type: nodes, incompatible shapes, points of stiffness and of mass (a brick's along an
/// edge).
struct SolidType {
  const char* name;
  int nodes, internal, stiffness_points, mass_points;
};
constexpr SolidType kSolidTypes[] = {{"C3D4", 4, 0, 1, 4},    {"C3D8", 8, 0, 2, 2},   {"C3D8I", 8, 3, 2, 2},
                                     {"C3D10", 10, 0, 4, 15}, {"C3D20", 20, 0, 3, 3}, {"C3D20R", 20, 0, 2, 3}};

const SolidType* find_solid_type(const std::string& name) {
  const auto* found = std::find_if(std::begin(kSolidTypes), std::end(kSolidTypes),
                                   [&](const SolidType& type) { return name == type.name; });
  return found == std::end(kSolidTypes) ? nullptr : found;
}

std::vector<IntegrationPoint> solid_rule(const SolidType& type, int points) {
  return type.nodes == 8 || type.nodes == 20 ? brick_rule(points) : tetrahedron_rule(points);
}

/// "C3D8 element of the nodes 0 1 4 ..." by `label(node)`.
template <class Label>
std::string element_name(const std::string& type, const std::vector<int>& nodes, Label&& label) {
  std::string text = type + " element of the nodes";
  for (int node : nodes) text += " " + std::to_string(label(node));
  return text;
}

[[noreturn]] void refuse_element(const std::string& problem, const std::string& type, const std::vector<int>& nodes,
                                 const std::string& fix) {
  throw SceneError(problem, element_name(type, nodes, [](int node) { return node; }) + " (indices)", fix);
}

const SolidType& require_solid(const std::string& name, const std::vector<int>& nodes, const Matrix3X& positions) {
  const SolidType* type = find_solid_type(name);
  if (!type) {
    std::string known;
    for (const SolidType& other : kSolidTypes) known += (known.empty() ? "" : ", ") + std::string(other.name);
    refuse_element("no solid element type '" + name + "'.", name, nodes, "known are " + known + ".");
  }
  if (static_cast<int>(nodes.size()) != type->nodes)
    refuse_element("it has " + std::to_string(nodes.size()) + " nodes.", name, nodes,
                   "give " + std::to_string(type->nodes) + ", in the order of CalculiX.");
  for (int node : nodes)
    if (node < 0 || node >= positions.cols())
      refuse_element("node index " + std::to_string(node) + " of " + std::to_string(positions.cols()) + " nodes.", name,
                     nodes, "connectivity is by node index, counted from 0.");
  return *type;
}

void require_elastic(const std::string& type, const std::vector<int>& nodes, const Material& material) {
  if (!(material.young > 0) || !std::isfinite(material.young))
    refuse_element("Young's modulus is " + std::to_string(material.young) + " Pa.", type, nodes,
                   "give ElementBlock::material, E > 0.");
  if (!(material.poisson > -1 && material.poisson < 0.5))
    refuse_element("Poisson's ratio is " + std::to_string(material.poisson) + ".", type, nodes,
                   "give -1 < nu < 0.5; rubber has 0.49, which bricks of the second order bear best.");
}

/// Positions of an element's nodes, 3 x a, and its size, the diagonal of the box around them.
struct SolidGeometry {
  Matrix3X x;
  double size;
  SolidGeometry(const std::vector<int>& nodes, const Matrix3X& positions)
      : x(positions(Eigen::all, nodes)), size((x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm()) {}

  /// ∂x/∂ξ; its determinant is to be positive.
  Matrix3 jacobian(const ShapeValues& shape, const std::string& type, const std::vector<int>& nodes) const {
    const Matrix3 J = x * shape.gradients;
    const double j = J.determinant(), flat = kFlatElement * size * size * size;
    if (!(j > flat))
      refuse_element(j < -flat ? "it is turned inside out." : "it has no volume, or a position is not a number.", type,
                     nodes,
                     j < -flat ? "number its nodes in the order of CalculiX, or fix the mesh where it folds."
                               : "merge its coinciding nodes and drop it, or fix the mesh.");
    return J;
  }
};

/// ∫ Bᵀ D B over the element, internal coordinates last and not condensed.
MatrixX full_stiffness(const SolidElement& element) {
  const Matrix6 D = elasticity(element.material);
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(element.nodes.size()) + 3 * element.internal;
  MatrixX K = MatrixX::Zero(size, size);
  for (const SolidPoint& point : element.points) {
    const MatrixX B = strain_matrix(point.gradients);
    K.noalias() += B.transpose() * (point.volume * D * B);
  }
  return K;
}

/// visit(block, nodes) of every element; errors name the model and the labels of the nodes.
template <class Visit>
void at_elements(const FiniteElementModel& model, Visit&& visit) {
  for (const ElementBlock& block : model.elements)
    for (const auto& nodes : block.nodes) try {
        visit(block, nodes);
      } catch (const SceneError& error) {
        const auto label = [&](int node) {
          return node >= 0 && node < model.node_count() ? model.node_ids[static_cast<size_t>(node)] : node;
        };
        throw SceneError(error.problem(), "model '" + model.name + "', " + element_name(block.type, nodes, label),
                         error.fix());
      }
}

}  // namespace

bool is_solid_type(const std::string& type) { return find_solid_type(type) != nullptr; }

int solid_node_count(const std::string& type) {
  const SolidType* found = find_solid_type(type);
  return found ? found->nodes : 0;
}

VectorX SolidElement::coordinates_of(const Eigen::Ref<const VectorX>& displacements) const {
  const auto count = static_cast<Eigen::Index>(nodes.size());
  VectorX all(3 * (count + internal));
  for (Eigen::Index a = 0; a < count; ++a)
    all.segment<3>(3 * a) = displacements.segment<3>(3 * nodes[static_cast<size_t>(a)]);
  if (internal > 0) all.tail(3 * internal).noalias() = internal_from_nodal * all.head(3 * count);
  return all;
}

SolidElement make_solid_element(const std::string& type_name, const std::vector<int>& nodes, const Matrix3X& positions,
                                const Material& material) {
  const SolidType& type = require_solid(type_name, nodes, positions);
  require_elastic(type_name, nodes, material);
  const SolidGeometry geometry(nodes, positions);
  SolidElement element{nodes, material, {}, type.internal, {}, {}};

  Matrix3 centre_inverse;
  double centre_volume = 0;
  if (type.internal > 0) {
    const Matrix3 J = geometry.jacobian(shape_functions(type.nodes, Vector3::Zero()), type_name, nodes);
    centre_inverse = J.inverse();
    centre_volume = J.determinant();
  }
  for (const IntegrationPoint& at : solid_rule(type, type.stiffness_points)) {
    const ShapeValues shape = shape_functions(type.nodes, at.xi);
    const Matrix3 J = geometry.jacobian(shape, type_name, nodes);
    const double j = J.determinant();
    MatrixX gradients(type.nodes + type.internal, 3);
    gradients.topRows(type.nodes) = shape.gradients * J.inverse();
    // Incompatible shapes 1 - ξ_k². With the Jacobian of the centre and the factor j0/j their strain has no mean, so
    // that constant strain passes (Taylor, Beresford & Wilson 1976, Int. J. Numer. Meth. Eng. 10, 1211).
    for (int k = 0; k < type.internal; ++k)
      gradients.row(type.nodes + k) = -2 * at.xi[k] * centre_volume / j * centre_inverse.row(k);
    element.points.push_back({at.weight * j, std::move(gradients)});
  }

  if (type.internal > 0) {
    const MatrixX K = full_stiffness(element);
    const Eigen::Index internal = 3 * type.internal, nodal = 3 * type.nodes;
    element.internal_compliance = inverse_of(K.bottomRightCorner(internal, internal));
    element.internal_from_nodal = -element.internal_compliance * K.bottomLeftCorner(internal, nodal);
  }
  return element;
}

std::vector<SolidElement> make_solid_elements(const FiniteElementModel& model) {
  std::vector<SolidElement> elements;
  at_elements(model, [&](const ElementBlock& block, const std::vector<int>& nodes) {
    elements.push_back(make_solid_element(block.type, nodes, model.nodes, block.material));
  });
  return elements;
}

Matrix6 elasticity(const Material& material) {
  const double shear = material.young / (2 * (1 + material.poisson));
  const double lame = material.young * material.poisson / ((1 + material.poisson) * (1 - 2 * material.poisson));
  Matrix6 D = Matrix6::Zero();
  D.topLeftCorner<3, 3>().setConstant(lame);
  D.diagonal() += shear * (Vector6() << 2, 2, 2, 1, 1, 1).finished();
  return D;
}

Matrix3 hooke(const Matrix3& strain, const Material& material) {
  const double shear = material.young / (2 * (1 + material.poisson));
  const double lame = 2 * shear * material.poisson / (1 - 2 * material.poisson);
  return 2 * shear * strain + lame * strain.trace() * Matrix3::Identity();
}

MatrixX stiffness(const SolidElement& element) {
  const MatrixX full = full_stiffness(element);
  if (element.internal == 0) return full;
  const Eigen::Index nodal = 3 * static_cast<Eigen::Index>(element.nodes.size()), internal = 3 * element.internal;
  const MatrixX K =
      full.topLeftCorner(nodal, nodal) + full.topRightCorner(nodal, internal) * element.internal_from_nodal;
  return 0.5 * (K + K.transpose());
}

MatrixX scalar_mass(const std::string& type_name, const std::vector<int>& nodes, const Matrix3X& positions,
                    const Material& material, MassIntegration integration) {
  const SolidType& type = require_solid(type_name, nodes, positions);
  if (!(material.density > 0) || !std::isfinite(material.density))
    refuse_element("its density is " + std::to_string(material.density) + " kg/m³.", type_name, nodes,
                   "give ElementBlock::material, density > 0.");
  const SolidGeometry geometry(nodes, positions);
  MatrixX m = MatrixX::Zero(type.nodes, type.nodes);
  const int points = integration == MassIntegration::exact ? type.mass_points : type.stiffness_points;
  for (const IntegrationPoint& at : solid_rule(type, points)) {
    const ShapeValues shape = shape_functions(type.nodes, at.xi);
    const double j = geometry.jacobian(shape, type_name, nodes).determinant();
    m.noalias() += (material.density * at.weight * j) * shape.values * shape.values.transpose();
  }
  return m;
}

void assemble_matrices(FiniteElementModel& model, MassIntegration integration) {
  // The pattern first, from the mass of one component: a third of the rows, and no list of single stiffness entries.
  std::vector<Eigen::Triplet<double>> entries;
  size_t count = 0;
  for (const ElementBlock& block : model.elements)
    for (const auto& nodes : block.nodes) count += nodes.size() * nodes.size();
  if (count == 0)
    throw SceneError("the model has no elements.", "model '" + model.name + "'", "fill FiniteElementModel::elements.");
  entries.reserve(count);
  at_elements(model, [&](const ElementBlock& block, const std::vector<int>& nodes) {
    const MatrixX m = scalar_mass(block.type, nodes, model.nodes, block.material, integration);
    for (Eigen::Index b = 0; b < m.cols(); ++b)
      for (Eigen::Index a = 0; a < m.rows(); ++a)
        entries.emplace_back(nodes[static_cast<size_t>(a)], nodes[static_cast<size_t>(b)], m(a, b));
  });
  const int n = model.node_count();
  SparseMatrix m(n, n);
  m.setFromTriplets(entries.begin(), entries.end());
  entries = {};

  model.mass = SparseMatrix(3 * n, 3 * n);
  model.mass.reserve(3 * m.nonZeros());
  model.stiffness = SparseMatrix(3 * n, 3 * n);
  model.stiffness.reserve(9 * m.nonZeros());
  for (int column = 0; column < 3 * n; ++column) {
    model.mass.startVec(column);
    model.stiffness.startVec(column);
    for (SparseMatrix::InnerIterator entry(m, column / 3); entry; ++entry) {
      const int row = 3 * static_cast<int>(entry.row());
      model.mass.insertBack(row + column % 3, column) = entry.value();
      for (int axis = 0; axis < 3; ++axis) model.stiffness.insertBack(row + axis, column) = 0;
    }
  }
  model.mass.finalize();
  model.stiffness.finalize();

  double* values = model.stiffness.valuePtr();
  at_elements(model, [&](const ElementBlock& block, const std::vector<int>& nodes) {
    const MatrixX K = stiffness(make_solid_element(block.type, nodes, model.nodes, block.material));
    for (size_t b = 0; b < nodes.size(); ++b) {
      const int *begin = m.innerIndexPtr() + m.outerIndexPtr()[nodes[b]],
                *end = m.innerIndexPtr() + m.outerIndexPtr()[nodes[b] + 1];
      for (size_t a = 0; a < nodes.size(); ++a) {
        const auto place = 3 * (std::lower_bound(begin, end, nodes[a]) - begin);
        for (int axis = 0; axis < 3; ++axis)
          Eigen::Map<Vector3>(values + model.stiffness.outerIndexPtr()[3 * nodes[b] + axis] + place) +=
              K.block<3, 1>(3 * static_cast<Eigen::Index>(a), 3 * static_cast<Eigen::Index>(b) + axis);
      }
    }
  });
}

StiffnessDifference stiffness_difference(const FiniteElementModel& model) {
  // K less the elements' entries, in its own place; what it has no place for is gathered beside it.
  SparseMatrix rest = model.stiffness, outside(rest.rows(), rest.cols());
  rest.makeCompressed();
  const VectorX diagonal = rest.diagonal();
  std::vector<Eigen::Triplet<double>> entries;
  at_elements(model, [&](const ElementBlock& block, const std::vector<int>& nodes) {
    const MatrixX K = stiffness(make_solid_element(block.type, nodes, model.nodes, block.material));
    for (Eigen::Index b = 0; b < K.cols(); ++b) {
      const auto column = 3 * nodes[static_cast<size_t>(b / 3)] + static_cast<int>(b % 3);
      const int *all = rest.innerIndexPtr(), *begin = all + rest.outerIndexPtr()[column],
                *end = all + rest.outerIndexPtr()[column + 1];
      for (Eigen::Index a = 0; a < K.rows(); ++a) {
        const auto row = 3 * nodes[static_cast<size_t>(a / 3)] + static_cast<int>(a % 3);
        const int* place = std::lower_bound(begin, end, row);
        if (place != end && *place == row)
          rest.valuePtr()[place - all] -= K(a, b);
        else
          entries.emplace_back(row, column, -K(a, b));
      }
    }
  });
  outside.setFromTriplets(entries.begin(), entries.end());

  StiffnessDifference found;
  for (const SparseMatrix* part : {&rest, &outside})
    for (int column = 0; column < part->outerSize(); ++column)
      for (SparseMatrix::InnerIterator entry(*part, column); entry; ++entry) {
        if (entry.value() == 0) continue;
        const double scale = std::sqrt(diagonal[entry.row()] * diagonal[column]);
        const double difference = std::abs(entry.value()) / scale;
        if (difference <= found.largest) continue;
        found = {difference, static_cast<int>(entry.row()) / 3};
      }
  return found;
}

}  // namespace lithe
