#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <set>

#include "plugins/inertial_body/brick_mesh.h"

namespace lithe {
namespace {

/// One pass over the deck: a keyword line sets what its data lines mean.
class DeckReader {
 public:
  explicit DeckReader(const std::string& path) : path_(path), in_(path) {
    if (!in_) throw FileError("cannot be opened", path, "give the path of a CalculiX input deck");
  }

  BrickMesh read() {
    std::string line;
    while (std::getline(in_, line)) {
      ++line_;
      if (line.starts_with("**")) continue;
      split(line);
      if (words_.empty()) continue;
      if (line.starts_with('*'))
        keyword();
      else
        data();
    }
    return finish();
  }

 private:
  enum class Card { other, node, element, node_set, elastic, density };

  [[noreturn]] void fail(const std::string& what, const std::string& fix) const {
    throw FileError(what, path_ + ":" + std::to_string(line_), fix);
  }

  /// Words between commas, without blanks, in lower case; a comma at the end leaves none.
  void split(const std::string& line) {
    words_.clear();
    std::string word;
    for (char c : line + ",") {
      if (c == ',') {
        words_.push_back(word);
        word.clear();
      } else if (!std::isspace(static_cast<unsigned char>(c))) {
        word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      }
    }
    while (!words_.empty() && words_.back().empty()) words_.pop_back();
  }

  std::string option(const std::string& name) const {
    for (const std::string& word : words_)
      if (word.starts_with(name + "=")) return word.substr(name.size() + 1);
    return "";
  }

  template <class Number>
  Number number(const std::string& word) const {
    Number value{};
    const char *begin = word.data() + (word.starts_with('+') ? 1 : 0), *end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error != std::errc() || stop != end) fail("'" + word + "' is not a number", "correct the deck");
    return value;
  }

  void keyword() {
    const std::string& name = words_[0];
    card_ = Card::other;
    if (name == "*node") {
      card_ = Card::node;
      set_ = option("nset");
    } else if (name == "*element") {
      const std::string type = option("type");
      if (type != "c3d8i" && type != "c3d8")
        fail("element type '" + type + "' is not an 8-node brick", "mesh the body with C3D8I or C3D8");
      const BrickType brick = type == "c3d8i" ? BrickType::incompatible_modes : BrickType::plain;
      if (!elements_.empty() && brick != mesh_.type) fail("C3D8I and C3D8 in one mesh", "use one of them");
      mesh_.type = brick;
      card_ = Card::element;
    } else if (name == "*nset") {
      card_ = Card::node_set;
      set_ = option("nset");
      generate_ = std::find(words_.begin(), words_.end(), "generate") != words_.end();
    } else if (name == "*elastic" && mesh_.material.young == 0) {
      if (const std::string type = option("type"); !type.empty() && !type.starts_with("iso"))
        fail("material is not isotropic", "use *ELASTIC with E and nu");
      card_ = Card::elastic;
    } else if (name == "*density" && mesh_.material.density == 0) {
      card_ = Card::density;
    } else if (name == "*include" || name == "*transform") {
      fail("cannot read " + name, "write the deck in one file and in one system of axes");
    }
  }

  void data() {
    switch (card_) {
      case Card::node: {
        if (words_.size() < 4) fail("a node needs a label and three coordinates", "correct the deck");
        const int id = number<int>(words_[0]);
        if (!places_
                 .emplace(id, Vector3(number<double>(words_[1]), number<double>(words_[2]), number<double>(words_[3])))
                 .second)
          fail("node " + std::to_string(id) + " is given twice", "correct the deck");
        if (!set_.empty()) mesh_.node_sets[set_].push_back(id);
        break;
      }
      case Card::element:
        for (const std::string& word : words_) open_.push_back(number<int>(word));
        if (open_.size() > 9) fail("an 8-node brick has more than eight nodes", "correct the deck");
        if (open_.size() == 9) elements_.push_back(std::move(open_)), open_.clear();
        break;
      case Card::node_set:
        if (generate_) {
          if (words_.size() < 2) fail("GENERATE needs first, last and step", "correct the deck");
          const int first = number<int>(words_[0]), last = number<int>(words_[1]);
          const int step = words_.size() > 2 ? number<int>(words_[2]) : 1;
          if (step < 1) fail("GENERATE needs a step of at least 1", "correct the deck");
          for (int id = first; id <= last; id += step) mesh_.node_sets[set_].push_back(id);
        } else {
          for (const std::string& word : words_) {
            if (const auto other = mesh_.node_sets.find(word); other != mesh_.node_sets.end()) {
              const std::vector<int> members = other->second;
              auto& set = mesh_.node_sets[set_];
              set.insert(set.end(), members.begin(), members.end());
            } else {
              mesh_.node_sets[set_].push_back(number<int>(word));
            }
          }
        }
        break;
      case Card::elastic:
        if (words_.size() < 2) fail("*ELASTIC needs E and nu", "correct the deck");
        mesh_.material.young = number<double>(words_[0]);
        mesh_.material.poisson = number<double>(words_[1]);
        card_ = Card::other;  // the first temperature
        break;
      case Card::density:
        mesh_.material.density = number<double>(words_[0]);
        card_ = Card::other;
        break;
      case Card::other:
        break;
    }
  }

  BrickMesh finish() {
    mesh_.name = path_;
    if (elements_.empty()) fail("the deck has no 8-node brick", "mesh the body with C3D8I or C3D8");
    if (!open_.empty()) fail("the last element has fewer than eight nodes", "correct the deck");
    std::set<int> used;
    for (const auto& element : elements_) used.insert(element.begin() + 1, element.end());
    std::map<int, int> index;
    mesh_.nodes.resize(3, static_cast<int>(used.size()));
    for (int id : used) {
      const auto at = places_.find(id);
      if (at == places_.end()) fail("an element names node " + std::to_string(id) + ", which is not given", "add it");
      mesh_.nodes.col(static_cast<int>(mesh_.node_ids.size())) = at->second;
      index[id] = static_cast<int>(mesh_.node_ids.size());
      mesh_.node_ids.push_back(id);
    }
    for (const auto& element : elements_) {
      mesh_.element_ids.push_back(element[0]);
      auto& nodes = mesh_.elements.emplace_back();
      for (int a = 0; a < 8; ++a) nodes[a] = index[element[a + 1]];
    }
    // Sets keep their order, each node once; nodes of no element are left out.
    for (auto& [name, ids] : mesh_.node_sets) {
      std::set<int> seen;
      std::erase_if(ids, [&](int id) { return !used.contains(id) || !seen.insert(id).second; });
    }
    return std::move(mesh_);
  }

  const std::string path_;
  std::ifstream in_;
  int line_ = 0;
  Card card_ = Card::other;
  std::vector<std::string> words_;
  std::string set_;
  bool generate_ = false;
  std::map<int, Vector3> places_;
  std::vector<std::vector<int>> elements_;  // label, then node labels
  std::vector<int> open_;                   // an element that goes on in the next line
  BrickMesh mesh_;
};

}  // namespace

BrickMesh read_brick_mesh(const std::string& path) { return DeckReader(path).read(); }

}  // namespace lithe
