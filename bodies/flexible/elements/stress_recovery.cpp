#include "bodies/flexible/elements/stress_recovery.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "bodies/flexible/elements/shape_functions.h"
#include "engine/base/dense_inverse.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr int kInternalSteps = 50;           // each gains a digit, at strains of some percent
constexpr double kInternalTolerance = 1e-9;  // of the largest displacement

bool same_elasticity(const Material& a, const Material& b) { return a.young == b.young && a.poisson == b.poisson; }

/// Rows: nodes, columns: integration points: the polynomial through the points (1, 4, 8), or the least squares fit of
/// the shapes of the brick of 20 nodes (27 points).
MatrixX extrapolation_matrix(size_t nodes, size_t points) {
  const Matrix3X at = natural_nodes(static_cast<int>(nodes));
  const auto n = static_cast<Eigen::Index>(nodes), count = static_cast<Eigen::Index>(points);
  if (points == 1) return MatrixX::Ones(n, 1);
  if (points == 4) {
    MatrixX through(4, 4), wanted(n, 4);
    const auto rule = tetrahedron_rule(4);
    for (Eigen::Index p = 0; p < 4; ++p) through.row(p) << 1, rule[static_cast<size_t>(p)].xi.transpose();
    wanted << VectorX::Ones(n), at.transpose();
    return wanted * inverse_of(through);
  }
  // Shapes through the points: eight corners of a smaller brick, or the twenty shapes fitted to 27 points.
  const double reach = points == 8 ? std::sqrt(1.0 / 3) : 1.0;
  const int shapes = points == 8 ? 8 : 20;
  const auto rule = brick_rule(points == 8 ? 2 : 3);
  MatrixX through(count, shapes), wanted(n, shapes);
  for (Eigen::Index p = 0; p < count; ++p)
    through.row(p) = shape_functions(shapes, rule[static_cast<size_t>(p)].xi / reach).values.transpose();
  for (Eigen::Index a = 0; a < n; ++a) wanted.row(a) = shape_functions(shapes, at.col(a) / reach).values.transpose();
  return wanted * pseudo_inverse_of(through);
}

Matrix3 strain_of(const Matrix3& H, StrainMeasure measure) {
  const Matrix3 linear = 0.5 * (H + H.transpose());
  return measure == StrainMeasure::small ? linear : Matrix3(linear + 0.5 * H.transpose() * H);
}

Matrix3 tensor(const Vector6& s) { return Matrix3{{s[0], s[3], s[4]}, {s[3], s[1], s[5]}, {s[4], s[5], s[2]}}; }

Vector6 components(const Matrix3& S) {
  return (Vector6() << S(0, 0), S(1, 1), S(2, 2), S(0, 1), S(0, 2), S(1, 2)).finished();
}

}  // namespace

PointStress point_stress(const SolidElement& element, const Eigen::Ref<const VectorX>& displacements,
                         StrainMeasure measure) {
  VectorX all = element.coordinates_of(displacements);
  Eigen::Map<Matrix3X> u(all.data(), 3, all.size() / 3);
  if (element.internal > 0 && measure == StrainMeasure::green_lagrange) {
    // The force on the internal coordinates is zero for small strain; here they still have to give way, by Newton's
    // method with the tangent at rest.
    const double scale = u.cwiseAbs().maxCoeff();
    VectorX step;
    int left = kInternalSteps;
    do {
      Matrix3X force = Matrix3X::Zero(3, element.internal);
      for (const SolidPoint& point : element.points) {
        const Matrix3 H = u * point.gradients;
        force += point.volume * (Matrix3::Identity() + H) * hooke(strain_of(H, measure), element.material) *
                 point.gradients.bottomRows(element.internal).transpose();
      }
      step = element.internal_compliance * force.reshaped();
      all.tail(3 * element.internal) -= step;
    } while (--left > 0 && step.cwiseAbs().maxCoeff() > kInternalTolerance * scale);
  }
  const auto count = static_cast<Eigen::Index>(element.points.size());
  PointStress result{Matrix6X(6, count), Matrix6X(6, count)};
  for (Eigen::Index p = 0; p < count; ++p) {
    const Matrix3 H = u * element.points[static_cast<size_t>(p)].gradients, E = strain_of(H, measure);
    Matrix3 S = hooke(E, element.material);
    if (measure == StrainMeasure::green_lagrange) {
      const Matrix3 F = Matrix3::Identity() + H;
      S = (F * S * F.transpose() / F.determinant()).eval();
    }
    result.strain.col(p) = components(E).cwiseProduct((Vector6() << 1, 1, 1, 2, 2, 2).finished());
    result.stress.col(p) = components(S);
  }
  return result;
}

StressRecovery::StressRecovery(const ModalBasis& basis, StrainMeasure measure) : name_(basis.name) {
  FiniteElementModel mesh;  // in body axes
  mesh.name = basis.name;
  mesh.node_ids = basis.node_ids;
  mesh.nodes = basis.nodes;
  mesh.elements = basis.elements;
  if (basis.nodal) {
    coordinates_ = basis.mode_count();
    take_elements(mesh, basis.free_dofs, measure);
    return;
  }
  const int more = basis.deflection ? basis.deflection->field_count() : 0;
  MatrixX fields(basis.modes.rows(), basis.modes.cols() + more);
  fields.leftCols(basis.modes.cols()) = basis.modes;
  if (more > 0) fields.rightCols(more) = basis.deflection->fields;
  *this = StressRecovery(mesh, fields, measure);
}

StressRecovery::StressRecovery(const FiniteElementModel& model, const MatrixX& fields, StrainMeasure measure)
    : name_(model.name), coordinates_(static_cast<int>(fields.cols())), fields_(fields) {
  if (fields.rows() < 3 * model.node_count())
    throw SceneError("displacement fields with " + std::to_string(fields.rows()) + " rows for " +
                         std::to_string(model.node_count()) + " nodes.",
                     "model '" + model.name + "'", "give three rows a node.");
  take_elements(model, {}, measure);
}

StressRecovery::StressRecovery(MatrixX stress_modes)
    : name_("stress modes"),
      nodes_(static_cast<int>(stress_modes.rows() / 6)),
      coordinates_(static_cast<int>(stress_modes.cols())),
      stress_modes_(std::move(stress_modes)) {
  if (stress_modes_.rows() % 6 != 0 || nodes_ == 0 || !stress_modes_.allFinite())
    throw SceneError(std::to_string(stress_modes_.rows()) + " rows of stress modes, or an entry that is not a number.",
                     name_, "give six finite rows a node: xx yy zz xy xz yz.");
}

void StressRecovery::take_elements(const FiniteElementModel& model, const std::vector<int>& free_dofs,
                                   StrainMeasure measure) {
  measure_ = measure;
  free_dofs_ = free_dofs;
  nodes_ = model.node_count();
  elements_ = make_solid_elements(model);
  if (elements_.empty())
    throw SceneError("stresses of a mesh without elements.", "model '" + model.name + "'",
                     "import the elements with the matrices, or give stress modes.");
  node_materials_.assign(static_cast<size_t>(nodes_), {});
  for (const SolidElement& element : elements_) {
    const auto shape = std::pair(element.nodes.size(), element.points.size());
    if (!extrapolation_.count(shape)) extrapolation_[shape] = extrapolation_matrix(shape.first, shape.second);
    for (int node : element.nodes)
      if (Material& here = node_materials_[static_cast<size_t>(node)]; element.material.young > here.young)
        here = element.material;
  }
  shares_ = VectorX::Zero(nodes_);
  for (const SolidElement& element : elements_)
    for (int node : element.nodes)
      if (same_elasticity(element.material, node_materials_[static_cast<size_t>(node)])) shares_[node] += 1;
  shares_ = (shares_.array() > 0).select(shares_.cwiseInverse(), 0.0);

  if (measure == StrainMeasure::small && free_dofs.empty()) {
    stress_modes_.resize(6 * nodes_, coordinates_);
    for (int k = 0; k < coordinates_; ++k)
      stress_modes_.col(k) = nodal(fields_.col(k), &PointStress::stress).reshaped();
    elements_.clear();
    fields_.resize(0, 0);
  }
}

Matrix6X StressRecovery::nodal(const VectorX& displacements, Matrix6X PointStress::*quantity) const {
  Matrix6X values = Matrix6X::Zero(6, nodes_);
  for (const SolidElement& element : elements_) {
    const MatrixX& E = extrapolation_.at({element.nodes.size(), element.points.size()});
    const Matrix6X at_nodes = point_stress(element, displacements, measure_).*quantity * E.transpose();
    for (size_t a = 0; a < element.nodes.size(); ++a)
      if (const int node = element.nodes[a];
          same_elasticity(element.material, node_materials_[static_cast<size_t>(node)]))
        values.col(node) += shares_[node] * at_nodes.col(static_cast<Eigen::Index>(a));
  }
  return values;
}

void StressRecovery::require_coordinates(ConstVectorRef coordinates) const {
  if (coordinates.size() != coordinates_)
    throw SceneError(std::to_string(coordinates.size()) + " coordinates for the stresses of " +
                         std::to_string(coordinates_) + " fields.",
                     "model '" + name_ + "'", "give those of all fields of the basis.");
}

VectorX StressRecovery::displacements(ConstVectorRef coordinates) const {
  if (fields_.size() > 0) return fields_ * coordinates;
  VectorX u = VectorX::Zero(3 * nodes_);
  for (size_t k = 0; k < free_dofs_.size(); ++k) u[free_dofs_[k]] = coordinates[static_cast<Eigen::Index>(k)];
  return u;
}

Matrix6X StressRecovery::stress(ConstVectorRef coordinates) const {
  require_coordinates(coordinates);
  if (elements_.empty()) return (stress_modes_ * coordinates).reshaped(6, nodes_);
  return nodal(displacements(coordinates), &PointStress::stress);
}

Matrix6X StressRecovery::strain(ConstVectorRef coordinates) const {
  require_coordinates(coordinates);
  if (node_materials_.empty())
    throw SceneError("strains from stress modes alone.", "model '" + name_ + "'", "give elements with their material.");
  if (!elements_.empty()) return nodal(displacements(coordinates), &PointStress::strain);
  // Hooke's law commutes with the means: they are over elements of one material.
  Matrix6X strain = stress(coordinates);
  for (int i = 0; i < nodes_; ++i) {
    const Material& material = node_materials_[static_cast<size_t>(i)];
    if (!(material.young > 0)) continue;
    const Matrix6 compliance = inverse_of(elasticity(material));
    strain.col(i) = compliance * strain.col(i);
  }
  return strain;
}

VectorX von_mises(const Matrix6X& stress) {
  const auto s = stress.array();
  return (0.5 * ((s.row(0) - s.row(1)).square() + (s.row(1) - s.row(2)).square() + (s.row(2) - s.row(0)).square()) +
          3 * (s.row(3).square() + s.row(4).square() + s.row(5).square()))
      .sqrt()
      .matrix()
      .transpose();
}

Matrix3X principal(const Matrix6X& stress) {
  Matrix3X values(3, stress.cols());
  for (Eigen::Index i = 0; i < stress.cols(); ++i)
    values.col(i) =
        Eigen::SelfAdjointEigenSolver<Matrix3>(tensor(stress.col(i)), Eigen::EigenvaluesOnly).eigenvalues().reverse();
  return values;
}

Matrix6X turned_stress(const Matrix6X& stress, const Matrix3& rotation) {
  Matrix6X result(6, stress.cols());
  for (Eigen::Index i = 0; i < stress.cols(); ++i) {
    result.col(i) = components(rotation * tensor(stress.col(i)) * rotation.transpose());
  }
  return result;
}

void StressExtrema::add(double at, const Matrix6X& stress) {
  const VectorX now = von_mises(stress);
  if (!now.allFinite() || (largest.size() > 0 && largest.size() != now.size()))
    throw SceneError("stresses of " + std::to_string(now.size()) + " nodes after " + std::to_string(largest.size()) +
                         ", or not a number.",
                     "StressExtrema, t = " + std::to_string(at), "add the stresses of one body, of finite states.");
  if (largest.size() == 0) {
    largest = VectorX::Constant(now.size(), -1);
    times = VectorX::Zero(now.size());
  }
  for (Eigen::Index i = 0; i < now.size(); ++i) {
    if (now[i] <= largest[i]) continue;
    largest[i] = now[i];
    times[i] = at;
    if (node >= 0 && now[i] <= value) continue;
    value = now[i];
    time = at;
    node = static_cast<int>(i);
  }
}

}  // namespace lithe
