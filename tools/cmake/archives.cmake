# `cpack --config build/release/CPackConfig.cmake`: a .deb for the Debian it is made on and a tarball, each with the command, headers,
# libraries, plug-ins, pages and examples. tests/package/check_archives.sh unpacks both into an empty root.
install(DIRECTORY examples docs DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN "CMakeLists.txt" EXCLUDE)
install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(CPACK_GENERATOR DEB TGZ)
set(CPACK_PACKAGE_NAME lithe)
set(CPACK_PACKAGE_CONTACT "Lithe")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE zstd)  # smaller here than gzip, and made faster
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# `lithe run` compiles scenes against the shared library and Eigen alone; find_package(lithe) links the static ones.
set(compiler "g++ (>= 12)")
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  string(REGEX MATCH "^[0-9]+" version ${CMAKE_CXX_COMPILER_VERSION})
  string(PREPEND compiler "clang-${version} | ")
endif()
set(CPACK_DEBIAN_PACKAGE_DEPENDS "${compiler}, libeigen3-dev (>= 3.4)")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
    "gnuplot-nox, libbullet-dev, libhdf5-dev, libpugixml-dev, libspdlog-dev, libsuitesparse-dev, libsundials-dev, libzip-dev, zlib1g-dev")
include(CPack)
