#pragma once

#include <string>
#include <vector>

namespace lithe {

/// A field of a matrix of results: two short lines of text on a colour.
struct MatrixField {
  std::string text, detail;
  int colour = 0;  // index into MatrixChart::legend
};
struct MatrixRow {
  std::string title;
  std::vector<MatrixField> fields;  // rows may be of different lengths
};
/// Results shown by colour: one row of fields per subject, a legend above. Texts are plain, and cut where they do not
/// fit.
struct MatrixChart {
  std::string title;
  std::vector<std::string> legend;  // what the colours mean, at most four
  std::vector<MatrixRow> rows;
};

/// Draws it with gnuplot as path.svg and path.png, as high as it has rows; colours told apart by colour-blind readers
/// too (Okabe & Ito). Throws SceneError for a matrix without rows or a colour that the legend does not have; else as
/// write_chart().
void write_matrix_chart(const MatrixChart& chart, const std::string& path_without_extension);

}  // namespace lithe
