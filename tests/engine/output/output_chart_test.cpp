#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine/base/error.h"
#include "engine/output/chart.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::output_chart_test {

using lithe::Chart;
using lithe::ChartLine;
using lithe::Error;
using lithe::LineStyle;
using lithe::SceneError;
using lithe::write_chart;
using lithe::test::file_text;
using lithe::test::message_of;
using lithe::test::ScratchFolder;
using testing::HasSubstr;

namespace {

// Width and height stand big-endian at bytes 16 and 20 of a PNG.
int big_endian(const std::string& bytes, std::size_t at) {
  int value = 0;
  for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

bool holds(const std::string& svg, const std::string& text) { return svg.find(text) != std::string::npos; }

}  // namespace

TEST(output_chart, both_pictures_appear_and_nothing_else) {
  const ScratchFolder folder;
  Chart chart{.title = "Pendulum", .x_label = "time [s]", .y_label = "height [m]"};
  ChartLine tip{.title = "tip"}, exact{.title = "exact", .style = LineStyle::dashed};
  for (int i = 0; i <= 200; ++i) {
    tip.x.push_back(0.02 * i);
    tip.y.push_back(-std::cos(2 * tip.x.back()));
  }
  exact.x = tip.x;
  exact.y = tip.y;
  chart.lines = {exact, tip};
  write_chart(chart, folder.path("pictures/pendulum"));

  const std::string png = file_text(folder.path("pictures/pendulum.png"));
  ASSERT_GT(png.size(), 5000u);
  EXPECT_EQ(png.substr(1, 3), "PNG");
  EXPECT_EQ(big_endian(png, 16), 1200);
  EXPECT_EQ(big_endian(png, 20), 750);
  const std::string svg = file_text(folder.path("pictures/pendulum.svg"));
  EXPECT_TRUE(holds(svg, "viewBox=\"0 0 1200 750\""));
  EXPECT_TRUE(holds(svg, "</svg>"));
  EXPECT_EQ(folder.file_count(), 2);
}

TEST(output_chart, texts_appear_as_written) {
  const ScratchFolder folder;
  write_chart({.title = "flexible_pendulum {a^2}",
               .x_label = "it's \"time\"",
               .y_label = "two\nlines",
               .lines = {{.title = "l'Hôpital_rule @ $x `id`", .x = {0, 1}, .y = {0, 1}}}},
              folder.path("it's a chart"));
  const std::string svg = file_text(folder.path("it's a chart.svg"));
  for (const std::string text : {"flexible_pendulum {a^2}", "it's \"time\"", "two lines", "l'Hôpital_rule @ $x `id`"})
    EXPECT_TRUE(holds(svg, text)) << text;
}

TEST(output_chart, logarithmic_axes_are_labelled_with_powers_or_with_numbers_if_short) {
  const ScratchFolder folder;
  write_chart({.lines = {{.title = "a", .x = {2, 9}, .y = {1e-12, 1}, .style = LineStyle::marked},
                         {.title = "b", .x = {3, 4}, .y = {1e-3, 1e-3}, .style = LineStyle::points}},
               .log_x = true,
               .log_y = true},
              folder.path("log"));
  const std::string svg = file_text(folder.path("log.svg"));
  EXPECT_TRUE(holds(svg, ">-10<"));
  EXPECT_TRUE(holds(svg, ">5<"));
}

TEST(output_chart, values_that_hardly_change_are_told_apart_and_constants_are_drawn) {
  const ScratchFolder folder;
  write_chart({.lines = {{.x = {0, 1}, .y = {12.3456, 12.34560001}}}}, folder.path("energy"));
  EXPECT_TRUE(holds(file_text(folder.path("energy.svg")), "12.345600002"));
  // One point; a flat line; a flat line but for rounding; a flat line on a logarithmic axis.
  write_chart({.lines = {{.x = {1}, .y = {1}}}}, folder.path("point"));
  write_chart({.lines = {{.x = {0, 1}, .y = {0, 0}}}}, folder.path("zero"));
  write_chart({.lines = {{.x = {0, 1}, .y = {5, std::nextafter(5.0, 6.0)}}}}, folder.path("rounding"));
  write_chart({.lines = {{.x = {0, 1}, .y = {1e-9, 1e-9}}}, .log_y = true}, folder.path("flat"));
}

TEST(output_chart, more_lines_than_colours_still_look_different) {
  const ScratchFolder folder;
  Chart chart;
  for (int i = 0; i < 7; ++i)
    chart.lines.push_back({.title = "line " + std::to_string(i), .x = {0, 1}, .y = {0, 1.0 * i}});
  write_chart(chart, folder.path("six_and_one"));
  EXPECT_TRUE(holds(file_text(folder.path("six_and_one.svg")), "stroke-dasharray"));
  chart.lines.pop_back();
  write_chart(chart, folder.path("six"));
  EXPECT_FALSE(holds(file_text(folder.path("six.svg")), "stroke-dasharray"));
}

TEST(output_chart, a_value_that_cannot_be_drawn_is_named_by_line_and_place) {
  const ScratchFolder folder;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [&](const Chart& chart) {
    return message_of<SceneError>([&] { write_chart(chart, folder.path("bad")); });
  };
  const std::string undefined = message({.lines = {{.title = "tip", .x = {0, 1}, .y = {0, nan}}}});
  EXPECT_THAT(undefined, HasSubstr("value nan"));
  EXPECT_THAT(undefined, HasSubstr("line 'tip', y[1]"));
  EXPECT_THAT(message({.lines = {{.title = "tip", .x = {0, 1}, .y = {1, 0}}}, .log_y = true}),
              HasSubstr("logarithmic axis cannot show the value 0"));
  EXPECT_THAT(message({.lines = {{.title = "tip", .x = {0, 1}, .y = {1}}}}), HasSubstr("2 x and 1 y"));
  EXPECT_THAT(message({.lines = {{.title = "tip"}}}), HasSubstr("line 'tip'"));
  EXPECT_THAT(message({}), HasSubstr("no lines"));
  EXPECT_EQ(folder.file_count(), 0);
}

TEST(output_chart, a_missing_gnuplot_is_told_with_the_package_to_install) {
  const ScratchFolder folder;
  const std::string path = getenv("PATH");
  setenv("PATH", folder.path("empty").c_str(), 1);
  const std::string message = message_of<Error>([&] {
    write_chart({.lines = {{.x = {0, 1}, .y = {0, 1}}}}, folder.path("chart"));
  });
  setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(message, HasSubstr("apt-get install gnuplot-nox"));
  EXPECT_EQ(folder.file_count(), 0);
}

TEST(output_chart, a_failing_gnuplot_is_told_with_its_own_words) {
  const ScratchFolder folder;
  const std::string path = getenv("PATH");
  lithe::test::write_text(folder.path("gnuplot"), "#!/bin/sh\necho unknown terminal >&2\nexit 1\n");
  std::filesystem::permissions(folder.path("gnuplot"), std::filesystem::perms::owner_all);
  setenv("PATH", (folder.path("") + ":" + path).c_str(), 1);
  const std::string message = message_of<Error>([&] {
    write_chart({.lines = {{.x = {0, 1}, .y = {0, 1}}}}, folder.path("chart"));
  });
  setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(message, HasSubstr("unknown terminal"));
  EXPECT_EQ(folder.file_count(), 1);
}

}  // namespace lithe::test::output_chart_test
