#pragma once

#include <vector>

#include "engine/study/study.h"

namespace lithe {

/// The integrators of this folder as studies run them (engine/study/): by a tolerance, relative and absolute alike, or
/// with a fixed step.
std::vector<StudyMethod> standard_methods();

/// Two of different kind and high order, to give a reference and to prove it.
std::vector<StudyMethod> reference_methods();

}  // namespace lithe
