#pragma once

#include <vector>

#include "engine/base/rotations.h"
#include "joints/contact/contact.h"

namespace lithe {

/// A round bar on a node of a line: its middle before or behind the node, and the length of its cylindrical part, m.
struct CapsulePiece {
  double middle, length;
};
/// From half way to the node before to half way to the one after, nodes at these arc lengths; the line ends with the
/// rounding. SceneError for a radius that is not above zero or too large for the end pieces.
std::vector<CapsulePiece> capsule_pieces(const std::vector<double>& arcs, double radius);

/// Colliders of a beam: round bars along it, each fixed in its node. Where a bent beam's bars overlap, both touch.
/// Throws as capsule_pieces().
///   std::vector<Collider> all = capsules(beam, 0.01);
///   all.push_back({graph.ground().marker(), shape::half_space()});
///   graph.add<Contact>("table", all, {.law = Compliance{.stiffness = 1e7}});
template <class Line>
std::vector<Collider> capsules(Line& beam, double radius) {
  std::vector<double> arcs;
  for (int i = 0; i < beam.node_count(); ++i) arcs.push_back(beam.arc(i));
  const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2);  // a capsule's z along axis 1
  std::vector<Collider> bars;
  for (const CapsulePiece& piece : capsule_pieces(arcs, radius))
    bars.push_back(
        {beam.marker(arcs[bars.size()], Vector3(piece.middle, 0, 0), along), shape::capsule(radius, piece.length)});
  return bars;
}

}  // namespace lithe
