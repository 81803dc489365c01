#include "models/read_tir.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/log.h"

namespace lithe {
namespace {

using C = TyreCoefficients;

enum Dimension { kNumber, kLength, kSpeed, kForce, kPressure, kStiffness, kDamping, kAngle };

struct Coefficient {
  const char* name;
  double C::*member;
  Dimension dimension = kNumber;
};

/// All that are read. Names in files are those of the members.
const std::vector<Coefficient>& known() {
#define LITHE_TIR(name) \
  Coefficient { #name, &C::name }
#define LITHE_TIR_IN(name, dimension) \
  Coefficient { #name, &C::name, dimension }
  static const std::vector<Coefficient> all = {
      LITHE_TIR_IN(longvl, kSpeed), LITHE_TIR_IN(vxlow, kSpeed), LITHE_TIR_IN(unloaded_radius, kLength),
      LITHE_TIR_IN(inflpres, kPressure), LITHE_TIR_IN(nompres, kPressure), LITHE_TIR_IN(fnomin, kForce),
      LITHE_TIR_IN(vertical_stiffness, kStiffness), LITHE_TIR_IN(vertical_damping, kDamping), LITHE_TIR(breff),
      LITHE_TIR(dreff), LITHE_TIR(freff), LITHE_TIR(q_re0), LITHE_TIR(q_v1), LITHE_TIR(q_v2), LITHE_TIR(q_fz1),
      LITHE_TIR(q_fz2), LITHE_TIR(pfz1), LITHE_TIR_IN(longitudinal_stiffness, kStiffness),
      LITHE_TIR_IN(lateral_stiffness, kStiffness), LITHE_TIR(pcfx1), LITHE_TIR(pcfx2), LITHE_TIR(pcfx3),
      LITHE_TIR(pcfy1), LITHE_TIR(pcfy2), LITHE_TIR(pcfy3), LITHE_TIR(ptx1), LITHE_TIR(ptx2), LITHE_TIR(ptx3),
      LITHE_TIR(pty1), LITHE_TIR(pty2), LITHE_TIR_IN(fzmax, kForce), LITHE_TIR(kpumin), LITHE_TIR(kpumax),
      LITHE_TIR_IN(alpmin, kAngle), LITHE_TIR_IN(alpmax, kAngle), LITHE_TIR_IN(cammin, kAngle),
      LITHE_TIR_IN(cammax, kAngle),
      // [SCALING_COEFFICIENTS]
      LITHE_TIR(lfzo), LITHE_TIR(lcx), LITHE_TIR(lmux), LITHE_TIR(lex), LITHE_TIR(lkx), LITHE_TIR(lhx), LITHE_TIR(lvx),
      LITHE_TIR(lcy), LITHE_TIR(lmuy), LITHE_TIR(ley), LITHE_TIR(lky), LITHE_TIR(lhy), LITHE_TIR(lvy), LITHE_TIR(ltr),
      LITHE_TIR(lres), LITHE_TIR(lxal), LITHE_TIR(lyka), LITHE_TIR(lvyka), LITHE_TIR(ls), LITHE_TIR(lkyc),
      LITHE_TIR(lkzc), LITHE_TIR(lvmx), LITHE_TIR(lmx), LITHE_TIR(lmy), LITHE_TIR(lmuv), LITHE_TIR(lsgkp),
      LITHE_TIR(lsgal),
      // [LONGITUDINAL_COEFFICIENTS]
      LITHE_TIR(pcx1), LITHE_TIR(pdx1), LITHE_TIR(pdx2), LITHE_TIR(pdx3), LITHE_TIR(pex1), LITHE_TIR(pex2),
      LITHE_TIR(pex3), LITHE_TIR(pex4), LITHE_TIR(pkx1), LITHE_TIR(pkx2), LITHE_TIR(pkx3), LITHE_TIR(phx1),
      LITHE_TIR(phx2), LITHE_TIR(pvx1), LITHE_TIR(pvx2), LITHE_TIR(ppx1), LITHE_TIR(ppx2), LITHE_TIR(ppx3),
      LITHE_TIR(ppx4), LITHE_TIR(rbx1), LITHE_TIR(rbx2), LITHE_TIR(rbx3), LITHE_TIR(rcx1), LITHE_TIR(rex1),
      LITHE_TIR(rex2), LITHE_TIR(rhx1),
      // [OVERTURNING_COEFFICIENTS]
      LITHE_TIR(qsx1), LITHE_TIR(qsx2), LITHE_TIR(qsx3), LITHE_TIR(qsx4), LITHE_TIR(qsx5), LITHE_TIR(qsx6),
      LITHE_TIR(qsx7), LITHE_TIR(qsx8), LITHE_TIR(qsx9), LITHE_TIR(qsx10), LITHE_TIR(qsx11), LITHE_TIR(ppmx1),
      // [LATERAL_COEFFICIENTS]
      LITHE_TIR(pcy1), LITHE_TIR(pdy1), LITHE_TIR(pdy2), LITHE_TIR(pdy3), LITHE_TIR(pey1), LITHE_TIR(pey2),
      LITHE_TIR(pey3), LITHE_TIR(pey4), LITHE_TIR(pey5), LITHE_TIR(pky1), LITHE_TIR(pky2), LITHE_TIR(pky3),
      LITHE_TIR(pky4), LITHE_TIR(pky5), LITHE_TIR(pky6), LITHE_TIR(pky7), LITHE_TIR(phy1), LITHE_TIR(phy2),
      LITHE_TIR(phy3), LITHE_TIR(pvy1), LITHE_TIR(pvy2), LITHE_TIR(pvy3), LITHE_TIR(pvy4), LITHE_TIR(ppy1),
      LITHE_TIR(ppy2), LITHE_TIR(ppy3), LITHE_TIR(ppy4), LITHE_TIR(ppy5), LITHE_TIR(rby1), LITHE_TIR(rby2),
      LITHE_TIR(rby3), LITHE_TIR(rby4), LITHE_TIR(rcy1), LITHE_TIR(rey1), LITHE_TIR(rey2), LITHE_TIR(rhy1),
      LITHE_TIR(rhy2), LITHE_TIR(rvy1), LITHE_TIR(rvy2), LITHE_TIR(rvy3), LITHE_TIR(rvy4), LITHE_TIR(rvy5),
      LITHE_TIR(rvy6),
      // [ROLLING_COEFFICIENTS]
      LITHE_TIR(qsy1), LITHE_TIR(qsy2), LITHE_TIR(qsy3), LITHE_TIR(qsy4), LITHE_TIR(qsy5), LITHE_TIR(qsy6),
      LITHE_TIR(qsy7), LITHE_TIR(qsy8),
      // [ALIGNING_COEFFICIENTS]
      LITHE_TIR(qbz1), LITHE_TIR(qbz2), LITHE_TIR(qbz3), LITHE_TIR(qbz4), LITHE_TIR(qbz5), LITHE_TIR(qbz9),
      LITHE_TIR(qbz10), LITHE_TIR(qcz1), LITHE_TIR(qdz1), LITHE_TIR(qdz2), LITHE_TIR(qdz3), LITHE_TIR(qdz4),
      LITHE_TIR(qdz6), LITHE_TIR(qdz7), LITHE_TIR(qdz8), LITHE_TIR(qdz9), LITHE_TIR(qdz10), LITHE_TIR(qdz11),
      LITHE_TIR(qez1), LITHE_TIR(qez2), LITHE_TIR(qez3), LITHE_TIR(qez4), LITHE_TIR(qez5), LITHE_TIR(qhz1),
      LITHE_TIR(qhz2), LITHE_TIR(qhz3), LITHE_TIR(qhz4), LITHE_TIR(ppz1), LITHE_TIR(ppz2), LITHE_TIR(ssz1),
      LITHE_TIR(ssz2), LITHE_TIR(ssz3), LITHE_TIR(ssz4)};
#undef LITHE_TIR
#undef LITHE_TIR_IN
  return all;
}

/// Sections that a file must have, and what they must give.
const std::vector<std::pair<std::string, std::vector<std::string>>>& required() {
  static const std::vector<std::pair<std::string, std::vector<std::string>>> all = {
      {"model", {"fittyp", "longvl"}},
      {"dimension", {"unloaded_radius"}},
      {"vertical", {"fnomin"}},
      {"longitudinal_coefficients", {"pcx1", "pdx1", "pkx1"}},
      {"lateral_coefficients", {"pcy1", "pdy1", "pky1", "pky2"}},
      {"aligning_coefficients", {"qbz1", "qcz1", "qdz1"}}};
  return all;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}
std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}
std::string trimmed(const std::string& text) {
  const char* blanks = " \t\r\n\f\v";
  const auto first = text.find_first_not_of(blanks);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

class TirReader {
 public:
  explicit TirReader(const std::filesystem::path& path) : path_(path.string()) {
    std::ifstream file(path);
    if (!file) throw FileError("cannot open the tyre '" + path_ + "'", path_, "check the path");
    std::string text;
    for (int line = 1; std::getline(file, text); ++line) take(trimmed(text.substr(0, text.find_first_of("$!"))), line);
    if (file.bad()) throw FileError("cannot read the tyre '" + path_ + "'", path_, "check the disk");
  }

  TyreCoefficients read() {
    for (const auto& [section, names] : required()) {
      const auto at = sections_.find(section);
      if (at == sections_.end())
        fail(0, "the tyre has no section [" + upper(section) + "]", "give a complete .tir file of MF-Tyre");
      for (const std::string& name : names)
        if (!values_.count(name))
          fail(at->second, "section [" + upper(section) + "] has no " + upper(name),
               "add the line " + upper(name) + " = value");
    }
    const double type = number("fittyp");
    if (type != 6 && type != 60 && type != 61 && type != 62)
      fail(values_.at("fittyp").line, "FITTYP is " + values_.at("fittyp").text,
           "give 6 (MF-Tyre 5.2), 60, 61 or 62; fit other tyres anew");
    result_.before_60 = type == 6;
    read_units();
    for (const Coefficient& c : known())
      if (values_.count(c.name)) result_.*c.member = number(c.name) * scale(c.dimension);
    warn_of_unused();
    return result_;
  }

 private:
  struct Entry {
    std::string text;
    int line;
    bool acts;  // stands where coefficients of forces do
    bool used = false;
  };

  [[noreturn]] void fail(int line, const std::string& what, const std::string& fix) const {
    throw FileError(what, line > 0 ? path_ + ":" + std::to_string(line) : path_, fix);
  }

  void take(const std::string& text, int line) {
    if (text.empty()) return;
    if (text.front() == '[') {
      if (text.back() != ']') fail(line, "'" + text + "' has no closing bracket", "write [SECTION]");
      section_ = lower(trimmed(text.substr(1, text.size() - 2)));
      if (!sections_.emplace(section_, line).second)
        fail(line, "section [" + upper(section_) + "] is there twice", "keep one of them");
      return;
    }
    const auto equals = text.find('=');
    if (equals == std::string::npos) {
      if (section_ == "shape" || section_.ends_with("_curve")) return;  // tables
      fail(line, "'" + text.substr(0, 40) + "' is no section and no NAME = value", "start comments with $ or !");
    }
    const std::string name = lower(trimmed(text.substr(0, equals)));
    std::string value = trimmed(text.substr(equals + 1));
    if (value.size() >= 2 && (value.front() == '\'' || value.front() == '"') && value.back() == value.front())
      value = trimmed(value.substr(1, value.size() - 2));
    if (section_.empty()) fail(line, upper(name) + " comes before any section", "start with [MODEL] or [UNITS]");
    const bool acts = section_.ends_with("_coefficients") || section_ == "vertical" || section_ == "structural";
    // Units name what they are of, as [INERTIA] does with MASS.
    if (!(section_ == "units" ? units_ : values_).emplace(name, Entry{value, line, acts}).second)
      fail(line, upper(name) + " is there twice", "keep one of them");
  }

  double number(const std::string& name) {
    Entry& entry = values_.at(name);
    entry.used = true;
    const char *first = entry.text.data(), *last = first + entry.text.size();
    double value = 0;
    const auto [end, error] = std::from_chars(first + (first != last && *first == '+'), last, value);
    if (error != std::errc{} || end != last || !std::isfinite(value))
      fail(entry.line, upper(name) + " is '" + entry.text.substr(0, 40) + "', which is no finite number",
           "give one number, as 1.5 or -2e-3");
    return value;
  }

  double unit(const std::string& of, const std::map<std::string, double>& units, double otherwise) const {
    const auto at = units_.find(of);
    if (at == units_.end()) return otherwise;
    const auto found = units.find(lower(at->second.text));
    if (found != units.end()) return found->second;
    std::string list;
    for (const auto& [name, factor] : units) list += (list.empty() ? "" : ", ") + name;
    fail(at->second.line, "the unit '" + at->second.text + "' of " + upper(of) + " is not known",
         "give one of " + list);
  }

  void read_units() {
    length_ = unit("length",
                   {{"meter", 1},
                    {"m", 1},
                    {"mm", 1e-3},
                    {"millimeter", 1e-3},
                    {"cm", 1e-2},
                    {"centimeter", 1e-2},
                    {"inch", 0.0254},
                    {"in", 0.0254},
                    {"foot", 0.3048},
                    {"ft", 0.3048}},
                   1);
    force_ = unit("force",
                  {{"newton", 1},
                   {"n", 1},
                   {"kilonewton", 1e3},
                   {"kn", 1e3},
                   {"kgf", 9.80665},
                   {"kilogram_force", 9.80665},
                   {"lbf", 4.4482216152605},
                   {"pound_force", 4.4482216152605}},
                  1);
    time_ = unit("time",
                 {{"second", 1},
                  {"sec", 1},
                  {"s", 1},
                  {"millisecond", 1e-3},
                  {"ms", 1e-3},
                  {"minute", 60},
                  {"min", 60},
                  {"hour", 3600},
                  {"h", 3600}},
                 1);
    const double degree = std::numbers::pi / 180;
    angle_ =
        unit("angle",
             {{"radian", 1}, {"radians", 1}, {"rad", 1}, {"degree", degree}, {"degrees", degree}, {"deg", degree}}, 1);
    pressure_ = unit("pressure", {{"pascal", 1}, {"pa", 1}, {"kpa", 1e3}, {"bar", 1e5}, {"psi", 6894.757293168}},
                     force_ / (length_ * length_));
  }

  double scale(Dimension dimension) const {
    switch (dimension) {
      case kLength:
        return length_;
      case kSpeed:
        return length_ / time_;
      case kForce:
        return force_;
      case kPressure:
        return pressure_;
      case kStiffness:
        return force_ / length_;
      case kDamping:
        return force_ * time_ / length_;
      case kAngle:
        return angle_;
      case kNumber:
        break;
    }
    return 1;
  }

  /// Coefficients of parts of MF-Tyre that are not here.
  void warn_of_unused() const {
    std::string names;
    for (const auto& [name, entry] : values_) {
      double value = 0;
      const char* last = entry.text.data() + entry.text.size();
      const bool numeric = std::from_chars(entry.text.data(), last, value).ptr == last;
      if (entry.acts && !entry.used && numeric && value != 0) names += (names.empty() ? "" : ", ") + upper(name);
    }
    if (!names.empty()) log::warn("tyre '" + path_ + "': without effect here are " + names + ".");
  }

  const std::string path_;
  std::string section_;
  std::map<std::string, int> sections_;  // and their lines
  std::map<std::string, Entry> values_, units_;
  TyreCoefficients result_;
  double length_ = 1, force_ = 1, time_ = 1, angle_ = 1, pressure_ = 1;
};

}  // namespace

TyreCoefficients read_tir(const std::filesystem::path& path) { return TirReader(path).read(); }

}  // namespace lithe
