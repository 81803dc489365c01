# The package: `cmake --install <build> --prefix P`, then find_package(lithe CONFIG), target_link_libraries(app
# lithe::lithe) and #include "lithe/lithe.h" elsewhere. tests/package/ is such a project.
include(CMakePackageConfigHelpers)
set(LITHE_LIBRARIES models integrators joints bodies engine)  # users first: the order static libraries want

# lithe/lithe.h includes every public header. It is generated, since no folder below examples/ may include all others.
set(header_globs ${LITHE_LIBRARIES})
list(TRANSFORM header_globs REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/\\1/*.h")
file(GLOB_RECURSE public_headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} ${header_globs})
# What no scene names, and would pay for with each compile: factors, kernels, the insides of assembly, contact and runs,
# what the readers and reductions are made of.
foreach(internal
    assembly/.* "cones/(cone_|contact_|dense_|friction_|joint_).*" contact/.* factor/.* fmu/.* forward/.* base/dense.* base/four_vectors base/temporary_folder
    analysis/perturbation analysis/static_equations
    gradient/contact_numbers gradient/differences gradient/event_derivative gradient/event_landing gradient/moved_drawing
    gradient/parameter_derivative gradient/parameter_terms gradient/recorded_run gradient/repeated_steps
    gradient/row_rates gradient/sample_weights gradient/sensor_derivative gradient/static_derivative
    gradient/tangent_equations gradient/unreached_directions
    motion/chart_maps motion/kept_factor motion/singular_pose motion/step_derivative
    plugin/.*_from_c plugin/.*_to_c run/driven_oscillator run/event_finder run/followed_inputs run/island_run
    simplify/rows_in_plane simplify/stand_in study/model_error study/model_run study/recorded_wrench)
  list(FILTER public_headers EXCLUDE REGEX "^engine/${internal}\\.h$")
endforeach()
list(APPEND public_headers engine/assembly/batch_of.h)  # scenes with elements of their own
foreach(internal dof_table fixed_columns labelled_mesh matrix_entries ansys_archive nastran_deck shape_functions elastic_problem
    static_modes general_inertia eigen_modes quadratic_deflection readers/text_file)
  list(FILTER public_headers EXCLUDE REGEX "/${internal}\\.h$")
endforeach()
list(FILTER public_headers EXCLUDE REGEX "_internal\\.h$|(^|/)detail/")
list(SORT public_headers)
list(TRANSFORM public_headers REPLACE "(.+)" "#include \"\\1\"" OUTPUT_VARIABLE include_lines)
list(JOIN include_lines "\n" LITHE_INCLUDES)
configure_file(${CMAKE_CURRENT_LIST_DIR}/lithe.h.in ${PROJECT_BINARY_DIR}/include/lithe/lithe.h @ONLY)

add_library(lithe INTERFACE)
add_library(lithe::lithe ALIAS lithe)
target_include_directories(lithe INTERFACE $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>
                           $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(lithe INTERFACE ${LITHE_LIBRARIES})

# Headers keep their folders, so "engine/model/body.h" means the same installed as here. The private ones come along: a
# public template may lean on one.
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/lithe)
install(TARGETS lithe ${LITHE_LIBRARIES} EXPORT lithe_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/lithe)
install(EXPORT lithe_targets NAMESPACE lithe:: FILE lithe-targets.cmake DESTINATION ${package_dir})
install(FILES ${PROJECT_BINARY_DIR}/include/lithe/lithe.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lithe)
foreach(library ${LITHE_LIBRARIES})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${library} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lithe_headers
          FILES_MATCHING PATTERN "*.h")
endforeach()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/lithe-config.cmake.in
                              ${PROJECT_BINARY_DIR}/package/lithe-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/lithe-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/lithe-config.cmake ${PROJECT_BINARY_DIR}/package/lithe-config-version.cmake
        ${CMAKE_CURRENT_LIST_DIR}/FindCHOLMOD.cmake ${CMAKE_CURRENT_LIST_DIR}/FindBulletDouble.cmake
        ${CMAKE_CURRENT_LIST_DIR}/FindHDF5Serial.cmake
        ${CMAKE_CURRENT_LIST_DIR}/lithe_plugin.cmake ${CMAKE_CURRENT_LIST_DIR}/lithe_plugin.map
        DESTINATION ${package_dir})
