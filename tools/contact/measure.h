#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/contact/piles.h"

namespace lithe::contact_bench {

using MakeStepper = std::function<std::unique_ptr<Stepper>(const Pile& pile, double step)>;
struct Contender {
  std::string name;
  MakeStepper make;
};

/// One engine on one pile at one step.
struct Measurement {
  std::string pile, contender, failure;  // why it stopped; empty: it did not
  double step = 0;                       // s
  int bodies = 0;
  std::vector<double> microseconds;  // a step, processor time, of each repetition
  double deepest = 0, late = 0;      // overlap, m: of the run; deepest of a state, mean over the last quarter
  double gain = 0;                   // largest rise of the energy above its least so far, over what has been lost
  int tunnelled = 0;                 // most at any time
  double kinetic = 0;                // at the end, J
  double highest = 0;                // centre at the end, m
  double iterations = 0;
  double median() const;
};

/// Runs all contenders on a pile, one after another, `repeats` times: what else the machine does meets all of them.
/// What is measured of the motion comes from the first repetition; every repetition is the same motion.
std::vector<Measurement> measure(const Pile& pile, double step, const std::vector<Contender>& contenders, int repeats);

/// Markdown; overlaps relative to those of the first contender of the same pile and step too.
std::string table_of(const std::vector<Measurement>& measurements);
std::string json_of(const std::vector<Measurement>& measurements);

}  // namespace lithe::contact_bench
