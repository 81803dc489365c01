#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "engine/cones/cone_problem.h"

namespace lithe {

/// Groups of a cone problem that contacts tie to one another, directly or through others.
class ContactIslands {
 public:
  /// `ties(i)`: whether contact i ties the groups on its sides.
  template <class Ties>
  void form(const ConeProblem& problem, Ties&& ties) {
    parents_.resize(problem.groups.size());
    std::iota(parents_.begin(), parents_.end(), 0);
    for (int i = 0; i < static_cast<int>(problem.contacts.size()); ++i) {
      const auto& sides = problem.contacts[i].sides;
      if (sides[0].group >= 0 && sides[1].group >= 0 && ties(i))
        parents_[of_group(sides[0].group)] = of_group(sides[1].group);
    }
  }
  /// The group that stands for the island of a group.
  int of_group(int i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  /// The same of contact i, which has a group on one side at least.
  int of(const ConeProblem& problem, int i) {
    const auto& sides = problem.contacts[i].sides;
    return of_group(std::max(sides[0].group, sides[1].group));
  }

 private:
  std::vector<int> parents_;
};

}  // namespace lithe
