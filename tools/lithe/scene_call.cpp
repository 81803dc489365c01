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

/// The source as one text, and the place in it that the compiler names.
struct Place {
  std::string text;
  std::size_t at = 0;

  Place(const std::vector<std::string>& source, int line, int column) {
    for (int i = 0; i < static_cast<int>(source.size()); ++i) {
      if (i + 1 == line) at = text.size() + static_cast<std::size_t>(column - 1);
      text += source[i] + "\n";
    }
  }
};

/// The bracketed text that begins (or ends) there, without its brackets; empty if there is none.
std::string bracketed(const std::string& text, std::size_t at) {
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

/// What is wrong with the first of a call's arguments that is such a list of fields.
std::optional<Explanation> explain_arguments(const std::string& call, const std::string& type,
                                             const Vocabulary& vocabulary) {
  for (const std::string& argument : split_arguments(call))
    if (const auto found = explain_fields(argument, type, vocabulary)) return found;
  return std::nullopt;
}

Explanation explain_constructor(const std::string& type, const std::string& call, const Vocabulary& vocabulary) {
  const std::string parameters = type + "::Parameters";
  if (const auto found = explain_arguments(call, parameters, vocabulary)) return *found;
  const std::vector<FieldText>* fields = vocabulary.find_fields(parameters);
  return {"the arguments do not fit " + type,
          fields ? "the fields of its parameters are:" + declarations_of(*fields) : ""};
}

/// GCC's words, which name the type that is called. nullopt: none that we know.
std::optional<Explanation> explain_gcc(const std::string& message, const Place& place, const Vocabulary& vocabulary) {
  std::smatch match;
  // graph.add<T>(...): the caret is at a bracket
  static const std::regex add(R"(no matching function for call to '.*SystemGraph::add<(?:\w+::)*(\w+)>\(.*)");
  if (std::regex_match(message, match, add)) return explain_add(match[1], bracketed(place.text, place.at), vocabulary);

  // T integrator{{.step = ...}}: the caret is at the last brace
  static const std::regex made(R"(no matching function for call to '(?:lithe::)?((?:\w+::)*)(\w+)::\2\(.*)");
  if (std::regex_match(message, match, made) && vocabulary.find_fields(match[2].str() + "::Parameters"))
    return explain_constructor(match[2], bracketed(place.text, place.at), vocabulary);

  static const std::regex order(R"(designator order for field '(?:lithe::)?([\w:]+)::(\w+)' does not match .*)");
  if (std::regex_match(message, match, order))
    if (const auto* fields = vocabulary.find_fields(match[1])) return too_late(match[1], match[2], *fields);

  // write_chart({.titel = ...}, ...)
  static const std::regex no_conversion(
      R"(could not convert '([\s\S]*)' from '<brace-enclosed .*>' to '(?:const )?(?:lithe::)?([\w:]+)&?')");
  if (std::regex_match(message, match, no_conversion))
    return explain_arguments(bracketed(place.text, place.at), match[2], vocabulary);
  return std::nullopt;
}

/// Clang's, which name the function alone; the caret is at the name, and the type stands in the source.
std::optional<Explanation> explain_clang(const std::string& message, const Place& place, const Vocabulary& vocabulary) {
  const std::string& text = place.text;
  const auto call_at = [&](std::size_t at) {
    const std::size_t open = text.find_first_of("({", at);
    return open == std::string::npos ? "" : bracketed(text, open);
  };
  static const std::regex call_of_add(R"(^add<(?:\w+::)*(\w+)>)");
  const auto add_at = [&](std::size_t at) -> std::optional<Explanation> {
    std::smatch match;
    const std::string rest = text.substr(std::min(at, text.size()));
    if (!std::regex_search(rest, match, call_of_add)) return std::nullopt;
    return explain_add(match[1], call_at(at), vocabulary);
  };

  if (message == "no matching member function for call to 'add'") return add_at(place.at);

  std::smatch match;
  static const std::regex made(R"(no matching constructor for initialization of '(?:const )?(?:lithe::)?([\w:]+)')");
  if (std::regex_match(message, match, made) && vocabulary.find_fields(match[1].str() + "::Parameters"))
    return explain_constructor(match[1], call_at(place.at), vocabulary);

  // Clang itself would only warn; scene_cache.cpp makes an error of it, as it is to GCC.
  static const std::regex order(R"(ISO C\+\+ requires field designators .*; field '(\w+)' will be .*)");
  if (std::regex_match(message, match, order)) {
    const std::size_t add = text.rfind("add<", place.at);
    if (const auto found = add == std::string::npos ? std::nullopt : add_at(add)) return found;
    return Explanation{"field '" + match[1].str() + "' comes too early", "C++ wants the fields as they are declared"};
  }

  // write_chart({.titel = ...}, ...): compiler_messages.cpp appends the type, which Clang's note names
  static const std::regex no_conversion(
      R"(no matching function for call to '\w+'; its list is no (?:lithe::)?([\w:]+))");
  if (std::regex_match(message, match, no_conversion))
    return explain_arguments(call_at(place.at), match[1], vocabulary);
  return std::nullopt;
}

}  // namespace

Explanation explain_call(const std::string& message, const std::vector<std::string>& source, int line, int column,
                         const Vocabulary& vocabulary) {
  const Place place(source, line, column);
  if (const auto found = explain_gcc(message, place, vocabulary)) return *found;
  if (const auto found = explain_clang(message, place, vocabulary)) return *found;

  std::smatch match;
  // ChartLine{.titel = ...}
  static const std::regex no_member(R"('(?:lithe::)?([\w:]+)' has no non-static data member named '(\w+)')");
  if (std::regex_match(message, match, no_member))
    if (const auto* fields = vocabulary.find_fields(match[1])) return unknown_field(match[1], match[2], *fields);
  static const std::regex no_field(
      R"(field designator '(\w+)' does not refer to any field in type '(?:lithe::)?([\w:]+)'.*)");
  if (std::regex_match(message, match, no_field))
    if (const auto* fields = vocabulary.find_fields(match[2])) return unknown_field(match[2], match[1], *fields);

  // an unknown name, by GCC and by Clang
  static const std::regex undeclared(R"('(\w+)' (?:was not declared in this scope|does not name a type)(.*))");
  static const std::regex unknown(R"((?:use of undeclared identifier|unknown type name) '(\w+)'(.*))");
  if (std::regex_match(message, match, undeclared) || std::regex_match(message, match, unknown)) {
    const std::string word = match[1], guess = vocabulary.nearest_type(word);
    if (vocabulary.has_type(word) || word == "assemble")
      return {"'" + word + "' is not known here",
              "#include \"lithe/lithe.h\" and write  using namespace lithe;  above"};
    const bool may_be_type = std::isupper(static_cast<unsigned char>(word[0])) && !guess.empty();
    // The compiler's own guess, if any, is the same: else it knows a nearer name.
    if (may_be_type && (match[2].length() == 0 || match[2].str().find("'" + guess + "'") != std::string::npos))
      return {"there is no type '" + word + "'", "did you mean '" + guess + "'?"};
    return {"'" + word + "' is not declared" + plain(match[2]), ""};
  }
  return {plain(message), ""};
}

}  // namespace lithe::command
