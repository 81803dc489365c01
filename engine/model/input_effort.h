#pragma once

#include "engine/model/input.h"

namespace lithe {

/// The effort of a motor that an Input is: what a std::function holds, so that it can be recognized.
struct InputEffort {
  const Input* input;
  double operator()(double time, double, double) const { return input->value(time); }
};

}  // namespace lithe
