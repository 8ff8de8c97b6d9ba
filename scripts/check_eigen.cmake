# Checks that Eigen 3.4 and newer are accepted, and an older one refused by its version: where
# Highwall is built (cmake/HighwallEigen.cmake), and where it is installed (highwallConfig.cmake).
# The packages of Eigen and Ceres are mock packages made here, with version files like the real
# ones.
# Usage: cmake -D ROOT=<project> -D WORK=<folder> -P scripts/check_eigen.cmake
cmake_minimum_required(VERSION 3.23)
set(CMAKE_FIND_USE_CMAKE_SYSTEM_PATH OFF)  # nor is any other found
set(CMAKE_FIND_USE_SYSTEM_ENVIRONMENT_PATH OFF)
set(CMAKE_FIND_USE_CMAKE_ENVIRONMENT_PATH OFF)
set(CMAKE_FIND_USE_PACKAGE_REGISTRY OFF)

if(ASK STREQUAL "build")  # one question, in a process of its own
  include(${ROOT}/cmake/HighwallEigen.cmake)
  return()
elseif(ASK STREQUAL "package")
  find_package(highwall REQUIRED COMPONENTS core)
  return()
endif()

include(CMakePackageConfigHelpers)
function(make_package prefix name version)
  file(WRITE ${prefix}/cmake/${name}Config.cmake "")
  write_basic_package_version_file(${prefix}/cmake/${name}ConfigVersion.cmake VERSION ${version}
                                   COMPATIBILITY SameMajorVersion ARCH_INDEPENDENT)
endfunction()

file(REMOVE_RECURSE ${WORK})
set(wrong "")
foreach(case IN ITEMS "3.3.9 refused" "3.4.0 accepted" "3.4.90 accepted" "5.0.0 accepted"
                      "5.0.1 accepted" "6.1.0 accepted")
  string(REPLACE " " ";" case "${case}")
  list(GET case 0 version)
  list(GET case 1 expected)
  set(prefix ${WORK}/${version})
  make_package(${prefix} Eigen3 ${version})
  make_package(${prefix} Ceres 2.2.0)
  set(HIGHWALL_SHARED OFF)
  configure_package_config_file(${ROOT}/cmake/highwallConfig.cmake.in
                                ${prefix}/cmake/highwallConfig.cmake
                                INSTALL_DESTINATION cmake INSTALL_PREFIX ${prefix})
  file(WRITE ${prefix}/cmake/highwall_core.cmake "")
  foreach(ask IN ITEMS build package)
    execute_process(COMMAND ${CMAKE_COMMAND} -D ROOT=${ROOT} -D ASK=${ask}
                            -D CMAKE_PREFIX_PATH=${prefix} -P ${CMAKE_CURRENT_LIST_FILE}
                    RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
    string(REGEX REPLACE "[ \n]+" " " said "${said}")  # lines break where a path is long
    if(result EQUAL 0)
      set(answer accepted)
    elseif(said MATCHES "Eigen 3\\.3\\.9 in[^:]*is too old")
      set(answer refused)
    else()
      set(answer "refused with: ${said}")
    endif()
    if(NOT answer STREQUAL expected)
      string(APPEND wrong "\n${ask}: Eigen ${version} is ${answer}")
    endif()
  endforeach()
endforeach()
if(wrong)
  message(FATAL_ERROR "${wrong}")
endif()
