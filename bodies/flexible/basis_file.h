#pragma once

#include <memory>
#include <string>

#include "bodies/flexible/modal_basis.h"

namespace lithe {

/// Saves a reduced body, all of ModalBasis, to one HDF5 file; read_modal_basis() gives it back bit by bit. The file
/// appears when it is complete. Layout: one data set a member, matrices column by column; sparse ones as rows, columns,
/// values; version in the attribute "version" of "/". FileError if it cannot be written.
void write_modal_basis(const ModalBasis& basis, const std::string& path);

/// FileError for a file that is missing, cut, damaged, of another kind or a newer version, or whose parts do not fit
/// one another.
std::shared_ptr<const ModalBasis> read_modal_basis(const std::string& path);

}  // namespace lithe
