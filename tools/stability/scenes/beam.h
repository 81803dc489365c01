#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <memory>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "tools/stability/bench.h"

/// Straight beams along x as flexible bodies: mass points on stations, four each, off the axis by the section's radius
/// of gyration, so that sections turn with the slope; shapes and stiffnesses in closed form.
namespace lithe::lab {

struct Section {
  double bending;      // EI, N m², alike in both directions
  double line;         // kg/m
  double radius;       // of gyration, m, alike in both directions
  double axial = 0;    // EA, N
  double torsion = 0;  // GJ, N m²
};
/// A square section of side `a`, m.
inline Section square(double a, double young, double poisson, double density) {
  const double I = std::pow(a, 4) / 12;
  return {young * I, density * a * a, a / std::sqrt(12), young * a * a, young / (2 + 2 * poisson) * 0.140577 * 12 * I};
}

/// What a section does in a mode: its place moves, and it turns (small).
struct SectionMotion {
  Vector3 place = Vector3::Zero(), turn = Vector3::Zero();
};

/// A body of given shapes and their stiffness matrix: shape(k, x) -> SectionMotion.
template <class Shape>
std::shared_ptr<const ModalBasis> beam_basis(const std::string& name, double length, const Section& section,
                                             const MatrixX& stiffness, int intervals, Shape&& shape) {
  const int count = 4 * (intervals + 1), modes = static_cast<int>(stiffness.rows());
  Matrix3X nodes(3, count);
  SparseMatrix mass(count, count);
  MatrixX B(3 * count, modes);
  for (int i = 0; i < count; ++i) {
    const int station = i / 4;
    const double x = length * station / intervals, r = section.radius;
    const Vector3 off(0, i % 2 ? r : -r, i % 4 < 2 ? r : -r);
    nodes.col(i) = Vector3(x, 0, 0) + off;
    const double simpson = station == 0 || station == intervals ? 1 : station % 2 ? 4 : 2;
    mass.insert(i, i) = simpson / 3 * section.line * length / intervals / 4;
    for (int k = 0; k < modes; ++k) {
      const SectionMotion m = shape(k, x);
      B.block<3, 1>(3 * i, k) = m.place + m.turn.cross(off);
    }
  }
  return basis_from_modes(name, nodes, mass, stiffness.sparseView(), B);
}
/// Nodes of the section at the far end: their mean is its marker.
inline std::vector<int> end_section(const ModalBasis& basis) {
  const int last = static_cast<int>(basis.nodes.cols());
  return {last - 3, last - 2, last - 1, last};
}

enum class Freedom { plane, space };
/// A piece clamped at its frame, with the deflections that loads at its far end make: (x/L)², (x/L)³ across, in the
/// plane x-y or in both planes with stretch and twist. Pieces welded in a row are beam elements of large motion.
inline std::shared_ptr<const ModalBasis> beam_piece(double length, const Section& section, Freedom freedom) {
  const Eigen::Matrix2d bending = section.bending / std::pow(length, 3) * Eigen::Matrix2d{{4, 6}, {6, 12}};
  MatrixX K = bending;
  if (freedom == Freedom::space) {
    K = MatrixX::Zero(6, 6);
    K.topLeftCorner<2, 2>() = K.block<2, 2>(2, 2) = bending;
    K(4, 4) = section.axial / length, K(5, 5) = section.torsion / length;
  }
  return beam_basis("beam piece", length, section, K, 12, [length](int k, double x) -> SectionMotion {
    const double s = x / length, p = k % 2 ? s * s * s : s * s, slope = (k % 2 ? 3 * s * s : 2 * s) / length;
    if (k < 2) return {{0, p, 0}, {0, 0, slope}};
    if (k < 4) return {{0, 0, p}, {0, -slope, 0}};
    if (k == 4) return {{s, 0, 0}, {0, 0, 0}};
    return {{0, 0, 0}, {s, 0, 0}};
  });
}

/// Deflection and slope of a clamped-free beam's mode of unit mean square, by its root of cos z cosh z = -1.
inline constexpr double kCantileverRoots[] = {1.87510406871196,  4.69409113297417,  7.85475743823761,
                                              10.99554073487547, 14.13716839104647, 17.2787595320882,
                                              20.4203522510413,  23.5619449018064,  26.7035375555183};
inline std::array<double, 2> cantilever_mode(int k, double s) {
  const double root = kCantileverRoots[k], z = root * s;
  // exp(-z) and exp(z - 2 root) keep the difference of large numbers away.
  const double ratio = (std::cosh(root) + std::cos(root)) / (std::sinh(root) + std::sin(root));
  const double grown = 0.5 * std::exp(z) * (1 - ratio), fallen = 0.5 * std::exp(-z) * (1 + ratio);
  return {grown + fallen - std::cos(z) + ratio * std::sin(z),
          root * (grown - fallen + std::sin(z) + ratio * std::cos(z))};
}
/// The first modes of a cantilever in the plane x-y, Bernoulli's theory.
inline std::shared_ptr<const ModalBasis> cantilever(double length, const Section& section, int modes,
                                                    int intervals = 40) {
  VectorX stiffness(modes);
  for (int k = 0; k < modes; ++k) stiffness[k] = section.bending * length * std::pow(kCantileverRoots[k] / length, 4);
  return beam_basis("cantilever", length, section, stiffness.asDiagonal(), intervals,
                    [length](int k, double x) -> SectionMotion {
                      const auto [w, slope] = cantilever_mode(k, x / length);
                      return {{0, w, 0}, {0, 0, slope / length}};
                    });
}

/// A bar of 20-node bricks with the section's EI, EA and mass, which bends first in the plane x-y: its first modes,
/// held at one end face. No lateral contraction, as in beam theory.
inline std::shared_ptr<const ModalBasis> solid_cantilever(double length, const Section& section, int modes,
                                                          Deflection deflection) {
  const double height = std::sqrt(12.0) * section.radius, width = 4 * height, area = height * width;
  const FiniteElementModel model =
      brick_mesh({.size = {length, height, width},
                  .divisions = {32, 1, 1},
                  .material = {section.bending / (section.radius * section.radius) / area, 0, section.line / area},
                  .name = "cantilever"});
  return make_basis(model, TangentFrame{model.node_set("x_min")}, modes, {.deflection = deflection});
}

/// A base before Bench, so that what draws its graph can fill it.
struct EndMarker {
  Marker end;
};

}  // namespace lithe::lab
