#include "engine/base/number_text.h"

#include <cmath>
#include <cstdio>

namespace lithe {

std::string three_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string short_number(double value) {
  char text[32];
  if (value == 0 || (std::abs(value) >= 0.1 && std::abs(value) < 1e4)) {
    const bool thousands = std::abs(value) >= 999.5;  // 1410, not 1.41e+03
    std::snprintf(text, sizeof text, thousands ? "%.0f" : "%.3g", thousands ? 10 * std::round(value / 10) : value);
    return text;
  }
  // "1e-5" to an engineer, not "1.00e-05".
  std::snprintf(text, sizeof text, "%.2e", value);
  std::string out = text;
  auto e = out.find('e');
  if (e == std::string::npos) return out;  // inf
  while (out[e - 1] == '0' || out[e - 1] == '.') {
    const bool point = out[e - 1] == '.';
    out.erase(--e, 1);
    if (point) break;
  }
  if (out[e + 1] == '+') out.erase(e + 1, 1);
  const std::size_t digits = out[e + 1] == '-' ? e + 2 : e + 1;
  while (digits + 1 < out.size() && out[digits] == '0') out.erase(digits, 1);
  return out;
}

}  // namespace lithe
