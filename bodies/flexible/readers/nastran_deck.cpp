#include "bodies/flexible/readers/nastran_deck.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <set>
#include <unordered_set>

#include "bodies/flexible/readers/fixed_columns.h"
#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr const char* kDeck = "give the bulk data of the export: GRID entries, and DMIG entries or a file of OUTPUT4.";
constexpr size_t kMostFields = 3'000'000;  // of one entry: a column of a full matrix of 700,000 rows

/// One entry of bulk data: its name in lower case without '*', and its data fields, eight or four a line.
struct Entry {
  std::string name;
  std::vector<std::string> fields;
  int line = 0;
  bool too_long = false;
};

/// Name (blank, '+...' or '*...' for a continuation) and data fields of one line.
struct FieldLine {
  std::string head;
  std::vector<std::string> fields;
  bool too_long = false;  // more fields than a line of bulk data has: case control, or damaged
  bool continues() const { return head.empty() || head[0] == '+' || head[0] == '*'; }
};

FieldLine fields_of(std::string line) {
  for (size_t tab = line.find('\t'); tab != std::string::npos; tab = line.find('\t'))
    line.replace(tab, 1, std::string(8 - tab % 8, ' '));
  FieldLine result;
  if (line.find(',') != std::string::npos) {
    std::vector<std::string> fields;
    for (size_t start = 0, comma = 0; comma != std::string::npos; start = comma + 1) {
      comma = line.find(',', start);
      fields.emplace_back(trimmed(std::string_view(line).substr(start, comma - start)));
    }
    result.head = lower_case(fields[0]);
    const size_t most = result.head.find('*') != std::string::npos ? 4 : 8;
    result.too_long = fields.size() > most + 2;
    fields.resize(most + 1);
    result.fields.assign(fields.begin() + 1, fields.end());
    return result;
  }
  result.head = lower_case(column_of(line, 0, 8));
  const bool large = result.head.find('*') != std::string::npos;
  for (size_t k = 0; k < (large ? 4 : 8); ++k)
    result.fields.emplace_back(column_of(line, 8 + k * (large ? 16 : 8), large ? 16 : 8));
  return result;
}

class NastranDeckReader {
 public:
  NastranDeckReader(const std::string& path, NastranDeck& deck)
      : file_(path, kDeck), deck_(deck), known_(deck.node_ids.begin(), deck.node_ids.end()) {}

  void read() {
    Entry entry;
    bool ended = false;
    while (!ended && file_.next()) {
      std::string line(file_.line().substr(0, std::min(file_.line().find('$'), file_.line().size())));
      const std::string text = lower_case(trimmed(line));
      if (text.empty()) continue;
      if (text.rfind("begin", 0) == 0 && text.find("bulk") != std::string::npos) {
        entry = {};  // what came before was executive and case control
        continue;
      }
      ended = text == "enddata";
      if (text.rfind("include", 0) == 0) file_.fail("an INCLUDE.", "put what it names into this file.");
      FieldLine fields = fields_of(line);
      if (!ended && fields.continues()) {
        if (entry.fields.size() > kMostFields) file_.fail("an entry without end.", kDeck);
        entry.too_long = entry.too_long || fields.too_long;
        std::move(fields.fields.begin(), fields.fields.end(), std::back_inserter(entry.fields));
        continue;
      }
      take(entry);
      std::erase(fields.head, '*');
      entry = {fields.head, std::move(fields.fields), file_.line_number(), fields.too_long};
    }
    if (!ended) take(entry);
    if (file_.ended_in_mid_line() && !ended)
      file_.fail("the last line has no end: the file is cut.", "export it again.");
    for (const auto& [id, line] : used_)
      if (!known_.count(id)) {
        entry.line = line;
        fail(entry, "node " + std::to_string(id) + " is used, but no GRID defines it.", kDeck);
      }
  }

 private:
  void take(const Entry& entry) {
    static const std::set<std::string> kRead = {"grid", "grdset", "chexa", "cpenta", "ctetra", "dmig"};
    if (!kRead.count(entry.name)) return;
    if (entry.too_long)
      fail(entry, "a line with too many fields.", "a line has a name, 8 fields (4 with *) and a continuation mark.");
    if (entry.name == "grid")
      add_grid(entry);
    else if (entry.name == "grdset")
      require_global_axes(entry, 1, 5);
    else if (entry.name == "chexa")
      add_element(entry, {8, 20}, "C3D");
    else if (entry.name == "cpenta")
      add_element(entry, {6, 15}, "C3D");
    else if (entry.name == "ctetra")
      add_element(entry, {4, 10}, "C3D");
    else
      add_dmig(entry);
  }

  // ---- fields of an entry; errors name the line where it begins

  [[noreturn]] void fail(const Entry& entry, const std::string& problem, const std::string& fix) const {
    throw FileError(problem, file_.path() + ":" + std::to_string(entry.line), fix);
  }
  static const std::string& field(const Entry& entry, size_t k) {
    static const std::string kEmpty;
    return k < entry.fields.size() ? entry.fields[k] : kEmpty;
  }
  int integer(const Entry& entry, size_t k, const char* what) const {
    try {
      return file_.integer(field(entry, k), what);
    } catch (const FileError& error) {  // its line is that of the entry's end
      fail(entry, error.problem(), error.fix());
    }
  }
  double number(const Entry& entry, size_t k, const char* what) const {
    try {
      return fortran_number(file_, field(entry, k), what);
    } catch (const FileError& error) {
      fail(entry, error.problem(), error.fix());
    }
  }

  // ---- nodes and elements

  void require_global_axes(const Entry& entry, size_t position, size_t displacement) const {
    for (size_t k : {position, displacement})
      if (!field(entry, k).empty() && field(entry, k) != "0")
        fail(entry,
             "the coordinate system " + field(entry, k).substr(0, 20) + " in field " + std::to_string(k + 2) + ".",
             "write nodes and matrices in the basic coordinate system (CP and CD blank or 0).");
  }

  void add_grid(const Entry& entry) {
    const int id = integer(entry, 0, "node label");
    if (id < 1) fail(entry, "node " + std::to_string(id) + ".", "nodes count from 1.");
    if (!known_.insert(id).second)
      fail(entry, "node " + std::to_string(id) + " is defined twice.", "number nodes once.");
    require_global_axes(entry, 1, 5);
    Vector3 position = Vector3::Zero();  // blank is zero, as in Nastran
    for (size_t k = 0; k < 3; ++k)
      if (!field(entry, 2 + k).empty()) position[Eigen::Index(k)] = number(entry, 2 + k, "node coordinate");
    deck_.node_ids.push_back(id);
    deck_.positions.push_back(position);
  }

  void add_element(const Entry& entry, std::pair<size_t, size_t> sizes, const std::string& family) {
    std::vector<int> nodes;
    size_t last = entry.fields.size();
    while (last > 2 && entry.fields[last - 1].empty()) --last;
    integer(entry, 0, "element label");
    for (size_t k = 2; k < last; ++k) nodes.push_back(integer(entry, k, "node label"));
    if (nodes.size() != sizes.first && nodes.size() != sizes.second)
      fail(entry, "a " + entry.name + " of " + std::to_string(nodes.size()) + " nodes.",
           "it has " + std::to_string(sizes.first) + " or " + std::to_string(sizes.second) +
               ", all mid-side nodes or none; the file may be cut.");
    // Nastran lists the nodes in the middle of upright edges before those of the top face, Abaqus behind them.
    if (nodes.size() == 20) std::rotate(nodes.begin() + 12, nodes.begin() + 16, nodes.end());
    if (nodes.size() == 15) std::rotate(nodes.begin() + 9, nodes.begin() + 12, nodes.end());
    for (int id : nodes) used_.emplace_back(id, entry.line);
    const std::string type = family + std::to_string(nodes.size());
    const auto same = [&](const ElementBlock& block) { return block.type == type; };
    auto block = std::find_if(deck_.elements.begin(), deck_.elements.end(), same);
    if (block == deck_.elements.end()) block = deck_.elements.insert(block, {type, {}});
    block->nodes.push_back(std::move(nodes));
  }

  // ---- matrices

  /// DMIG,name,0,form,type,... announces a matrix; DMIG,name,node,direction,,node,direction,value,,... is a column.
  void add_dmig(const Entry& entry) {
    const std::string name = lower_case(field(entry, 0));
    if (name.empty()) fail(entry, "a DMIG without a name.", kDeck);
    const auto same = [&](const NastranMatrix& matrix) { return matrix.name == name; };
    const auto matrix = std::find_if(deck_.matrices.begin(), deck_.matrices.end(), same);
    const bool skipped = skipped_.count(name) > 0;
    if (field(entry, 1) == "0") {
      if (matrix != deck_.matrices.end() || skipped) fail(entry, "a second header of " + name + ".", kDeck);
      const int form = integer(entry, 2, "form"), type = integer(entry, 3, "type");
      if ((form != 1 && form != 2 && form != 6 && form != 9) || type < 1 || type > 4)
        fail(entry, "a matrix of form " + std::to_string(form) + " and type " + std::to_string(type) + ".",
             "forms are 1, 2, 6, 9, types 1 to 4.");
      if ((form == 1 || form == 6) && type < 3)
        deck_.matrices.push_back({name, {file_.path(), form == 1, {}}});
      else
        skipped_.insert(name);
      return;
    }
    if (skipped) return;
    if (matrix == deck_.matrices.end())
      fail(entry, "a column of " + name + " before its header.", "write DMIG," + name + ",0,6,2 before it.");
    const DofRow column = row_at(entry, 1);
    for (size_t k = 4; k < entry.fields.size(); k += 4) {
      if (field(entry, k).empty() && field(entry, k + 1).empty() && field(entry, k + 2).empty()) continue;
      const DofRow row = row_at(entry, k);
      if (!field(entry, k + 3).empty() && number(entry, k + 3, "imaginary part") != 0)
        fail(entry, "an imaginary part in the real matrix " + name + ".", kDeck);
      matrix->matrix.entries.push_back({row, column, number(entry, k + 2, "matrix entry")});
    }
  }

  DofRow row_at(const Entry& entry, size_t k) const {
    const DofRow row{integer(entry, k, "node label"),
                     field(entry, k + 1).empty() ? 0 : integer(entry, k + 1, "direction")};
    if (row.node < 1 || row.direction < 0 || row.direction > 6)
      fail(entry, "node " + std::to_string(row.node) + ", direction " + std::to_string(row.direction) + ".",
           "nodes count from 1; directions are 1 to 6, and 0 for scalar points.");
    return row;
  }

  TextFile file_;
  NastranDeck& deck_;
  std::unordered_set<int> known_;
  std::vector<std::pair<int, int>> used_;  // node labels of elements, and their line
  std::unordered_set<std::string> skipped_;
};

}  // namespace

void read_nastran_deck(const std::string& path, NastranDeck& deck) { NastranDeckReader(path, deck).read(); }

}  // namespace lithe
