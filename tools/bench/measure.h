#pragma once

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <stdexcept>
#include <string>

/// What the programs here share: a command line, a clock, and what one run has cost.
namespace lithe::bench {

/// `--name value` pairs. Throws std::invalid_argument for anything else, and by finish() for a name nobody asked for.
class Arguments {
 public:
  Arguments(int count, char** words) {
    for (int i = 1; i < count; i += 2) {
      const std::string name = words[i];
      if (name.size() < 3 || name.compare(0, 2, "--") != 0 || i + 1 == count)
        throw std::invalid_argument("'" + name + "' is not the name of a value; write --name value");
      given_[name.substr(2)] = words[i + 1];
    }
  }
  std::string text(const std::string& name, const std::string& otherwise) {
    const auto found = given_.find(name);
    if (found == given_.end()) return otherwise;
    const std::string value = found->second;
    given_.erase(found);
    return value;
  }
  double number(const std::string& name, double otherwise) {
    const std::string value = text(name, "");
    return value.empty() ? otherwise : std::stod(value);
  }
  int integer(const std::string& name, int otherwise) { return static_cast<int>(number(name, otherwise)); }
  void finish() const {
    if (!given_.empty()) throw std::invalid_argument("nothing here is called --" + given_.begin()->first);
  }

 private:
  std::map<std::string, std::string> given_;
};

/// CPU time of this process.
inline double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// What the steps of one run have cost, and where its last point ended: equal equations end at equal points.
struct Cost {
  double seconds = 0;  // CPU, of the stepping loop alone
  long steps = 0, newton_iterations = 0, factorizations = 0;
  double tip[3] = {};  // m, world axes

  double microseconds_per_step() const { return 1e6 * seconds / static_cast<double>(steps); }
  /// `"steps": ..., ...`, the inside of a JSON object.
  void print_json() const {
    const double n = static_cast<double>(steps);
    std::printf(
        "\"us_per_step\": %.5g, \"newton_iterations_per_step\": %.5g, \"factorizations_per_step\": %.5g, "
        "\"steps\": %ld, \"tip\": [%.16g, %.16g, %.16g]",
        microseconds_per_step(), static_cast<double>(newton_iterations) / n, static_cast<double>(factorizations) / n,
        steps, tip[0], tip[1], tip[2]);
  }
};

/// The cheapest of some runs: what the machine's other business adds is never negative.
template <class Run>
Cost least_of(int repeats, Run&& run) {
  Cost best = run();
  for (int i = 1; i < repeats; ++i) {
    const Cost again = run();
    if (again.seconds < best.seconds) best = again;
  }
  return best;
}

/// main() of a program: its exceptions become one line and exit code 1.
template <class Program>
int run_program(int count, char** words, Program&& program) {
  try {
    Arguments arguments(count, words);
    program(arguments);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

}  // namespace lithe::bench
