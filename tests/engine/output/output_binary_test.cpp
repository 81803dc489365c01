#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "engine/output/binary.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::output_binary_test {

using lithe::FileError;
using lithe::read_binary;
using lithe::Table;
using lithe::write_binary;
using lithe::test::file_text;
using lithe::test::message_of;
using lithe::test::ScratchFolder;
using lithe::test::write_text;
using testing::HasSubstr;

namespace {

Table sample() {
  Table table{.columns = {"time", "énergie, \"J\"", ""}};
  table.add_row({0, 1.0 / 3.0, -0.0});
  table.add_row({1e-300, std::numeric_limits<double>::infinity(), 3});
  return table;
}

}  // namespace

TEST(output_binary, a_table_reads_back_as_it_was) {
  const ScratchFolder folder;
  for (const Table& table : {sample(), Table{}, Table{.columns = {"no rows"}}}) {
    write_binary(table, folder.path("sub/run.bin"));
    const Table read = read_binary(folder.path("sub/run.bin"));
    EXPECT_EQ(read.columns, table.columns);
    EXPECT_EQ(read.values, table.values);
  }
}

TEST(output_binary, the_bytes_are_the_documented_ones) {
  const ScratchFolder folder;
  write_binary({.columns = {"t"}, .values = {1.0}}, folder.path("run.bin"));
  using namespace std::string_literals;
  const std::string expected =
      "LITHETBL"s + "\1\0\0\0"s + "\1\0\0\0"s + "\1\0\0\0\0\0\0\0"s + "\1\0\0\0t"s + "\0\0\0\0\0\0\xf0\x3f"s;
  const std::string bytes = file_text(folder.path("run.bin"));
  EXPECT_EQ(bytes.size(), expected.size() + 8);
  EXPECT_EQ(bytes.substr(0, expected.size()), expected);
}

TEST(output_binary, a_file_cut_anywhere_is_refused) {
  const ScratchFolder folder;
  write_binary(sample(), folder.path("run.bin"));
  const std::string whole = file_text(folder.path("run.bin"));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_text(folder.path("cut.bin"), whole.substr(0, size));
    EXPECT_THROW(read_binary(folder.path("cut.bin")), FileError) << size << " bytes";
  }
  write_text(folder.path("long.bin"), whole + "x");
  EXPECT_THROW(read_binary(folder.path("long.bin")), FileError);
}

TEST(output_binary, any_single_damaged_byte_is_seen) {
  const ScratchFolder folder;
  write_binary(sample(), folder.path("run.bin"));
  const std::string whole = file_text(folder.path("run.bin"));
  for (std::size_t i = 0; i < whole.size(); ++i)
    for (const int flip : {0x01, 0x80, 0xff}) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      write_text(folder.path("damaged.bin"), damaged);
      EXPECT_THROW(read_binary(folder.path("damaged.bin")), FileError) << "byte " << i;
    }
}

TEST(output_binary, absurd_counts_are_refused_before_memory_is_asked_for) {
  const ScratchFolder folder;
  using namespace std::string_literals;
  const std::string most(8, '\xff');
  for (const std::string& counts : {most + most, "\1\0\0\0"s + most + "\0\0\0\0"s, "\0\0\0\0"s + most}) {
    write_text(folder.path("absurd.bin"), "LITHETBL"s + "\1\0\0\0"s + counts + "12345678"s);
    EXPECT_THROW(read_binary(folder.path("absurd.bin")), FileError);
  }
}

TEST(output_binary, another_format_version_or_absent_file_is_named) {
  const ScratchFolder folder;
  write_text(folder.path("run.csv"), "time,z\n0,1\n");
  EXPECT_THAT(message_of<FileError>([&] { read_binary(folder.path("run.csv")); }), HasSubstr("LITHETBL"));
  write_text(folder.path("next.bin"), std::string("LITHETBL\2\0\0\0", 12));
  EXPECT_THAT(message_of<FileError>([&] { read_binary(folder.path("next.bin")); }), HasSubstr("version 2"));
  EXPECT_THROW(read_binary(folder.path("absent.bin")), FileError);
}

}  // namespace lithe::test::output_binary_test
