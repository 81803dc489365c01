#pragma once

#include <charconv>
#include <string>

namespace lithe {

/// Appends the shortest decimal text that reads back as the same double (at most 17 significant digits).
inline void append_number(std::string& text, double value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
  text.append(digits, end);
}

/// That text alone.
inline std::string number_text(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

/// "t = 0.53 s", to the last digit, as messages name a time.
inline std::string time_text(double time) {
  return "t = " + number_text(time) + " s";
}

}  // namespace lithe
