#pragma once

#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

namespace lithe {

/// One moving line on stderr for work that takes minutes:
///   [=====>              ] 12/40  explicit Runge-Kutta 5(4) 1e-6   left 0:35
/// The work is a number of lines (methods), each a number of runs of growing cost (tolerances). The time left is
/// predicted from the runs done: a line's cost keeps growing as it did last, at most fourfold a run; a line without a
/// finished run costs what the others do on average.
class Progress {
 public:
  enum class Show { on_terminal, always, never };  // on_terminal: silent where stderr is not one
  /// `longest`: no run takes longer, s.
  Progress(std::vector<int> runs_a_line, double longest, Show show = Show::on_terminal, std::FILE* out = stderr);
  /// Wipes the line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// A run begins, and is named.
  void begin(int line, const std::string& name);
  /// It has ended and took so long; without an argument as long as the clock says since begin().
  void end(double seconds);
  void end();
  /// Runs of a line that will not take place.
  void skip(int line, int runs);

  double seconds_left() const;  // negative: nothing is known yet
  std::string text() const;

 private:
  struct Line {
    int left = 0, done = 0;
    double last = 0, growth = 2;  // s of the last run; over the one before
    double estimate(double longest) const;
  };
  void draw() const;

  std::vector<Line> lines_;
  double longest_;
  bool shown_;
  std::FILE* out_;
  int line_ = 0, done_ = 0, total_ = 0;
  std::string name_;
  std::chrono::steady_clock::time_point begun_;
};

}  // namespace lithe
