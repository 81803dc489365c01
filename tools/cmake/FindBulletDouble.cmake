# Bullet::Double, the double-precision Bullet. find_package(Bullet) silently gives the single-precision libraries, so
# this one asks pkg-config by name. Also installed beside lithe's own package.
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(BULLET_DOUBLE QUIET IMPORTED_TARGET GLOBAL bullet-float64)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(BulletDouble REQUIRED_VARS BULLET_DOUBLE_LINK_LIBRARIES
                                  VERSION_VAR BULLET_DOUBLE_VERSION)

if(BulletDouble_FOUND AND NOT TARGET Bullet::Double)
  # Debian's .pc names /usr/include too. As -isystem of one source it comes before the C++ library's headers, which then
  # do not find the <stdlib.h> behind them.
  get_target_property(bullet_folders PkgConfig::BULLET_DOUBLE INTERFACE_INCLUDE_DIRECTORIES)
  if(bullet_folders AND CMAKE_CXX_IMPLICIT_INCLUDE_DIRECTORIES)
    list(REMOVE_ITEM bullet_folders ${CMAKE_CXX_IMPLICIT_INCLUDE_DIRECTORIES})
    set_target_properties(PkgConfig::BULLET_DOUBLE PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${bullet_folders}")
  endif()
  add_library(Bullet::Double ALIAS PkgConfig::BULLET_DOUBLE)
endif()
