// Runs that were recorded: a file of any bytes, and one whose description, arrays and rows the input gives. It is
// refused, or its channels can be read and a page made of it.
#include <charconv>
#include <map>
#include <sstream>

#include "engine/output/hdf5_series.h"
#include "engine/page/page.h"
#include "engine/page/run.h"
#include "tools/fuzz/targets.h"

namespace lithe::fuzz {
namespace {

/// What `lithe view` does.
void view(const std::string& path) {
  const Run run = Run::read(path);
  const std::vector<double> times = run.channel("t");
  demand(times.size() == static_cast<std::size_t>(run.frame_count()), "a channel has not one number a state");
  write_page(run, path + ".html");
}

void run_file(std::string_view input, const std::filesystem::path& folder) { view(file_of(input, folder, "run.h5")); }

/// Numbers without a meaning.
MatrixX pattern(int rows, int columns) {
  MatrixX values(rows, columns);
  for (Eigen::Index i = 0; i < values.size(); ++i) values.reshaped()[i] = static_cast<double>(i * 7 % 11);
  return values;
}

/// "NAME ROWS COLUMNS" lines of arrays, "row VALUES", "contact VALUES" and "event VALUES" lines of rows; then, behind
/// an empty line, the description as JSON.
void run_scene(std::string_view input, const std::filesystem::path& folder) {
  const std::string path = (folder / "run.h5").string();
  const std::size_t empty = std::min(input.find("\n\n"), input.size());
  std::istringstream lines{std::string(input.substr(0, empty))};
  const std::string_view description = input.substr(std::min(empty + 2, input.size()));
  {
    Hdf5Series file(path);
    file.attribute("/", "format", "lithe run");
    file.attribute("/", "version", "1");
    file.write("/scene", std::vector<int>(description.begin(), description.end()));
    std::string names;
    int number = 0;
    std::map<std::string, std::vector<VectorX>> rows{{"/contacts", {}}, {"/events", {}}, {"/rows", {}}};
    for (std::string line, name; std::getline(lines, line);) {
      std::istringstream words(line);
      words >> name;
      std::vector<double> values;
      for (std::string word; words >> word && values.size() < 1000;) {
        double entry = 0;
        if (std::from_chars(word.data(), word.data() + word.size(), entry).ec != std::errc{}) break;
        values.push_back(entry);
      }
      if (const auto kind = rows.find('/' + name + 's'); kind != rows.end()) {
        if (!kind->second.empty()) values.resize(static_cast<std::size_t>(kind->second[0].size()), 0.5);
        if (!values.empty()) kind->second.push_back(Eigen::Map<const VectorX>(values.data(), std::ssize(values)));
      } else if (values.size() >= 2 && values[0] >= 0 && values[0] <= 100 && values[1] >= 0 && values[1] <= 100) {
        file.write("/set_" + std::to_string(number++),
                   pattern(static_cast<int>(values[0]), static_cast<int>(values[1])));
        names += name + '\n';
      }
    }
    file.write("/set_names", std::vector<int>(names.begin(), names.end()));
    for (const auto& [name, all] : rows) file.add(name, all.empty() ? 8 : static_cast<int>(all[0].size()));
    file.begin();
    for (const auto& [name, all] : rows)
      for (const VectorX& row : all) file.append(name, row);
  }
  view(path);
}

}  // namespace

std::vector<Target> run_targets() { return {{"run_file", run_file}, {"run_scene", run_scene}}; }

}  // namespace lithe::fuzz
