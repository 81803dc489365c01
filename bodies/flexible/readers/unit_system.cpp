#include "bodies/flexible/readers/unit_system.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/number_text.h"

namespace lithe {
namespace {

double tetrahedron(const Matrix3X& r, int a, int b, int c, int d) {
  const Vector3 u = r.col(b) - r.col(a), v = r.col(c) - r.col(a), w = r.col(d) - r.col(a);
  return u.cross(v).dot(w) / 6;
}

/// By its corners: five or six tetrahedra, three for a wedge. 0 for what is no solid.
double corner_volume(const Matrix3X& r, const std::vector<int>& e) {
  switch (e.size()) {
    case 4:
    case 10:
      return tetrahedron(r, e[0], e[1], e[2], e[3]);
    case 6:
    case 15:
      return tetrahedron(r, e[0], e[1], e[2], e[3]) + tetrahedron(r, e[1], e[2], e[3], e[4]) +
             tetrahedron(r, e[2], e[3], e[4], e[5]);
    case 8:
    case 20: {
      // Around the diagonal 0-6.
      constexpr int ring[] = {1, 2, 3, 7, 4, 5, 1};
      double sum = 0;
      for (int k = 0; k < 6; ++k) sum += tetrahedron(r, e[0], e[6], e[ring[k]], e[ring[k + 1]]);
      return sum;
    }
    default:
      return 0;
  }
}

/// Of the box around the nodes along the principal axes of their cloud; if that is flat, of a cube of its longest side.
double box_volume(const Matrix3X& nodes) {
  if (nodes.cols() < 2) return 0;
  const Vector3 mean = nodes.rowwise().mean();
  const Matrix3X arms = nodes.colwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Matrix3> axes(arms * arms.transpose());
  const Matrix3X turned = axes.eigenvectors().transpose() * arms;
  const Vector3 sides = turned.rowwise().maxCoeff() - turned.rowwise().minCoeff();
  return sides.minCoeff() > 1e-6 * sides.maxCoeff() ? sides.prod() : std::pow(sides.maxCoeff(), 3);
}

void scale_materials(std::vector<ElementBlock>& blocks, const UnitSystem& u) {
  for (ElementBlock& block : blocks) {
    block.material.young *= u.mass / (u.length * u.time * u.time);
    block.material.density *= u.mass / (u.length * u.length * u.length);
  }
}

}  // namespace

const std::vector<UnitSystem>& unit_systems() {
  constexpr double inch = 0.0254, foot = 0.3048, pound = 0.45359237, gravity = 9.80665;
  static const std::vector<UnitSystem> known{
      {"m-kg-s", 1, 1, 1, "SI: N, Pa"},
      {"mm-t-s", 1e-3, 1e3, 1, "N, MPa"},
      {"mm-kg-ms", 1e-3, 1, 1e-3, "kN, GPa"},
      {"mm-kg-s", 1e-3, 1, 1, "mN, kPa"},
      {"mm-g-ms", 1e-3, 1e-3, 1e-3, "N, MPa"},
      {"cm-g-s", 1e-2, 1e-3, 1, "dyn"},
      {"inch-lbf-s", inch, pound * gravity / inch, 1, "lbf, psi; mass in lbf s2/in"},
      {"foot-lbf-s", foot, pound * gravity / foot, 1, "lbf, psf; mass in slug"}};
  return known;
}

const UnitSystem& unit_system(const std::string& name) {
  if (name == "SI" || name == "si") return unit_systems().front();
  std::string known = "SI";
  for (const UnitSystem& system : unit_systems()) {
    if (system.name == name) return system;
    known += ", " + system.name;
  }
  throw SceneError("no system of units '" + name + "'.", "units", "known are " + known + ".");
}

void convert_to_si(FiniteElementModel& model, const UnitSystem& u) {
  model.nodes *= u.length;
  // Rows of rotations are moments where those of translations are forces: one more length each way.
  VectorX arm = VectorX::Ones(model.dof_count());
  arm.tail(static_cast<Eigen::Index>(model.rotations.size())).setConstant(u.length);
  const auto scale = [&](SparseMatrix& A, double unit) {
    for (int j = 0; j < A.outerSize(); ++j)
      for (SparseMatrix::InnerIterator entry(A, j); entry; ++entry)
        entry.valueRef() *= unit * arm[entry.row()] * arm[j];
  };
  if (u.mass != 1 || u.length != 1 || u.time != 1) {
    scale(model.stiffness, u.mass / (u.time * u.time));
    scale(model.mass, u.mass);
    scale(model.damping, u.mass / u.time);
  }
  scale_materials(model.elements, u);
}

void convert_to_si(ModalBasis& basis, const UnitSystem& u) {
  // η' = √(mass) length η: displacements B η in metres then ask for B' = B / √mass, and Mff stays as it is.
  const double root = std::sqrt(u.mass), moment = u.mass * u.length * u.length;
  const Eigen::Index translations = 3 * basis.nodes.cols();
  basis.origin *= u.length;
  basis.nodes *= u.length;
  basis.modes.topRows(translations) /= root;
  basis.modes.bottomRows(basis.modes.rows() - translations) /= root * u.length;
  basis.nodal_mass *= u.mass;
  basis.stiffness /= u.time * u.time;
  basis.damping /= u.time;
  basis.frequencies /= u.time;
  InertiaIntegrals& I = basis.integrals;
  I.mass *= u.mass;
  I.s0 *= u.mass * u.length;
  I.J0 *= moment;
  I.Ct *= root;
  I.C0 *= root * u.length;
  I.J1 *= root * u.length;
  scale_materials(basis.elements, u);
}

UnitEvidence unit_evidence(const FiniteElementModel& model) {
  UnitEvidence found;
  double mass = 0, space = 0, modulus = 0, weight = 0;
  for (int j = 0; j < model.mass.outerSize() && j < 3 * model.node_count(); ++j)
    for (SparseMatrix::InnerIterator e(model.mass, j); e; ++e)
      if (e.row() < 3 * model.node_count() && e.row() % 3 == j % 3) mass += e.value() / 3;
  for (const ElementBlock& block : model.elements) {
    if (block.type.rfind("C3D", 0) != 0) continue;
    for (const auto& element : block.nodes) {
      const double v = std::abs(corner_volume(model.nodes, element));
      space += v;
      modulus += v * block.material.young, weight += v * block.material.density;
    }
  }
  found.of_elements = space > 0;
  if (!found.of_elements) space = box_volume(model.nodes);
  if (space > 0 && mass > 0) found.density = mass / space;
  if (found.of_elements && modulus > 0 && weight > 0) {
    found.wave_speed = std::sqrt(modulus / weight);
    found.of_material = true;
    return found;
  }

  // A rod of linear elements, consistent mass: K_ii / M_ii = 3 c² / h² inside.
  if (model.stiffness.rows() != model.dof_count() || model.mass.rows() != model.dof_count()) return found;
  std::vector<double> speeds;
  const VectorX k = model.stiffness.diagonal(), m = model.mass.diagonal();
  for (int i = 0; i < model.node_count(); ++i) {
    double nearest = 0;
    for (SparseMatrix::InnerIterator e(model.stiffness, 3 * i); e; ++e) {
      const auto other = static_cast<int>(e.row()) / 3;
      if (other == i || other >= model.node_count()) continue;
      const double distance = (model.nodes.col(other) - model.nodes.col(i)).norm();
      if (distance > 0 && (nearest == 0 || distance < nearest)) nearest = distance;
    }
    const double stiff = k.segment<3>(3 * i).sum(), heavy = m.segment<3>(3 * i).sum();
    if (nearest > 0 && stiff > 0 && heavy > 0) speeds.push_back(nearest * std::sqrt(stiff / heavy / 3));
  }
  if (speeds.empty()) return found;
  const auto middle = speeds.begin() + static_cast<long>(speeds.size() / 2);
  std::nth_element(speeds.begin(), middle, speeds.end());
  found.wave_speed = *middle;
  return found;
}

UnitEvidence unit_evidence(const ModalBasis& basis) {
  const double box = box_volume(basis.nodes);
  return {.density = box > 0 ? basis.integrals.mass / box : 0};
}

bool plausible(const UnitEvidence& e, const UnitSystem& u) {
  const double density = e.density * u.mass / (u.length * u.length * u.length);
  const double speed = e.wave_speed * u.length / u.time;
  if (e.density == 0 && e.wave_speed == 0) return false;
  const bool dense = e.density == 0 || ((density >= (e.of_elements ? 20 : 2e-3)) && density <= 25000);
  const bool stiff = e.wave_speed == 0 || (speed >= (e.density == 0 ? 100 : 5) && speed <= 40000);
  return dense && stiff;
}

std::string figures(const UnitEvidence& e, const UnitSystem& u) {
  std::string text;
  if (e.density > 0)
    text += std::string("density ") + (e.of_elements ? "" : "at least ") +
            three_digits(e.density * u.mass / (u.length * u.length * u.length)) + " kg/m3";
  if (e.wave_speed > 0)
    text += std::string(text.empty() ? "" : ", ") + "wave speed " + (e.of_material ? "" : "about ") +
            three_digits(e.wave_speed * u.length / u.time) + " m/s";
  return text.empty() ? "neither density nor wave speed known" : text;
}

const UnitSystem& choose_units(const std::string& name, const UnitEvidence& evidence, const std::string& path) {
  if (!name.empty()) return unit_system(name);
  if (plausible(evidence, unit_systems().front())) return unit_systems().front();
  std::string candidates;
  for (const UnitSystem& system : unit_systems())
    candidates += "\n    " + system.name + " (" + system.remark + "): " + figures(evidence, system) +
                  (plausible(evidence, system) ? "  <- possible" : "");
  throw FileError("the file does not state its units, and they are not metre, kilogram, second.", path,
                  "say which they are (.units, or --units on the command line):" + candidates);
}

}  // namespace lithe
