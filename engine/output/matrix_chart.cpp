#include "engine/output/matrix_chart.h"

#include <algorithm>
#include <ostream>

#include "engine/base/error.h"
#include "engine/output/gnuplot.h"

namespace lithe {
namespace {

// Okabe & Ito's green, orange, vermilion and blue, light enough to be written on.
constexpr const char* kColours[] = {"#8FD3BD", "#F5D08A", "#F0A37C", "#9CC7E6"};
constexpr int kColourCount = 4;

// In pixels of the picture.
constexpr int kRowHeight = 46, kTitleWidth = 300, kFieldWidth = 232, kHeadHeight = 84, kMargin = 12;
constexpr std::size_t kTitleLetters = 42, kFieldLetters = 36;

/// At most so many letters (bytes that are not the continuation of one).
std::string cut(const std::string& text, std::size_t letters) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0) == 0x80) continue;
    if (++count > letters) return text.substr(0, i) + "…";
  }
  return text;
}

void require_drawable(const MatrixChart& chart) {
  const std::string where = "matrix chart '" + chart.title + "'";
  if (chart.rows.empty()) throw SceneError("the matrix has no rows.", where, "add at least one MatrixRow.");
  if (chart.legend.empty() || static_cast<int>(chart.legend.size()) > kColourCount)
    throw SceneError("the legend has " + std::to_string(chart.legend.size()) + " colours.", where, "name one to four.");
  for (const MatrixRow& row : chart.rows)
    for (const MatrixField& field : row.fields)
      if (field.colour < 0 || field.colour >= static_cast<int>(chart.legend.size()))
        throw SceneError("a field has colour " + std::to_string(field.colour) + ", which the legend does not name.",
                         where + ", row '" + row.title + "'", "number colours as the legend does, from 0.");
}

struct Pen {
  std::ostream& script;
  int height, objects = 0;

  /// From the upper left corner, pixels.
  void rectangle(int x, int y, int width, int tall, const char* colour) {
    script << "set object " << ++objects << " rectangle from " << x << "," << height - y << " to " << x + width << ","
           << height - y - tall << " fc rgb '" << colour << "' fillstyle solid border rgb '#FFFFFF' lw 2\n";
  }
  void text(int x, int y, const std::string& what, int size, const char* colour = "#222222") {
    script << "set label " << gnuplot_text(what) << " at " << x << "," << height - y << " left noenhanced font ',"
           << size << "' textcolor rgb '" << colour << "'\n";
  }
};

}  // namespace

void write_matrix_chart(const MatrixChart& chart, const std::string& path_without_extension) {
  require_drawable(chart);
  std::size_t columns = 1;
  for (const MatrixRow& row : chart.rows) columns = std::max(columns, row.fields.size());
  const int width = kTitleWidth + static_cast<int>(columns) * kFieldWidth + kMargin;
  const int height = kHeadHeight + static_cast<int>(chart.rows.size()) * kRowHeight + kMargin;

  draw_with_gnuplot(path_without_extension, [&](std::ostream& script, const std::string& svg, const std::string& png) {
    script << "set encoding utf8\nunset border\nunset tics\nunset key\n"
           << "set lmargin 0\nset rmargin 0\nset tmargin 0\nset bmargin 0\n"
           << "set xrange [0:" << width << "]\nset yrange [0:" << height << "]\n";
    Pen pen{script, height};
    pen.text(kMargin, 22, chart.title, 16);
    for (std::size_t i = 0; i < chart.legend.size(); ++i) {
      const int x = kTitleWidth + static_cast<int>(i) * kFieldWidth;
      pen.rectangle(x, 44, 24, 24, kColours[i]);
      pen.text(x + 32, 57, chart.legend[i], 12);
    }
    for (std::size_t r = 0; r < chart.rows.size(); ++r) {
      const int y = kHeadHeight + static_cast<int>(r) * kRowHeight;
      pen.text(kMargin, y + kRowHeight / 2, cut(chart.rows[r].title, kTitleLetters), 12);
      for (std::size_t c = 0; c < chart.rows[r].fields.size(); ++c) {
        const MatrixField& field = chart.rows[r].fields[c];
        const int x = kTitleWidth + static_cast<int>(c) * kFieldWidth;
        pen.rectangle(x, y, kFieldWidth, kRowHeight, kColours[field.colour]);
        pen.text(x + 8, y + 15, cut(field.text, kFieldLetters), 10);
        pen.text(x + 8, y + 32, cut(field.detail, kFieldLetters), 10, "#444444");
      }
    }
    const std::string size = std::to_string(width) + "," + std::to_string(height);
    // svg counts letters in pixels, png in points of 4/3 pixel.
    script << "set terminal svg size " << size << " font 'DejaVu Sans,12' fontscale 1.05 background '#FFFFFF'\n"
           << "set output " << gnuplot_text(svg) << "\nplot -1 notitle lc rgb '#FFFFFF'\n"
           << "set terminal pngcairo size " << size << " font 'DejaVu Sans,12' fontscale 0.8 background '#FFFFFF'\n"
           << "set output " << gnuplot_text(png) << "\nreplot\nunset output\n";
  });
}

}  // namespace lithe
