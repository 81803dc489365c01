#include "engine/analysis/campbell.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/output/chart.h"
#include "engine/output/csv.h"

namespace lithe {
namespace {

/// How far a frequency may stray from the trend, of the frequency, before a like shape is doubted.
constexpr double kTrend = 0.1;
constexpr double kSurelyAnother = 0.05;  // modal assurance below which a mode is not the same

double assurance(const Eigen::VectorXcd& a, const Eigen::VectorXcd& b) {
  const double lengths = a.squaredNorm() * b.squaredNorm();
  return lengths > 0 ? std::norm(a.dot(b)) / lengths : 0;
}

/// Where the branch is bound: its last frequency and the slope of the two last speeds.
double expected_frequency(const Campbell::Branch& branch, double speed) {
  const std::size_t n = branch.speed.size();
  if (n < 2) return branch.frequency.back();
  const double slope =
      (branch.frequency[n - 1] - branch.frequency[n - 2]) / (branch.speed[n - 1] - branch.speed[n - 2]);
  return branch.frequency.back() + slope * (speed - branch.speed.back());
}

void append(Campbell::Branch& branch, double speed, const Mode& mode) {
  branch.speed.push_back(speed);
  branch.frequency.push_back(mode.frequency());
  branch.damping_ratio.push_back(mode.damping_ratio());
}

}  // namespace

Campbell campbell(const std::vector<double>& speeds, const std::function<Linearization(double speed)>& scene,
                  const CampbellOptions& options) {
  if (speeds.empty() || !std::is_sorted(speeds.begin(), speeds.end()))
    throw SceneError("a Campbell diagram of no speeds, or of speeds that do not ascend", "campbell",
                     "give ascending speeds in rad/s");
  Campbell diagram;
  diagram.orders = options.orders;
  std::vector<Eigen::VectorXcd> shapes;  // of each branch, at its last speed
  for (double speed : speeds) {
    std::vector<Mode> modes = scene(speed).modes;
    std::erase_if(modes, [&](const Mode& m) { return m.frequency() < options.lowest_frequency; });
    if (shapes.empty()) {
      if (modes.empty())
        throw SceneError("nothing oscillates at the first speed", "campbell", "give springs, or another first speed");
      modes.resize(std::min<std::size_t>(modes.size(), static_cast<std::size_t>(options.mode_count)));
      for (Mode& mode : modes) {
        append(diagram.branches.emplace_back(), speed, mode);
        shapes.push_back(std::move(mode.shape));
      }
      continue;
    }
    // The likeliest pair of a branch and a mode first, then the likeliest of the rest.
    struct Pair {
      double likeness;
      std::size_t branch, mode;
    };
    std::vector<Pair> pairs;
    for (std::size_t b = 0; b < shapes.size(); ++b) {
      const double expected = expected_frequency(diagram.branches[b], speed);
      for (std::size_t m = 0; m < modes.size(); ++m) {
        const double alike = assurance(shapes[b], modes[m].shape);
        const double stray =
            (modes[m].frequency() - expected) / (kTrend * std::abs(expected) + options.lowest_frequency);
        if (alike > kSurelyAnother) pairs.push_back({alike / (1 + stray * stray), b, m});
      }
    }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.likeness > b.likeness; });
    std::vector<char> branch_taken(shapes.size(), 0), mode_taken(modes.size(), 0);
    for (const Pair& pair : pairs) {
      if (branch_taken[pair.branch] || mode_taken[pair.mode]) continue;
      branch_taken[pair.branch] = mode_taken[pair.mode] = 1;
      append(diagram.branches[pair.branch], speed, modes[pair.mode]);
      shapes[pair.branch] = modes[pair.mode].shape;
    }
    // A branch without its mode has ended: it likens to nothing any more.
    for (std::size_t b = 0; b < shapes.size(); ++b)
      if (!branch_taken[b]) shapes[b].setZero();
  }
  return diagram;
}

Table Campbell::table() const {
  Table table{.columns = {"speed", "mode", "frequency", "damping_ratio"}};
  for (std::size_t b = 0; b < branches.size(); ++b)
    for (std::size_t k = 0; k < branches[b].speed.size(); ++k)
      table.add_row(
          {branches[b].speed[k], static_cast<double>(b + 1), branches[b].frequency[k], branches[b].damping_ratio[k]});
  return table;
}

void Campbell::write_csv(const std::string& path) const { lithe::write_csv(table(), path); }

void Campbell::write_chart(const std::string& path_without_extension, const std::string& title) const {
  Chart chart{.title = title, .x_label = "speed (rad/s)", .y_label = "frequency (Hz)"};
  double from = 0, to = 0, highest = 0;
  for (std::size_t b = 0; b < branches.size(); ++b) {
    chart.lines.push_back({"mode " + std::to_string(b + 1), branches[b].speed, branches[b].frequency});
    from = std::min(from, branches[b].speed.front()), to = std::max(to, branches[b].speed.back());
    highest = std::max(highest, *std::max_element(branches[b].frequency.begin(), branches[b].frequency.end()));
  }
  for (double order : orders) {
    const double end = std::min(to, order > 0 ? 2 * M_PI * highest / order : to);
    chart.lines.push_back({"order " + std::to_string(order).substr(0, 4),
                           {from, end},
                           {order * from / (2 * M_PI), order * end / (2 * M_PI)},
                           LineStyle::dashed});
  }
  lithe::write_chart(chart, path_without_extension);
}

}  // namespace lithe
