# Installed package: find_package(highwall COMPONENTS core factors frontend mapping).
include(CMakePackageConfigHelpers)
configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/highwallConfig.cmake.in ${PROJECT_BINARY_DIR}/highwallConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/highwall)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/highwallConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/highwallConfig.cmake
              ${PROJECT_BINARY_DIR}/highwallConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/highwall)
install(EXPORT highwallTargets NAMESPACE highwall::
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/highwall)
