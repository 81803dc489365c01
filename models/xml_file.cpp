#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "engine/base/error.h"
#include "models/xml_file_internal.h"

namespace lithe {
namespace {

constexpr std::uintmax_t kLargest = 64 << 20;

int line_of(const std::string& text, std::ptrdiff_t offset) {
  if (offset < 0) return 0;
  const auto end = text.begin() + std::min<std::ptrdiff_t>(offset, static_cast<std::ptrdiff_t>(text.size()));
  return 1 + static_cast<int>(std::count(text.begin(), end, '\n'));
}

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
  const pugi::xml_parse_result result = document_.load_buffer(text_.data(), text_.size());
  if (!result)
    throw FileError(std::string("the XML is not well-formed: ") + result.description() + ".",
                    path_ + ":" + std::to_string(line_of(text_, result.offset)), "correct the tag there.");
  if (!root()) throw FileError("the file has no element.", path_, "give a model file.");
}

int XmlFile::line(const pugi::xml_node& node) const { return line_of(text_, node.offset_debug()); }

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

void XmlFile::numbers(const pugi::xml_node& node, const char* attribute, double* out, int count) const {
  const std::string value = node.attribute(attribute).as_string();
  const char *at = value.data(), *end = at + value.size();
  const auto skip = [&] {
    while (at != end && (std::isspace(static_cast<unsigned char>(*at)) || *at == '+')) ++at;
  };
  for (int i = 0; i < count; ++i) {
    skip();
    const auto [next, error] = std::from_chars(at, end, out[i]);
    if (error != std::errc() || !std::isfinite(out[i]))
      fail(node,
           "<" + std::string(node.name()) + " " + attribute + "=\"" + value + "\"> is not " +
               (count == 1 ? "a number" : std::to_string(count) + " numbers") + ".",
           "give finite numbers, separated by spaces.");
    at = next;
  }
  skip();
  if (at != end)
    fail(node,
         "<" + std::string(node.name()) + " " + attribute + "=\"" + value + "\"> has more than " +
             std::to_string(count) + (count == 1 ? " number." : " numbers."),
         "give " + std::to_string(count) + ".");
}

double XmlFile::number(const pugi::xml_node& node, const char* attribute, std::optional<double> fallback) const {
  if (!node.attribute(attribute)) {
    if (fallback) return *fallback;
    text(node, attribute);
  }
  double value = 0;
  numbers(node, attribute, &value, 1);
  return value;
}

Vector3 XmlFile::vector(const pugi::xml_node& node, const char* attribute, const Vector3& fallback) const {
  if (!node.attribute(attribute)) return fallback;
  Vector3 value;
  numbers(node, attribute, value.data(), 3);
  return value;
}

}  // namespace lithe
