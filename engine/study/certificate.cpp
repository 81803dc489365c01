#include "engine/study/certificate.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/output/partial_file.h"
#include "engine/study/model_run.h"
#include "engine/study/study_run.h"
#include "engine/study/text_table.h"

namespace lithe {
namespace {

constexpr std::size_t kTitleLetters = 40;  // of a model, in the chart's legend

using Json = nlohmann::ordered_json;

Json json(const CertifiedQuantity& q) {
  return {{"name", q.name},
          {"change", q.change},
          {"bound", q.bound},
          {"met", q.met()},
          {"error",
           {{"total", q.error.total()},
            {"truncation", q.error.truncation},
            {"deflection", q.error.deflection},
            {"mesh", q.error.mesh},
            {"time", q.error.time},
            {"solver", q.error.solver}}}};
}

Json json(const ChosenBody& body) {
  Json modes = Json::array();
  for (const ModeEffect& mode : body.modes)
    modes.push_back(
        {{"mode", mode.mode}, {"frequency_Hz", mode.frequency}, {"used", mode.used}, {"effect", mode.effect}});
  return {{"name", body.name},
          {"fidelity", {{"modes", body.fidelity.modes}, {"deflection", to_string(body.fidelity.deflection)}}},
          {"finest", to_string(body.finest)},
          {"why", body.why},
          {"elements", body.elements},
          {"modes", modes},
          {"deflection_effect", body.deflection_effect}};
}

Json json(const CertificateTrial& trial) {
  return {{"model", trial.model},
          {"tolerance", trial.tolerance},
          {"run", trial.run},
          {"error", trial.error},
          {"cost_s", trial.cost}};
}

Json json(const CertificateCost& spent) {
  return {{"what", spent.what}, {"runs", spent.runs}, {"steps", spent.steps}, {"cost_s", spent.cost}};
}

template <class Entry>
Json json(const std::vector<Entry>& entries) {
  Json out = Json::array();
  for (const Entry& entry : entries) out.push_back(json(entry));
  return out;
}

}  // namespace

std::string to_string(Deflection deflection) {
  switch (deflection) {
    case Deflection::linear:
      return "linear";
    case Deflection::stiffened:
      return "stiffened";
    case Deflection::quadratic:
      return "quadratic";
    case Deflection::exact:
      break;
  }
  return "exact";
}

std::string model_text(const Fidelity& fidelity, int candidates) {
  if (fidelity.deflection == Deflection::exact) return std::to_string(fidelity.elements) + " exact elements";
  if (fidelity.modes.empty()) return "rigid";
  return std::to_string(fidelity.modes.size()) + " of " + std::to_string(candidates) + " modes, " +
         to_string(fidelity.deflection);
}

bool Certificate::met() const {
  return !quantities.empty() &&
         std::all_of(quantities.begin(), quantities.end(), [](const CertifiedQuantity& q) { return q.met(); });
}

void Certificate::write_json(const std::string& path) const {
  const Json sheet = {{"scene", scene},
                      {"duration_s", duration},
                      {"met", met()},
                      {"quantities", json(quantities)},
                      {"bodies", json(bodies)},
                      {"simplification", simplification},
                      {"integrator", integrator},
                      {"tolerance", tolerance},
                      {"steps", steps},
                      {"mean_step_s", mean_step},
                      {"trials", json(trials)},
                      {"chosen", chosen >= 0 ? Json(chosen) : Json()},
                      {"cost_s", cost},
                      {"answer_cost_s", answer_cost},
                      {"costs", json(costs)},
                      {"remarks", remarks}};
  PartialFile file(path);
  // Numbers that are not finite come out as null; names that are no UTF-8 are fixed.
  file.stream() << sheet.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
  file.commit();
}

Chart Certificate::chart() const {
  ChartLine ran{.title = "run", .x = {}, .y = {}, .style = LineStyle::marked};
  ChartLine estimated{.title = "estimated", .x = {}, .y = {}, .style = LineStyle::points};
  ChartLine best{.title = "", .x = {}, .y = {}, .style = LineStyle::points};
  const auto add = [](ChartLine& line, const CertificateTrial& trial) {
    line.x.push_back(trial.cost);
    line.y.push_back(trial.error);
  };

  // From cheap to dear, or the line of runs would go back and forth.
  std::vector<const CertificateTrial*> by_cost;
  for (const CertificateTrial& trial : trials)
    if (trial.cost > 0 && trial.error > 0 && std::isfinite(trial.cost) && std::isfinite(trial.error))
      by_cost.push_back(&trial);
  std::stable_sort(by_cost.begin(), by_cost.end(), [](const auto* a, const auto* b) { return a->cost < b->cost; });
  for (const CertificateTrial* trial : by_cost) {
    if (trial - trials.data() != chosen) {
      add(trial->run ? ran : estimated, *trial);
      continue;
    }
    best.title = "chosen: " + shortened(trial->model, kTitleLetters);
    if (trial->run && trial->tolerance > 0)
      best.title += ", " + setting_text(StudyMethod::Setting::tolerance, trial->tolerance);
    add(best, *trial);
  }

  Chart out{.title = "Certificate: " + scene,
            .x_label = "CPU time (s)",
            .y_label = "stated error, in parts of what was asked",
            .lines = {ran, estimated, best},
            .log_x = true,
            .log_y = true};
  std::erase_if(out.lines, [](const ChartLine& line) { return line.x.empty(); });
  if (!by_cost.empty()) {
    const double low = by_cost.front()->cost, high = by_cost.back()->cost;
    const double margin = high > low ? 1 : 2;  // a line needs some length
    out.lines.push_back(
        {.title = "what was asked", .x = {low / margin, high * margin}, .y = {1, 1}, .style = LineStyle::dashed});
  }
  return out;
}

}  // namespace lithe
