#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "engine/base/error.h"
#include "models/xml_file_internal.h"

namespace lithe {
namespace {

constexpr std::uintmax_t kLargest = 64 << 20;

}  // namespace

XmlFile::XmlFile(const std::filesystem::path& path) : path_(path.string()) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error || !std::filesystem::is_regular_file(path))
    throw FileError("there is no such file.", path_, "give the path of a model file.");
  if (size > kLargest) throw FileError("the file is larger than 64 MiB.", path_, "no model is: give another file.");
  std::ifstream file(path, std::ios::binary);
  std::ostringstream all;
  all << file.rdbuf();
  if (!file) throw FileError("the file cannot be read.", path_, "look at its permissions.");
  text_ = all.str();
  for (std::size_t i = 0; i < text_.size(); ++i)
    if (text_[i] == '\n') ends_.push_back(static_cast<std::ptrdiff_t>(i));
  const pugi::xml_parse_result result = document_.load_buffer(text_.data(), text_.size());
  if (!result)
    throw FileError(std::string("the XML is not well-formed: ") + result.description() + ".",
                    path_ + ":" + std::to_string(line_at(result.offset)), "correct the tag there.");
  if (!root()) throw FileError("the file has no element.", path_, "give a model file.");
}

int XmlFile::line_at(std::ptrdiff_t offset) const {
  if (offset < 0) return 0;
  return 1 + static_cast<int>(std::lower_bound(ends_.begin(), ends_.end(), offset) - ends_.begin());
}

int XmlFile::line(const pugi::xml_node& node) const { return line_at(node.offset_debug()); }

void XmlFile::fail(const pugi::xml_node& node, const std::string& problem, const std::string& fix) const {
  throw FileError(problem, path_ + ":" + std::to_string(line(node)), fix);
}

std::string XmlFile::text(const pugi::xml_node& node, const char* attribute) const {
  const std::string value = node.attribute(attribute).as_string();
  if (value.empty())
    fail(node, "<" + std::string(node.name()) + "> has no " + attribute + ".",
         "give it as " + std::string(attribute) + "=\"...\".");
  return value;
}

std::vector<double> XmlFile::numbers(const pugi::xml_node& node, const std::string& what, const std::string& text,
                                     int least, int most) const {
  std::vector<double> all;
  const char *at = text.data(), *end = at + text.size();
  const auto shown = [&] { return what + "=\"" + (text.size() > 60 ? text.substr(0, 60) + "..." : text) + "\""; };
  const auto counted = [&](int count) { return count == 1 ? "a number" : std::to_string(count) + " numbers"; };
  const auto skip = [&] {
    while (at != end && (std::isspace(static_cast<unsigned char>(*at)) || *at == '+')) ++at;
  };
  for (skip(); at != end && static_cast<int>(all.size()) < most; skip()) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    const bool apart = next == end || std::isspace(static_cast<unsigned char>(*next));
    if (error != std::errc() || !std::isfinite(value) || !apart) break;
    all.push_back(value);
    at = next;
  }
  if (static_cast<int>(all.size()) < least || (at != end && static_cast<int>(all.size()) < most))
    fail(node, "<" + shown() + "> is not " + counted(least) + ".", "give finite numbers, separated by spaces.");
  if (at != end)
    fail(node, "<" + shown() + "> has more than " + std::to_string(most) + (most == 1 ? " number." : " numbers."),
         "give " + std::to_string(most) + ".");
  return all;
}

std::vector<double> XmlFile::content(const pugi::xml_node& node, int count) const {
  return numbers(node, node.name(), node.text().as_string(), count, count);
}

double XmlFile::content(const pugi::xml_node& parent, const char* child, double fallback) const {
  const pugi::xml_node node = parent.child(child);
  return node ? content(node, 1)[0] : fallback;
}

double XmlFile::number(const pugi::xml_node& node, const char* attribute, std::optional<double> fallback) const {
  if (!node.attribute(attribute)) {
    if (fallback) return *fallback;
    text(node, attribute);
  }
  return numbers(node, std::string(node.name()) + " " + attribute, node.attribute(attribute).as_string(), 1, 1)[0];
}

Vector3 XmlFile::vector(const pugi::xml_node& node, const char* attribute, const Vector3& fallback) const {
  if (!node.attribute(attribute)) return fallback;
  return Eigen::Map<const Vector3>(
      numbers(node, std::string(node.name()) + " " + attribute, node.attribute(attribute).as_string(), 3, 3).data());
}

}  // namespace lithe
