#include "bodies/flexible/readers/nastran_op4.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "bodies/flexible/readers/fixed_columns.h"
#include "bodies/flexible/readers/matrix_entries.h"
#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace lithe {
namespace {

constexpr const char* kOp4Export = "write K and M again by OUTPUT4.";
constexpr long kNonBigmatRows = 65536;  // beyond this a row does not fit into half a word
constexpr long kLargestNumber = 1'000'000'000'000;

struct Header {
  std::string name;
  long columns = 0, rows = 0, form = 0, type = 0;
  bool bigmat = false;
  bool wanted() const { return rows == columns && type <= 2; }
  long numbers_a_value() const { return type > 2 ? 2 : 1; }
};

/// First row of a column (0: it is sparse), and its length: numbers, or words in a sparse or binary column.
struct Column {
  long number = 0, first_row = 0, length = 0;
};

/// A run of numbers in a sparse column. BIGMAT: length and first row, a word each; else both in one word.
struct Run {
  long first_row = 0, words = 0, header_words = 0;
};
Run long_header(long length, long first_row) { return {first_row, length - 1, 2}; }
Run short_header(long both) { return {both % kNonBigmatRows, both / kNonBigmatRows - 1, 1}; }

/// What the text and the binary file have in common; they differ in how numbers are fetched.
class Source {
 public:
  virtual ~Source() = default;
  virtual bool next_header(Header& header) = 0;  // false: the file ends here
  virtual Column next_column() = 0;
  virtual Run run_header(bool bigmat) = 0;
  virtual void values(long count, std::vector<double>& out) = 0;  // what follows the header of a column or run
  virtual void end_column() = 0;                                  // checks that nothing is left
  virtual void skip_last() = 0;                                   // the number that closes a matrix
  virtual long words_a_number() const = 0;                        // as the length of a sparse column counts them
  virtual bool length_in_words() const = 0;                       // of a dense column
  [[noreturn]] virtual void fail(const std::string& problem, const std::string& fix) const = 0;
};

class TextSource final : public Source {
 public:
  explicit TextSource(const std::string& path) : file_(path, kOp4Export) {}

  bool next_header(Header& header) override {
    do {
      if (!file_.next()) {
        if (file_.line_number() == 0) file_.fail("the file is empty.", kOp4Export);
        return false;
      }
    } while (file_.blank());
    const std::string_view line = file_.line();
    header.columns = at(0, "number of columns");
    header.rows = at(1, "number of rows");
    header.form = at(2, "form");
    header.type = at(3, "type");
    header.name = lower_case(column_of(line, 32, 8));
    type_ = header.type;
    const std::string_view format = column_of(line, 40, 40);
    format_ = format.empty() ? ColumnFormat{5, 16} : column_format(file_, format);
    return true;
  }
  Column next_column() override {
    next_line();
    return {at(0, "column number"), at(1, "row number"), at(2, "length of column")};
  }
  Run run_header(bool bigmat) override {
    next_line();
    if (bigmat) return long_header(at(0, "length of a run"), at(1, "row number"));
    return short_header(file_.integer(trimmed(file_.line()), "header of a run"));
  }
  void values(long count, std::vector<double>& out) override {
    ColumnReader reader(file_, format_);
    for (long k = 0; k < count; ++k) out.push_back(reader.number("matrix entry"));
  }
  void end_column() override {}
  void skip_last() override { next_line(); }
  long words_a_number() const override { return type_ % 2 == 1 ? 1 : 2; }
  bool length_in_words() const override { return false; }
  void fail(const std::string& problem, const std::string& fix) const override { file_.fail(problem, fix); }

 private:
  long at(int k, const char* what) const {
    return file_.integer(column_of(file_.line(), 8 * static_cast<size_t>(k), 8), what);
  }
  void next_line() {
    if (!file_.next()) file_.fail("the file ends within a matrix.", "it is cut; write it again.");
  }

  TextFile file_;
  ColumnFormat format_;
  long type_ = 0;
};

class BinarySource final : public Source {
 public:
  explicit BinarySource(const std::string& path) : path_(path), stream_(path, std::ios::binary) {
    std::error_code ignored;
    size_ = static_cast<std::uint64_t>(std::filesystem::file_size(path, ignored));
    if (!stream_ || ignored) throw FileError("the file cannot be opened.", path, "check its permissions.");
    std::uint32_t length = 0;
    stream_.read(reinterpret_cast<char*>(&length), 4);
    swapped_ = length != 24 && length != 48;
    word_ = (swapped_ ? __builtin_bswap32(length) : length) == 48 ? 8 : 4;
    stream_.seekg(0);
  }

  bool next_header(Header& header) override {
    if (start_ + taken_ == size_) return false;
    next_record();
    if (record_.size() != 6 * word_)
      fail("a record of " + std::to_string(record_.size()) + " bytes, not a header.", kOp4Export);
    header.columns = integer();
    header.rows = integer();
    header.form = integer();
    header.type = integer();
    for (size_t k = 4 * word_; k < record_.size(); ++k)
      if (record_[k] > ' ' && record_[k] < 127) header.name += record_[k];
    header.name = lower_case(header.name);
    type_ = header.type;
    return true;
  }
  Column next_column() override {
    next_record();
    Column column;
    column.number = integer();
    column.first_row = integer();
    column.length = integer();
    return column;
  }
  Run run_header(bool bigmat) override {
    const long first = integer();
    return bigmat ? long_header(first, integer()) : short_header(first);
  }
  void values(long count, std::vector<double>& out) override {
    const size_t bytes = number_bytes();
    if (count < 0 || static_cast<std::uint64_t>(count) > (record_.size() - at_) / bytes)
      fail(std::to_string(count) + " numbers announced in a record too short for them.", kOp4Export);
    for (long k = 0; k < count; ++k) {
      double value = 0;
      if (bytes == 8) {
        const std::uint64_t bits = fetch(8);
        std::memcpy(&value, &bits, 8);
      } else {
        const auto bits = static_cast<std::uint32_t>(fetch(4));
        float single = 0;
        std::memcpy(&single, &bits, 4);
        value = static_cast<double>(single);
      }
      if (!std::isfinite(value)) fail("a matrix entry is not a finite number.", "the finite-element run has failed.");
      out.push_back(value);
    }
  }
  void end_column() override {
    if (at_ != record_.size()) fail("a record longer than its column.", kOp4Export);
  }
  void skip_last() override {}
  long words_a_number() const override { return static_cast<long>(number_bytes() / word_); }
  bool length_in_words() const override { return true; }
  void fail(const std::string& problem, const std::string& fix) const override {
    throw FileError(problem, path_ + ": byte " + std::to_string(start_), fix);
  }

 private:
  long integer() {
    const long value = word_ == 8 ? static_cast<long>(fetch(8)) : static_cast<std::int32_t>(fetch(4));
    if (value > kLargestNumber || value < -kLargestNumber)
      fail("the whole number " + std::to_string(value) + ".", "the file is damaged; write it again.");
    return value;
  }
  size_t number_bytes() const { return type_ % 2 == 1 && word_ == 4 ? 4 : 8; }

  std::uint32_t length_mark() {
    char bytes[4];
    stream_.read(bytes, 4);
    std::uint32_t length = 0;
    std::memcpy(&length, bytes, 4);
    return swapped_ ? __builtin_bswap32(length) : length;
  }
  /// Length, that many bytes, the length again.
  void next_record() {
    start_ += taken_;
    taken_ = 0;
    if (size_ - start_ < 8) fail("the file ends within a matrix.", "it is cut; write it again.");
    const std::uint32_t length = length_mark();
    if (length > size_ - start_ - 8)
      fail("a record of " + std::to_string(length) + " bytes goes beyond the end.",
           "the file is cut or damaged; write it again.");
    record_.resize(length);
    stream_.read(record_.data(), length);
    if (length_mark() != length || !stream_)
      fail("a record whose two lengths differ.", "the file is damaged; write it again, as binary.");
    taken_ = length + 8;
    at_ = 0;
  }
  std::uint64_t fetch(size_t bytes) {
    if (record_.size() - at_ < bytes) fail("a record is too short.", kOp4Export);
    std::uint64_t bits = 0;
    std::uint32_t half = 0;
    if (bytes == 8)
      std::memcpy(&bits, record_.data() + at_, 8);
    else
      std::memcpy(&half, record_.data() + at_, 4);
    at_ += bytes;
    if (bytes == 4) return swapped_ ? __builtin_bswap32(half) : half;
    return swapped_ ? __builtin_bswap64(bits) : bits;
  }

  std::string path_;
  std::ifstream stream_;
  std::uint64_t size_ = 0, start_ = 0, taken_ = 0;  // bytes: of the file, before the record, of the record
  std::vector<char> record_;
  size_t at_ = 0, word_ = 4;
  bool swapped_ = false;
  long type_ = 0;
};

class Op4Reader {
 public:
  Op4Reader(std::unique_ptr<Source> source, const std::string& path) : source_(std::move(source)), path_(path) {}

  std::vector<Op4Matrix> read() {
    std::vector<Op4Matrix> matrices;
    for (Header header; source_->next_header(header); header = {}) {
      check(header);
      MatrixEntries entries(static_cast<int>(header.rows));
      read_columns(header, entries);
      if (!header.wanted()) continue;
      // Not even every tenth row has an entry: no stiffness, and not worth the memory of its rows.
      if (header.rows > 100 + 10 * static_cast<long>(entries.count()))
        log::warn(path_ + ": matrix '" + header.name + "' is all but empty; passed over.");
      else
        matrices.push_back({header.name, entries.one_triangle_or_both(path_)});
    }
    return matrices;
  }

 private:
  void check(Header& header) const {
    header.bigmat = header.rows < 0 || header.rows >= kNonBigmatRows;
    if (header.rows < 0) header.rows = -header.rows;
    if (header.rows < 1 || header.columns < 1 || header.rows > 100'000'000 || header.columns > 100'000'000 ||
        header.type < 1 || header.type > 4 || header.form < 1 || header.form > 20)
      source_->fail("a matrix of " + std::to_string(header.rows) + " x " + std::to_string(header.columns) + ", form " +
                        std::to_string(header.form) + ", type " + std::to_string(header.type) + ".",
                    "types are 1 to 4; give a file of OUTPUT4, text or binary.");
  }

  void read_columns(const Header& header, MatrixEntries& entries) {
    for (long last = 0;;) {
      const Column column = source_->next_column();
      if (column.number <= last || column.number > header.columns + 1)
        source_->fail("column " + std::to_string(column.number) + " after column " + std::to_string(last) + " of " +
                          std::to_string(header.columns) + ".",
                      "columns follow each other; the file is damaged: write it again.");
      last = column.number;
      if (last == header.columns + 1) return source_->skip_last();
      if (column.length < 1) source_->fail("a column of length " + std::to_string(column.length) + ".", kOp4Export);
      if (column.first_row > 0) {
        const long a_number = source_->length_in_words() ? source_->words_a_number() : 1;
        add(header, last, column.first_row, divided(column.length, a_number), entries);
      } else {
        read_runs(header, column, entries);
      }
      source_->end_column();
    }
  }

  void read_runs(const Header& header, const Column& column, MatrixEntries& entries) {
    for (long left = column.length; left > 0;) {
      const Run run = source_->run_header(header.bigmat);
      left -= run.words + run.header_words;
      if (run.words < 1 || left < 0)
        source_->fail("a run of " + std::to_string(run.words) + " words goes beyond its column.", kOp4Export);
      add(header, column.number, run.first_row, divided(run.words, source_->words_a_number()), entries);
    }
  }

  long divided(long words, long a_number) const {
    if (words % a_number != 0) source_->fail("half a number at the end of a column.", kOp4Export);
    return words / a_number;
  }

  void add(const Header& header, long column, long first_row, long numbers, MatrixEntries& entries) {
    const long count = divided(numbers, header.numbers_a_value());
    if (first_row < 1 || first_row > header.rows || count > header.rows - first_row + 1)
      source_->fail("rows " + std::to_string(first_row) + " to " + std::to_string(first_row + count - 1) + " of " +
                        std::to_string(header.rows) + ".",
                    "the file is damaged; write it again.");
    values_.clear();
    source_->values(numbers, values_);
    if (!header.wanted()) return;
    for (long k = 0; k < count; ++k)
      if (values_[size_t(k)] != 0)
        entries.add(static_cast<int>(first_row + k) - 1, static_cast<int>(column) - 1, values_[size_t(k)]);
  }

  std::unique_ptr<Source> source_;
  std::string path_;
  std::vector<double> values_;
};

bool is_binary(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  unsigned char head[4] = {};
  stream.read(reinterpret_cast<char*>(head), 4);
  const auto one = [&](int at) { return head[at] == 24 || head[at] == 48; };
  return stream && ((one(0) && head[1] + head[2] + head[3] == 0) || (one(3) && head[0] + head[1] + head[2] == 0));
}

}  // namespace

bool is_op4(const std::string& path) {
  if (is_binary(path)) return true;
  TextFile file(path, kOp4Export);
  if (!file.next()) return false;
  const auto& words = file.words();
  const auto number = [](std::string_view word) {
    return word.find_first_not_of("-0123456789") == std::string_view::npos;
  };
  return words.size() >= 4 && std::all_of(words.begin(), words.begin() + 3, number);
}

std::vector<Op4Matrix> read_op4(const std::string& path) {
  std::unique_ptr<Source> source;
  if (is_binary(path))
    source = std::make_unique<BinarySource>(path);
  else
    source = std::make_unique<TextSource>(path);
  return Op4Reader(std::move(source), path).read();
}

}  // namespace lithe
