#include "engine/plugin/plugin_type.h"

#include <algorithm>
#include <cstring>
#include <set>
#include <span>

#include "engine/base/error.h"

namespace lithe {
namespace {

/// Letters to insert, delete or exchange to make one word the other (Levenshtein 1966).
size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t exchanged = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, exchanged});
    }
  }
  return row[b.size()];
}

const char* kind_in_words(size_t kind) {
  constexpr const char* kWords[] = {"a number", "a text", "a vector"};
  return kind < std::size(kWords) ? kWords[kind] : "of an unknown kind";
}

/// One parameter as C sees it; it borrows the texts and vectors of `given`.
lithe_parameter as_c(const Parameter& given) {
  lithe_parameter p{given.name.c_str(), static_cast<int32_t>(given.value.index()), 0, 0, nullptr, nullptr};
  if (const auto* number = std::get_if<double>(&given.value)) p.number = *number;
  if (const auto* text = std::get_if<std::string>(&given.value)) p.text = text->c_str();
  if (const auto* vector = std::get_if<std::vector<double>>(&given.value)) {
    p.vector = vector->data();
    p.size = static_cast<int32_t>(vector->size());
  }
  return p;
}

void check(const lithe_field& field, const lithe_parameter& given, const std::string& type) {
  const std::string which = "parameter '" + std::string(field.name) + "' of " + type;
  if (field.kind != given.kind)
    throw SceneError(which + " is given as " + kind_in_words(given.kind), "",
                     std::string("give ") + kind_in_words(field.kind));
  if (field.kind == LITHE_VECTOR && field.size > 0 && field.size != given.size)
    throw SceneError(which + " is given " + std::to_string(given.size) + " numbers", "",
                     "give " + std::to_string(field.size));
}

}  // namespace

std::string name_hint(const std::string& wrong, const std::vector<std::string>& known) {
  if (known.empty()) return "there are none";
  std::string all;
  const std::string* nearest = &known.front();
  for (const std::string& name : known) {
    all += (all.empty() ? "" : ", ") + name;
    if (edit_distance(wrong, name) < edit_distance(wrong, *nearest)) nearest = &name;
  }
  const bool near = edit_distance(wrong, *nearest) <= std::max<size_t>(2, wrong.size() / 3);
  return (near ? "did you mean '" + *nearest + "'? " : "") + "known are " + all;
}

std::string ErrorText::all() const { return {text, strnlen(text, sizeof text)}; }  // its end may be missing

std::string ErrorText::problem() const {
  const std::string all = this->all();
  return all.empty() ? "it gave no reason" : all.substr(0, all.find('\n'));
}

std::string ErrorText::fix() const {
  const std::string all = this->all();
  const size_t at = all.find('\n');
  return at == std::string::npos ? "" : all.substr(at + 1);
}

std::string PluginObject::describe(const char* kind, const std::string& name, const PluginLibrary* library) {
  return std::string(kind) + " type '" + name + "'" + (library ? " of " + library->path().filename().string() : "");
}

void* PluginObject::make(const lithe_field* fields, size_t field_count,
                         void* (*create)(const lithe_parameter*, size_t, char*, size_t),
                         const ParameterList& parameters) const {
  std::vector<lithe_parameter> given;
  std::set<std::string> names;
  for (const Parameter& p : parameters) {
    const auto all = std::span(fields, field_count);
    const auto field = std::find_if(all.begin(), all.end(), [&](const lithe_field& f) { return p.name == f.name; });
    if (field == all.end()) {
      std::vector<std::string> known;
      for (const lithe_field& f : all) known.emplace_back(f.name);
      throw SceneError(description_ + " has no parameter '" + p.name + "'", "", name_hint(p.name, known));
    }
    if (!names.insert(p.name).second)
      throw SceneError("parameter '" + p.name + "' of " + description_ + " is given twice", "", "give it once");
    given.push_back(as_c(p));
    check(*field, given.back(), description_);
  }
  ErrorText why;
  void* object = create(given.data(), given.size(), why.text, sizeof why.text);
  if (!object)
    throw SceneError(description_ + " refuses: " + why.problem(), "",
                     why.fix().empty() ? "see what its author says of its parameters" : why.fix());
  return object;
}

void PluginObject::fail(const Element& element, const ErrorText& why) const {
  throw SimulationError("'" + element.name() + "': " + description_ + " failed: " + why.problem(), element.where(),
                        why.fix().empty() ? "see what its author says; the state reached before is kept" : why.fix());
}

}  // namespace lithe
