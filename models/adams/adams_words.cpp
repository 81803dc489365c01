#include "models/adams/adams_words_internal.h"

namespace lithe::adams {

const std::map<std::string, KnownFunction>& function_words() {
  using enum AdamsFunction::Operation;
  static const std::map<std::string, KnownFunction> all = {{"ABS", {absolute, 1, 1}},
                                                           {"ACOS", {arc_cosine, 1, 1}},
                                                           {"AINT", {truncated, 1, 1}},
                                                           {"ANINT", {rounded, 1, 1}},
                                                           {"INT", {truncated, 1, 1}},
                                                           {"NINT", {rounded, 1, 1}},
                                                           {"ASIN", {arc_sine, 1, 1}},
                                                           {"ATAN", {arc_tangent, 1, 1}},
                                                           {"ATAN2", {quadrant_arc_tangent, 2, 2}},
                                                           {"COS", {cosine, 1, 1}},
                                                           {"COSH", {hyperbolic_cosine, 1, 1}},
                                                           {"DIM", {excess, 2, 2}},
                                                           {"EXP", {exponential, 1, 1}},
                                                           {"LOG", {logarithm, 1, 1}},
                                                           {"LOG10", {decimal_logarithm, 1, 1}},
                                                           {"MAX", {maximum, 2, 2}},
                                                           {"MIN", {minimum, 2, 2}},
                                                           {"MOD", {remainder, 2, 2}},
                                                           {"SIGN", {with_sign, 2, 2}},
                                                           {"SIN", {sine, 1, 1}},
                                                           {"SINH", {hyperbolic_sine, 1, 1}},
                                                           {"SQRT", {square_root, 1, 1}},
                                                           {"TAN", {tangent, 1, 1}},
                                                           {"TANH", {hyperbolic_tangent, 1, 1}},
                                                           {"STEP", {cubic_step, 5, 5}},
                                                           {"STEP5", {quintic_step, 5, 5}},
                                                           {"HAVSIN", {haversine_step, 5, 5}},
                                                           {"BISTOP", {bistop, 8, 8}},
                                                           {"IMPACT", {impact, 7, 7}},
                                                           {"POLY", {polynomial, 3, 33}},
                                                           {"SHF", {harmonic, 5, 6}},
                                                           {"FORCOS", {cosine_series, 4, 34}},
                                                           {"FORSIN", {sine_series, 4, 34}},
                                                           {"CHEBY", {chebyshev, 3, 33}}};
  return all;
}

const std::map<std::string, AdamsMeasure::Kind>& measure_words() {
  using enum AdamsMeasure::Kind;
  static const std::map<std::string, AdamsMeasure::Kind> all = {
      {"DM", DM},     {"DX", DX},     {"DY", DY},       {"DZ", DZ},     {"AX", AX},     {"AY", AY},
      {"AZ", AZ},     {"PSI", PSI},   {"THETA", THETA}, {"PHI", PHI},   {"YAW", YAW},   {"PITCH", PITCH},
      {"ROLL", ROLL}, {"VM", VM},     {"VR", VR},       {"VX", VX},     {"VY", VY},     {"VZ", VZ},
      {"WM", WM},     {"WX", WX},     {"WY", WY},       {"WZ", WZ},     {"ACCM", ACCM}, {"ACCX", ACCX},
      {"ACCY", ACCY}, {"ACCZ", ACCZ}, {"WDTM", WDTM},   {"WDTX", WDTX}, {"WDTY", WDTY}, {"WDTZ", WDTZ}};
  return all;
}

std::vector<int*> markers_of(AdamsMeasure& m) {
  using enum AdamsMeasure::Kind;
  const auto from = [&](AdamsMeasure::Kind least, AdamsMeasure::Kind most) {
    return m.kind >= least && m.kind <= most;
  };
  if (m.kind == VM || m.kind == VR || m.kind == ACCM || m.kind == WDTM) return {&m.i, &m.j, &m.l};
  if (from(DX, DZ) || from(WX, WZ)) return {&m.i, &m.j, &m.k};
  if (from(VX, VZ) || from(ACCX, ACCZ) || from(WDTX, WDTZ)) return {&m.i, &m.j, &m.k, &m.l};
  return {&m.i, &m.j};
}

}  // namespace lithe::adams
