#pragma once

#include <functional>
#include <ostream>
#include <string>

namespace lithe {

/// Writes the commands that draw one picture twice: as svg, then as png, at the paths given.
using GnuplotScript =
    std::function<void(std::ostream& script, const std::string& svg_path, const std::string& png_path)>;

/// Runs gnuplot on a script; path.svg and path.png appear under their names only when complete. Throws Error if
/// gnuplot is missing or fails, FileError if the pictures cannot be written. (In chart.cpp, gnuplot's one home.)
void draw_with_gnuplot(const std::string& path_without_extension, const GnuplotScript& write_commands);

/// Text as gnuplot quotes it: it knows no escapes but the doubled quote, and a line break would end the command.
std::string gnuplot_text(const std::string& text);

}  // namespace lithe
