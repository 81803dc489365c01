#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/math.h"

namespace lithe::adams {

/// One argument of a statement: NAME = value, value ..., or a name alone.
struct Argument {
  std::string name;                 // upper case; empty: a value alone
  std::vector<std::string> values;  // as written, trimmed
  int line = 0;
};

/// NAME/id, arguments. Knows what was asked for, so that what was not can be told.
struct Statement {
  std::string keyword;  // whole, upper case
  int id = 0;           // 0: none
  int line = 0;
  std::vector<Argument> arguments;
  std::string name() const { return keyword + "/" + (id > 0 ? std::to_string(id) : ""); }
};

/// The statements of a data set, keywords and argument names complete. Throws FileError, naming the line.
struct DataSet {
  std::string path, title;
  std::vector<Statement> statements;

  explicit DataSet(const std::filesystem::path& path);
  [[noreturn]] void fail(int line, const std::string& problem, const std::string& fix) const;
};

/// Arguments of one statement by name.
class Arguments {
 public:
  Arguments(const DataSet& file, const Statement& statement) : file_(file), statement_(statement) {}

  [[noreturn]] void fail(const std::string& problem, const std::string& fix) const;
  const Argument* find(const std::string& name) const;
  bool has(const std::string& name) const { return find(name) != nullptr; }
  /// Whole numbers above zero.
  int identifier(const std::string& name) const;
  std::optional<int> identifier_if(const std::string& name) const;
  std::vector<int> identifiers(const std::string& name, int least, int most) const;
  /// Numbers; 90D is an angle in degrees, turned to radians.
  double number(const std::string& name, std::optional<double> fallback = {}) const;
  std::vector<double> numbers(const std::string& name, int least, int most) const;
  Vector3 vector(const std::string& name, const Vector3& fallback) const;
  /// The text of a function or comment.
  std::string text(const std::string& name) const;
  double to_number(const std::string& text) const;

 private:
  const DataSet& file_;
  const Statement& statement_;
};

}  // namespace lithe::adams
