#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "engine/output/csv.h"
#include "engine/output/partial_file.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::output_csv_test {

using lithe::FileError;
using lithe::PartialFile;
using lithe::read_csv;
using lithe::SceneError;
using lithe::Table;
using lithe::write_csv;
using lithe::test::file_text;
using lithe::test::message_of;
using lithe::test::ScratchFolder;
using lithe::test::write_text;
using testing::HasSubstr;

TEST(output_csv, a_file_reads_as_one_expects) {
  const ScratchFolder folder;
  Table table{.columns = {"time", "z"}};
  table.add_row({0.1, -2.0});
  write_csv(table, folder.path("new/folders/run.csv"));
  EXPECT_EQ(file_text(folder.path("new/folders/run.csv")), "time,z\n0.1,-2\n");
}

TEST(output_csv, every_number_reads_back_to_the_last_bit) {
  const ScratchFolder folder;
  using Limits = std::numeric_limits<double>;
  Table table{.columns = {"a", "b"}};
  table.add_row({Limits::max(), Limits::lowest()});
  table.add_row({Limits::min(), Limits::denorm_min()});
  table.add_row({-0.0, 1.0 / 3.0});
  table.add_row({Limits::infinity(), -Limits::infinity()});
  std::mt19937_64 random(7);
  while (table.row_count() < 2000) {
    const double a = std::bit_cast<double>(random()), b = std::bit_cast<double>(random());
    if (std::isfinite(a) && std::isfinite(b)) table.add_row({a, b});
  }
  write_csv(table, folder.path("run.csv"));
  const Table read = read_csv(folder.path("run.csv"));

  EXPECT_EQ(read.columns, table.columns);
  ASSERT_EQ(read.values.size(), table.values.size());
  for (std::size_t i = 0; i < read.values.size(); ++i)
    ASSERT_EQ(std::bit_cast<std::uint64_t>(read.values[i]), std::bit_cast<std::uint64_t>(table.values[i])) << i;
}

TEST(output_csv, an_undefined_number_stays_undefined) {
  const ScratchFolder folder;
  Table table{.columns = {"a"}};
  table.add_row({std::numeric_limits<double>::quiet_NaN()});
  write_csv(table, folder.path("run.csv"));
  EXPECT_TRUE(std::isnan(read_csv(folder.path("run.csv")).at(0, 0)));
}

TEST(output_csv, column_names_may_hold_commas_and_quotes) {
  const ScratchFolder folder;
  Table table{.columns = {"p(x, y)", "the \"tip\"", "", "plain"}};
  table.add_row({1, 2, 3, 4});
  write_csv(table, folder.path("run.csv"));
  EXPECT_EQ(read_csv(folder.path("run.csv")).columns, table.columns);
  EXPECT_THROW(write_csv({.columns = {"two\nlines"}}, folder.path("bad.csv")), SceneError);
  EXPECT_THROW(write_csv({}, folder.path("bad.csv")), SceneError);
}

TEST(output_csv, files_of_other_programs_are_understood) {
  const ScratchFolder folder;
  write_text(folder.path("other.csv"), "time, z\r\n 0 , 1.5e-3\r\n\r\n1,\t2\r\n");
  const Table read = read_csv(folder.path("other.csv"));
  EXPECT_EQ(read.columns, (std::vector<std::string>{"time", "z"}));
  EXPECT_EQ(read.values, (std::vector<double>{0, 1.5e-3, 1, 2}));
}

TEST(output_csv, a_broken_line_is_named_by_file_and_number) {
  const ScratchFolder folder;
  const std::string path = folder.path("broken.csv");
  const auto message = [&](const std::string& text) {
    write_text(path, text);
    return message_of<FileError>([&] { read_csv(path); });
  };
  EXPECT_THAT(message("t,z\n0,1\n0.1\n"), HasSubstr(path + ":3"));
  EXPECT_THAT(message("t,z\n0,1,2\n"), HasSubstr("3 values, the header names 2"));
  EXPECT_THAT(message("t,z\n\n0,1x\n"), testing::AllOf(HasSubstr("'1x' in column 'z'"), HasSubstr(path + ":3")));
  EXPECT_THAT(message("t,z\n0,\n"), HasSubstr("'' in column 'z'"));
  EXPECT_THAT(message("t,z\n0,1e999\n"), HasSubstr("'1e999'"));
  EXPECT_THAT(message(""), HasSubstr("no header"));
  EXPECT_THROW(read_csv(folder.path("absent.csv")), FileError);
}

TEST(output_csv, an_unwritable_path_says_how_to_fix_it) {
  const ScratchFolder folder;
  write_text(folder.path("file"), "not a folder");
  const std::string message =
      message_of<FileError>([&] { write_csv({.columns = {"t"}}, folder.path("file/run.csv")); });
  EXPECT_THAT(message, HasSubstr(folder.path("file/run.csv")));
  EXPECT_THAT(message, HasSubstr("fix:  choose a path"));
  std::filesystem::create_directory(folder.path("taken"));
  EXPECT_THROW(write_csv({.columns = {"t"}}, folder.path("taken")), FileError);
  EXPECT_EQ(folder.file_count(), 1) << "a temporary file was left behind";
}

TEST(output_csv, an_unfinished_file_leaves_the_old_one_and_no_rest) {
  const ScratchFolder folder;
  write_text(folder.path("run.csv"), "old");
  {
    PartialFile file(folder.path("run.csv"));
    file.stream() << "half of the n";
    EXPECT_EQ(file_text(folder.path("run.csv")), "old");
  }
  EXPECT_EQ(file_text(folder.path("run.csv")), "old");
  EXPECT_EQ(folder.file_count(), 1);
}

}  // namespace lithe::test::output_csv_test
