#pragma once

#include "tests/doctor_judged/judged_scene.h"

namespace lithe::test {

std::vector<SeededError> errors_of_geometry();  // joints, markers, what is tied to what
std::vector<SeededError> errors_of_numbers();   // units, signs, forces, settings of the run
std::vector<JudgedScene> sound_machines();      // mechanisms, drives, gears
std::vector<JudgedScene> sound_oddities();      // unusual scales, forces, flexible bodies, contact

// Ten each, written when the rules had been mended.
std::vector<SeededError> errors_of_second_round();
std::vector<JudgedScene> sound_second_round();

}  // namespace lithe::test
