#pragma once

#include <filesystem>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// An XML file whose errors name the line.
class XmlFile {
 public:
  /// Throws FileError for a file that is missing, larger than 64 MiB, or not well-formed.
  explicit XmlFile(const std::filesystem::path& path);

  pugi::xml_node root() const { return document_.document_element(); }
  const std::string& path() const { return path_; }
  int line(const pugi::xml_node& node) const;
  /// Throws FileError at the node's line.
  [[noreturn]] void fail(const pugi::xml_node& node, const std::string& problem, const std::string& fix) const;

  /// The text of an attribute that must be there and not be empty.
  std::string text(const pugi::xml_node& node, const char* attribute) const;
  /// Numbers of an attribute; the fallback if it is not there. Fails for text that is no number, another count, and
  /// what is not finite.
  double number(const pugi::xml_node& node, const char* attribute, std::optional<double> fallback = {}) const;
  Vector3 vector(const pugi::xml_node& node, const char* attribute, const Vector3& fallback) const;
  /// The numbers in a text of this node, least to most of them; `what` names the text in errors.
  std::vector<double> numbers(const pugi::xml_node& node, const std::string& what, const std::string& text, int least,
                              int most) const;
  /// Numbers between the tags of a node.
  std::vector<double> content(const pugi::xml_node& node, int count) const;
  double content(const pugi::xml_node& parent, const char* child, double fallback) const;

  int line_at(std::ptrdiff_t offset) const;

  std::string path_, text_;
  std::vector<std::ptrdiff_t> ends_;  // of the lines
  pugi::xml_document document_;
};

}  // namespace lithe
