#include "engine/output/table_stream.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "engine/base/number_text.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_series.h"
#include "engine/output/hdf5_table.h"

namespace lithe {
namespace {

bool ends_with(const std::string& path, const std::string& ending) {
  return std::filesystem::path(path).extension() == ending;
}

std::string line_of(std::span<const double> row) {
  std::string line;
  for (double value : row) {
    if (!line.empty()) line += ',';
    append_number(line, value);
  }
  return line += '\n';
}

}  // namespace

TableStream::TableStream(std::string path) : path_(std::move(path)), is_text_(ends_with(path_, ".csv")) {
  if (!is_text_ && !ends_with(path_, ".h5"))
    throw SceneError("rows cannot be streamed into '" + path_ + "'", "TableStream",
                     "give a path that ends in .csv or .h5");
}

TableStream::~TableStream() {
  if (file_ >= 0) ::close(file_);
}

void TableStream::fail() const {
  throw FileError("cannot write the file: " + std::error_code(errno, std::generic_category()).message() + ".", path_,
                  "choose a path in a folder you may write to, and check that the disk is not full.");
}

void TableStream::write(const std::string& text) {
  const auto written = ::write(file_, text.data(), text.size());
  if (written == static_cast<ssize_t>(text.size())) return;
  // Half a line would spoil those that follow.
  const int why = written < 0 ? errno : ENOSPC;
  if (written > 0) (void)!::ftruncate(file_, ::lseek(file_, 0, SEEK_END) - written);
  errno = why;
  fail();
}

void TableStream::begin(const Table& rows) {
  const std::vector<std::string>& columns = rows.columns;
  if (is_text_) {
    write_csv(rows, path_);
    file_ = ::open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    if (file_ < 0) fail();
  } else {
    series_ = std::make_unique<Hdf5Series>(path_);
    series_->write("/columns", columns);
    series_->attribute("/", "kind", "lithe table");
    series_->add("/values", static_cast<int>(columns.size()));
    const auto width = static_cast<Eigen::Index>(columns.size());
    for (int i = 0; i < rows.row_count(); ++i)
      series_->append("/values", Eigen::Map<const VectorX>(rows.values.data() + i * width, width));
    series_->begin();
    series_->flush();
  }
  begun_ = true;
}

void TableStream::append(const std::vector<std::string>& columns, std::span<const double> row) {
  if (!begun_) begin({.columns = columns});
  if (is_text_) return write(line_of(row));
  series_->append("/values", Eigen::Map<const VectorX>(row.data(), static_cast<Eigen::Index>(row.size())));
  series_->flush();
}

Table TableStream::go_on(const std::vector<std::string>& columns, int rows) {
  Table table{.columns = columns};
  if (rows == 0) return table;
  const auto refuse = [&](const std::string& problem) {
    throw FileError(
        "the file " + problem, path_,
        "resume with the file that the run wrote, or let the recorder keep its rows in memory: no stream()");
  };
  if (is_text_) {
    // Not all of it: a kill may have cut its last line.
    std::ifstream file(path_);
    std::string text, line;
    for (int i = 0; i <= rows; ++i) {
      if (!std::getline(file, line) || file.eof()) refuse("has fewer rows than the checkpoint knows of");
      text += line + '\n';
    }
    file.close();
    std::istringstream lines(text);
    table = read_csv(lines, path_);
    if (table.columns != columns || table.row_count() != rows) refuse("has other columns than the recorder");
    if (::truncate(path_.c_str(), static_cast<off_t>(text.size())) != 0) fail();
    file_ = ::open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    if (file_ < 0) fail();
    begun_ = true;
    return table;
  }
  table = read_hdf5_table(path_);
  if (table.columns != columns) refuse("has other columns than the recorder");
  if (table.row_count() < rows) refuse("has fewer rows than the checkpoint knows of");
  table.values.resize(static_cast<std::size_t>(rows) * columns.size());
  begin(table);
  return table;
}

}  // namespace lithe
