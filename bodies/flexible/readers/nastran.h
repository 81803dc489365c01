#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// What Nastran writes of a free body: bulk data with its nodes, and stiffness and mass as DMIG (.pch; or in the bulk
/// data itself) or by OUTPUT4 (.op4, text or binary). Prefer OUTPUT4: the ten digits of a punched DMIG move the first
/// frequencies of a slender body in the fifth digit, where modal stiffness is a small difference of large entries.
struct NastranFiles {
  std::string deck;
  std::vector<std::string> matrices{};  // none: the DMIG of the deck
  /// Names of the matrices; none: KAAX, KGG, K2GG ... and MAAX, MGG, M2GG ..., or else the first that begins with K, M.
  std::string stiffness{}, mass{};
  /// Rows of OUTPUT4 matrices, one a line: node and direction (1-6; 0: a scalar point). None: all nodes by ascending
  /// label, three or six rows each.
  std::string rows{};
};

/// Empty rows (rotations of solids in a set of six each) are left out. Throws FileError naming file:line, or the byte
/// of a binary file.
FiniteElementModel read_nastran(const NastranFiles& files);

}  // namespace lithe
