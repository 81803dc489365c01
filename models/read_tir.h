#pragma once

#include <filesystem>

#include "joints/tyre/tyre_coefficients.h"

namespace lithe {

/// Reads a tyre property file (.tir) of MF-Tyre: FITTYP 6 (MF-Tyre 5.2), 60, 61 and 62. Sections [NAME], lines
/// NAME = value, comments from $ or ! on. Lengths, forces, times, pressures and the angles of ranges are converted by
/// [UNITS], SI without it; coefficients of the formula stay as they are, in radians. What a file does not give has the
/// default of TyreCoefficients. Coefficients that no formula here uses (turn slip, rigid ring, contact patch) and are
/// not zero are listed in one warning. Throws FileError, naming file and line, for a file that cannot be read, lines
/// that are neither, a section or coefficient that is missing or there twice, a number that is none or not finite, an
/// unknown unit and another FITTYP.
TyreCoefficients read_tir(const std::filesystem::path& path);

}  // namespace lithe
