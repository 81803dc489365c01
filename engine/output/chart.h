#pragma once

#include <string>
#include <vector>

namespace lithe {

enum class LineStyle {
  solid,
  dashed,  // thin, dark and above the others: a reference or an exact answer
  marked,  // line and symbols: measured samples such as a work-precision curve
  points,  // symbols alone
};

struct ChartLine {
  std::string title;         // for the legend; plain text, no markup
  std::vector<double> x, y;  // equally long, finite; positive on a logarithmic axis
  LineStyle style = LineStyle::solid;
};

/// A picture of y over x. Texts are plain: underscores and braces appear as written. Name units in the labels.
struct Chart {
  std::string title, x_label, y_label;
  std::vector<ChartLine> lines;
  bool log_x = false, log_y = false;
};

/// Draws a chart with gnuplot (its one home) as path.svg and path.png, 1200 x 750, colours told apart by colour-blind
/// readers too (Okabe & Ito). Parent folders are created; the files appear under their names only when complete.
/// Throws SceneError naming the line that is empty, has unequal x and y, or a value that cannot be drawn;
/// Error if gnuplot is missing or fails; FileError if the pictures cannot be written.
void write_chart(const Chart& chart, const std::string& path_without_extension);

}  // namespace lithe
