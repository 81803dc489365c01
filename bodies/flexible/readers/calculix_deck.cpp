#include "bodies/flexible/readers/calculix_deck.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <unordered_map>
#include <unordered_set>

#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr int kIncludeDepth = 10;
constexpr long kMostGenerated = 10'000'000;  // a slip of the pen must not fill the memory

/// "*NSET, NSET=Tip" → name "*nset", options {nset: tip}. Blanks inside the keyword do not count, as in CalculiX.
struct Keyword {
  std::string name;
  std::map<std::string, std::string> options;  // values as written
};

Keyword parse_keyword(TextFile& file) {
  Keyword keyword;
  const auto& fields = file.fields();
  for (char c : lower_case(fields[0]))
    if (c != ' ' && c != '\t') keyword.name += c;
  for (size_t k = 1; k < fields.size(); ++k) {
    const size_t equal = std::min(fields[k].find('='), fields[k].size());
    const std::string option = lower_case(trimmed(fields[k].substr(0, equal)));
    if (!option.empty())
      keyword.options[option] = equal < fields[k].size() ? std::string(trimmed(fields[k].substr(equal + 1))) : "";
  }
  return keyword;
}

/// Nodes of a solid by its type's digits: C3D8I has 8, C3D20R 20. 0 for types of other make.
size_t nodes_of_type(const std::string& type) {
  if (type.rfind("C3D", 0) != 0) return 0;
  size_t count = 0;
  for (size_t k = 3; k < type.size() && std::isdigit(static_cast<unsigned char>(type[k])); ++k)
    count = 10 * count + static_cast<size_t>(type[k] - '0');
  return count;
}

/// Named lists of labels, each label once.
struct LabelSets {
  std::map<std::string, std::vector<int>> lists;
  std::map<std::string, std::unordered_set<int>> members;
  void append(const std::string& set, int id) {
    if (members[set].insert(id).second) lists[set].push_back(id);
  }
};

/// *MATERIAL as it is read: lines of *ELASTIC beyond the first make it depend on temperature.
struct DeckMaterial {
  Material values;
  int elastic_lines = 0, density_lines = 0;
  bool isotropic = true;

  Material known() const {
    Material material = elastic_lines == 1 && isotropic ? values : Material{};
    material.density = density_lines == 1 ? values.density : 0;
    return material;
  }
};

class DeckReader {
 public:
  CalculixDeck deck;

  void read(const std::string& path, int depth) {
    TextFile file(path, "keep the deck of the export beside its matrices.");
    if (depth > kIncludeDepth) throw FileError("*INCLUDE goes too deep.", path, "a file includes itself?");
    section_ = Section::skipped;
    while (file.next()) {
      const std::string_view line = trimmed(file.line());
      if (line.empty() || line.substr(0, 2) == "**") continue;
      if (line[0] == '*')
        open_section(file, depth);
      else if (section_ == Section::nodes)
        add_node(file);
      else if (section_ == Section::elements)
        add_element_line(file);
      else if (section_ == Section::set)
        add_to_set(file);
      else if (section_ == Section::elastic)
        add_elastic(file);
      else if (section_ == Section::density)
        add_density(file);
    }
    close_element(file);
  }

  /// What is known at the end of the deck: sets, and which element has which material. Blocks are split by it.
  CalculixDeck finished() {
    require_known_nodes();
    deck.node_sets = std::move(node_sets_.lists);
    std::unordered_map<int, size_t> section_of;  // by element label; a later section wins, as in CalculiX
    for (size_t k = 0; k < sections_.size(); ++k)
      if (const auto set = element_sets_.lists.find(sections_[k].first); set != element_sets_.lists.end())
        for (int id : set->second) section_of[id] = k;

    std::vector<ElementBlock> blocks;
    std::map<std::pair<size_t, std::string>, size_t> place;  // type and material to block
    for (size_t b = 0; b < deck.elements.size(); ++b)
      for (size_t e = 0; e < deck.elements[b].nodes.size(); ++e) {
        const auto section = section_of.find(element_ids_[b][e]);
        const std::string material = section == section_of.end() ? "" : sections_[section->second].second;
        const auto [block, is_new] = place.emplace(std::pair(b, material), blocks.size());
        if (is_new)
          blocks.push_back({deck.elements[b].type, {}, material.empty() ? Material{} : materials_[material].known()});
        blocks[block->second].nodes.push_back(std::move(deck.elements[b].nodes[e]));
      }
    deck.elements = std::move(blocks);
    return std::move(deck);
  }

 private:
  enum class Section { skipped, nodes, elements, set, elastic, density };

  /// Elements and sets may precede their nodes in the deck, so labels are looked up at its end.
  void require_known_nodes() const {
    const std::unordered_set<int> known(deck.node_ids.begin(), deck.node_ids.end());
    for (const auto& [id, where] : mentioned_)
      if (!known.count(id))
        throw FileError("node " + std::to_string(id) + " is used, but no *NODE defines it.", where,
                        "define the node or remove it here.");
  }

  void open_section(TextFile& file, int depth) {
    close_element(file);
    const Keyword keyword = parse_keyword(file);
    section_ = Section::skipped;
    const auto option = [&](const char* name) {
      const auto found = keyword.options.find(name);
      return found == keyword.options.end() ? std::string() : found->second;
    };
    if (keyword.name == "*node") {
      section_ = Section::nodes;
      set_ = lower_case(option("nset"));
    } else if (keyword.name == "*element") {
      section_ = Section::elements;
      set_ = lower_case(option("elset"));
      open_elements(file, option("type"));
    } else if (keyword.name == "*nset" || keyword.name == "*elset") {
      section_ = Section::set;
      sets_ = keyword.name == "*nset" ? &node_sets_ : &element_sets_;
      set_ = lower_case(option(keyword.name == "*nset" ? "nset" : "elset"));
      generate_ = keyword.options.count("generate") > 0;
      if (set_.empty()) file.fail("a set without a name.", "write *NSET, NSET=name or *ELSET, ELSET=name.");
      sets_->lists[set_];
    } else if (keyword.name == "*material") {
      material_ = lower_case(option("name"));
    } else if (keyword.name == "*elastic") {
      section_ = Section::elastic;
      const std::string type = lower_case(option("type"));
      materials_[material_].isotropic = type.empty() || type == "iso" || type == "isotropic";
    } else if (keyword.name == "*density") {
      section_ = Section::density;
    } else if (keyword.name == "*solidsection") {
      sections_.emplace_back(lower_case(option("elset")), lower_case(option("material")));
    } else if (keyword.name == "*include") {
      const std::string input = option("input");
      if (input.empty()) file.fail("an *INCLUDE without a file.", "write *INCLUDE, INPUT=file.");
      const auto folder = std::filesystem::path(file.path()).parent_path();
      read((folder / input).string(), depth + 1);
      section_ = Section::skipped;
    } else if (keyword.name == "*transform" || keyword.name == "*system") {
      file.fail("'" + keyword.name + "' turns the axes of nodes.", "export the matrices in global axes, without it.");
    }
  }

  void open_elements(TextFile& file, std::string type) {
    std::transform(type.begin(), type.end(), type.begin(), [](unsigned char c) { return std::toupper(c); });
    if (type.empty()) file.fail("an *ELEMENT without a type.", "write *ELEMENT, TYPE=C3D8.");
    element_size_ = nodes_of_type(type);
    if (type.rfind("C3D", 0) == 0 && (element_size_ < 4 || element_size_ > 20))
      file.fail("unknown element type '" + type + "'.", "solids are C3D4, 6, 8, 10, 15 and 20.");
    const auto same = [&](const ElementBlock& block) { return block.type == type; };
    const auto found = std::find_if(deck.elements.begin(), deck.elements.end(), same);
    block_ = static_cast<size_t>(found - deck.elements.begin());
    if (found == deck.elements.end()) deck.elements.push_back({type, {}});
    element_ids_.resize(deck.elements.size());
  }

  void add_node(TextFile& file) {
    const auto& fields = file.fields();
    if (fields.size() < 2 || fields.size() > 5 || (fields.size() == 5 && !fields[4].empty()))
      file.fail(std::to_string(fields.size()) + " columns in *NODE.", "write label, x, y, z; the file may be cut.");
    const int id = file.integer(fields[0], "node label");
    if (!defined_.insert(id).second)
      file.fail("node " + std::to_string(id) + " is defined twice.", "number nodes once.");
    Vector3 position = Vector3::Zero();  // a coordinate left out is zero, as in CalculiX
    for (size_t k = 1; k < std::min<size_t>(4, fields.size()); ++k)
      if (!fields[k].empty()) position[static_cast<Eigen::Index>(k) - 1] = file.number(fields[k], "node coordinate");
    deck.node_ids.push_back(id);
    deck.positions.push_back(position);
    if (!set_.empty()) node_sets_.append(set_, id);
  }

  void add_elastic(TextFile& file) {
    DeckMaterial& material = materials_[material_];
    if (!material.isotropic || ++material.elastic_lines > 1) return;
    const auto& fields = file.fields();
    if (fields.size() < 2) file.fail("*ELASTIC with one number.", "write Young's modulus, Poisson's ratio.");
    material.values.young = file.number(fields[0], "Young's modulus");
    material.values.poisson = file.number(fields[1], "Poisson's ratio");
  }

  void add_density(TextFile& file) {
    DeckMaterial& material = materials_[material_];
    if (++material.density_lines == 1) material.values.density = file.number(file.fields()[0], "density");
  }

  void add_element_line(TextFile& file) {
    const auto& fields = file.fields();
    const bool continued = fields.back().empty();
    size_t k = 0;
    if (pending_.empty() && !open_) {
      element_ids_[block_].push_back(file.integer(fields[k++], "element label"));
      if (!set_.empty()) element_sets_.append(set_, element_ids_[block_].back());
      open_ = true;
    }
    for (; k < fields.size(); ++k) {
      if (fields[k].empty()) continue;
      pending_.push_back(file.integer(fields[k], "node label"));
      mention(file, pending_.back());
    }
    // Solids say by their type how many nodes they have; others go on while a line ends with a comma.
    if (element_size_ > 0 ? pending_.size() >= element_size_ : !continued) close_element(file);
  }

  void close_element(TextFile& file) {
    if (!open_) return;
    ElementBlock& block = deck.elements[block_];
    if (element_size_ > 0 && pending_.size() != element_size_)
      file.fail("an element of type " + block.type + " with " + std::to_string(pending_.size()) + " nodes.",
                "it has " + std::to_string(element_size_) + "; the deck may be cut.");
    if (block.type == "C3D8I") ++deck.incompatible_elements;
    block.nodes.push_back(std::move(pending_));
    pending_ = {};
    open_ = false;
  }

  void add_to_set(TextFile& file) {
    const auto& fields = file.fields();
    if (generate_) {
      const size_t given = fields.size() - (fields.back().empty() ? 1 : 0);
      if (given < 2 || given > 3) file.fail("GENERATE wants first, last, step.", "write 1, 9, 2.");
      const int first = file.integer(fields[0], "first label"), last = file.integer(fields[1], "last label");
      const int step = given == 3 ? file.integer(fields[2], "step") : 1;
      if (step < 1 || last < first) file.fail("GENERATE does not count upwards.", "write first, last, step.");
      generated_ += (static_cast<long>(last) - first) / step + 1;
      if (generated_ > kMostGenerated)
        file.fail("GENERATE has made more than ten million labels.", "check first, last and step.");
      for (long id = first; id <= last; id += step) add_member(file, static_cast<int>(id));
      return;
    }
    for (const auto& field : fields) {
      if (field.empty()) continue;
      if (std::isdigit(static_cast<unsigned char>(field[0])) || field[0] == '-' || field[0] == '+') {
        add_member(file, file.integer(field, "label"));
        continue;
      }
      const auto other = sets_->lists.find(lower_case(field));
      if (other == sets_->lists.end() || other->first == set_)
        file.fail("set '" + set_ + "' names set '" + std::string(field) + "', which is not defined yet.",
                  "define it above, or write labels.");
      for (int id : std::vector<int>(other->second)) sets_->append(set_, id);
    }
  }

  void add_member(const TextFile& file, int id) {
    if (sets_ == &node_sets_) mention(file, id);
    sets_->append(set_, id);
  }

  void mention(const TextFile& file, int id) {
    if (!mentioned_.count(id)) mentioned_.emplace(id, file.where());
  }

  Section section_ = Section::skipped;
  std::string set_;  // that *NODE, *ELEMENT, *NSET or *ELSET adds to
  LabelSets node_sets_, element_sets_;
  LabelSets* sets_ = &node_sets_;  // of the *NSET or *ELSET that is being read
  bool generate_ = false;
  long generated_ = 0;       // labels of all GENERATE so far
  size_t block_ = 0;         // of deck.elements
  size_t element_size_ = 0;  // nodes, 0 if the type does not say
  bool open_ = false;        // an element's lines are being gathered
  std::vector<int> pending_;
  std::unordered_set<int> defined_;
  std::vector<std::vector<int>> element_ids_;  // labels, as deck.elements
  std::string material_;                       // that *ELASTIC and *DENSITY describe
  std::map<std::string, DeckMaterial> materials_;
  std::vector<std::pair<std::string, std::string>> sections_;  // element set, material
  std::map<int, std::string> mentioned_;                       // first use of a label
};

}  // namespace

CalculixDeck read_calculix_deck(const std::string& path) {
  DeckReader reader;
  reader.read(path, 0);
  if (reader.deck.node_ids.empty())
    throw FileError("the deck defines no node.", path, "give the deck of the export, with its *NODE block.");
  return reader.finished();
}

FiniteElementModel read_calculix_mesh(const std::string& path, MassIntegration mass) {
  CalculixDeck deck = read_calculix_deck(path);
  std::unordered_set<int> in_use;
  for (const ElementBlock& block : deck.elements)
    for (const auto& nodes : block.nodes) in_use.insert(nodes.begin(), nodes.end());

  FiniteElementModel model;
  model.name = path;
  model.nodes.resize(3, static_cast<Eigen::Index>(in_use.size()));
  std::unordered_map<int, int> index;
  for (size_t i = 0; i < deck.node_ids.size(); ++i) {
    if (!in_use.count(deck.node_ids[i])) continue;
    const int next = static_cast<int>(model.node_ids.size());
    index.emplace(deck.node_ids[i], next);
    model.node_ids.push_back(deck.node_ids[i]);
    model.nodes.col(next) = deck.positions[i];
  }
  for (const auto& [set, members] : deck.node_sets)
    for (int id : members)
      if (index.count(id)) model.node_sets[set].push_back(id);
  model.elements = std::move(deck.elements);
  for (ElementBlock& block : model.elements)
    for (auto& nodes : block.nodes)
      for (int& node : nodes) node = index.at(node);
  assemble_matrices(model, mass);
  return model;
}

}  // namespace lithe
