#include "bodies/flexible/readers/calculix_modes.h"

#include <unordered_map>

#include "bodies/flexible/readers/text_file.h"

namespace lithe {
namespace {

constexpr const char* kWriteModes = "run *FREQUENCY with *NODE FILE, U again, ASCII (not BINARY); the file may be cut.";

/// The blocks of one .frd, line by line (CalculiX: cgx user's manual, "Result format").
class ModeReader {
 public:
  ModeReader(const std::string& path, const FiniteElementModel& model)
      : file_(path, "give the results of *FREQUENCY (.frd)."), model_(model) {
    for (size_t i = 0; i < model.node_ids.size(); ++i) index_.emplace(model.node_ids[i], static_cast<int>(i));
  }

  ImportedModes read() {
    bool first = true, mode = false, ended = false;
    while (file_.next() && !ended) {
      const std::string_view line = file_.line();
      if (first && trimmed(line.substr(0, 6)) != "1C") file_.fail("this is not a .frd file of CalculiX.", kWriteModes);
      first = false;
      if (const std::string_view key = column(0, 11); key.find("1PMODE") != std::string_view::npos)
        mode = true;
      else if (key.find("1PSTEP") != std::string_view::npos)
        mode = false;
      if (column(0, 6) == "100CL" || column(0, 6) == "100C") open_block(mode);
      ended = column(0, 6) == "9999";
    }
    if (!ended) file_.fail("the file ends without its last line, 9999.", kWriteModes);
    ImportedModes modes;
    const auto count = static_cast<Eigen::Index>(shapes_.size());
    modes.frequencies = Eigen::Map<const VectorX>(frequencies_.data(), count);
    modes.shapes.resize(model_.dof_count(), count);
    for (Eigen::Index k = 0; k < count; ++k) modes.shapes.col(k) = shapes_[static_cast<size_t>(k)];
    return modes;
  }

 private:
  std::string_view column(size_t from, size_t width) const {
    const std::string_view line = file_.line();
    return from < line.size() ? trimmed(line.substr(from, width)) : std::string_view();
  }
  void next_line() {
    if (!file_.next()) file_.fail("the file ends within a block of results.", kWriteModes);
  }

  /// "  100CL  101 3.89345E-06          68                     2    1MODAL      1", then -4 DISP, -5 names, -1 figures.
  void open_block(bool mode) {
    const std::string_view format = column(73, 2);
    if (format != "0" && format != "1")
      file_.fail("format '" + std::string(format) + "' of a block of results.", kWriteModes);
    const size_t node_width = format == "0" ? 5 : 10;
    const double value = mode ? file_.number(column(12, 12), "frequency") : 0;
    next_line();
    const bool displacement = mode && column(0, 3) == "-4" && column(5, 8) == "DISP";
    VectorX shape = VectorX::Zero(displacement ? model_.dof_count() : 0);
    std::vector<char> given(displacement ? model_.node_ids.size() : 0, 0);
    for (next_line(); column(0, 3) != "-3"; next_line()) {
      if (!displacement || column(0, 3) != "-1") continue;
      const int id = file_.integer(column(3, node_width), "node label");
      const auto found = index_.find(id);
      if (found == index_.end()) continue;
      if (given[static_cast<size_t>(found->second)]++)
        file_.fail("node " + std::to_string(id) + " is given twice in a mode.", kWriteModes);
      for (int axis = 0; axis < 3; ++axis)
        shape[3 * found->second + axis] =
            file_.number(column(3 + node_width + 12 * static_cast<size_t>(axis), 12), "displacement");
    }
    if (!displacement) return;
    for (size_t i = 0; i < given.size(); ++i)
      if (!given[i])
        file_.fail("node " + std::to_string(model_.node_ids[i]) + " has no displacement in mode " +
                       std::to_string(shapes_.size() + 1) + ".",
                   "take matrices and modes from the same deck, *NODE FILE without a node set.");
    shapes_.push_back(std::move(shape));
    frequencies_.push_back(value);
  }

  TextFile file_;
  const FiniteElementModel& model_;
  std::unordered_map<int, int> index_;
  std::vector<VectorX> shapes_;
  std::vector<double> frequencies_;
};

}  // namespace

ImportedModes read_calculix_modes(const std::string& frd, const FiniteElementModel& model) {
  return ModeReader(frd, model).read();
}

}  // namespace lithe
