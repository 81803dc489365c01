#include "engine/output/chart.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <system_error>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/output/gnuplot.h"
#include "engine/output/partial_file.h"

namespace lithe {

namespace {

// Okabe & Ito's palette without its yellow, too pale for a line on white, and its black, kept for references.
constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"};
constexpr int kSymbols[] = {7, 5, 9, 13, 11, 6};  // filled circle, square, triangle, diamond, triangle down; ring
constexpr const char* kDashes[] = {"(9,6)", "(2,4)", "(12,5,2,5)", "(4,3)"};
constexpr int kColourCount = 6, kDashCount = 4;

std::string number(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

void require_drawable(const ChartLine& line, const std::vector<double>& values, const std::string& axis,
                      bool logarithmic) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string where = "line '" + line.title + "', " + axis + "[" + std::to_string(i) + "]";
    if (!std::isfinite(values[i]))
      throw SceneError("a chart cannot show the value " + number(values[i]) + ".", where,
                       "leave the point out, or find where the value became infinite or undefined.");
    if (logarithmic && values[i] <= 0)
      throw SceneError("a logarithmic axis cannot show the value " + number(values[i]) + ".", where,
                       "raise values to a floor such as 1e-16, or draw the axis linearly.");
  }
}

void require_drawable(const Chart& chart) {
  if (chart.lines.empty())
    throw SceneError("the chart has no lines.", "chart '" + chart.title + "'", "add at least one ChartLine.");
  for (const auto& line : chart.lines) {
    if (line.x.empty() || line.x.size() != line.y.size())
      throw SceneError("a chart line has " + std::to_string(line.x.size()) + " x and " + std::to_string(line.y.size()) +
                           " y values.",
                       "line '" + line.title + "'", "give as many y as x, at least one.");
    require_drawable(line, line.x, "x", chart.log_x);
    require_drawable(line, line.y, "y", chart.log_y);
  }
}

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  double span() const { return high - low; }
  double largest() const { return std::max(std::abs(low), std::abs(high)); }
};

Range value_range(const Chart& chart, char axis) {
  Range range;
  for (const auto& line : chart.lines) {
    const auto [least, greatest] = std::ranges::minmax(axis == 'x' ? line.x : line.y);
    range = {std::min(range.low, least), std::max(range.high, greatest)};
  }
  return range;
}

// Ticks of a logarithmic axis, `decades` being the logarithm of its range: whole powers of ten on a long axis, at most
// eight of them, and numbers between them on a short one, which gnuplot alone would leave without any.
void write_logarithmic_ticks(std::ostream& script, char axis, const Range& decades) {
  script << "set logscale " << axis << "\n";
  if (decades.span() >= 2) {
    const int step = std::max(1, static_cast<int>(std::ceil(decades.span() / 8)));
    script << "set format " << axis << " '10^{%L}'\nset " << axis << "tics 1e" << step << "\n";
    if (step > 1) script << "set m" << axis << "tics 1\n";
    return;
  }
  const std::vector<int> digits = decades.span() >= 1 ? std::vector{1, 2, 5} : std::vector{1, 2, 3, 4, 5, 6, 7, 8, 9};
  std::string ticks;
  for (int power = static_cast<int>(std::floor(decades.low)); power <= decades.high; ++power) {
    for (const int digit : digits) {
      if (!ticks.empty()) ticks += ", ";
      ticks += std::to_string(digit) + "e" + std::to_string(power);
    }
  }
  script << "set " << axis << "tics (" << ticks << ")\n";
}

// Range, scale and tick labels of the axis 'x' or 'y'. Gnuplot's own range would clip symbols at the border, and its
// labels of six digits would all read the same along a value that hardly changes, such as a conserved energy.
void write_axis(std::ostream& script, const Chart& chart, char axis, bool logarithmic, double margin) {
  Range range = value_range(chart, axis);
  // Within a factor of two a logarithmic axis looks linear, and has too few round powers to be labelled: draw it so.
  if (logarithmic && range.high > range.low && range.high < 2 * range.low) logarithmic = false;
  if (logarithmic) range = {std::log10(range.low), std::log10(range.high)};

  if (range.span() <= 1e-13 * range.largest()) {
    // Equal but for rounding: a flat line in the middle, not a picture of the rounding.
    const double half = logarithmic ? 0.5 : (range.largest() > 0 ? 0.1 * range.largest() : 1.0);
    range = {range.low - half, range.high + half};
  }
  const double extra = margin * range.span();
  range = {range.low - extra, range.high + extra};

  script << "set format " << axis << " '%h'\n";
  if (logarithmic) {
    write_logarithmic_ticks(script, axis, range);
    range = {std::pow(10, range.low), std::pow(10, range.high)};
  } else if (const int digits = static_cast<int>(std::ceil(std::log10(range.largest() / range.span()))) + 2;
             digits > 6) {
    script << "set format " << axis << " '%." << digits << "g'\n";
  }
  script << "set " << axis << "range [" << number(range.low) << ":" << number(range.high) << "]\n";
}

bool has_symbols(const ChartLine& line) { return line.style == LineStyle::marked || line.style == LineStyle::points; }

// The `with …` of each line. Lines beyond the palette repeat its colours, with dashes and other symbols.
std::vector<std::string> line_looks(const std::vector<ChartLine>& lines) {
  std::vector<std::string> looks;
  int coloured = 0, dashed = 0;
  for (const auto& line : lines) {
    if (line.style == LineStyle::dashed) {
      looks.push_back("with lines lw 1.8 lc rgb '#222222' dt " + std::string(kDashes[dashed++ % kDashCount]));
      continue;
    }
    const int turn = coloured / kColourCount, index = coloured++ % kColourCount;
    const std::string colour = std::string(" lc rgb '") + kColours[index] + "'";
    const std::string symbol = " pt " + std::to_string(kSymbols[(index + turn) % kColourCount]) + " ps 1.2";
    const std::string dash = turn == 0 ? "" : std::string(" dt ") + kDashes[(turn - 1) % kDashCount];
    if (line.style == LineStyle::points)
      looks.push_back("with points" + symbol + colour);
    else if (line.style == LineStyle::marked)
      looks.push_back("with linespoints lw 2.5" + symbol + colour + dash);
    else
      looks.push_back("with lines lw 2.8" + colour + dash);
  }
  return looks;
}

void write_plot_command(std::ostream& script, const Chart& chart) {
  const auto looks = line_looks(chart.lines);
  std::vector<std::size_t> order(chart.lines.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  // References go on top, or a curve that agrees with its reference would hide it.
  std::stable_partition(order.begin(), order.end(),
                        [&](std::size_t i) { return chart.lines[i].style != LineStyle::dashed; });

  for (std::size_t k = 0; k < order.size(); ++k) {
    const ChartLine& line = chart.lines[order[k]];
    script << (k == 0 ? "plot " : ", \\\n     ") << "$line" << order[k] << " using 1:2 " << looks[order[k]]
           << (line.title.empty() ? " notitle" : " title " + gnuplot_text(line.title) + " noenhanced");
  }
  script << "\n";
}

void write_script(std::ostream& script, const Chart& chart, const std::string& svg_path, const std::string& png_path) {
  // 1. The data, inside the script: no second file to find or to leave behind.
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    const ChartLine& line = chart.lines[i];
    script << "$line" << i << " << EOD\n";
    for (std::size_t k = 0; k < line.x.size(); ++k) script << number(line.x[k]) << " " << number(line.y[k]) << "\n";
    script << "EOD\n";
  }

  // 2. Labels, a quiet grid behind the data, the legend above it where it hides nothing. The title heads the legend if
  // there is one, since gnuplot would put its own title between legend and data.
  const bool legend = std::ranges::any_of(chart.lines, [](const ChartLine& line) { return !line.title.empty(); });
  script << "set encoding utf8\n"
            "set border 3 lw 1.2 lc rgb '#444444'\n"
            "set tics nomirror out textcolor rgb '#222222'\n"
            "set grid back lt 1 lw 0.8 lc rgb '#DDDDDD'\n"
            "set key outside top center horizontal reverse Left samplen 2.5 spacing 1.15 width 3 height 0.5\n"
            "set rmargin 4\nset bmargin 4\n"
         << (legend ? "set key title " : "set title ") << gnuplot_text(chart.title) << " noenhanced font ',16'\n"
         << "set xlabel " << gnuplot_text(chart.x_label) << " noenhanced font ',14'\n"
         << "set ylabel " << gnuplot_text(chart.y_label) << " noenhanced font ',14'\n";
  write_axis(script, chart, 'x', chart.log_x, std::ranges::any_of(chart.lines, has_symbols) ? 0.03 : 0.0);
  write_axis(script, chart, 'y', chart.log_y, 0.05);

  // 3. The same picture twice; svg counts letters in pixels, png in points of 4/3 pixel.
  script << "set terminal svg size 1200,750 font 'DejaVu Sans,12' fontscale 1.333 background '#FFFFFF'\n"
         << "set output " << gnuplot_text(svg_path) << "\n";
  write_plot_command(script, chart);
  script << "set terminal pngcairo size 1200,750 font 'DejaVu Sans,12' dashlength 1.8 background '#FFFFFF'\n"
         << "set output " << gnuplot_text(png_path) << "\n"
         << "replot\nunset output\n";
}

// Runs gnuplot on a script, its messages going to a file. Returns its exit status; throws Error if it cannot start.
int run_gnuplot(const std::string& script_path, const std::string& message_path) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, message_path.c_str(), O_WRONLY | O_TRUNC, 0);
  std::string program = "gnuplot", script = script_path;
  char* arguments[] = {program.data(), script.data(), nullptr};
  pid_t process = 0;
  const int failure = posix_spawnp(&process, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0)
    throw Error("gnuplot, which draws charts, cannot be started: " + std::generic_category().message(failure) + ".",
                "PATH", "apt-get install gnuplot-nox");
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) continue;
  return status;
}

}  // namespace

std::string gnuplot_text(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? "''" : std::string(1, c == '\n' || c == '\r' ? ' ' : c);
  return result + "'";
}

void draw_with_gnuplot(const std::string& path_without_extension, const GnuplotScript& write_commands) {
  // Script and messages are never committed, so they vanish with their names.
  PartialFile svg(path_without_extension + ".svg"), png(path_without_extension + ".png");
  PartialFile script(path_without_extension + ".gnuplot"), messages(path_without_extension + ".messages");
  write_commands(script.stream(), svg.temporary_path(), png.temporary_path());
  script.stream().flush();

  if (run_gnuplot(script.temporary_path(), messages.temporary_path()) != 0) {
    const std::string said = (std::ostringstream() << std::ifstream(messages.temporary_path()).rdbuf()).str();
    throw Error("gnuplot failed: " + said, path_without_extension + ".svg",
                "check that gnuplot has the terminals svg and pngcairo: apt-get install gnuplot-nox");
  }
  svg.commit();
  png.commit();
}

void write_chart(const Chart& chart, const std::string& path_without_extension) {
  require_drawable(chart);
  draw_with_gnuplot(path_without_extension,
                    [&](std::ostream& script, const std::string& svg_path, const std::string& png_path) {
                      write_script(script, chart, svg_path, png_path);
                    });
}

}  // namespace lithe
