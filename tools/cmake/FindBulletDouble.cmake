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
  add_library(Bullet::Double ALIAS PkgConfig::BULLET_DOUBLE)
endif()
