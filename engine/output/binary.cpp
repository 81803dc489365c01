#include "engine/output/binary.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>
#include <type_traits>

#include "engine/base/fnv1a.h"
#include "engine/output/partial_file.h"

namespace lithe {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie in memory");

constexpr std::string_view kMagic = "LITHETBL";
constexpr std::uint32_t kVersion = 1;

template <class T>
void append(std::string& bytes, T value) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

// Takes pieces off the front of the file; every count is checked against what is left before it is believed.
class Cursor {
 public:
  Cursor(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  std::string_view take(std::uint64_t size) {
    if (size > bytes_.size()) fail("is truncated");
    const std::string_view piece = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return piece;
  }
  template <class T>
  T number() {
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::size_t left() const { return bytes_.size(); }
  [[noreturn]] void fail(const std::string& how) const {
    throw FileError("the binary table " + how + ".", path_, "write it again with write_binary().");
  }

 private:
  std::string_view bytes_;
  const std::string& path_;
};

}  // namespace

void write_binary(const Table& table, const std::string& path) try {
  std::string bytes(kMagic);
  append(bytes, kVersion);
  append(bytes, static_cast<std::uint32_t>(table.columns.size()));
  append(bytes, static_cast<std::uint64_t>(table.row_count()));
  for (const auto& name : table.columns) {
    append(bytes, static_cast<std::uint32_t>(name.size()));
    bytes += name;
  }
  bytes.append(reinterpret_cast<const char*>(table.values.data()), table.values.size() * sizeof(double));
  append(bytes, fnv1a(bytes));

  PartialFile file(path);
  file.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.commit();
} catch (...) {
  rethrow_as_error("writing the file", path, "see what it says; an older file of that name is unharmed");
}

Table read_binary(const std::string& path) try {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw FileError("cannot open the binary table.", path, "check the path and the right to read it.");
  const std::string bytes = (std::ostringstream() << file.rdbuf()).str();
  Cursor cursor(bytes, path);

  if (bytes.substr(0, kMagic.size()) != kMagic) cursor.fail("does not begin with '" + std::string(kMagic) + "'");
  cursor.take(kMagic.size());
  if (const auto version = cursor.number<std::uint32_t>(); version != kVersion)
    cursor.fail("has version " + std::to_string(version) + ", known is " + std::to_string(kVersion));

  const auto columns = cursor.number<std::uint32_t>();
  const auto rows = cursor.number<std::uint64_t>();
  Table table;
  for (std::uint32_t i = 0; i < columns; ++i) table.columns.emplace_back(cursor.take(cursor.number<std::uint32_t>()));

  // Division keeps a damaged row count from overflowing.
  const std::uint64_t row_size = columns * sizeof(double), data_size = cursor.left() - sizeof(std::uint64_t);
  if (cursor.left() < sizeof(std::uint64_t) || (row_size > 0 && rows > data_size / row_size))
    cursor.fail("is truncated");
  if (rows * row_size != data_size) cursor.fail("is longer than its header says");
  table.values.resize(data_size / sizeof(double));
  if (data_size > 0) std::memcpy(table.values.data(), cursor.take(data_size).data(), data_size);

  if (cursor.number<std::uint64_t>() != fnv1a(std::string_view(bytes).substr(0, bytes.size() - sizeof(std::uint64_t))))
    cursor.fail("is damaged: its checksum does not fit");
  return table;
} catch (...) {
  rethrow_as_error("reading the file", path, "see what it says");
}

}  // namespace lithe
