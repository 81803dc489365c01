# Clang builds Lithe in three fifths of the time that GCC 12 takes (docs/benchmarks/build.md): 16 of Debian 12, 19 of
# Debian 13. It is chosen where it is installed, with the OpenMP header that SUNDIALS asks for, unless CC, CXX, a toolchain
# or a preset names a compiler.
if(CMAKE_C_COMPILER OR CMAKE_CXX_COMPILER OR CMAKE_TOOLCHAIN_FILE OR DEFINED ENV{CC} OR DEFINED ENV{CXX})
  return()
endif()
foreach(version 16 19)
  find_program(LITHE_CLANG_${version} clang-${version})
  find_program(LITHE_CLANGXX_${version} clang++-${version})
  find_path(LITHE_CLANG_OPENMP_${version} omp.h PATHS /usr/lib/llvm-${version}/lib/clang/${version}/include NO_DEFAULT_PATH)
  mark_as_advanced(LITHE_CLANG_${version} LITHE_CLANGXX_${version} LITHE_CLANG_OPENMP_${version})
  if(LITHE_CLANG_${version} AND LITHE_CLANGXX_${version} AND LITHE_CLANG_OPENMP_${version})
    set(CMAKE_C_COMPILER ${LITHE_CLANG_${version}})
    set(CMAKE_CXX_COMPILER ${LITHE_CLANGXX_${version}})
    break()
  endif()
endforeach()
