#include "engine/study/stability_map.h"

#include <cmath>
#include <map>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/output/matrix_chart.h"
#include "engine/output/partial_file.h"
#include "engine/study/study_run.h"

namespace lithe {
namespace {

constexpr StabilityOutcome kOutcomes[] = {StabilityOutcome::converged, StabilityOutcome::inaccurate,
                                          StabilityOutcome::unstable, StabilityOutcome::refused};

std::string number_or_dash(double value) {
  if (!std::isfinite(value)) return "-";
  const bool whole = std::abs(value) >= 999.5 && std::abs(value) < 1e5;  // 1490, not 1.49e3
  return whole ? std::to_string(std::lround(value)) : short_number(value);
}

/// Places of the cells of each scene, scenes in the order of their first cells.
std::vector<std::vector<int>> by_scene(const std::vector<StabilityCell>& cells) {
  std::vector<std::vector<int>> groups;
  std::map<std::string, std::size_t> group_of;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto [at, is_new] = group_of.try_emplace(cells[i].scene, groups.size());
    if (is_new) groups.emplace_back();
    groups[at->second].push_back(static_cast<int>(i));
  }
  return groups;
}

/// A cell of a markdown table: "|" would end it.
std::string escaped(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.replace(at, 1, "\\|");
  return text;
}

std::string heading(const StabilityCell& cell) {
  return cell.title.empty() ? cell.scene : cell.scene + " " + cell.title;
}

}  // namespace

std::string to_string(StabilityOutcome outcome) {
  switch (outcome) {
    case StabilityOutcome::converged:
      return "converged";
    case StabilityOutcome::inaccurate:
      return "inaccurate";
    case StabilityOutcome::unstable:
      return "unstable";
    case StabilityOutcome::refused:
      break;
  }
  return "refused";
}

StabilityOutcome stability_outcome(std::string_view word) {
  for (const StabilityOutcome outcome : kOutcomes)
    if (to_string(outcome) == word) return outcome;
  throw SceneError("'" + std::string(word) + "' is not an outcome of a stability study", "stability_outcome",
                   "known are converged, inaccurate, unstable, refused");
}

std::string StabilityMap::table() const {
  // 1. Who does how, a line a scene.
  std::string text = "| scene | converged | inaccurate | unstable | refused |\n|---|---|---|---|---|\n";
  for (const std::vector<int>& group : by_scene(cells_)) {
    text += "| " + escaped(heading(cells_[group[0]])) + " |";
    for (const StabilityOutcome outcome : kOutcomes) {
      std::string names;
      for (const int i : group)
        if (cells_[i].outcome == outcome) names += (names.empty() ? "" : "; ") + cells_[i].method;
      text += " " + (names.empty() ? "-" : escaped(names)) + " |";
    }
    text += "\n";
  }
  // 2. The figures.
  text +=
      "\n| scene | method | outcome | figure | value | largest stable step, s | more | expected |\n"
      "|---|---|---|---|---|---|---|---|\n";
  for (const StabilityCell& cell : cells_)
    text += "| " + cell.scene + " | " + escaped(cell.method) + " | " + to_string(cell.outcome) + " | " +
            escaped(cell.measure) + " | " + number_or_dash(cell.value) + " | " +
            number_or_dash(cell.largest_stable_step) + " | " + escaped(cell.more) + " | " + escaped(cell.expected) +
            " |\n";
  return text;
}

void StabilityMap::write_table(const std::string& path) const {
  PartialFile file(path);
  file.stream() << table();
  file.commit();
}

void StabilityMap::draw(const std::string& path_without_extension) const {
  MatrixChart chart{"Stability map: scenes x methods", {}, {}};
  for (const StabilityOutcome outcome : kOutcomes) chart.legend.push_back(to_string(outcome));
  for (const std::vector<int>& group : by_scene(cells_)) {
    MatrixRow row{heading(cells_[group[0]]), {}};
    for (const int i : group) {
      const StabilityCell& cell = cells_[i];
      row.fields.push_back(
          {cell.method, number_or_dash(cell.value) + "  " + cell.measure, static_cast<int>(cell.outcome)});
    }
    chart.rows.push_back(std::move(row));
  }
  write_matrix_chart(chart, path_without_extension);
}

double largest_stable_step(const std::function<bool(double)>& run, double low, double high, double width) {
  if (!run(low)) return 0;
  if (run(high)) return high;
  while (high / low > 1 + width) {
    const double middle = std::sqrt(low * high);
    (run(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace lithe
