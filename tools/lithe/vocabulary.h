#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace lithe::command {

/// A field of a parameter struct, as its header declares it.
struct FieldText {
  std::string name, declaration, comment;  // "length", "std::optional<double> length{}", "L, m; none: as drawn"
};

/// The words of a scene: types and their fields, read from the text of the headers and of the scene itself. Serves
/// messages only, so it may know less than the compiler, never something else.
class Vocabulary {
 public:
  void read(const std::filesystem::path& file);

  /// Fields of "DistanceJoint::Parameters" or "ChartLine" in their order; null if there is no such type.
  const std::vector<FieldText>* find_fields(const std::string& type) const;
  bool has_type(const std::string& type) const { return marker_counts_.contains(type); }
  /// Markers of a joint or force; 0 if its header does not say.
  int marker_count(const std::string& type) const;
  /// The element types that resemble a misspelt name most; empty if none does.
  std::string nearest_type(const std::string& word) const;

 private:
  std::map<std::string, std::vector<FieldText>> fields_;
  std::map<std::string, int> marker_counts_;  // every class
};

/// The one of `known` that differs from `word` least, if that is little enough for a slip of the pen; else empty.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

/// Splits at commas outside of brackets and strings: "a, {b, c}" gives "a" and "{b, c}".
std::vector<std::string> split_arguments(const std::string& text);

}  // namespace lithe::command
