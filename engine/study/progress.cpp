#include "engine/study/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace lithe {
namespace {

constexpr int kWidth = 20;  // of the bar, characters
constexpr double kMostGrowth = 4;

std::string clock_text(double seconds) {
  const long whole = std::lround(seconds);
  char text[32];
  if (whole >= 3600)
    std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
  else
    std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

}  // namespace

Progress::Progress(std::vector<int> runs_a_line, double longest, Show show, std::FILE* out)
    : longest_(longest), shown_(show == Show::always || (show == Show::on_terminal && isatty(fileno(out)))), out_(out) {
  for (int runs : runs_a_line) {
    Line line;
    line.left = runs;
    lines_.push_back(line);
    total_ += runs;
  }
}

Progress::~Progress() {
  if (shown_) std::fprintf(out_, "\r\033[K"), std::fflush(out_);
}

void Progress::begin(int line, const std::string& name) {
  line_ = line;
  name_ = name;
  begun_ = std::chrono::steady_clock::now();
  draw();
}

void Progress::end() { end(std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count()); }

void Progress::end(double seconds) {
  Line& line = lines_.at(line_);
  if (line.done > 0 && line.last > 0) line.growth = std::clamp(seconds / line.last, 1.0, kMostGrowth);
  line.last = seconds;
  ++line.done, --line.left, ++done_;
  draw();
}

void Progress::skip(int line, int runs) {
  lines_.at(line).left -= runs;
  total_ -= runs;
}

double Progress::Line::estimate(double longest) const {
  double sum = 0, next = last;
  for (int i = 0; i < left; ++i) sum += next = std::min(longest, next * growth);
  return sum;
}

double Progress::seconds_left() const {
  double sum = 0, mean = 0;
  int known = 0, unknown_runs = 0;
  for (const Line& line : lines_) {
    if (line.done > 0) {
      const double left = line.estimate(longest_);
      sum += left;
      mean += (left + line.last) / (line.left + 1);
      ++known;
    } else {
      unknown_runs += line.left;
    }
  }
  return known == 0 ? -1 : sum + unknown_runs * mean / known;
}

std::string Progress::text() const {
  const int filled = total_ == 0 ? kWidth : std::min(kWidth, kWidth * done_ / total_);
  std::string bar(kWidth, ' ');
  std::fill(bar.begin(), bar.begin() + filled, '=');
  if (filled < kWidth) bar[filled] = '>';
  const double left = seconds_left();
  return "[" + bar + "] " + std::to_string(done_) + "/" + std::to_string(total_) + "  " + name_ + "   left " +
         (left < 0 ? "?" : clock_text(left));
}

void Progress::draw() const {
  if (shown_) std::fprintf(out_, "\r\033[K%s", text().c_str()), std::fflush(out_);
}

}  // namespace lithe
