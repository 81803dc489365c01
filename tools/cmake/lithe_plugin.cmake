# lithe_add_plugin(my_joint my_joint.cpp ...): a library that Registry::load_plugin() loads, my_joint.so. Its sources
# include engine/plugin.h and export their classes with LITHE_EXPORT_JOINT and its like. What it uses of the engine (the
# rows joints are composed of, rotations, checks) is linked into it and hidden: the library needs no symbol of its host
# and exports one, lithe_plugin_v1. Compiled for the engine's instruction set, so that rows are those of a class compiled
# in, bit by bit.
set(LITHE_PLUGIN_SYMBOLS ${CMAKE_CURRENT_LIST_DIR}/lithe_plugin.map)

function(lithe_add_plugin name)
  add_library(${name} MODULE ${ARGN})
  add_dependencies(${name} lithe::engine)
  set_target_properties(${name} PROPERTIES PREFIX "" CXX_EXTENSIONS OFF CXX_VISIBILITY_PRESET hidden
                        VISIBILITY_INLINES_HIDDEN ON LINK_DEPENDS "${LITHE_PLUGIN_SYMBOLS};$<TARGET_FILE:lithe::engine>")
  target_compile_features(${name} PRIVATE cxx_std_20)
  target_compile_definitions(${name} PRIVATE LITHE_PLUGIN)
  target_include_directories(${name} PRIVATE $<TARGET_PROPERTY:lithe::engine,INTERFACE_INCLUDE_DIRECTORIES>)
  target_compile_options(${name} PRIVATE $<TARGET_PROPERTY:lithe::engine,INTERFACE_COMPILE_OPTIONS>)
  # The archive alone, not the target: a plug-in has no use for the packages that the engine links.
  target_link_libraries(${name} PRIVATE $<TARGET_FILE:lithe::engine> Eigen3::Eigen)
  target_link_options(${name} PRIVATE LINKER:--version-script=${LITHE_PLUGIN_SYMBOLS})
  # What is missing is told here, not when a scene loads it. (Clang's sanitizers live in the host.)
  if(NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize")
    target_link_options(${name} PRIVATE LINKER:-z,defs)
  endif()
endfunction()
