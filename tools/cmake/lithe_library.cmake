# lithe_library(engine DEPENDS ... PRIVATE ...): one library a folder, all its .cpp files; repeats HOUSE's arrows to the
# linker. Sources are globbed: a new body, joint or integrator is one new file.
add_library(lithe_flags INTERFACE)
target_compile_options(lithe_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                       $<$<BOOL:${LITHE_WARNINGS_AS_ERRORS}>:-Werror>)
# GCC 12 reports false positives of these two inside Eigen at -O3.
target_compile_options(lithe_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-array-bounds>)

function(lithe_library name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;PRIVATE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_library(${name} STATIC ${sources})
  add_library(lithe::${name} ALIAS ${name})
  set_target_properties(${name} PROPERTIES OUTPUT_NAME lithe_${name})
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/lithe_headers>)
  target_link_libraries(${name} PUBLIC ${ARG_DEPENDS} PRIVATE $<BUILD_INTERFACE:lithe_flags> ${ARG_PRIVATE})
  if(LITHE_NATIVE)
    # Eigen's alignment follows the instruction set, so users of the library must be compiled with the same one.
    target_compile_options(${name} PUBLIC -march=native)
  endif()
endfunction()
