#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/number_text.h"
#include "engine/output/partial_file.h"
#include "engine/study/text_table.h"
#include "engine/study/work_precision.h"

namespace lithe {
namespace {

using Outcome = StudyRun::Outcome;

constexpr int kFirstDecade = -2, kLastDecade = -15;  // of the errors recommended for

std::string number(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' ? ' ' : c);
  return out + '"';
}

const char* word(Outcome outcome) {
  switch (outcome) {
    case Outcome::reached:
      return "reached";
    case Outcome::failed:
      return "failed";
    case Outcome::too_slow:
      return "too slow";
  }
  return "";
}

}  // namespace

bool WorkPrecision::is_below_floor(const WorkPoint& point) const {
  return point.outcome == Outcome::reached && point.error < floor();
}

bool WorkPrecision::reference_good() const {
  return std::none_of(points.begin(), points.end(), [&](const WorkPoint& point) { return is_below_floor(point); });
}

std::vector<Recommendation> WorkPrecision::recommendations() const {
  const auto counts = [&](const WorkPoint& point) {
    return point.outcome == Outcome::reached && !is_below_floor(point);
  };
  double smallest = std::numeric_limits<double>::infinity();
  for (const WorkPoint& point : points)
    if (counts(point)) smallest = std::min(smallest, point.error);

  // A small error at a loose setting may be luck; it is not if tighter ones keep it.
  const auto keeps = [&](const WorkPoint& point, double error) {
    return counts(point) && point.error <= error &&
           std::none_of(points.begin(), points.end(), [&](const WorkPoint& other) {
             return other.method == point.method && other.setting < point.setting &&
                    other.outcome == Outcome::reached && other.error > error;
           });
  };

  std::vector<Recommendation> out;
  for (int decade = kFirstDecade; decade >= kLastDecade && std::pow(10, decade) >= smallest; --decade) {
    Recommendation best{std::pow(10, decade), -1};
    for (std::size_t i = 0; i < points.size(); ++i)
      if (keeps(points[i], best.error) && (best.point < 0 || points[i].cpu < points[best.point].cpu))
        best.point = static_cast<int>(i);
    if (best.point >= 0) out.push_back(best);
  }
  return out;
}

std::string WorkPrecision::table() const {
  std::string out = scene + ", " + short_number(duration) + " s; errors in units of " +
                    short_number(characteristic_length) + "\nreference: " + reference + "\n";
  const auto below =
      std::count_if(points.begin(), points.end(), [&](const WorkPoint& point) { return is_below_floor(point); });
  if (below > 0)
    out += "THE REFERENCE IS NOT GOOD ENOUGH for " + std::to_string(below) + " of " + std::to_string(points.size()) +
           " points (marked *): they are below ten times its own uncertainty and are not recommended.\n";

  TextTable rows;
  rows.add({"", "setting", "error", "CPU a second", "steps", "rejected", "evaluations", "factorizations", "Newton",
            "outcome"});
  for (const WorkPoint& point : points) {
    const bool reached = point.outcome == Outcome::reached;
    const IntegratorStatistics& done = point.statistics;
    rows.add({point.method, setting_text(point.kind, point.setting),
              reached ? short_number(point.error) + (is_below_floor(point) ? "*" : "") : "-",
              reached ? duration_text(point.cpu / duration) : "-", std::to_string(done.steps),
              std::to_string(done.rejected), std::to_string(done.evaluations), std::to_string(done.factorizations),
              std::to_string(done.newton_iterations),
              word(point.outcome) + (point.why.empty() ? "" : ": " + point.why)});
  }
  out += rows.text();

  const std::vector<Recommendation> best = recommendations();
  if (best.empty()) return out + "no run keeps an error of " + short_number(std::pow(10, kFirstDecade)) + "\n";
  for (const auto& [error, index] : best) {
    const WorkPoint& point = points[index];
    out += "for " + short_number(error) + ": " + point.method + ", " + setting_text(point.kind, point.setting) + ", " +
           duration_text(point.cpu / duration) + " a second\n";
  }
  return out;
}

Chart WorkPrecision::chart(const std::vector<ChartLine>& more) const {
  Chart chart{.title = "Work-precision: " + scene,
              .x_label = "largest error, in units of " + short_number(characteristic_length),
              .y_label = "CPU time a simulated second (s)",
              .lines = {},
              .log_x = true,
              .log_y = true};
  std::vector<int> lost;  // points of each line that did not reach the end
  for (const WorkPoint& point : points) {
    if (&point == &points.front() || chart.lines.back().title != point.method) {
      chart.lines.push_back({.title = point.method, .x = {}, .y = {}, .style = LineStyle::marked});
      lost.push_back(0);
    }
    if (point.outcome != Outcome::reached) ++lost.back();
    if (point.outcome != Outcome::reached || !(point.error > 0) || !(point.cpu > 0)) continue;
    chart.lines.back().x.push_back(point.error);
    chart.lines.back().y.push_back(point.cpu / duration);
  }
  for (std::size_t i = 0; i < lost.size(); ++i)
    if (lost[i] > 0) chart.lines[i].title += " (" + std::to_string(lost[i]) + " did not finish)";
  std::erase_if(chart.lines, [](const ChartLine& line) { return line.x.empty(); });

  // What lies left of the floor says nothing but "at least so good".
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const ChartLine& line : chart.lines)
    for (double y : line.y) low = std::min(low, y), high = std::max(high, y);
  if (high > 0 && std::isfinite(floor()) && !reference_good())
    chart.lines.push_back({.title = "left of it: below the reference's floor",
                           .x = {floor(), floor()},
                           .y = {low, high},
                           .style = LineStyle::dashed});
  chart.lines.insert(chart.lines.end(), more.begin(), more.end());
  return chart;
}

void WorkPrecision::write_csv(const std::string& path) const {
  PartialFile file(path);
  file.stream() << "method,kind,setting,error,cpu_s,cpu_s_per_s,steps,rejected,evaluations,factorizations,"
                   "newton_iterations,newton_failures,outcome,below_floor,why\n";
  for (const WorkPoint& point : points) {
    const bool reached = point.outcome == Outcome::reached;
    const IntegratorStatistics& done = point.statistics;
    file.stream() << quoted(point.method) << (point.kind == StudyMethod::Setting::step ? ",step," : ",tolerance,")
                  << number(point.setting) << ',' << (reached ? number(point.error) : "") << ',' << number(point.cpu)
                  << ',' << (reached ? number(point.cpu / duration) : "") << ',' << done.steps << ',' << done.rejected
                  << ',' << done.evaluations << ',' << done.factorizations << ',' << done.newton_iterations << ','
                  << done.newton_failures << ',' << word(point.outcome) << ',' << (is_below_floor(point) ? 1 : 0) << ','
                  << quoted(point.why) << '\n';
  }
  file.commit();
}

void WorkPrecision::write_chart(const std::string& path_without_extension, const std::vector<ChartLine>& more) const {
  lithe::write_chart(chart(more), path_without_extension);
}

}  // namespace lithe
