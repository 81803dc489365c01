#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// A matrix of an OUTPUT4 file; its rows are not named there.
struct Op4Matrix {
  std::string name;     // lower case
  SparseMatrix matrix;  // both triangles
};

/// Whether the file is a binary OUTPUT4 file, or text whose first line looks like the header of one.
bool is_op4(const std::string& path);

/// All real square matrices of a Nastran OUTPUT4 file: text (any format of numbers) or binary (records of Fortran,
/// either byte order, words of 4 or 8 bytes); dense columns or sparse ones, BIGMAT or not; single or double precision.
/// Rectangular and complex matrices are passed over. (MSC Nastran DMAP Programmer's Guide, OUTPUT4.)
/// Throws FileError naming file:line, or the byte of a binary file.
std::vector<Op4Matrix> read_op4(const std::string& path);

}  // namespace lithe
