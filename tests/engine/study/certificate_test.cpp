#include "engine/study/certificate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/engine/output/output_scratch_folder.h"
#include "tests/support/json_file.h"

namespace lithe::test::certificate_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A flexible pendulum: its tip asked to 1 %, the pin's force to 2 %; stiffening matters more than modes.
Certificate pendulum() {
  Certificate sheet;
  sheet.scene = "flexible pendulum";
  sheet.duration = 1;
  sheet.simplification = {"'bob' and 'rod' are welded: one body", "'frame' is tied to ground and vanishes"};
  ChosenBody rod{.name = "rod", .fidelity = {{0, 1, 3}, Deflection::stiffened}, .finest = Deflection::quadratic};
  const double frequencies[] = {52.13, 143.4, 281.2, 1214, 1500, 2000, 2500, 3000, 4000, 5000};
  for (int i = 0; i < 10; ++i)
    rod.modes.push_back({.mode = i,
                         .frequency = frequencies[i],
                         .used = i < 2 || i == 3,
                         .effect = {i == 4 ? 5.3e-3 : 1e-4 / (i + 1), i == 2 ? 0.0123 : 1e-3 / (i + 1)}});
  rod.deflection_effect = {8.123e-2, 0.05};
  rod.why = "stiffening by gravity and spin moves the tip by 81.2 mm, which no number of modes brings";
  sheet.bodies = {rod, {.name = "base", .why = "a rigid body with springs"}};
  sheet.integrator = "Automatic";
  sheet.tolerance = 1e-5;
  sheet.steps = 412;
  sheet.mean_step = 2.427e-3;
  sheet.quantities = {{"tip", 1.412, 1.412e-2, {7.21e-3, 2.316e-3, 3.1e-4, 1.2e-12}},
                      {"force of the pin", 40, 0.8, {0.01, 0.02, 0.004, 0}}};
  sheet.trials = {{"rigid", 1e-3, true, 41.2, 0.0123},
                  {"10 of 10 modes, linear", 0, false, 5.75, 0.9},
                  {"3 of 10 modes, stiffened", 1e-5, true, 0.697, 0.118},
                  {"3 of 10 modes, quadratic", 0, false, 0.55, 0}};
  sheet.chosen = 2;
  sheet.cost = 0.2345;
  sheet.answer_cost = 0.118;
  sheet.costs = {{"rigid bodies", 2, 300, 0.0145}, {"estimates along a run", 3, 0, 0.02}, {"modes", 1, 412, 0.19}};
  sheet.remarks = {"no number of linear modes reaches 1 %: the second order alone is 575 % of it"};
  return sheet;
}

/// Blanks and line breaks that follow each other become one blank.
std::string in_one_line(std::string text) {
  for (char& c : text)
    if (std::isspace(static_cast<unsigned char>(c))) c = ' ';
  text.erase(std::unique(text.begin(), text.end(), [](char a, char b) { return a == ' ' && b == ' '; }), text.end());
  return text;
}

/// The line of a text that begins so, blanks before it left out and others as one; empty if there is none.
std::string line_of(const std::string& text, const std::string& beginning) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line = in_one_line(line.substr(std::min(line.find_first_not_of(' '), line.size())));
    if (line.rfind(beginning, 0) == 0) return line;
  }
  return "";
}

void expect_readable(const std::string& text) {
  EXPECT_EQ(text.find("nan"), std::string::npos) << text;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto letters = std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
    EXPECT_LE(letters, 100) << line;
    EXPECT_TRUE(line.empty() || line.back() != ' ') << "'" << line << "'";
  }
}

TEST(Certificate, TheSheetTellsWhatWasAskedAndWhatIsStated) {
  const std::string text = pendulum().text();
  expect_readable(text);
  EXPECT_EQ(line_of(text, "Certificate"), "Certificate: flexible pendulum, 1 s");
  EXPECT_EQ(line_of(text, "tip 1.41"), "tip 1.41 14.1e-3 9.84e-3 0.697 % 69.7 % yes");
  EXPECT_EQ(line_of(text, "tip 7.21"), "tip 7.21e-3 2.32e-3 0.31e-3 1.2e-12");
  EXPECT_EQ(line_of(text, "force of the pin 40"), "force of the pin 40 0.8 0.034 0.085 % 4.25 % yes");
  EXPECT_NE(text.find("\nMET: "), std::string::npos) << text;
  EXPECT_EQ(line_of(text, "Automatic"), "Automatic, tolerance 1e-5: 412 steps of 2.43 ms in the mean");
  EXPECT_EQ(line_of(text, "234 ms"), "234 ms of CPU, choosing included; 118 ms for the run that gave the answer");
  EXPECT_EQ(line_of(text, "rigid bodies"), "rigid bodies 2 300 14.5 ms");
  EXPECT_EQ(line_of(text, "estimates"), "estimates along a run 3 - 20 ms");
  EXPECT_EQ(line_of(text, "set-up"), "set-up, comparison 10 ms");  // what is left of 234.5 ms
  for (const char* told :
       {"- 'bob' and 'rod' are welded: one body", "- 'frame' is tied", "- no number of linear modes"})
    EXPECT_NE(text.find(told), std::string::npos) << told << "\n" << text;
}

TEST(Certificate, TheSheetTellsTheModelOfEachBodyAndTheLargestModesLeftOutFirst) {
  const std::string text = pendulum().text();
  EXPECT_EQ(line_of(text, "rod:"), "rod: 3 of 10 modes, stiffened");
  EXPECT_EQ(line_of(text, "modes 0"), "modes 0 (52.1 Hz), 1 (143 Hz), 3 (1.21 kHz)");
  EXPECT_EQ(line_of(text, "why: stiffening").substr(0, 40), "why: stiffening by gravity and spin move");
  // Mode 4 moves the tip by 37.5 % of the bound; mode 2 does most to the force, 1.54 %, though 1e-4 / 3 to the tip.
  EXPECT_EQ(line_of(text, "mode 4"), "mode 4 1.5 kHz 5.3e-3 37.5 % tip");
  EXPECT_EQ(line_of(text, "mode 2"), "mode 2 281 Hz 0.0123 1.54 % force of the pin");
  std::size_t last = 0;
  for (const char* mode : {"mode 4", "mode 2", "mode 5", "mode 6", "mode 7"}) {
    EXPECT_GT(text.find(mode), last) << mode;
    last = text.find(mode);
  }
  EXPECT_EQ(text.find("mode 8"), std::string::npos);
  EXPECT_EQ(line_of(text, "2 more"), "2 more 0.15 % in sum, at most");  // 1e-4 / 9 + 1e-4 / 10 of 14.12e-3
  EXPECT_EQ(line_of(text, "second order"), "second order: in, large deflection left out does of asked to");
  EXPECT_EQ(line_of(text, "81.2e-3"), "81.2e-3 575 % tip");
  EXPECT_EQ(line_of(text, "0.05"), "0.05 6.25 % force of the pin");
  EXPECT_EQ(line_of(text, "base:"), "base: it has one model only");

  Certificate linear = pendulum();
  linear.bodies[0].fidelity.deflection = Deflection::linear;
  EXPECT_EQ(line_of(linear.text(), "second order"),
            "second order: left out, modes do not bring it would do of asked to");
}

TEST(Certificate, TheSheetMarksTheChosenTrial) {
  const std::string text = pendulum().text();
  EXPECT_EQ(line_of(text, "run 1e-3"), "run 1e-3 41.2 12.3 ms rigid");
  EXPECT_EQ(line_of(text, "* "), "* run, chosen 1e-5 0.697 118 ms 3 of 10 modes, stiffened");
  EXPECT_EQ(line_of(text, "estimated -"), "estimated - 5.75 900 ms 10 of 10 modes, linear");
  EXPECT_NE(text.find("3 of 10 modes, quadratic"), std::string::npos);
}

TEST(Certificate, ASecondOrderThatCannotBeToldNamesTheDataThatIsMissing) {
  Certificate sheet = pendulum();
  sheet.bodies[0].deflection_effect.clear();
  sheet.bodies[0].finest = Deflection::linear;
  const std::string text = in_one_line(sheet.text());
  EXPECT_NE(text.find("the basis has no data for it"), std::string::npos) << text;
  EXPECT_NE(text.find("make_basis(..., {.deflection = Deflection::quadratic})"), std::string::npos) << text;
  sheet.bodies[0].finest = Deflection::quadratic;
  EXPECT_NE(in_one_line(sheet.text()).find("second order: not estimated"), std::string::npos);
}

TEST(Certificate, IsMetOnlyIfEveryStatedErrorIsANumberWithinItsBound) {
  Certificate sheet = pendulum();
  EXPECT_TRUE(sheet.met());
  sheet.quantities[1].error.time = 0.804;
  EXPECT_FALSE(sheet.met());
  EXPECT_NE(sheet.text().find("NOT MET: 'force of the pin'."), std::string::npos);
  EXPECT_EQ(line_of(sheet.text(), "force of the pin 40"), "force of the pin 40 0.8 0.834 2.08 % 104 % no");
  sheet.quantities[1].error.time = std::nan("");
  EXPECT_FALSE(sheet.met());
  expect_readable(sheet.text());
  sheet.quantities[1] = {"idle", 0, 0, {}};  // 1 % of no change at all, and no error
  EXPECT_TRUE(sheet.met());
  EXPECT_EQ(line_of(sheet.text(), "idle 0"), "idle 0 0 0 0 % 0 % yes");
  EXPECT_FALSE(Certificate{}.met());
}

TEST(Certificate, WithoutDeformableBodiesAndEstimatesItIsStillASheet) {
  Certificate sheet = pendulum();
  sheet.bodies.clear();
  sheet.trials.clear();
  sheet.chosen = -1;
  sheet.simplification.clear();
  sheet.remarks.clear();
  const std::string text = sheet.text();
  expect_readable(text);
  EXPECT_NE(text.find("no body can deform"), std::string::npos) << text;
  for (const char* absent : {"Remarks", "Models considered", "Simplified"})
    EXPECT_EQ(text.find(absent), std::string::npos) << absent;
  EXPECT_TRUE(sheet.chart().lines.empty());
  expect_readable(Certificate{}.text());

  sheet = pendulum();
  for (ModeEffect& mode : sheet.bodies[0].modes) mode.effect.clear();
  EXPECT_EQ(line_of(sheet.text(), "7 modes"), "7 modes not estimated");
  for (ModeEffect& mode : sheet.bodies[0].modes) mode.used = false;
  sheet.bodies[0].fidelity.modes.clear();
  EXPECT_EQ(line_of(sheet.text(), "rod:"), "rod: rigid");
  EXPECT_EQ(line_of(sheet.text(), "second order"), "second order: left out with the modes would do of asked to");
}

TEST(Certificate, ARunThatFailedIsToldAndNotDrawn) {
  Certificate sheet = pendulum();
  sheet.trials[0].error = kInfinity;
  sheet.quantities[0].error.time = kInfinity;
  sheet.bodies[0].modes[2].effect[0] = kInfinity;
  const std::string text = sheet.text();
  expect_readable(text);
  EXPECT_EQ(line_of(text, "failed"), "failed 1e-3 - 12.3 ms rigid");
  EXPECT_EQ(line_of(text, "tip 1.41"), "tip 1.41 14.1e-3 inf - - no");
  EXPECT_LT(text.find("mode 2"), text.find("mode 4"));
  for (const ChartLine& line : sheet.chart().lines)
    for (const double error : line.y) EXPECT_TRUE(std::isfinite(error)) << line.title;
}

TEST(Certificate, LongNamesAndManyBodiesStayWithinTheSheet) {
  Certificate sheet = pendulum();
  const std::string model = "Ärmel: 3 of 20 modes, stiffened; Unterarm: 12 of 20 modes, linear; Hand: rigid";
  sheet.quantities[0].name = "Abstand der Spitze von der Wand gegenüber, in Achsen der Wand";
  sheet.quantities[0].error = {1.2345e-8, 1.2345e8, 1.2345e-5, 1.2345e-12};
  sheet.bodies[0].deflection_effect[0] = 1.2345e-8;
  sheet.trials[2].model = model + "; " + model;
  sheet.scene = sheet.bodies[0].name = model + ", " + model;
  ChosenBody& rod = sheet.bodies[0];
  for (int i = 10; i < 50; ++i) rod.modes.push_back({.mode = i, .frequency = 1e3 * i, .used = true, .effect = {0, 0}});
  sheet.bodies.push_back(sheet.bodies[0]);
  sheet.bodies[1].fidelity.deflection = Deflection::linear;
  const std::string text = sheet.text();
  expect_readable(text);
  EXPECT_NE(text.find("Abstand der Spitze von …"), std::string::npos) << text;
  EXPECT_NE(in_one_line(text).find("49 (49 kHz)"), std::string::npos) << text;
}

TEST(Certificate, JsonHoldsTheSheetAndNullForWhatIsNotFinite) {
  const ScratchFolder folder;
  Certificate sheet = pendulum();
  sheet.trials[1].error = kInfinity;
  sheet.bodies[0].modes[9].effect[1] = std::nan("");
  sheet.remarks.push_back("a name that is no UTF-8: \xff");
  sheet.write_json(folder.path("deep/sheet.json"));
  EXPECT_EQ(folder.file_count(), 1);
  const std::string text = file_text(folder.path("deep/sheet.json"));
  const nlohmann::json read = parse_json(text);
  EXPECT_EQ(read.at("scene").get<std::string>(), "flexible pendulum");
  EXPECT_EQ(read.at("met").get<bool>(), true);
  const auto& tip = read.at("quantities").at(0);
  EXPECT_EQ(tip.at("bound").get<double>(), sheet.quantities[0].bound);
  EXPECT_EQ(tip.at("error").at("total").get<double>(), sheet.quantities[0].error.total());
  EXPECT_EQ(tip.at("error").at("truncation").get<double>(), 7.21e-3);
  const auto& rod = read.at("bodies").at(0);
  EXPECT_EQ(rod.at("fidelity").at("modes").get<std::vector<int>>(), (std::vector<int>{0, 1, 3}));
  EXPECT_EQ(rod.at("fidelity").at("deflection").get<std::string>(), "stiffened");
  EXPECT_EQ(rod.at("finest").get<std::string>(), "quadratic");
  EXPECT_EQ(rod.at("modes").at(4).at("effect").at(0).get<double>(), 5.3e-3);
  EXPECT_TRUE(rod.at("modes").at(9).at("effect").at(1).is_null());
  EXPECT_EQ(rod.at("deflection_effect"), sheet.bodies[0].deflection_effect);
  EXPECT_EQ(read.at("bodies").at(1).at("modes").get<std::vector<int>>(), std::vector<int>{});
  EXPECT_TRUE(read.at("trials").at(1).at("error").is_null());
  EXPECT_EQ(read.at("trials").at(0).at("cost_s").get<double>(), 0.0123);
  EXPECT_EQ(read.at("costs").at(2).at("steps").get<long>(), 412);
  EXPECT_EQ(read.at("costs").at(1).at("cost_s").get<double>(), 0.02);
  EXPECT_EQ(read.at("chosen").get<int>(), 2);
  EXPECT_EQ(read.at("simplification").size(), 2u);
  EXPECT_EQ(read.at("remarks").size(), 2u);
  EXPECT_EQ(read.at("mean_step_s").get<double>(), 2.427e-3);
  Certificate{}.write_json(folder.path("empty.json"));
  EXPECT_TRUE(parse_json(file_text(folder.path("empty.json"))).at("chosen").is_null());
}

TEST(Certificate, TheChartShowsTheChosenTrialAtItsCostAndErrorBelowTheLineOfWhatWasAsked) {
  const ScratchFolder folder;
  Certificate sheet = pendulum();
  sheet.trials.push_back({"1 of 10 modes, stiffened", 1e-4, true, 6, 0.05});  // cheaper than the chosen, tried later
  const Chart chart = sheet.chart();
  EXPECT_TRUE(chart.log_x && chart.log_y);
  ASSERT_EQ(chart.lines.size(), 4u);
  EXPECT_EQ(chart.lines[0].x, (std::vector<double>{0.0123, 0.05}));
  EXPECT_EQ(chart.lines[0].y, (std::vector<double>{41.2, 6}));
  EXPECT_EQ(chart.lines[0].style, LineStyle::marked);
  EXPECT_EQ(chart.lines[1].x, std::vector<double>{0.9});  // what was estimated without a cost is not drawn
  EXPECT_EQ(chart.lines[1].style, LineStyle::points);
  EXPECT_EQ(chart.lines[2].title, "chosen: 3 of 10 modes, stiffened, tolerance 1e-5");
  EXPECT_EQ(chart.lines[2].x, std::vector<double>{0.118});
  EXPECT_EQ(chart.lines[2].y, std::vector<double>{0.697});
  EXPECT_EQ(chart.lines[3].style, LineStyle::dashed);
  EXPECT_EQ(chart.lines[3].x, (std::vector<double>{0.0123, 0.9}));
  EXPECT_EQ(chart.lines[3].y, (std::vector<double>{1, 1}));
  write_chart(chart, folder.path("sheet"));
  EXPECT_EQ(folder.file_count(), 2);

  sheet.trials = {{"rigid", 1e-3, true, 0.5, 0.01}};  // the first try does
  sheet.chosen = 0;
  const Chart single = sheet.chart();
  ASSERT_EQ(single.lines.size(), 2u);
  EXPECT_EQ(single.lines[0].title, "chosen: rigid, tolerance 1e-3");
  EXPECT_LT(single.lines[1].x[0], single.lines[1].x[1]);
  write_chart(single, folder.path("single"));
}

}  // namespace
}  // namespace lithe::test::certificate_test
