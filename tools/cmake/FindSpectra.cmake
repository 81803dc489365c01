# Spectra::Spectra, headers only; Debian's package brings no CMake files.
find_path(SPECTRA_INCLUDE_DIR Spectra/SymGEigsShiftSolver.h)
mark_as_advanced(SPECTRA_INCLUDE_DIR)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Spectra REQUIRED_VARS SPECTRA_INCLUDE_DIR)

if(Spectra_FOUND AND NOT TARGET Spectra::Spectra)
  add_library(Spectra::Spectra INTERFACE IMPORTED)
  set_target_properties(Spectra::Spectra PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${SPECTRA_INCLUDE_DIR})
endif()
