#pragma once

#include <filesystem>
#include <optional>
#include <pugixml.hpp>
#include <string>

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

 private:
  void numbers(const pugi::xml_node& node, const char* attribute, double* out, int count) const;

  std::string path_, text_;
  pugi::xml_document document_;
};

}  // namespace lithe
