#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/modal_basis.h"

namespace lithe {

/// A consistent system of units, as finite-element decks use them without saying so. Figures are one unit in SI.
struct UnitSystem {
  std::string name;  // "mm-t-s"
  double length, mass, time;
  std::string remark;  // "N, MPa"
};

/// m-kg-s first.
const std::vector<UnitSystem>& unit_systems();
/// By name, or "SI"; SceneError listing the known ones.
const UnitSystem& unit_system(const std::string& name);

/// Nodes, K, M, damping and materials of a model, or a reduced body, from `units` into SI. Coordinates η of a reduced
/// body are scaled with it so that Mff keeps its numbers.
void convert_to_si(FiniteElementModel& model, const UnitSystem& units);
void convert_to_si(ModalBasis& basis, const UnitSystem& units);

/// What tells the units of a body: figures in its own units, 0 where they cannot be known.
struct UnitEvidence {
  double density = 0;        // mass over the volume of the elements, or of the box around the nodes
  bool of_elements = false;  // else of the box: a lower bound of the material's
  double wave_speed = 0;     // √(E/ρ) of the material, or about: node distance times √(K_ii/3M_ii), the median
  bool of_material = false;
};
UnitEvidence unit_evidence(const FiniteElementModel& model);
UnitEvidence unit_evidence(const ModalBasis& basis);
/// Could a body in these units exist? Densities of 20 (box: 0.002) to 25000 kg/m³; wave speeds of 5 to 40000 m/s, of
/// 100 at least where no density is known.
bool plausible(const UnitEvidence& evidence, const UnitSystem& units);
/// One line: "density 7850 kg/m3, wave speed 5170 m/s".
std::string figures(const UnitEvidence& evidence, const UnitSystem& units);

/// The system called `name`, or, with an empty name, SI if a body in SI could exist. FileError naming `path` otherwise:
/// it asks, and lists what each system would mean.
const UnitSystem& choose_units(const std::string& name, const UnitEvidence& evidence, const std::string& path);

}  // namespace lithe
