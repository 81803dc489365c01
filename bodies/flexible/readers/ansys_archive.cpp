#include "bodies/flexible/readers/ansys_archive.h"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "bodies/flexible/readers/fixed_columns.h"
#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace lithe {
namespace {

constexpr const char* kNodes = "write the nodes by CDWRITE,DB or NWRITE, or the listing of NLIST.";
constexpr long kMostMembers = 10'000'000;  // of ranges in components

bool label_number(std::string_view word) {
  return !word.empty() && word.find_first_not_of("0123456789") == std::string_view::npos;
}

class ArchiveReader {
 public:
  ArchiveReader(const std::string& path, FiniteElementModel& model) : file_(path, kNodes), model_(model) {}

  void read() {
    while (file_.next()) {
      const std::string keyword = lower_case(trimmed(file_.line()).substr(0, 8));
      if (keyword.rfind("nblock", 0) == 0)
        read_block();
      else if (keyword.rfind("cmblock", 0) == 0)
        read_component();
      else if (keyword.rfind("eblock", 0) == 0)
        read_elements();
      else if (keyword.rfind("et,", 0) == 0 && file_.fields().size() > 2)
        add_element_type();
      else if (!archive_ && !file_.words().empty() && label_number(file_.words()[0]))
        read_row();  // of a table; its headings begin with words
    }
    if (file_.ended_in_mid_line() && !archive_) file_.fail("the last line has no end: the file is cut.", kNodes);
    if (model_.node_ids.empty()) file_.fail("the file lists no node.", kNodes);
    model_.nodes = Eigen::Map<const Matrix3X>(positions_.data(), 3, static_cast<Eigen::Index>(positions_.size() / 3));
    index_elements();
    for (const auto& [set, members] : model_.node_sets)
      for (int id : members)
        if (!known_.count(id))
          throw FileError("component '" + set + "' names node " + std::to_string(id) + ", which is not listed.",
                          file_.path(), "write all nodes of the body.");
  }

 private:
  void add(int id, const double (&values)[6]) {
    if (id < 1) file_.fail("node " + std::to_string(id) + ".", "nodes count from 1; the file may be cut.");
    if (!known_.insert(id).second) file_.fail("node " + std::to_string(id) + " is given twice.", kNodes);
    for (int k = 3; k < 6; ++k)
      if (values[k] != 0)
        file_.fail("node " + std::to_string(id) + " has turned axes.",
                   "export with all nodal coordinate systems along the global axes (NROTAT, NMODIF).");
    model_.node_ids.push_back(id);
    positions_.insert(positions_.end(), values, values + 3);
  }

  /// Label and up to six numbers; NWRITE leaves out zeros at the end.
  void read_row() {
    const auto words = file_.words();
    if (words.size() > 7) file_.fail("a node with " + std::to_string(words.size() - 1) + " numbers.", kNodes);
    double values[6] = {};
    for (size_t k = 1; k < words.size(); ++k) values[k - 1] = fortran_number(file_, words[k], "node coordinate");
    add(file_.integer(words[0], "node label"), values);
  }

  /// NBLOCK,6,SOLID,largest,count and (3i9,6e21.13e3): label, two numbers of no use here, x, y, z, three angles.
  /// Trailing zeros are left out.
  void read_block() {
    archive_ = true;
    const auto& header = file_.fields();
    const int announced = header.size() > 4 ? file_.integer(header[4], "number of nodes") : -1;
    next("format of NBLOCK");
    const std::string_view format = trimmed(file_.line());
    const size_t comma = std::min(format.find(','), format.size());
    const ColumnFormat labels = column_format(file_, format.substr(0, comma));
    const ColumnFormat numbers = column_format(file_, format.substr(std::min(comma + 1, format.size())));
    const auto first = static_cast<size_t>(labels.per_line) * static_cast<size_t>(labels.width);
    const auto width = static_cast<size_t>(numbers.width);
    int count = 0;
    for (next("line of NBLOCK"); !ends_block(); next("line of NBLOCK"), ++count) {
      const std::string_view line = file_.line();
      double values[6] = {};
      for (size_t k = 0; k < 6 && !column_of(line, first + k * width, width).empty(); ++k) {
        if (line.size() < first + (k + 1) * width)
          file_.fail("the last number is shorter than its column.", "the file may be cut; write it again.");
        values[k] = fortran_number(file_, column_of(line, first + k * width, width), "node coordinate");
      }
      add(file_.integer(column_of(line, 0, static_cast<size_t>(labels.width)), "node label"), values);
    }
    if (announced >= 0 && announced != count)
      file_.fail(std::to_string(count) + " nodes instead of the " + std::to_string(announced) + " announced.", kNodes);
  }

  bool ends_block() const {
    const std::string line = lower_case(trimmed(file_.line()));
    return line == "-1" || line.rfind("n,", 0) == 0;  // "-1" or "N,R5.3,LOC,-1,"
  }

  /// CMBLOCK,NAME,NODE,count and (8i10): labels; a negative one ends a range that the label before it begins.
  void read_component() {
    archive_ = true;
    const auto& header = file_.fields();
    if (header.size() < 4) file_.fail("CMBLOCK wants name, kind and number of labels.", kNodes);
    if (lower_case(header[2]).rfind("node", 0) != 0) return;
    auto& members = model_.node_sets[lower_case(header[1])];
    const int count = file_.integer(trimmed(header[3].substr(0, header[3].find('!'))), "number of labels");
    next("format of CMBLOCK");
    const ColumnFormat format = column_format(file_, file_.line());
    ColumnReader reader(file_, format);
    for (int k = 0; k < count; ++k) {
      const int id = reader.integer("node label");
      if (id > 0) {
        members.push_back(id);
        continue;
      }
      if (id == 0 || members.empty() || -static_cast<long>(id) <= members.back() ||
          (members_ += -static_cast<long>(id) - members.back()) > kMostMembers)
        file_.fail("the range of nodes that ends with " + std::to_string(id) + " has no beginning.", kNodes);
      for (int member = members.back() + 1; member <= -id; ++member) members.push_back(member);
    }
  }

  /// ET,1,186: number of type 1. Anything else but a number (ET,1,SOLID186) has its digits at the end.
  void add_element_type() {
    const auto& fields = file_.fields();
    const std::string_view name = fields[2].substr(std::min(fields[2].find_first_of("0123456789"), fields[2].size()));
    if (label_number(fields[1]) && label_number(name))
      types_[file_.integer(fields[1], "element type")] = file_.integer(name, "element name");
  }

  /// EBLOCK,19,SOLID,... and (19i9): material, type, seven numbers of no use here, number of nodes in the ninth column,
  /// label in the eleventh, nodes; those beyond the eighth on the next line.
  void read_elements() {
    archive_ = true;
    const auto& header = file_.fields();
    if (header.size() < 3 || lower_case(header[2]) != "solid") return;  // the short form: no solids
    next("format of EBLOCK");
    const ColumnFormat format = column_format(file_, file_.line());
    for (next("line of EBLOCK"); trimmed(file_.line()) != "-1"; next("line of EBLOCK")) {
      const auto column = [&](int k) {
        return column_of(file_.line(), static_cast<size_t>(k * format.width), static_cast<size_t>(format.width));
      };
      const int type = file_.integer(column(1), "element type"), count = file_.integer(column(8), "number of nodes");
      file_.integer(column(10), "element label");
      if (count < 1 || count > 64) file_.fail("an element of " + std::to_string(count) + " nodes.", kNodes);
      std::vector<int> nodes;
      for (int k = 0; k < std::min(count, 8); ++k) nodes.push_back(file_.integer(column(11 + k), "node label"));
      if (count > 8) {
        ColumnReader reader(file_, format);
        for (int k = 8; k < count; ++k) nodes.push_back(reader.integer("node label"));
      }
      add_element(type, std::move(nodes));
    }
  }

  /// ANSYS' order of nodes is that of Abaqus for SOLID45, 95, 92, 185, 186, 187 and 285. Others, and those with nodes
  /// drawn together (prisms and pyramids made of bricks), are left out.
  void add_element(int type, std::vector<int> nodes) {
    static const std::map<int, size_t> kSolids = {{45, 8},   {95, 20},  {92, 10}, {185, 8},
                                                  {186, 20}, {187, 10}, {285, 4}};
    const auto name = types_.find(type);
    const auto solid = name == types_.end() ? kSolids.end() : kSolids.find(name->second);
    if (solid == kSolids.end() || solid->second != nodes.size() ||
        std::set<int>(nodes.begin(), nodes.end()).size() != nodes.size()) {
      ++left_out_;
      return;
    }
    const std::string block_type = "C3D" + std::to_string(nodes.size());
    auto block = std::find_if(model_.elements.begin(), model_.elements.end(),
                              [&](const ElementBlock& any) { return any.type == block_type; });
    if (block == model_.elements.end()) block = model_.elements.insert(block, {block_type, {}});
    block->nodes.push_back(std::move(nodes));
  }

  /// Labels become indices, once all nodes are known.
  void index_elements() {
    if (left_out_ > 0)
      log::warn(file_.path() + ": " + std::to_string(left_out_) + " element(s) of other kinds left out.");
    std::unordered_map<int, int> index;
    for (size_t i = 0; i < model_.node_ids.size(); ++i) index.emplace(model_.node_ids[i], static_cast<int>(i));
    for (ElementBlock& block : model_.elements)
      for (auto& element : block.nodes)
        for (int& node : element) {
          const auto found = index.find(node);
          if (found == index.end())
            throw FileError("an element names node " + std::to_string(node) + ", which is not listed.", file_.path(),
                            "write all nodes of the body.");
          node = found->second;
        }
  }

  void next(const char* what) {
    if (!file_.next()) file_.fail("a " + std::string(what) + " is missing: the file is cut.", kNodes);
  }

  TextFile file_;
  FiniteElementModel& model_;
  std::vector<double> positions_;
  std::unordered_set<int> known_;
  std::map<int, int> types_;  // number of an element type and of the element it stands for
  int left_out_ = 0;          // elements
  long members_ = 0;          // that ranges have made
  bool archive_ = false;
};

}  // namespace

void read_ansys_archive(const std::string& path, FiniteElementModel& model) { ArchiveReader(path, model).read(); }

}  // namespace lithe
