#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "engine/model/state.h"

namespace lithe {

/// The content of a checkpoint: numbers, integers and texts by name, bit for bit. A class saves and loads its history
/// in one function:
///   archive("h", h_);   archive("past", past_);   archive.group("starter", [&] { starter_->history(...); });
/// Loading throws FileError where a name is missing, or holds another kind of thing or another size than the class
/// works with (vectors that have a size keep it; empty ones take any).
class Archive {
 public:
  /// Empty, for saving.
  explicit Archive(std::string source = "memory") : source_(std::move(source)) {}

  bool loads() const { return loads_; }
  /// Switches from saving to loading.
  void rewind() { loads_ = true, prefix_.clear(); }
  /// Its source, for messages.
  const std::string& source() const { return source_; }

  /// What `visit` names lies below this name.
  template <class Visit>
  void group(std::string_view name, Visit&& visit) {
    const std::size_t size = prefix_.size();
    prefix_.append(name) += '/';
    visit();
    prefix_.resize(size);
  }

  void operator()(std::string_view name, double& value) { number(name, &value, 1, 1); }
  void operator()(std::string_view name, std::string& value);
  void operator()(std::string_view name, std::vector<double>& values);
  void operator()(std::string_view name, std::vector<int>& values);
  void operator()(std::string_view name, std::vector<std::string>& values);
  void operator()(std::string_view name, State& state);
  void operator()(std::string_view name, ContactMemory& memory);
  /// A struct that names its own members.
  template <class Kept>
  requires requires(Kept& kept, Archive& archive, std::string_view name) { kept.keep(archive, name); }
  void operator()(std::string_view name, Kept& kept) { kept.keep(*this, name); }
  template <class Integer>
  requires(std::is_integral_v<Integer> || std::is_enum_v<Integer>) void operator()(std::string_view name,
                                                                                   Integer& value) {
    auto wide = static_cast<std::int64_t>(value);
    integer(name, &wide, 1);
    if (loads_) value = static_cast<Integer>(wide);
  }
  template <class Number, std::size_t n>
  requires(!std::is_same_v<Number, std::string>) void operator()(std::string_view name, std::array<Number, n>& values) {
    if constexpr (std::is_same_v<Number, double>) {
      number(name, values.data(), n, 1);
    } else {
      std::array<std::int64_t, n> wide{};
      for (std::size_t i = 0; i < n; ++i) wide[i] = static_cast<std::int64_t>(values[i]);
      integer(name, wide.data(), n);
      for (std::size_t i = 0; loads_ && i < n; ++i) values[i] = static_cast<Number>(wide[i]);
    }
  }
  /// Vectors and matrices of Eigen.
  template <class Matrix>
  void operator()(std::string_view name, Eigen::PlainObjectBase<Matrix>& matrix) {
    if (loads_) {
      const auto [rows, columns] = extent(name);
      if (matrix.size() == 0 && rows * columns > 0 && fits<Matrix>(rows, columns)) matrix.resize(rows, columns);
    }
    number(name, matrix.data(), matrix.rows(), matrix.cols());
  }

  /// A parameter, which must not differ when loading: SceneError names both values.
  void same(std::string_view name, double value);
  void same(std::string_view name, const std::string& value);

  // ---- to and from files and plug-ins ----
  struct Content {
    std::vector<std::string> names, texts;
    std::vector<int> shapes;  // of each name: kind, rows, columns
    std::vector<double> numbers;
    std::vector<int> integers;  // of 64 bits, in halves
  };
  const Content& content() const { return content_; }
  /// For loading. Throws FileError for incomplete content.
  Archive(std::string source, Content content);
  /// The same as bytes of this machine, for a plug-in without files.
  std::vector<unsigned char> bytes() const;
  static Archive of_bytes(std::string source, const unsigned char* bytes, std::size_t size);

 private:
  enum Kind { kNumber, kInteger, kText };
  struct Entry {
    Kind kind;
    std::int64_t rows, columns;
    std::size_t first;  // in its array
  };
  template <class Matrix>
  static bool fits(std::int64_t rows, std::int64_t columns) {
    constexpr auto kDynamic = Eigen::Dynamic;
    return (Matrix::RowsAtCompileTime == kDynamic || Matrix::RowsAtCompileTime == rows) &&
           (Matrix::ColsAtCompileTime == kDynamic || Matrix::ColsAtCompileTime == columns);
  }
  std::string path(std::string_view name) const { return prefix_ + std::string(name); }
  void add(std::string_view name, Kind kind, std::int64_t rows, std::int64_t columns);
  const Entry& find(std::string_view name, Kind kind) const;
  std::pair<std::int64_t, std::int64_t> extent(std::string_view name) const;
  void number(std::string_view name, double* values, std::int64_t rows, std::int64_t columns);
  void integer(std::string_view name, std::int64_t* values, std::int64_t count);
  [[noreturn]] void refuse(std::string_view name, const std::string& problem) const;

  std::string source_, prefix_;
  bool loads_ = false;
  Content content_;
  std::map<std::string, Entry> entries_;
};

}  // namespace lithe
