#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/output/table.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::output_table_test {

using lithe::SceneError;
using lithe::Table;
using lithe::test::message_of;
using testing::HasSubstr;

TEST(output_table, rows_come_back_by_column_and_by_place) {
  Table table{.columns = {"time", "height"}};
  EXPECT_EQ(table.row_count(), 0);
  table.add_row({0.0, 1.0});
  const std::vector<double> second = {0.5, 0.75};
  table.add_row(second);

  EXPECT_EQ(table.row_count(), 2);
  EXPECT_EQ(table.column("height"), (std::vector<double>{1.0, 0.75}));
  EXPECT_EQ(table.at(1, 0), 0.5);
}

TEST(output_table, an_unknown_column_is_answered_with_the_known_ones_and_the_callers_line) {
  const Table table{.columns = {"time", "height"}};
  const std::string message = message_of<SceneError>([&] { table.column("heigth"); });
  EXPECT_THAT(message, HasSubstr("'heigth'"));
  EXPECT_THAT(message, HasSubstr("known are time, height"));
  EXPECT_THAT(message, HasSubstr("output_table_test.cpp:"));
}

TEST(output_table, a_row_that_does_not_fit_is_refused_and_leaves_the_table_as_it_was) {
  Table table{.columns = {"time", "height"}};
  EXPECT_THAT(message_of<SceneError>([&] { table.add_row({1.0, 2.0, 3.0}); }), HasSubstr("3 values does not fit 2"));
  EXPECT_EQ(table.row_count(), 0);
}

TEST(output_table, values_outside_or_in_an_incomplete_row_are_refused) {
  Table table{.columns = {"time", "height"}, .values = {0, 1}};
  EXPECT_THROW(table.at(1, 0), SceneError);
  EXPECT_THROW(table.at(0, 2), SceneError);
  EXPECT_THROW(table.at(-1, 0), SceneError);
  table.values.push_back(2);
  EXPECT_THAT(message_of<SceneError>([&] { table.row_count(); }), HasSubstr("do not fill whole rows"));
}

}  // namespace lithe::test::output_table_test
