#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "engine/base/number_text.h"
#include "engine/study/certificate.h"
#include "engine/study/model_run.h"
#include "engine/study/study_run.h"
#include "engine/study/text_table.h"

namespace lithe {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kWidth = 100, kNameWidth = 24, kModelWidth = 44;  // columns of the sheet
constexpr std::size_t kModesShown = 5;                                  // of those left out

// ---- texts ----

/// The text in lines of at most `width` letters, broken between words.
std::vector<std::string> broken(const std::string& text, std::size_t width) {
  std::vector<std::string> lines(1);
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && letter_count(lines.back()) + 1 + letter_count(word) > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

/// A text behind a head, broken at the width of the sheet and indented to the head's end.
std::string paragraph(const std::string& head, const std::string& text) {
  const std::string blanks(letter_count(head), ' ');
  std::string out;
  for (const std::string& line : broken(text, kWidth - blanks.size()))
    out += (out.empty() ? head : blanks) + line + "\n";
  return out;
}

void join(std::string& list, const std::string& entry) { list += (list.empty() ? "" : ", ") + entry; }

// ---- numbers ----

/// Three digits; those down to a thousandth without a power of ten, since they stand beside larger ones.
std::string number(double value) {
  if (std::isnan(value)) return "unknown";
  if (!(std::abs(value) >= 1e-3 && std::abs(value) < 0.1)) return short_number(value);
  return three_digits(value);
}

std::string percent(double ratio) { return std::isfinite(ratio) ? number(100 * ratio) + " %" : "-"; }

std::string hertz(double frequency) {
  return frequency < 999.5 ? number(frequency) + " Hz" : number(1e-3 * frequency) + " kHz";
}

/// In parts of a bound; of a bound of nothing, infinitely many.
double in_parts(double value, double bound) { return value == 0 ? 0 : bound > 0 ? value / bound : kInfinity; }

/// The power of a thousand in which a quantity's errors are written, so that they compare at a glance: that of what was
/// asked, none from 0.1 to 1e4.
int exponent(const CertifiedQuantity& quantity) {
  for (const double size : {quantity.bound, quantity.change, quantity.error.total()})
    if (size > 0 && std::isfinite(size))
      return size >= 0.1 && size < 1e4 ? 0 : 3 * static_cast<int>(std::floor(std::log10(size) / 3 + 1e-9));
  return 0;
}

/// "14.1e-3": an error of a quantity, or what a mode does to it.
std::string amount(double value, const CertifiedQuantity& quantity) {
  const int power = exponent(quantity);
  const double scaled = value / std::pow(10, power);
  if (power == 0 || !(scaled >= 1e-3 && scaled < 9995)) return number(value);
  return number(scaled) + "e" + std::to_string(power);
}

// ---- the sheet ----

using Quantities = std::vector<CertifiedQuantity>;

/// Where something does most, in parts of what was asked.
struct Worst {
  int quantity = -1;  // -1: not estimated
  double parts = 0;
};

Worst worst(const std::vector<double>& effect, const Quantities& quantities) {
  Worst out;
  for (std::size_t i = 0; i < std::min(effect.size(), quantities.size()); ++i) {
    double parts = in_parts(effect[i], quantities[i].bound);
    if (std::isnan(parts)) parts = kInfinity;
    if (out.quantity < 0 || parts > out.parts) out = {static_cast<int>(i), parts};
  }
  return out;
}

std::string verdict(const Certificate& sheet) {
  std::string missed;
  for (const CertifiedQuantity& q : sheet.quantities)
    if (!q.met()) join(missed, "'" + q.name + "'");
  if (sheet.quantities.empty()) missed = "nothing was asked";
  return sheet.met() ? "MET: all stated errors are within what was asked.\n" : paragraph("NOT MET: ", missed + ".");
}

std::string quantity_tables(const Quantities& quantities) {
  if (quantities.empty()) return "";
  TextTable stated, parts;
  stated.add({"Errors, largest of the run", "change", "asked", "stated", "of change", "of asked", "met"});
  const bool meshes =
      std::any_of(quantities.begin(), quantities.end(), [](const CertifiedQuantity& q) { return q.error.mesh != 0; });
  parts.add({"Parts of the stated error", "modes left out", "deflection", "time", "solver", meshes ? "mesh" : ""});
  for (const CertifiedQuantity& q : quantities) {
    const double total = q.error.total();
    const std::string name = "  " + shortened(q.name, kNameWidth);
    stated.add({name, number(q.change), amount(q.bound, q), amount(total, q), percent(in_parts(total, q.change)),
                percent(in_parts(total, q.bound)), q.met() ? "yes" : "no"});
    parts.add({name, amount(q.error.truncation, q), amount(q.error.deflection, q), amount(q.error.time, q),
               amount(q.error.solver, q), meshes ? amount(q.error.mesh, q) : ""});
  }
  return "\n" + stated.text() + "\n" + parts.text();
}

std::string used_modes(const ChosenBody& body) {
  std::string list;
  for (const ModeEffect& mode : body.modes)
    if (mode.used) join(list, std::to_string(mode.mode) + " (" + hertz(mode.frequency) + ")");
  return list.empty() ? "" : paragraph("    modes ", list);
}

/// The largest of the modes left out, and a line for the rest.
std::string left_out(const ChosenBody& body, const Quantities& quantities) {
  std::vector<std::pair<Worst, const ModeEffect*>> known;
  int unknown = 0;
  for (const ModeEffect& mode : body.modes) {
    if (mode.used) continue;
    const Worst most = worst(mode.effect, quantities);
    if (most.quantity < 0)
      ++unknown;
    else
      known.emplace_back(most, &mode);
  }
  if (known.empty() && unknown == 0) return "";
  std::stable_sort(known.begin(), known.end(),
                   [](const auto& a, const auto& b) { return a.first.parts > b.first.parts; });

  TextTable rows;
  rows.add({"    left out", "frequency", "would do", "of asked", "to"});
  double rest = 0;
  for (std::size_t i = 0; i < known.size(); ++i) {
    const auto& [most, mode] = known[i];
    if (i >= kModesShown) {
      rest += most.parts;
      continue;
    }
    const CertifiedQuantity& q = quantities[most.quantity];
    rows.add({"      mode " + std::to_string(mode->mode), hertz(mode->frequency),
              amount(mode->effect[most.quantity], q), percent(most.parts), shortened(q.name, kNameWidth)});
  }
  if (known.size() > kModesShown)
    rows.add(
        {"      " + std::to_string(known.size() - kModesShown) + " more", "", "", percent(rest), "in sum, at most"});
  if (unknown > 0) rows.add({"      " + std::to_string(unknown) + " modes", "", "", "", "not estimated"});
  return rows.text();
}

/// What the second order does, and whether it is in the model.
std::string second_order(const ChosenBody& body, const Quantities& quantities) {
  if (body.deflection_effect.empty()) {
    if (body.elements > 0) return "";  // it can be exact
    if (body.finest == Deflection::quadratic) return "    second order: not estimated\n";
    return paragraph("    second order: ", "what it does cannot be told, for the basis has no data for it (it is " +
                                               to_string(body.finest) +
                                               "). make_basis(..., {.deflection = Deflection::quadratic}) adds them.");
  }
  const bool rigid = body.fidelity.modes.empty();
  const Deflection used = body.fidelity.deflection;
  const std::string status = rigid                           ? "left out with the modes"
                             : used == Deflection::linear    ? "left out, modes do not bring it"
                             : used == Deflection::stiffened ? "in, large deflection left out"
                                                             : "in the model";
  TextTable rows;
  rows.add(
      {"    second order: " + status, rigid || used == Deflection::linear ? "would do" : "does", "of asked", "to"});
  for (std::size_t i = 0; i < std::min(body.deflection_effect.size(), quantities.size()); ++i) {
    const CertifiedQuantity& q = quantities[i];
    const double effect = body.deflection_effect[i];
    rows.add({"", amount(effect, q), percent(in_parts(effect, q.bound)), shortened(q.name, kNameWidth)});
  }
  return rows.text();
}

std::string body_text(const ChosenBody& body, const Quantities& quantities) {
  if (body.modes.empty())
    return paragraph("  ", body.name + ": it has one model only") +
           (body.why.empty() ? "" : paragraph("    why: ", body.why));
  const bool exact = body.fidelity.deflection == Deflection::exact;
  const bool reduced_mesh = body.elements > 0 && !exact && !body.fidelity.modes.empty();
  std::string out = paragraph("  ", body.name + ": " + model_text(body.fidelity, static_cast<int>(body.modes.size())) +
                                        (reduced_mesh ? ", of " + std::to_string(body.elements) + " elements" : ""));
  out += used_modes(body);
  if (!body.why.empty()) out += paragraph("    why: ", body.why);
  if (exact) return out;
  return out + left_out(body, quantities) + second_order(body, quantities);
}

std::string trial_table(const Certificate& sheet) {
  TextTable rows;
  rows.add({"Models considered", "tolerance", "error / asked", "cost", "model"});
  for (std::size_t i = 0; i < sheet.trials.size(); ++i) {
    const CertificateTrial& trial = sheet.trials[i];
    const bool chosen = static_cast<int>(i) == sheet.chosen;
    const std::string how = !trial.run ? "estimated" : std::isfinite(trial.error) ? "run" : "failed";
    const auto lines = broken(trial.model, kModelWidth);
    rows.add({chosen ? "* " + how + ", chosen" : "  " + how, trial.tolerance > 0 ? short_number(trial.tolerance) : "-",
              std::isfinite(trial.error) ? number(trial.error) : "-", trial.cost > 0 ? duration_text(trial.cost) : "-",
              lines.front()});
    for (std::size_t k = 1; k < lines.size(); ++k) rows.add({"", "", "", "", lines[k]});
  }
  return rows.text();
}

/// Where the time of choosing went; nothing where it is not known.
std::string cost_table(const Certificate& sheet) {
  if (sheet.costs.empty()) return "";
  TextTable rows;
  rows.add({"  of these", "runs", "steps", "cost"});
  double rest = sheet.cost;
  for (const CertificateCost& spent : sheet.costs) {
    rest -= spent.cost;
    rows.add({"    " + spent.what, std::to_string(spent.runs), spent.steps > 0 ? std::to_string(spent.steps) : "-",
              duration_text(spent.cost)});
  }
  rows.add({"    set-up, comparison", "", "", duration_text(std::max(0.0, rest))});
  return rows.text();
}

std::string listed(const std::string& heading, const std::vector<std::string>& entries) {
  if (entries.empty()) return "";
  std::string out = "\n" + heading + "\n";
  for (const std::string& entry : entries) out += paragraph("  - ", entry);
  return out;
}

}  // namespace

std::string Certificate::text() const {
  std::string out = paragraph("Certificate: ", scene + ", " + duration_text(duration)) + verdict(*this);
  out += quantity_tables(quantities);
  out += listed("Simplified before the start", simplification);

  out += "\nModels (modes count from 0, as in Fidelity::modes)\n";
  for (const ChosenBody& body : bodies) out += body_text(body, quantities);
  if (bodies.empty()) out += "  no body can deform: there was no model to choose.\n";

  out += "\nTime\n";
  if (steps > 0)
    out += paragraph("  ", integrator + ", " +
                               (tolerance > 0 ? setting_text(StudyMethod::Setting::tolerance, tolerance) + ": " : "") +
                               std::to_string(steps) + " steps of " + duration_text(mean_step) +
                               (tolerance > 0 ? " in the mean" : ""));
  else
    out += "  no run reached the end.\n";
  out += "  " + duration_text(cost) + " of CPU, choosing included; " + duration_text(answer_cost) +
         " for the run that gave the answer\n";
  out += cost_table(*this);

  if (!trials.empty()) out += "\n" + trial_table(*this);
  return out + listed("Remarks", remarks);
}

}  // namespace lithe
