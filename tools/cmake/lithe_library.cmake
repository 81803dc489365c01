# lithe_library(engine DEPENDS ... PRIVATE ... HEADERS_ONLY ...): one library a folder, all its .cpp files; repeats
# HOUSE's arrows to the linker. Sources are globbed: a new body, joint or integrator is one new file. HEADERS_ONLY
# packages are seen by the .cpp files alone, so users of the installed package need not have them.
add_library(lithe_flags INTERFACE)
target_compile_options(lithe_flags INTERFACE -Wall -Wextra -Wpedantic -Wnon-virtual-dtor
                       $<$<BOOL:${LITHE_WARNINGS_AS_ERRORS}>:-Werror>)
# A constructor's parameter may bear its member's name: Clang's -Wshadow allows that, GCC's needs to be told.
target_compile_options(lithe_flags INTERFACE $<IF:$<CXX_COMPILER_ID:GNU>,-Wshadow=local,-Wshadow>)
# Scenes name the parameters they set and leave the rest at their defaults.
target_compile_options(lithe_flags INTERFACE -Wno-missing-field-initializers)
# Registers of four numbers (engine/base/lanes.h) stay within one source: how they would be passed elsewhere is no matter.
target_compile_options(lithe_flags INTERFACE -Wno-psabi)
# GCC 12 reports false positives at -O3: the first two inside Eigen, the third inside std::string (GCC bug 105651), the
# last three in its AVX-512 header. In a unity build it takes every source but one for a header, whose classes must not
# have members of types that are local to a source.
target_compile_options(lithe_flags INTERFACE
                       $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-array-bounds -Wno-restrict
                       -Wno-stringop-overflow -Wno-stringop-overread -Wno-subobject-linkage>
                       $<$<AND:$<CXX_COMPILER_ID:GNU>,$<OR:$<BOOL:${LITHE_NATIVE}>,$<STREQUAL:${LITHE_ARCH},x86-64-v4>>>:-Wno-uninitialized>)

# Of inline functions that a target of less optimisation has too, the linker then keeps the libraries' own.
function(lithe_libraries_first target)
  set(first "")
  foreach(library ${LITHE_LIBRARIES})
    string(APPEND first " $<TARGET_FILE:${library}>")
  endforeach()
  get_target_property(type ${target} TYPE)
  if(type STREQUAL INTERFACE_LIBRARY)
    set(scope INTERFACE)
  else()
    set(scope PRIVATE)
  endif()
  target_link_options(${target} ${scope} "SHELL:-Wl,--whole-archive${first} -Wl,--no-whole-archive")
endfunction()

function(lithe_library name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;PRIVATE;HEADERS_ONLY" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_library(${name} STATIC ${sources})
  add_library(lithe::${name} ALIAS ${name})
  set_target_properties(${name} PROPERTIES OUTPUT_NAME lithe_${name})
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/lithe_headers>)
  target_link_libraries(${name} PUBLIC ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE})
  foreach(package lithe_flags ${ARG_HEADERS_ONLY})
    target_link_libraries(${name} PRIVATE $<BUILD_INTERFACE:${package}>)
  endforeach()
  target_compile_options(${name} PUBLIC ${LITHE_ARCH_FLAGS})
endfunction()
