#include <gtest/gtest.h>

#include <algorithm>

#include "tests/doctor_judged/seeded_errors.h"

namespace lithe::test {
namespace {

bool names(const SeededError& error, const Finding& found) {
  const std::string text = to_string(found.cause) + ": " + found.what + " " + found.fix;
  const auto says = [&](const std::string& word) { return text.find(word) != std::string::npos; };
  return (error.causes.empty() || std::ranges::find(error.causes, found.cause) != error.causes.end()) &&
         std::ranges::all_of(error.words, [&](const auto& any) { return std::ranges::any_of(any, says); });
}

class DoctorJudgedByErrors : public testing::TestWithParam<SeededError> {};
class DoctorJudgedBySoundScenes : public testing::TestWithParam<JudgedScene> {};

TEST_P(DoctorJudgedByErrors, NamesTheErrorFirst) {
  const Diagnosis diagnosis = examine(GetParam().judged);
  EXPECT_TRUE(!diagnosis.findings.empty() && names(GetParam(), diagnosis.findings.front()))
      << GetParam().judged.scene.name << "\n"
      << diagnosis.text();
}

TEST_P(DoctorJudgedBySoundScenes, RaisesNoAlarm) {
  const Diagnosis diagnosis = examine(GetParam());
  EXPECT_TRUE(diagnosis.sound() && diagnosis.reached) << GetParam().scene.name << "\n" << diagnosis.text();
}

INSTANTIATE_TEST_SUITE_P(Geometry, DoctorJudgedByErrors, testing::ValuesIn(errors_of_geometry()));
INSTANTIATE_TEST_SUITE_P(Numbers, DoctorJudgedByErrors, testing::ValuesIn(errors_of_numbers()));
INSTANTIATE_TEST_SUITE_P(Second, DoctorJudgedByErrors, testing::ValuesIn(errors_of_second_round()));
INSTANTIATE_TEST_SUITE_P(Machines, DoctorJudgedBySoundScenes, testing::ValuesIn(sound_machines()));
INSTANTIATE_TEST_SUITE_P(Oddities, DoctorJudgedBySoundScenes, testing::ValuesIn(sound_oddities()));
INSTANTIATE_TEST_SUITE_P(Second, DoctorJudgedBySoundScenes, testing::ValuesIn(sound_second_round()));

}  // namespace
}  // namespace lithe::test
