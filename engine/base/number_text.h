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

/// Three digits: "0.25", "0.0141", "1.41e+03".
std::string three_digits(double value);
/// Three digits as an engineer writes them: "0.25", "1410", "1e-5".
std::string short_number(double value);

/// "t = 0.53 s", to the last digit, as messages name a time.
inline std::string time_text(double time) { return "t = " + number_text(time) + " s"; }

}  // namespace lithe
