#include "engine/study/doctor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/engine/study/sound_scenes.h"
#include "tests/support/scenes.h"

namespace lithe::test::doctor_test {

namespace {

Diagnosis examine(const Patient& patient) {
  return diagnose(patient.scene, patient.method, {.setting = patient.setting, .max_steps = 20000, .time_limit = 30});
}

bool printing() { return std::getenv("LITHE_PRINT") != nullptr; }

}  // namespace

TEST(doctor, names_the_right_cause_first_in_nine_of_ten_seeded_faults) {
  const std::vector<Patient> faults = seeded_faults();
  ASSERT_GE(faults.size(), 30u);
  int right = 0;
  std::string missed;
  for (const Patient& fault : faults) {
    const Diagnosis diagnosis = examine(fault);
    const bool named = !diagnosis.findings.empty() && diagnosis.findings.front().cause == fault.cause;
    right += named;
    if (!named) missed += "\n" + fault.name + " (" + to_string(fault.cause) + "):\n" + diagnosis.text();
    if (printing()) std::printf("---- %s%s\n%s", named ? "" : "! ", fault.name.c_str(), diagnosis.text().c_str());
    for (const Finding& finding : diagnosis.findings) {
      EXPECT_FALSE(finding.what.empty());
      EXPECT_FALSE(finding.fix.empty());
    }
  }
  if (printing()) std::printf("%d of %zu\n", right, faults.size());
  EXPECT_GE(10 * right, 9 * static_cast<int>(faults.size())) << missed;
}

TEST(doctor, raises_no_alarm_on_sound_scenes) {
  const std::vector<Patient> scenes = sound_scenes();
  EXPECT_GE(scenes.size(), 30u);
  for (const Patient& sound : scenes) {
    const Diagnosis diagnosis = examine(sound);
    if (printing())
      std::printf("---- %s%s\n%s", diagnosis.sound() ? "" : "! ", sound.name.c_str(), diagnosis.text().c_str());
    EXPECT_TRUE(diagnosis.sound()) << sound.name << "\n" << diagnosis.text();
    EXPECT_TRUE(diagnosis.reached) << sound.name;
  }
}

TEST(doctor, finds_nothing_to_say_about_the_classical_scenes) {
  const auto expect_sound = [](const Scene& scene) {
    for (const Finding& finding : look_over(scene.system, scene.state)) EXPECT_FALSE(finding.alarm) << finding.what;
  };
  expect_sound(mass_chain({1.2}));
  expect_sound(mass_chain({M_PI / 2, M_PI / 3, 0.1}));
  expect_sound(box_chain(12, false));
  expect_sound(box_chain(12, true));
  expect_sound(heavy_top(15, 1, 0.24, 0.47, {0, 150, -4.6}));
  expect_sound(free_body({1, 2, 2.5}, {0.1, 10, 0.1}));
}

TEST(doctor, tells_of_a_state_that_its_joints_do_not_allow) {
  SystemGraph graph;
  draw_pendulum(graph, 1);
  const System system = assemble(graph);
  EXPECT_TRUE(look_over(system, system.initial_state()).empty());
  State moved = system.initial_state(), pushed = moved;
  moved.q[1] += 0.01;
  pushed.v[0] += 0.1;
  for (const State& state : {moved, pushed}) {
    const std::vector<Finding> findings = look_over(system, state);
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].cause, Cause::inconsistent_start);
    EXPECT_TRUE(findings[0].alarm);
    EXPECT_THAT(findings[0].what, testing::HasSubstr("'pin' row"));
    EXPECT_THAT(findings[0].fix, testing::HasSubstr("Projector"));
  }
}

namespace {

const Patient& fault(const std::vector<Patient>& all, const std::string& name) {
  const auto at = std::find_if(all.begin(), all.end(), [&](const Patient& p) { return p.name == name; });
  EXPECT_NE(at, all.end()) << name;
  return *at;
}

}  // namespace

TEST(doctor, tries_a_smaller_step_another_method_and_a_coarser_tolerance_and_says_whether_they_helped) {
  const std::vector<Patient> faults = seeded_faults();
  const struct {
    const char* name;
    const char* tried;
  } cases[] = {{"step too long for the motion", "the same method at h = 0.025 s"},
               {"bump stop of steel", "another method, generalized-alpha"},
               {"tolerance of 1e-15, IDA", "the same method at tolerance 1e-10"}};
  for (const auto& [name, tried] : cases) {
    const Patient& patient = fault(faults, name);
    const Diagnosis diagnosis = diagnose(patient.scene, patient.method,
                                         {.setting = patient.setting,
                                          .try_cures = true,
                                          .others = {alpha_by_step()},
                                          .max_steps = 20000,
                                          .time_limit = 30});
    ASSERT_EQ(diagnosis.cures.size(), 1u) << diagnosis.text();
    EXPECT_EQ(diagnosis.cures[0].cause, patient.cause);
    EXPECT_EQ(diagnosis.cures[0].tried, tried);
    EXPECT_TRUE(diagnosis.cures[0].helped) << diagnosis.text();
  }
}

TEST(doctor, names_the_part_at_fault_with_figures) {
  const std::vector<Patient> faults = seeded_faults();
  const struct {
    const char* name;
    const char* part;
  } cases[] = {{"pin a centimetre off", "'pin' row 3 does not close as drawn: it is off by -0.01"},
               {"bump stop of steel", "'wire' between 'rod' and 'bob' rings at 3.39e+04 rad/s"},
               {"dry friction without smoothing", "'rub' on ground and 'block' jumps from"},
               {"table that ends", "'wind' on 'rod' is not finite at t = 0.7"},
               {"two drives of one shaft", "'motor' and 'brake' repeat each other but do not agree: 'brake' row 1"},
               {"pin of a microgram between tons", "'rod' weighs 5e+09 times as much as 'hook'"},
               {"forgotten joint", "nothing ties 'cup' to ground"}};
  for (const auto& [name, part] : cases) {
    const Diagnosis diagnosis = examine(fault(faults, name));
    EXPECT_THAT(diagnosis.findings.front().what, testing::HasSubstr(part)) << diagnosis.text();
  }
}

}  // namespace lithe::test::doctor_test
