#include "tools/certify/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/output/partial_file.h"

namespace lithe::certify {

namespace {

// What solve() is to keep to.
constexpr double kCoverage = 0.95, kOverestimate = 3, kWorst = 30, kCostRatio = 3, kCostRatioShort = 6;

using Cases = std::vector<CertifiedCase>;

bool same_run(const CertifiedCase& a, const CertifiedCase& b) {
  return a.run.scene == b.run.scene && a.run.target == b.run.target;
}

/// The cases of one run after another: they stand together.
std::vector<Cases> by_run(const Cases& cases) {
  std::vector<Cases> runs;
  for (const CertifiedCase& c : cases) {
    if (runs.empty() || !same_run(runs.back().front(), c)) runs.emplace_back();
    runs.back().push_back(c);
  }
  return runs;
}

/// From loose to tight.
std::vector<double> targets(const Cases& cases) {
  std::set<double, std::greater<>> found;
  for (const CertifiedCase& c : cases) found.insert(c.run.target);
  return {found.begin(), found.end()};
}

Cases of_target(const Cases& cases, double target) {
  Cases found;
  std::copy_if(cases.begin(), cases.end(), std::back_inserter(found),
               [&](const CertifiedCase& c) { return c.run.target == target; });
  return found;
}

/// Of those that are numbers.
double median(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return kUnknown;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char out[512];
  std::snprintf(out, sizeof out, pattern, values...);
  return out;
}
std::string number(double value, const char* pattern = "%.3g") {
  return std::isnan(value) ? "-" : format(pattern, value);
}
std::string percent(double part) { return std::isnan(part) ? "-" : format("%.3g %%", 100 * part); }
std::string ratio(double value) { return number(value, "%.2f"); }

/// How near the true error comes to the stated one; without an answer nearer than anything.
double nearness(const CertifiedCase& c) {
  const double near = c.error / c.stated;
  return std::isnan(near) ? std::numeric_limits<double>::infinity() : near;
}

bool drawable(double x, double y) { return std::isfinite(x) && std::isfinite(y) && x > 0 && y > 0; }

/// A chart over logarithmic axes, points a target, and lines y = factor x over all of them.
Chart scatter(const std::string& title, const std::string& x_label, const std::string& y_label,
              std::vector<ChartLine> points, const std::vector<std::pair<double, std::string>>& factors) {
  Chart chart{.title = title, .x_label = x_label, .y_label = y_label, .lines = {}, .log_x = true, .log_y = true};
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (ChartLine& line : points) {
    if (line.x.empty()) continue;
    const auto [least, greatest] = std::minmax_element(line.x.begin(), line.x.end());
    low = std::min(low, *least), high = std::max(high, *greatest);
    chart.lines.push_back(std::move(line));
  }
  if (chart.lines.empty()) return chart;
  for (const auto& [factor, name] : factors)
    chart.lines.push_back(
        {.title = name, .x = {low, high}, .y = {factor * low, factor * high}, .style = LineStyle::dashed});
  return chart;
}

/// Of what the runs cost together: the share of each kind of run, with how many of them a run of solve() makes.
std::string shares(const std::vector<Cases>& runs) {
  std::map<std::string, CertificateCost> kinds;
  double cost = 0;
  for (const Cases& run : runs) {
    if (std::isnan(run.front().run.cost)) continue;
    cost += run.front().run.cost;
    for (const CertificateCost& spent : run.front().run.costs) {
      CertificateCost& kind = kinds[spent.what];
      kind.runs += spent.runs, kind.steps += spent.steps, kind.cost += spent.cost;
    }
  }
  std::string out;
  for (const auto& [what, kind] : kinds)
    out += format("  %-24s %5.1f %% of the cost, %.1f runs of %.0f steps\n", what.c_str(), 100 * kind.cost / cost,
                  static_cast<double>(kind.runs) / static_cast<double>(runs.size()),
                  static_cast<double>(kind.steps) / kind.runs);
  return out;
}

nlohmann::ordered_json json(const CertifiedCase& c) {
  const CertifiedRun& run = c.run;
  nlohmann::ordered_json j = {
      {"scene", run.scene},
      {"seen", run.seen},
      {"quantity", c.quantity},
      {"target", run.target},
      {"stated", c.stated},
      {"true", c.error},
      {"parts",
       {{"truncation", c.parts.truncation},
        {"deflection", c.parts.deflection},
        {"time", c.parts.time},
        {"solver", c.parts.solver},
        {"mesh", c.parts.mesh}}},
      {"reference_error", c.reference_error},
      {"covered", c.covered()},
      {"met", c.met},
      {"model", run.model},
      {"integrator", run.integrator},
      {"tolerance", run.tolerance},
      {"cost_s", run.cost},
      {"answer_cost_s", run.answer_cost},
      {"tuned_cost_s", run.tuned.cost},
      {"tuned_cost_by_tolerance_s", run.tuned.by_tolerance},
      {"tuned_model", run.tuned.model},
      {"cost_ratio", run.cost_ratio()},
      {"cost_ratio_by_tolerance", run.cost_ratio_by_tolerance()},
  };
  if (!run.failure.empty()) j["failure"] = run.failure;
  return j;
}

}  // namespace

bool CertifiedCase::covered(double allowed) const { return std::isfinite(stated) && error <= stated + allowed; }

bool CertifySummary::keeps_promise() const {
  bool keeps = median_overestimate <= kOverestimate && worst_overestimate <= kWorst;
  for (double covered : coverage_at) keeps &= !(covered < kCoverage);
  return keeps && !(median_cost_ratio_20ms > kCostRatio) && !(median_cost_ratio_short > kCostRatioShort);
}

std::vector<CertifiedCase> of_half(const std::vector<CertifiedCase>& cases, bool seen) {
  Cases found;
  std::copy_if(cases.begin(), cases.end(), std::back_inserter(found),
               [&](const CertifiedCase& c) { return c.run.seen == seen; });
  return found;
}

CertifySummary summarize(const std::vector<CertifiedCase>& cases) {
  CertifySummary s;
  std::set<std::string> scenes;
  std::vector<double> overestimates, cost_ratios, by_tolerance, long_runs, short_runs, choosing;
  int covered = 0, covered_alone = 0;
  for (const CertifiedCase& c : cases) {
    scenes.insert(c.run.scene);
    covered += c.covered();
    covered_alone += c.covered(0);
    s.not_met += !c.met;
    s.within_target += c.error <= c.run.target;
    overestimates.push_back(c.overestimate());
  }
  for (const Cases& run : by_run(cases)) {
    ++s.runs;
    cost_ratios.push_back(run.front().run.cost_ratio());
    const CertifiedRun& r = run.front().run;
    by_tolerance.push_back(r.cost_ratio_by_tolerance());
    (r.tuned.cost >= kShort ? long_runs : short_runs).push_back(r.cost_ratio());
    if (r.is_long) choosing.push_back((r.cost - r.answer_cost) / r.answer_cost);
  }
  s.scenes = static_cast<int>(scenes.size()), s.cases = static_cast<int>(cases.size());
  s.coverage = static_cast<double>(covered) / s.cases;
  s.coverage_without_reference_error = static_cast<double>(covered_alone) / s.cases;
  s.median_overestimate = median(overestimates);
  s.worst_overestimate = kUnknown;
  for (double each : overestimates) s.worst_overestimate = std::fmax(s.worst_overestimate, each);
  s.median_cost_ratio_20ms = median(long_runs), s.median_cost_ratio_short = median(short_runs);
  s.median_long_choosing = median(choosing);
  for (int i = 0; i < 3; ++i) {
    int all = 0, held = 0;
    for (const CertifiedCase& c : cases)
      if (std::abs(c.run.target - 0.1 * std::pow(10.0, -i)) < 1e-9) ++all, held += c.covered();
    if (all > 0) s.coverage_at[i] = static_cast<double>(held) / all;
  }
  s.median_cost_ratio = median(cost_ratios), s.median_cost_ratio_by_tolerance = median(by_tolerance);
  return s;
}

static nlohmann::ordered_json json_of_half(const Cases& cases, bool seen) {
  const CertifySummary s = summarize(of_half(cases, seen));
  return {{"scenes", s.scenes},
          {"coverage_10", s.coverage_at[0]},
          {"coverage_1", s.coverage_at[1]},
          {"coverage_01", s.coverage_at[2]},
          {"median_overestimate", s.median_overestimate},
          {"worst_overestimate", s.worst_overestimate},
          {"median_cost_ratio_20ms", s.median_cost_ratio_20ms},
          {"median_cost_ratio_short", s.median_cost_ratio_short},
          {"median_long_choosing", s.median_long_choosing},
          {"not_met", s.not_met},
          {"within_target", s.within_target}};
}

void write_json(const std::vector<CertifiedCase>& cases, const std::string& path) {
  const CertifySummary s = summarize(cases);
  nlohmann::ordered_json all = {{"scenes", s.scenes},
                                {"runs_count", s.runs},
                                {"cases_count", s.cases},
                                {"coverage", s.coverage},
                                {"coverage_without_reference_error", s.coverage_without_reference_error},
                                {"median_overestimate", s.median_overestimate},
                                {"median_cost_ratio", s.median_cost_ratio},
                                {"median_cost_ratio_by_tolerance", s.median_cost_ratio_by_tolerance},
                                {"not_met", s.not_met},
                                {"within_target", s.within_target},
                                {"seen", json_of_half(cases, true)},
                                {"unseen", json_of_half(cases, false)},
                                {"cases", nlohmann::ordered_json::array()}};
  for (const CertifiedCase& c : cases) all["cases"].push_back(json(c));
  PartialFile file(path);
  file.stream() << all.dump(1) << '\n';  // what is not finite comes out as null
  file.commit();
}

void write_charts(const std::vector<CertifiedCase>& cases, const std::string& folder) {
  std::vector<ChartLine> errors, costs;
  for (const double target : targets(cases)) {
    const Cases chosen = of_target(cases, target);
    ChartLine error{.title = percent(target) + " asked", .x = {}, .y = {}, .style = LineStyle::points};
    ChartLine cost = error;
    for (const CertifiedCase& c : chosen)
      if (drawable(c.error, c.stated)) error.x.push_back(100 * c.error), error.y.push_back(100 * c.stated);
    for (const Cases& run : by_run(chosen)) {
      const CertifiedRun& r = run.front().run;
      if (drawable(r.tuned.cost, r.cost)) cost.x.push_back(1e3 * r.tuned.cost), cost.y.push_back(1e3 * r.cost);
    }
    errors.push_back(std::move(error)), costs.push_back(std::move(cost));
  }
  const CertifySummary s = summarize(cases);
  const Chart stated =
      scatter(format("What solve() states and what is so: %d scenes, %.1f %% covered, median overestimate %.1f",
                     s.scenes, 100 * s.coverage, s.median_overestimate),
              "true error (% of the largest change)", "stated error (% of the largest change)", std::move(errors),
              {{1, "stated = true"}, {kOverestimate, format("%g x", kOverestimate)}});
  const Chart paid = scatter("What solve() costs, choosing included: median ratio " + ratio(s.median_cost_ratio),
                             "CPU time of the best run by hand (ms)", "CPU time of solve() (ms)", std::move(costs),
                             {{1, "as the best by hand"}, {kCostRatio, format("%g x", kCostRatio)}});
  if (!stated.lines.empty()) write_chart(stated, folder + "/certify");
  if (!paid.lines.empty()) write_chart(paid, folder + "/certify_cost");
}

void write_table(const std::vector<CertifiedCase>& cases, const std::string& path) {
  PartialFile file(path);
  std::ostream& out = file.stream();
  out << "# What solve() states, and what is so\n\n"
         "Written by `tools/certify.sh`; scenes and references: `tools/certify/README.md`. Errors are parts of the\n"
         "largest change of what is watched, the largest over the instants. A case is a watched quantity of a scene "
         "at\n"
         "a target. It is covered if its true error is at most the stated one and that of the reference (in brackets:\n"
         "the stated one alone). Costs are CPU times on one machine, choosing included; the best by hand is the\n"
         "cheapest of all models, integrators and steps whose true error is within the target, in brackets of those\n"
         "that need no step.\n\n"
         "| target | cases | covered | median overestimate | stated as not met | true error within target | median "
         "cost over the best by hand |\n|---|---|---|---|---|---|---|\n";
  const auto add = [&](const std::string& name, const CertifySummary& s) {
    out << "| " << name << " | " << s.cases << " | " << format("%.1f %%", 100 * s.coverage)
        << format(" (%.1f %%) | ", 100 * s.coverage_without_reference_error) << ratio(s.median_overestimate) << " | "
        << s.not_met << " | " << s.within_target << " | " << ratio(s.median_cost_ratio) << " ("
        << ratio(s.median_cost_ratio_by_tolerance) << ") |\n";
  };
  for (const double target : targets(cases)) add(percent(target), summarize(of_target(cases, target)));
  add("all", summarize(cases));

  for (const bool seen : {true, false}) {
    const Cases half = of_half(cases, seen);
    for (const double target : targets(half))
      add(percent(target) + (seen ? ", seen" : ", unseen"), summarize(of_target(half, target)));
  }

  out << "\nOf each run the quantity whose true error comes nearest to the stated one, or passes it furthest.\n\n"
         "| scene | target | quantity | stated | true | covered | met | model | cost (ms) | best by hand (ms) | ratio "
         "| "
         "its setting |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Cases& run : by_run(cases)) {
    const CertifiedCase& c = *std::max_element(run.begin(), run.end(),
                                               [](const auto& a, const auto& b) { return nearness(a) < nearness(b); });
    const CertifiedRun& r = c.run;
    const bool met = std::all_of(run.begin(), run.end(), [](const CertifiedCase& each) { return each.met; });
    out << "| " << r.scene << " | " << percent(r.target) << " | " << c.quantity << " | " << percent(c.stated) << " | "
        << percent(c.error) << " | " << (c.covered() ? "yes" : "**no**") << " | " << (met ? "yes" : "no") << " | "
        << (r.failure.empty() ? r.model : "none: " + r.failure) << " | " << number(1e3 * r.cost) << " | "
        << number(1e3 * r.tuned.cost) << " | " << ratio(r.cost_ratio()) << " | " << r.tuned.model << " |\n";
  }
  file.commit();
}

std::string text(const std::vector<CertifiedCase>& cases) {
  const CertifySummary s = summarize(cases);
  std::string out =
      format("%d scenes, %d runs, %d cases\n", s.scenes, s.runs, s.cases) +
      format("coverage %.1f %% (without the references' errors %.1f %%), at least %g %% wanted\n", 100 * s.coverage,
             100 * s.coverage_without_reference_error, 100 * kCoverage) +
      "median overestimate " + ratio(s.median_overestimate) + format(", at most %g wanted\n", kOverestimate) +
      "median cost over the best by hand " + ratio(s.median_cost_ratio) + ", over the best without fixed steps " +
      ratio(s.median_cost_ratio_by_tolerance) +
      format("; at most %g wanted, %g where that is short\n", kCostRatio, kCostRatioShort) +
      format("stated as not met: %d cases; true error within the target: %d cases\n", s.not_met, s.within_target);
  for (const bool seen : {true, false}) {
    const CertifySummary h = summarize(of_half(cases, seen));
    out += std::string(seen ? "seen:   " : "unseen: ") +
           format(
               "%d scenes, covered %.1f, %.1f, %.1f %%, overestimate %.2f in the median, %.1f at worst, cost %.2f "
               "(%.2f where short) times by hand, choosing %.2f of long runs\n",
               h.scenes, 100 * h.coverage_at[0], 100 * h.coverage_at[1], 100 * h.coverage_at[2], h.median_overestimate,
               h.worst_overestimate, h.median_cost_ratio_20ms, h.median_cost_ratio_short, h.median_long_choosing) +
           shares(by_run(of_half(cases, seen)));
  }
  for (const CertifiedCase& c : cases) {
    if (c.covered() && c.met) continue;
    out += format("  %-12s", !c.covered() ? "not covered" : "not met") + c.run.scene + ", " + c.quantity + ", " +
           percent(c.run.target) + ": stated " + percent(c.stated) + ", true " + percent(c.error) +
           (c.run.failure.empty() ? "" : "; " + c.run.failure) + "\n";
  }
  return out;
}

}  // namespace lithe::certify
