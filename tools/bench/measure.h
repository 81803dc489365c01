#pragma once

#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <initializer_list>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>

/// What programs that measure share: a command line, clocks, memory, lines of JSON, and what one run has cost.
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

inline double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
/// CPU time of this process.
inline double cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }
/// Time that passes, from no start in particular.
inline double wall_seconds() { return seconds_of(CLOCK_MONOTONIC); }

/// In use by this process, bytes.
inline double resident_memory() {
  long pages = 0, all = 0;
  std::ifstream("/proc/self/statm") >> all >> pages;
  return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE));
}
/// The most that was in use so far, bytes.
inline double peak_memory() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return 1024 * static_cast<double>(used.ru_maxrss);
}

/// One JSON object, printed as a line.
class JsonLine {
 public:
  JsonLine& add(const char* name, const std::string& text) { return put(name, '"' + text + '"'); }
  template <class Number, class = std::enable_if_t<std::is_integral_v<Number>>>  // C++17: as the peers are built
  JsonLine& add(const char* name, Number value) {
    return put(name, std::to_string(value));
  }
  /// What is not finite is null.
  JsonLine& add(const char* name, double value, int digits = 6) { return put(name, text_of(value, digits)); }
  JsonLine& add(const char* name, std::initializer_list<double> values, int digits = 6) {
    std::string list;
    for (const double value : values) list += (list.empty() ? "" : ", ") + text_of(value, digits);
    return put(name, '[' + list + ']');
  }
  void print() const { std::printf("{%s}\n", inside_.c_str()); }

 private:
  static std::string text_of(double value, int digits) {
    if (!std::isfinite(value)) return "null";
    char text[40];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
  }
  JsonLine& put(const char* name, const std::string& value) {
    inside_ += (inside_.empty() ? "\"" : ", \"") + std::string(name) + "\": " + value;
    return *this;
  }

  std::string inside_;
};

/// What the steps of one run have cost, and where its last point ended: equal equations end at equal points.
struct Cost {
  double seconds = 0;  // CPU, of the stepping loop alone
  long steps = 0, newton_iterations = 0, factorizations = 0;
  double tip[3] = {};  // m, world axes

  double microseconds_per_step() const { return 1e6 * seconds / static_cast<double>(steps); }
  JsonLine& add_to(JsonLine& line) const {
    const double n = static_cast<double>(steps);
    return line.add("us_per_step", microseconds_per_step(), 5)
        .add("newton_iterations_per_step", static_cast<double>(newton_iterations) / n, 5)
        .add("factorizations_per_step", static_cast<double>(factorizations) / n, 5)
        .add("steps", steps)
        .add("tip", {tip[0], tip[1], tip[2]}, 16);
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
