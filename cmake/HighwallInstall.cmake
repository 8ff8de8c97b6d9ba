# Installed package: find_package(highwall COMPONENTS core factors frontend mapping). Each module
# has an export set of its own, so that each works without the others that it does not need:
#   cmake --install build --component core
# With -DBUILD_SHARED_LIBS=ON the component runtime contains the files that programs need to run.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/highwall)
foreach(module IN LISTS modules)
  install(EXPORT highwall_${module} FILE highwall_${module}.cmake NAMESPACE highwall::
          DESTINATION ${package_dir} COMPONENT ${module})
endforeach()
if(BUILD_SHARED_LIBS)
  set(HIGHWALL_SHARED ON)
else()
  set(HIGHWALL_SHARED OFF)
endif()
configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/highwallConfig.cmake.in ${PROJECT_BINARY_DIR}/highwallConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/highwallConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
# Every module needs core.
install(FILES ${PROJECT_BINARY_DIR}/highwallConfig.cmake
              ${PROJECT_BINARY_DIR}/highwallConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT core)
include(${CMAKE_CURRENT_LIST_DIR}/HighwallPkgConfig.cmake)

# README.md and docs/ are installed side by side, as in the source, so that their links are valid;
# the notes of docs/lab/ stay in the repository.
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT core)
install(FILES README.md CHANGELOG.md CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT docs)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT docs PATTERN lab EXCLUDE)
foreach(module IN ITEMS core factors frontend mapping)
  install(FILES tests/consumer/use_${module}.cc DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs/examples
          COMPONENT docs)
endforeach()
