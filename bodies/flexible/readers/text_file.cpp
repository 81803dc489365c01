#include "bodies/flexible/readers/text_file.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr std::string_view kWhite = " \t\r\f\v";

std::string quoted(std::string_view token) {
  return "'" + std::string(token.substr(0, 40)) + (token.size() > 40 ? "...'" : "'");
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(kWhite);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kWhite) - first + 1);
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

TextFile::TextFile(std::string path, const std::string& fix) : path_(std::move(path)) {
  std::error_code ignored;
  if (!std::filesystem::exists(path_, ignored)) throw FileError("there is no such file.", path_, fix);
  if (std::filesystem::is_directory(path_, ignored)) throw FileError("this is a folder, not a file.", path_, fix);
  stream_.open(path_);
  if (!stream_) throw FileError("the file cannot be opened.", path_, "check its permissions.");
}

bool TextFile::next() {
  tokens_.clear();
  if (!std::getline(stream_, line_)) {
    if (stream_.bad()) throw FileError("reading failed.", where(), "check the disk or the network.");
    line_.clear();
    return false;
  }
  ++number_;
  cut_ = stream_.eof();
  return true;
}

std::string TextFile::where() const { return path_ + ":" + std::to_string(number_); }

bool TextFile::blank() const { return trimmed(line_).empty(); }

const std::vector<std::string_view>& TextFile::words() {
  tokens_.clear();
  const std::string_view text = line_;
  size_t start = text.find_first_not_of(kWhite);
  while (start != std::string_view::npos) {
    const size_t end = std::min(text.find_first_of(kWhite, start), text.size());
    tokens_.push_back(text.substr(start, end - start));
    start = text.find_first_not_of(kWhite, end);
  }
  return tokens_;
}

const std::vector<std::string_view>& TextFile::fields() {
  tokens_.clear();
  std::string_view rest = line_;
  for (size_t comma = rest.find(','); comma != std::string_view::npos; comma = rest.find(',')) {
    tokens_.push_back(trimmed(rest.substr(0, comma)));
    rest.remove_prefix(comma + 1);
  }
  tokens_.push_back(trimmed(rest));
  return tokens_;
}

double TextFile::number(std::string_view token, std::string_view what) const {
  std::string_view digits = token;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-')
    digits.remove_prefix(1);  // from_chars knows no plus sign
  double value = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (status == std::errc::invalid_argument || end != digits.data() + digits.size())
    fail("the " + std::string(what) + " is " + quoted(token) + ", not a number.",
         "write a decimal number such as 1.5e-3; if the file is cut, export it again.");
  if (status == std::errc::result_out_of_range) {
    // Either too small, which rounds to zero, or too large, which is an error below.
    value = std::strtod(std::string(digits).c_str(), nullptr);
  }
  if (!std::isfinite(value))
    fail("the " + std::string(what) + " is " + quoted(token) + ", not a finite number.",
         "export the file again; the finite-element run has failed.");
  return value;
}

int TextFile::integer(std::string_view token, std::string_view what) const {
  std::string_view digits = token;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  int value = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (status != std::errc() || end != digits.data() + digits.size())
    fail("the " + std::string(what) + " is " + quoted(token) + ", not a whole number.",
         "write a whole number below 2147483648; if the file is cut, export it again.");
  return value;
}

void TextFile::fail(const std::string& problem, const std::string& fix) const {
  throw FileError(problem, where(), fix);
}

}  // namespace lithe
