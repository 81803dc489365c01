#include "tools/lithe/vocabulary.h"

#include <algorithm>
#include <fstream>
#include <numeric>
#include <regex>
#include <utility>

namespace lithe::command {
namespace {

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\n");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\n") - first + 1);
}

int edit_distance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = std::exchange(row[0], static_cast<int>(i));
    for (std::size_t j = 1; j <= b.size(); ++j)
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])}));
  }
  return row.back();
}

/// "double kinetic = 0, elastic = 0;  // J" gives two fields; a function, a using or an enum gives none.
std::vector<FieldText> fields_of_line(const std::string& line) {
  const auto slashes = line.find("//");
  const std::string comment = slashes == std::string::npos ? "" : trimmed(line.substr(slashes + 2));
  std::string code = trimmed(line.substr(0, slashes));
  static const std::regex no_field(R"(^(static|using|enum|struct|class|friend|typedef|explicit|template|return)\b.*)");
  static const std::regex field(R"(^(.*[\w>&*]\s+[&*]*)?(\w+)\s*(=.*|\{.*\})?$)");
  if (!code.ends_with(';') || std::regex_match(code, no_field)) return {};
  code.pop_back();
  std::vector<FieldText> fields;
  for (const std::string& part : split_arguments(code)) {
    std::smatch match;
    if (!std::regex_match(part, match, field) || (fields.empty() && !match[1].matched)) return {};
    fields.push_back({match[2], part, comment});
  }
  return fields;
}

}  // namespace

std::string nearest(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  int least = 1 + std::max(1, static_cast<int>(word.size()) / 3);
  for (const std::string& candidate : known)
    if (const int distance = edit_distance(word, candidate); distance < least) least = distance, best = candidate;
  return best;
}

std::vector<std::string> split_arguments(const std::string& text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote) {
      if (c == '\\' && i + 1 < text.size())
        parts.back() += text[i++];
      else if (c == quote)
        quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (std::string("({[<").find(c) != std::string::npos) {
      ++depth;
    } else if (std::string(")}]").find(c) != std::string::npos ||
               (c == '>' && depth > 0 && i > 0 && text[i - 1] != '-')) {
      --depth;
    } else if (c == ',' && depth == 0) {
      parts.emplace_back();
      continue;
    }
    parts.back() += text[i];
  }
  for (std::string& part : parts) part = trimmed(part);
  if (parts.back().empty()) parts.pop_back();
  return parts;
}

void Vocabulary::read(const std::filesystem::path& file) {
  static const std::regex opens(R"(^\s*(?:template\s*<[^>]*>\s*)?(class|struct)\s+(\w+)[^;(]*\{.*)");
  static const std::regex markers(R"(\b(?:Joint|Force|Constraint)<\s*(?:/\*.*?\*/)?\s*(\d+))");
  struct Open {
    std::string name;
    int depth;
  };
  std::vector<Open> open;
  int depth = 0;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    const std::string code = line.substr(0, line.find("//"));
    std::smatch match;
    const bool is_type = std::regex_match(code, match, opens);
    if (is_type) {
      const std::string name = match[2];
      const bool nested = !open.empty() && open.back().depth == depth;
      std::smatch count;
      const bool counted = std::regex_search(code, count, markers);
      open.push_back({nested ? open.back().name + "::" + name : name, depth + 1});
      if (!nested) marker_counts_[name] = counted ? std::stoi(count[1]) : 0;
    }
    // One line may hold a whole struct: "struct Parameters { double length = 1.0; };"
    const auto brace = code.find('{');
    const bool whole = is_type && code.find("};") != std::string::npos;
    if (whole) {
      std::string body = code.substr(brace + 1, code.rfind('}') - brace - 1);
      for (std::size_t end; (end = body.find(';')) != std::string::npos; body = body.substr(end + 1))
        for (const FieldText& field : fields_of_line(body.substr(0, end + 1)))
          fields_[open.back().name].push_back(field);
    } else if (!is_type && !open.empty() && open.back().depth == depth) {
      for (const FieldText& field : fields_of_line(line)) fields_[open.back().name].push_back(field);
    }
    depth += static_cast<int>(std::count(code.begin(), code.end(), '{') - std::count(code.begin(), code.end(), '}'));
    while (!open.empty() && depth < open.back().depth) open.pop_back();
  }
}

const std::vector<FieldText>* Vocabulary::find_fields(const std::string& type) const {
  const auto at = fields_.find(type);
  return at == fields_.end() ? nullptr : &at->second;
}

int Vocabulary::marker_count(const std::string& type) const {
  const auto at = marker_counts_.find(type);
  return at == marker_counts_.end() ? 0 : at->second;
}

std::string Vocabulary::nearest_type(const std::string& word) const {
  std::vector<std::string> types;
  for (const auto& [type, count] : marker_counts_) types.push_back(type);
  return nearest(word, types);
}

}  // namespace lithe::command
