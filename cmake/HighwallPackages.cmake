# Debian packages, by scripts/make_packages: cpack in a build of the preset `package`. One for each
# group of install components.
#   libhighwall0      shared libraries              libhighwall-dev   headers, CMake, pkg-config
#   highwall-tools    highwall, highwall_bench_tum  python3-highwall  the Python module
#   highwall-doc      pages, reference, examples
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME highwall)
set(CPACK_PACKAGE_VENDOR "The Highwall authors")
set(HIGHWALL_PACKAGE_CONTACT "The Highwall authors <highwall@users.noreply.github.com>" CACHE STRING
    "Who the packages say to write to: name <address>")
set(CPACK_PACKAGE_CONTACT "${HIGHWALL_PACKAGE_CONTACT}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "")
foreach(module IN LISTS modules)
  list(APPEND CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/${module})
endforeach()
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

# highwall_package(name COMPONENTS ... SECTION ... SUMMARY ... DESCRIPTION ... [ARCHITECTURE all]
#                  [DEPENDS ...] [RECOMMENDS ...])
# Adds copyright and changelog as Debian's policy requires (12.5, 12.7). DEPENDS: dependencies in
# addition to the shared libraries of other packages, which are detected automatically.
function(highwall_package package)
  cmake_parse_arguments(PARSE_ARGV 1 ARG ""
    "SECTION;SUMMARY;DESCRIPTION;ARCHITECTURE;DEPENDS;RECOMMENDS" "COMPONENTS")
  string(MAKE_C_IDENTIFIER ${package} group)
  string(TOUPPER ${group} key)
  list(GET ARG_COMPONENTS 0 first)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/debian/copyright ${PROJECT_BINARY_DIR}/changelog.gz
          DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package} COMPONENT ${first}
          EXCLUDE_FROM_ALL)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${package} PARENT_SCOPE)
  foreach(field IN ITEMS SECTION ARCHITECTURE DEPENDS RECOMMENDS)
    if(ARG_${field})
      set(CPACK_DEBIAN_${key}_PACKAGE_${field} "${ARG_${field}}" PARENT_SCOPE)
    endif()
  endforeach()
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${ARG_SUMMARY}\n${ARG_DESCRIPTION}" PARENT_SCOPE)
  foreach(component IN LISTS ARG_COMPONENTS)
    string(TOUPPER ${component} component_key)
    set(CPACK_COMPONENT_${component_key}_GROUP ${group} PARENT_SCOPE)
  endforeach()
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${ARG_COMPONENTS} PARENT_SCOPE)
endfunction()

# Debian's form of a changelog, which refers to ours. SOURCE_DATE_EPOCH sets its date.
string(TIMESTAMP changelog_date "%a, %d %b %Y 00:00:00 +0000" UTC)
configure_file(${CMAKE_CURRENT_LIST_DIR}/debian/changelog.in ${PROJECT_BINARY_DIR}/changelog @ONLY)
execute_process(COMMAND gzip -9nc INPUT_FILE ${PROJECT_BINARY_DIR}/changelog
                OUTPUT_FILE ${PROJECT_BINARY_DIR}/changelog.gz COMMAND_ERROR_IS_FATAL ANY)

set(same "(= ${PROJECT_VERSION})")
highwall_package(libhighwall${HIGHWALL_SOVERSION} COMPONENTS runtime SECTION libs
  SUMMARY "point-line RGB-D-inertial SLAM - shared libraries"
  DESCRIPTION "Factor graph, residuals, SLAM system and dense maps for RGB-D cameras,\nwith or \
without an IMU.")
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_LIBHIGHWALL${HIGHWALL_SOVERSION}_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/cmake/debian/triggers)
highwall_package(libhighwall-dev COMPONENTS ${modules} SECTION libdevel
  SUMMARY "point-line RGB-D-inertial SLAM - headers"
  DESCRIPTION "Headers, and what CMake and pkg-config need to find the libraries, each\nmodule by \
itself: core, factors, frontend, mapping."
  DEPENDS "libhighwall${HIGHWALL_SOVERSION} ${same}, libceres-dev, libeigen3-dev"
  # Users of core and factors alone need nothing of OpenCV.
  RECOMMENDS "libopencv-dev, cmake, g++, pkgconf")
if(HIGHWALL_BUILD_APPS)
  highwall_package(highwall-tools COMPONENTS apps SECTION science
    SUMMARY "point-line RGB-D-inertial SLAM - programs"
    DESCRIPTION "SLAM over recordings, their errors, dense maps, calibration, simulated\n\
recordings; and a benchmark over TUM RGB-D."
    DEPENDS "libhighwall${HIGHWALL_SOVERSION} ${same}"
    RECOMMENDS "highwall-doc")
endif()
if(TARGET highwall_python)
  math(EXPR python_next "${Python3_VERSION_MINOR} + 1")
  set(python_now ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR})
  highwall_package(python3-highwall COMPONENTS python SECTION python
    SUMMARY "point-line RGB-D-inertial SLAM - Python module"
    DESCRIPTION "Residuals, factor graph, trajectories, SLAM system and dense maps for\nPython, with \
NumPy arrays."
    DEPENDS "libhighwall${HIGHWALL_SOVERSION} ${same}, \
python3 (>= ${python_now}), python3 (<< ${Python3_VERSION_MAJOR}.${python_next}), python3-numpy")
endif()
highwall_package(highwall-doc COMPONENTS docs SECTION doc ARCHITECTURE all
  SUMMARY "point-line RGB-D-inertial SLAM - manual"
  DESCRIPTION "Pages, tutorials, reference and examples."
  RECOMMENDS "libjs-mathjax")
include(CPack)
