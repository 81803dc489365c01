#pragma once

#include <functional>
#include <string>

#include "tools/differential/runs.h"

namespace lithe::differential {

enum class Verdict {
  agree,
  refused,   // every way, by the same kind of error
  loose,     // differ by more than the bound, and less at a tighter tolerance: both go to one answer
  disagree,  // differ however tight the tolerance is
  uneven,    // refused one way and not another
  restart,   // not the same bits after a restart
};
constexpr const char* kVerdictNames[] = {"agree", "refused", "loose", "disagree", "uneven", "restart"};

struct Judgement {
  Verdict verdict = Verdict::agree;
  std::string text;  // what differs, or what was refused
  double worst = 0;  // largest difference, in allowances
};

/// Differences up to this many times tolerance x sensitivity count as agreement: what docs/accuracy.md has behind kinks
/// and many periods, with some to spare. Sensitivity: the difference that a disturbance of gravity and velocities
/// makes, over the disturbance, each kind by itself, at least 1.
constexpr double kAllowed = 300;

/// Runs the scene all ways; `begins` is told of each before it begins.
Judgement judge(
    const DrawnScene& scene, const std::function<void(const std::string&)>& begins = [](const std::string&) {});

}  // namespace lithe::differential
