# Clang 16 builds Lithe in three fifths of the time that GCC 12 takes (docs/benchmarks/build.md). It is chosen where it is
# installed, with the OpenMP header that SUNDIALS asks for, unless CC, CXX, a toolchain or a preset names a compiler.
if(CMAKE_C_COMPILER OR CMAKE_CXX_COMPILER OR CMAKE_TOOLCHAIN_FILE OR DEFINED ENV{CC} OR DEFINED ENV{CXX})
  return()
endif()
find_program(LITHE_CLANG clang-16)
find_program(LITHE_CLANGXX clang++-16)
find_path(LITHE_CLANG_OPENMP omp.h PATHS /usr/lib/llvm-16/lib/clang/16/include NO_DEFAULT_PATH)
mark_as_advanced(LITHE_CLANG LITHE_CLANGXX LITHE_CLANG_OPENMP)
if(LITHE_CLANG AND LITHE_CLANGXX AND LITHE_CLANG_OPENMP)
  set(CMAKE_C_COMPILER ${LITHE_CLANG})
  set(CMAKE_CXX_COMPILER ${LITHE_CLANGXX})
endif()
