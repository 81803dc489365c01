#include <cstdio>
#include <ostream>

#include "bodies/flexible/readers/calculix_deck.h"
#include "engine/base/error.h"
#include "engine/output/partial_file.h"

namespace lithe {
namespace {

constexpr std::size_t kPerLine = 16;  // entries of a data line, at most

std::string exact(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

/// Numbers with commas; a line that goes on ends with one.
void write_list(std::ostream& out, const std::vector<int>& numbers) {
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    out << numbers[k];
    const bool last = k + 1 == numbers.size();
    out << (last ? "\n" : (k + 1) % kPerLine == 0 ? ",\n" : ",");
  }
}

void require_writable(const FiniteElementModel& model) {
  const std::string where = "model '" + model.name + "'";
  if (model.elements.empty())
    throw SceneError("it has no elements to write.", where, "read it with its mesh, or make it with brick_mesh().");
  for (const ElementBlock& block : model.elements) {
    if (!is_solid_type(block.type))
      throw SceneError("no deck can be written for elements '" + block.type + "'.", where,
                       "known are C3D4, C3D8, C3D8I, C3D10, C3D20, C3D20R.");
    if (!(block.material.young > 0))
      throw SceneError("elements '" + block.type + "' have no material.", where,
                       "give Young's modulus, Poisson's ratio and density.");
  }
  for (const auto& [set, nodes] : model.node_sets)
    if (set.empty() || set.size() > 80 || set.find_first_of(", \t\n=*\"") != std::string::npos)
      throw SceneError("no deck can hold the set name '" + set + "'.", where, "name it with letters, digits and _.");
}

}  // namespace

void write_calculix_deck(const std::string& path, const FiniteElementModel& model) {
  require_writable(model);
  PartialFile file(path);
  std::ostream& out = file.stream();
  out << "** " << model.name << "\n*NODE\n";
  for (int i = 0; i < model.node_count(); ++i) {
    out << model.node_ids[static_cast<std::size_t>(i)];
    for (double x : model.nodes.col(i)) out << "," << exact(x);
    out << "\n";
  }
  int label = 0, part = 0;
  for (const ElementBlock& block : model.elements) {
    const std::string name = "PART" + std::to_string(++part);
    out << "*ELEMENT, TYPE=" << block.type << ", ELSET=" << name << "\n";
    for (const auto& nodes : block.nodes) {
      std::vector<int> line{++label};
      for (int node : nodes) line.push_back(model.node_ids.at(static_cast<std::size_t>(node)));
      write_list(out, line);
    }
    out << "*MATERIAL, NAME=" << name << "\n*ELASTIC\n"
        << exact(block.material.young) << "," << exact(block.material.poisson) << "\n*DENSITY\n"
        << exact(block.material.density) << "\n*SOLID SECTION, ELSET=" << name << ", MATERIAL=" << name << "\n";
  }
  for (const auto& [set, nodes] : model.node_sets) {
    if (nodes.empty()) continue;
    out << "*NSET, NSET=" << set << "\n";
    write_list(out, nodes);
  }
  file.commit();
}

}  // namespace lithe
