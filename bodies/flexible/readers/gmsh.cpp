#include "bodies/flexible/readers/gmsh.h"

#include <algorithm>
#include <array>
#include <set>
#include <unordered_map>

#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace lithe {
namespace {

constexpr const char* kSaveAgain = "save the mesh again as MSH 4.1 or 2.2 ASCII; the file may be cut.";

/// Element types of gmsh by their number (Geuzaine & Remacle, gmsh reference manual, "Node ordering").
struct GmshType {
  int number, dimension, nodes;
  const char* solid;          // CalculiX's name, null: not read as a solid
  std::array<int, 20> order;  // CalculiX's node k is gmsh's node order[k]
};
constexpr GmshType kTypes[] = {
    {15, 0, 1, nullptr, {}},
    {1, 1, 2, nullptr, {}},
    {8, 1, 3, nullptr, {}},
    {2, 2, 3, nullptr, {}},
    {3, 2, 4, nullptr, {}},
    {9, 2, 6, nullptr, {}},
    {10, 2, 9, nullptr, {}},
    {16, 2, 8, nullptr, {}},
    {4, 3, 4, "C3D4", {0, 1, 2, 3}},
    {5, 3, 8, "C3D8I", {0, 1, 2, 3, 4, 5, 6, 7}},
    {11, 3, 10, "C3D10", {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}},
    {17, 3, 20, "C3D20", {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15}},
};

using Group = std::pair<int, int>;  // dimension and number of a physical group

class MeshReader {
 public:
  MeshReader(const std::string& path, const std::map<std::string, Material>& materials)
      : file_(path, "give a mesh that gmsh has saved (.msh)."), materials_(materials) {
    model_.name = path;
  }

  FiniteElementModel read() {
    bool nodes = false, elements = false, format = false;
    while (next_section()) {
      const std::string section = section_;
      if (section != "MeshFormat" && !format) fail("the file does not begin with $MeshFormat.");
      if (section == "MeshFormat") {
        read_format();
        format = true;
      } else if (section == "PhysicalNames") {
        read_names();
      } else if (section == "Entities" && version4_) {
        read_entities();
      } else if (section == "PartitionedEntities") {
        file_.fail("the mesh is partitioned.", "save it in one piece.");
      } else if (section == "Nodes") {
        if (nodes) fail("a second section $Nodes.");
        version4_ ? read_node_blocks() : read_node_list();
        nodes = true;
      } else if (section == "Elements") {
        if (!nodes || elements) fail("$Elements belongs behind $Nodes, once.");
        version4_ ? read_element_blocks() : read_element_list();
        elements = true;
      } else {
        skip_section();
      }
    }
    if (!elements) fail("the file has no section $Elements.");
    return settled();
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { file_.fail(problem, kSaveAgain); }

  bool next_section() {
    while (file_.next()) {
      if (file_.blank()) continue;
      const std::string_view line = trimmed(file_.line());
      if (line[0] != '$' || line.rfind("$End", 0) == 0)
        fail("'" + std::string(line.substr(0, 40)) + "' where a section should begin.");
      section_ = line.substr(1);
      return true;
    }
    return false;
  }
  void end_section() {
    next_line("$End" + section_);
    if (trimmed(file_.line()) != "$End" + section_) fail("$End" + section_ + " should stand here.");
  }
  void skip_section() {
    do next_line("$End" + section_);
    while (trimmed(file_.line()) != "$End" + section_);
  }
  /// The next line that is not blank, cut into words.
  const std::vector<std::string_view>& next_line(const std::string& wanted) {
    do
      if (!file_.next()) fail("the file ends where " + wanted + " should stand.");
    while (file_.blank());
    return file_.words();
  }
  const std::vector<std::string_view>& next_line(const std::string& wanted, size_t words) {
    const auto& line = next_line(wanted);
    if (line.size() != words) fail(wanted + " should be " + std::to_string(words) + " numbers.");
    return line;
  }
  int integer(std::string_view word, std::string_view what) const { return file_.integer(word, what); }
  int count(std::string_view word, std::string_view what) const {
    const int value = integer(word, what);
    if (value < 0) fail("the " + std::string(what) + " is negative.");
    return value;
  }

  void read_format() {
    const auto& words = next_line("version, type and size", 3);
    const double version = file_.number(words[0], "version");
    version4_ = version == 4.1;
    if (!version4_ && version != 2.2 && version != 2)
      file_.fail("version " + std::string(words[0].substr(0, 10)) + " of the format.",
                 "save the mesh as MSH 4.1 or 2.2 (gmsh -format msh41).");
    if (words[1] != "0")
      file_.fail("the file is binary.", "save the mesh as ASCII (gmsh without -bin; Mesh.Binary=0).");
    end_section();
  }

  void read_names() {
    const int names = count(next_line("the number of names", 1)[0], "number of names");
    for (int k = 0; k < names; ++k) {
      const auto& words = next_line("dimension, number and name of a physical group");
      if (words.size() < 3) fail("a physical group without a name.");
      const Group group{integer(words[0], "dimension"), integer(words[1], "physical group")};
      const std::string_view line = file_.line();
      const size_t open = line.find('"'), close = line.rfind('"');
      if (open == close) fail("the name of a physical group stands in quotes.");
      names_[group] = lower_case(trimmed(line.substr(open + 1, close - open - 1)));
    }
    end_section();
  }

  std::string name_of(const Group& group) const {
    if (const auto found = names_.find(group); found != names_.end() && !found->second.empty()) return found->second;
    constexpr const char* kinds[] = {"point_", "line_", "surface_", "volume_"};
    return kinds[group.first] + std::to_string(group.second);
  }

  /// Version 4: the physical groups of each geometric entity.
  void read_entities() {
    const auto& counts = next_line("four numbers of entities", 4);
    std::array<int, 4> entities;
    for (size_t d = 0; d < 4; ++d) entities[d] = count(counts[d], "number of entities");
    for (int dimension = 0; dimension < 4; ++dimension)
      for (int k = 0; k < entities[static_cast<size_t>(dimension)]; ++k) {
        const auto& words = next_line("an entity");
        const size_t box = dimension == 0 ? 4 : 7;  // behind tag and point, or tag and box
        if (words.size() <= box) fail("an entity without its number of physical groups.");
        const int entity = integer(words[0], "entity"), groups = count(words[box], "number of physical groups");
        if (words.size() < box + 1 + static_cast<size_t>(groups)) fail("an entity with fewer groups than it counts.");
        for (size_t g = 0; g < static_cast<size_t>(groups); ++g)
          groups_[{dimension, entity}].push_back(integer(words[box + 1 + g], "physical group"));
      }
    end_section();
  }

  void add_node(int id, std::string_view x, std::string_view y, std::string_view z) {
    if (!index_.emplace(id, static_cast<int>(positions_.size())).second)
      fail("node " + std::to_string(id) + " is given twice.");
    if (id < 1) fail("node " + std::to_string(id) + ": labels are positive.");
    ids_.push_back(id);
    positions_.emplace_back(file_.number(x, "x coordinate"), file_.number(y, "y coordinate"),
                            file_.number(z, "z coordinate"));
  }

  void read_node_list() {
    const int nodes = count(next_line("the number of nodes", 1)[0], "number of nodes");
    for (int k = 0; k < nodes; ++k) {
      const auto& words = next_line("node, x, y and z", 4);
      add_node(integer(words[0], "node label"), words[1], words[2], words[3]);
    }
    end_section();
  }

  void read_node_blocks() {
    const auto& head = next_line("blocks, nodes, lowest and highest label", 4);
    const int blocks = count(head[0], "number of blocks"), nodes = count(head[1], "number of nodes");
    for (int b = 0; b < blocks; ++b) {
      const auto& words = next_line("dimension, entity, parametric and number of nodes", 4);
      const bool parametric = words[2] != "0";
      const int size = count(words[3], "number of nodes");
      if (size > nodes - static_cast<int>(ids_.size())) fail("more nodes than the section announces.");
      std::vector<int> ids;
      for (int k = 0; k < size; ++k) ids.push_back(integer(next_line("a node label", 1)[0], "node label"));
      for (int id : ids) {
        const auto& at = next_line("x, y and z");
        if (at.size() < 3 || (!parametric && at.size() != 3)) fail("x, y and z should stand here.");
        add_node(id, at[0], at[1], at[2]);
      }
    }
    if (static_cast<int>(ids_.size()) != nodes)
      fail(std::to_string(ids_.size()) + " nodes, where " + std::to_string(nodes) + " are announced.");
    end_section();
  }

  const GmshType* find_type(int number) const {
    const auto found = std::find_if(std::begin(kTypes), std::end(kTypes), [&](auto& t) { return t.number == number; });
    return found == std::end(kTypes) ? nullptr : found;
  }
  const GmshType& type_of(int number) const {
    if (const GmshType* type = find_type(number)) return *type;
    file_.fail("an element of gmsh's type " + std::to_string(number) + ".",
               "mesh with tetrahedra or hexahedra of first or second order (hexahedra: Mesh.SecondOrderIncomplete=1).");
  }

  /// `nodes` in gmsh's order; a solid that several groups list is one.
  void add_element(const GmshType& type, const std::vector<std::string_view>& words, size_t first,
                   const std::vector<int>& groups) {
    if (words.size() != first + static_cast<size_t>(type.nodes))
      fail("an element of " + std::to_string(words.size() - std::min(first, words.size())) + " nodes, it has " +
           std::to_string(type.nodes) + ".");
    std::vector<int> nodes;
    for (size_t k = first; k < words.size(); ++k) {
      const int id = integer(words[k], "node label");
      const auto found = index_.find(id);
      if (found == index_.end()) fail("node " + std::to_string(id) + " is not in $Nodes.");
      nodes.push_back(found->second);
    }
    for (int group : groups) {
      auto& members = sets_[{type.dimension, group}];
      members.insert(members.end(), nodes.begin(), nodes.end());
    }
    if (!type.solid) return;
    std::vector<int> key = nodes;
    std::sort(key.begin(), key.end());
    if (std::adjacent_find(key.begin(), key.end()) != key.end()) fail("an element uses a node twice.");
    if (!solids_.insert(key).second) return;
    std::vector<int> solid;
    for (size_t k = 0; k < nodes.size(); ++k) solid.push_back(nodes[static_cast<size_t>(type.order[k])]);
    const std::string name = groups.empty() ? "" : name_of({3, groups.front()});
    ElementBlock& block = blocks_[{name, type.number}];
    if (block.nodes.empty()) block.type = type.solid, block.material = material_of(name);
    block.nodes.push_back(std::move(solid));
  }

  Material material_of(const std::string& volume) const {
    for (const auto& [name, material] : materials_)
      if (!name.empty() && lower_case(name) == volume) return material;
    const auto found = materials_.find("");
    if (found != materials_.end()) return found->second;
    file_.fail("no material for volume '" + volume + "'.",
               "give one under this name, or one for all volumes: E, nu and density.");
  }

  void read_element_list() {
    const int elements = count(next_line("the number of elements", 1)[0], "number of elements");
    for (int k = 0; k < elements; ++k) {
      const auto& words = next_line("an element");
      if (words.size() < 3) fail("an element without type and tags.");
      const GmshType& type = type_of(integer(words[1], "element type"));
      const int tags = count(words[2], "number of tags");
      if (tags > static_cast<int>(words.size())) fail("an element with fewer tags than it counts.");
      std::vector<int> groups;
      if (tags > 0 && words.size() > 3)
        if (const int group = integer(words[3], "physical group"); group != 0) groups.push_back(group);
      add_element(type, words, 3 + static_cast<size_t>(tags), groups);
    }
    end_section();
  }

  void read_element_blocks() {
    const auto& head = next_line("blocks, elements, lowest and highest label", 4);
    const int blocks = count(head[0], "number of blocks"), elements = count(head[1], "number of elements");
    long found = 0;
    for (int b = 0; b < blocks; ++b) {
      const auto& words = next_line("dimension, entity, type and number of elements", 4);
      const Group entity{integer(words[0], "dimension"), integer(words[1], "entity")};
      const GmshType& type = type_of(integer(words[2], "element type"));
      const int size = count(words[3], "number of elements");
      const auto groups = groups_.find(entity);
      found += size;
      for (int k = 0; k < size; ++k)
        add_element(type, next_line("an element"), 1, groups == groups_.end() ? std::vector<int>() : groups->second);
    }
    if (found != elements)
      fail(std::to_string(found) + " elements, where " + std::to_string(elements) + " are announced.");
    end_section();
  }

  /// Nodes of solids alone, sets among them.
  FiniteElementModel settled() {
    if (blocks_.empty())
      throw FileError("the mesh has no tetrahedra or hexahedra.", file_.path(),
                      "mesh the volume (gmsh -3), and put it into a physical group if others are.");
    std::vector<char> used(ids_.size(), 0);
    for (const auto& [key, block] : blocks_)
      for (const auto& element : block.nodes)
        for (int node : element) used[static_cast<size_t>(node)] = 1;
    std::vector<int> place(ids_.size(), -1);
    for (size_t i = 0; i < ids_.size(); ++i) {
      if (!used[i]) continue;
      place[i] = static_cast<int>(model_.node_ids.size());
      model_.node_ids.push_back(ids_[i]);
    }
    model_.nodes.resize(3, static_cast<Eigen::Index>(model_.node_ids.size()));
    for (size_t i = 0; i < ids_.size(); ++i)
      if (used[i]) model_.nodes.col(place[i]) = positions_[i];
    if (const size_t dropped = ids_.size() - model_.node_ids.size(); dropped > 0)
      log::info(file_.path() + ": " + std::to_string(dropped) + " node(s) belong to no volume element; left out.");
    for (auto& [key, block] : blocks_) {
      for (auto& element : block.nodes)
        for (int& node : element) node = place[static_cast<size_t>(node)];
      model_.elements.push_back(std::move(block));
    }
    for (const auto& [group, members] : sets_) {
      std::set<int> taken;
      auto& set = model_.node_sets[name_of(group)];
      taken.insert(set.begin(), set.end());
      for (int node : members)
        if (used[static_cast<size_t>(node)] && taken.insert(ids_[static_cast<size_t>(node)]).second)
          set.push_back(ids_[static_cast<size_t>(node)]);
    }
    return std::move(model_);
  }

  TextFile file_;
  const std::map<std::string, Material>& materials_;
  FiniteElementModel model_;
  std::string section_;
  bool version4_ = false;
  std::map<Group, std::string> names_;
  std::map<Group, std::vector<int>> groups_;  // version 4: by dimension and entity
  std::vector<int> ids_;
  std::vector<Vector3> positions_;
  std::unordered_map<int, int> index_;
  std::map<Group, std::vector<int>> sets_;  // node indices
  std::set<std::vector<int>> solids_;
  std::map<std::pair<std::string, int>, ElementBlock> blocks_;  // by volume and type
};

}  // namespace

FiniteElementModel read_gmsh(const std::string& path, const std::map<std::string, Material>& materials) {
  return MeshReader(path, materials).read();
}

FiniteElementModel read_gmsh(const std::string& path, const Material& material) {
  return read_gmsh(path, std::map<std::string, Material>{{"", material}});
}

}  // namespace lithe
