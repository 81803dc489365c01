#include <cctype>

#include "models/adams/read_adams_internal.h"

namespace lithe::adams {
namespace {

struct Unit {
  const char* name;
  double value;
};
// Exact by definition, but for the pound-force and what follows from it: 0.45359237 kg * 9.80665 m/s².
constexpr Unit kForces[] = {{"NEWTON", 1},
                            {"KNEWTON", 1e3},
                            {"KILONEWTON", 1e3},
                            {"MILLINEWTON", 1e-3},
                            {"MEGANEWTON", 1e6},
                            {"DYNE", 1e-5},
                            {"KILOGRAM_FORCE", 9.80665},
                            {"POUND_FORCE", 0.45359237 * 9.80665},
                            {"KPOUND_FORCE", 453.59237 * 9.80665},
                            {"OUNCE_FORCE", 0.45359237 / 16 * 9.80665},
                            {"POUNDAL", 0.45359237 * 0.3048}};
constexpr Unit kMasses[] = {{"KILOGRAM", 1},
                            {"GRAM", 1e-3},
                            {"MEGAGRAM", 1e3},
                            {"TONNE", 1e3},
                            {"POUND_MASS", 0.45359237},
                            {"KPOUND_MASS", 453.59237},
                            {"OUNCE_MASS", 0.45359237 / 16},
                            {"SLUG", 0.45359237 * 9.80665 / 0.3048},
                            {"SLINCH", 0.45359237 * 9.80665 / 0.0254}};
constexpr Unit kLengths[] = {{"METER", 1},     {"MM", 1e-3},       {"MILLIMETER", 1e-3}, {"CENTIMETER", 1e-2},
                             {"CM", 1e-2},     {"KILOMETER", 1e3}, {"INCH", 0.0254},     {"FOOT", 0.3048},
                             {"FEET", 0.3048}, {"MILE", 1609.344}, {"MICROMETER", 1e-6}};
constexpr Unit kTimes[] = {{"SECOND", 1}, {"MILLISECOND", 1e-3}, {"MINUTE", 60}, {"HOUR", 3600}};

template <std::size_t N>
double unit(const Arguments& a, const char* name, const Unit (&known)[N]) {
  std::string all, text = a.text(name);
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const Unit& one : known)
    if (text == one.name) return one.value;
  for (const Unit& one : known) {
    if (text.size() >= 2 && std::string(one.name).compare(0, text.size(), text) == 0) return one.value;
    all += std::string(all.empty() ? "" : ", ") + one.name;
  }
  a.fail("has " + (text.empty() ? "no " + std::string(name) : "the unknown " + std::string(name) + " " + text) + ".",
         "known are " + all + ".");
}

}  // namespace

AdamsUnits read_adams_units(const DataSet& file) {
  AdamsUnits units;
  bool found = false;
  for (const Statement& statement : file.statements) {
    if (statement.keyword != "UNITS") continue;
    const Arguments a(file, statement);
    if (found) a.fail("is there twice.", "give it once.");
    found = true;
    if (a.has("UCF")) a.fail("has UCF, a factor between force and mass times acceleration.", "give the four units.");
    if (a.has("SYSTEM")) {
      std::string text = a.text("SYSTEM");
      for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      if (text == "CGS")
        units = {.mass = 1e-3, .length = 1e-2, .time = 1, .force = 1e-5};
      else if (text != "MKS")
        a.fail("has SYSTEM = " + text.substr(0, 40) + ", which is not read.", "give FORCE, MASS, LENGTH and TIME.");
      continue;
    }
    units.force = unit(a, "FORCE", kForces);
    units.mass = unit(a, "MASS", kMasses);
    units.length = unit(a, "LENGTH", kLengths);
    units.time = unit(a, "TIME", kTimes);
  }
  if (!found)
    file.fail(1, "the data set has no UNITS.",
              "give UNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = METER, TIME = SECOND, or those it is in.");
  return units;
}

}  // namespace lithe::adams
