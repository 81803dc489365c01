# The instruction set of everything that is built, and of scenes and outside projects with it, since Eigen's alignment
# follows it: LITHE_ARCH_FLAGS. x86-64-v3 (AVX2, FMA) is one machine code for all processors that have these; its
# price against -march=native is not measured yet.
include(CheckCXXSourceRuns)
set(LITHE_ARCH_FLAGS "")
if(LITHE_NATIVE)
  set(LITHE_ARCH_FLAGS -march=native)
elseif(LITHE_ARCH AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(LITHE_ARCH_FLAGS -march=${LITHE_ARCH})
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND LITHE_ARCH_FLAGS AND NOT CMAKE_CROSSCOMPILING)
  file(READ ${CMAKE_CURRENT_LIST_DIR}/wide_constants.cpp wide_constants)
  set(CMAKE_REQUIRED_FLAGS "-O2 ${LITHE_ARCH_FLAGS}")
  check_cxx_source_runs("${wide_constants}" LITHE_WIDE_CONSTANTS_ARE_SOUND)
  if(NOT LITHE_WIDE_CONSTANTS_ARE_SOUND)
    list(APPEND LITHE_ARCH_FLAGS -mtune-ctrl=^inter_unit_moves_to_vec)  # no wide constants from general registers
  endif()
  unset(CMAKE_REQUIRED_FLAGS)
endif()
