#include "tools/lithe/scene_call.h"

#include <algorithm>
#include <optional>
#include <regex>

namespace lithe::command {
namespace {

std::string plain(std::string text) {
  static const std::regex space(R"(\blithe::)");
  return std::regex_replace(text, space, "");
}

/// The bracketed text that begins (or ends) at a place, without its brackets; empty if there is none.
std::string bracketed(const std::vector<std::string>& source, int line, int column) {
  std::string text;
  std::size_t at = 0;
  for (int i = 0; i < static_cast<int>(source.size()); ++i) {
    if (i + 1 == line) at = text.size() + static_cast<std::size_t>(column - 1);
    text += source[i] + "\n";
  }
  if (at >= text.size()) return "";
  const bool backwards = text[at] == ')' || text[at] == '}';
  int depth = 0;
  for (std::size_t i = at; i < text.size(); backwards ? --i : ++i) {
    if (text[i] == '(' || text[i] == '{') ++depth;
    if (text[i] == ')' || text[i] == '}') --depth;
    if (depth == 0) return i == at ? "" : text.substr(std::min(i, at) + 1, std::max(i, at) - std::min(i, at) - 1);
    if (i == 0) break;
  }
  return "";
}

std::string list_of(const std::vector<FieldText>& fields) {
  std::string list;
  for (const FieldText& field : fields) list += (list.empty() ? "" : ", ") + field.name;
  return list;
}

/// The fields with units and defaults, as their header declares them.
std::string declarations_of(const std::vector<FieldText>& fields) {
  std::string text;
  for (const FieldText& field : fields)
    text += "\n          " + field.declaration + (field.comment.empty() ? "" : "  // " + field.comment);
  return text;
}

Explanation unknown_field(const std::string& type, const std::string& word, const std::vector<FieldText>& fields) {
  std::vector<std::string> names;
  for (const FieldText& field : fields) names.push_back(field.name);
  const std::string guess = nearest(word, names);
  return {type + " has no field '" + word + "'; its fields are: " + list_of(fields),
          guess.empty() ? "use one of them:" + declarations_of(fields) : "did you mean '" + guess + "'?"};
}

Explanation too_late(const std::string& type, const std::string& word, const std::vector<FieldText>& fields) {
  return {"field '" + word + "' of " + type + " comes too late",
          "C++ wants the fields once each and in this order: " + list_of(fields)};
}

/// What is wrong with "{.length = 0.5, ...}" as parameters of that type.
std::optional<Explanation> explain_fields(const std::string& braced, const std::string& type,
                                          const Vocabulary& vocabulary) {
  const std::vector<FieldText>* fields = vocabulary.find_fields(type);
  if (!fields || !braced.starts_with('{') || !braced.ends_with('}')) return std::nullopt;
  static const std::regex designated(R"(^\.(\w+)[\s\S]*)");
  int last = -1;
  for (const std::string& part : split_arguments(braced.substr(1, braced.size() - 2))) {
    std::smatch match;
    if (!std::regex_match(part, match, designated)) continue;
    const std::string word = match[1];
    const auto at = std::find_if(fields->begin(), fields->end(), [&](const FieldText& f) { return f.name == word; });
    if (at == fields->end()) return unknown_field(type, word, *fields);
    const int place = static_cast<int>(at - fields->begin());
    if (place <= last) return too_late(type, word, *fields);
    last = place;
  }
  if (last < 0) return std::nullopt;
  return Explanation{"a value does not fit its field of " + type, "the fields are:" + declarations_of(*fields)};
}

Explanation explain_add(const std::string& type, const std::string& call, const Vocabulary& vocabulary) {
  const std::vector<std::string> arguments = split_arguments(call);
  const std::string parameters = type + "::Parameters";
  const std::vector<FieldText>* fields = vocabulary.find_fields(parameters);
  const int markers = vocabulary.marker_count(type);
  const std::string form = "graph.add<" + type + ">(\"name\"" +
                           (markers == 0   ? std::string(fields ? ", {.field = value}" : "")
                            : markers == 1 ? std::string(", {A}")
                                           : std::string(", {A, B") + (markers > 2 ? ", ...}" : "}")) +
                           (markers > 0 && fields ? ", {.field = value})" : ")");

  // A name, then markers, then parameters; bodies have no markers of their own to give.
  if (arguments.empty() || arguments[0].starts_with('{'))
    return {"this " + type + " has no name", "name, markers, parameters: " + form};
  const std::string last = arguments.back();
  static const std::regex designated(R"(^\{\s*\.[\s\S]*)");
  const bool has_parameters = arguments.size() > 1 && std::regex_match(last, designated);
  if (markers > 0 && arguments.size() == (has_parameters ? 2u : 1u))
    return {type + " '" + arguments[0] + "' has no markers: it needs " + std::to_string(markers),
            "name, markers, parameters: " + form};
  if (has_parameters) {
    if (!fields) return {type + " takes no parameters", form};
    if (const auto found = explain_fields(last, parameters, vocabulary)) return *found;
  }
  if (markers > 0)
    return {"the arguments do not fit " + type, "it needs " + std::to_string(markers) +
                                                    " markers, made by body.marker(...): " + form +
                                                    (fields ? "\n        its fields:" + declarations_of(*fields) : "")};
  return {"the arguments do not fit " + type,
          form + (fields ? "\n        its fields:" + declarations_of(*fields) : "")};
}

}  // namespace

Explanation explain_call(const std::string& message, const std::vector<std::string>& source, int line, int column,
                         const Vocabulary& vocabulary) {
  std::smatch match;
  // graph.add<T>(...)
  static const std::regex add(R"(no matching function for call to '.*SystemGraph::add<(?:\w+::)*(\w+)>\(.*)");
  if (std::regex_match(message, match, add)) return explain_add(match[1], bracketed(source, line, column), vocabulary);

  // T integrator{{.step = ...}}: the caret is at the last brace
  static const std::regex made(R"(no matching function for call to '(?:lithe::)?((?:\w+::)*)(\w+)::\2\(.*)");
  if (std::regex_match(message, match, made)) {
    const std::string type = match[2];
    for (const std::string& argument : split_arguments(bracketed(source, line, column)))
      if (const auto found = explain_fields(argument, type + "::Parameters", vocabulary)) return *found;
    if (const auto* fields = vocabulary.find_fields(type + "::Parameters"))
      return {"the arguments do not fit " + type, "the fields of its parameters are:" + declarations_of(*fields)};
  }

  static const std::regex order(R"(designator order for field '(?:lithe::)?([\w:]+)::(\w+)' does not match .*)");
  if (std::regex_match(message, match, order))
    if (const auto* fields = vocabulary.find_fields(match[1])) return too_late(match[1], match[2], *fields);

  // ChartLine{.titel = ...}
  static const std::regex no_member(R"('(?:lithe::)?([\w:]+)' has no non-static data member named '(\w+)')");
  if (std::regex_match(message, match, no_member))
    if (const auto* fields = vocabulary.find_fields(match[1])) return unknown_field(match[1], match[2], *fields);

  // write_chart({.titel = ...}, ...)
  static const std::regex no_conversion(
      R"(could not convert '([\s\S]*)' from '<brace-enclosed .*>' to '(?:const )?(?:lithe::)?([\w:]+)&?')");
  if (std::regex_match(message, match, no_conversion))
    for (const std::string& argument : split_arguments(bracketed(source, line, column)))
      if (const auto found = explain_fields(argument, match[2], vocabulary)) return *found;

  // an unknown type
  static const std::regex undeclared(R"('(\w+)' (?:was not declared in this scope|does not name a type)(.*))");
  if (std::regex_match(message, match, undeclared)) {
    const std::string word = match[1], guess = vocabulary.nearest_type(word);
    if (vocabulary.has_type(word) || word == "assemble")
      return {"'" + word + "' is not known here",
              "#include \"lithe/lithe.h\" and write  using namespace lithe;  above"};
    if (match[2].length() == 0 && !guess.empty() && std::isupper(static_cast<unsigned char>(word[0])))
      return {"there is no type '" + word + "'", "did you mean '" + guess + "'?"};
  }
  return {plain(message), ""};
}

}  // namespace lithe::command
