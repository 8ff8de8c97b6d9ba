# Configures, builds and tests HIGHWALL_MODULES=core,factors with Eigen, Ceres and GoogleTest alone:
# no other package that the project uses may be found. Builds a project that takes both with
# add_subdirectory, and runs its programs, without a build type, as such a project may be; Highwall
# by itself is only configured. Uses clang if available, which takes a third of the time.
# Usage: cmake -D ROOT=<project> -D BUILD=<folder, made anew> [-D TESTS=<regular expression>]
#              [-D CONFIGURE_ONLY=ON] -P scripts/check_core_and_factors.cmake
# TESTS: the test sources that are built and run; "." matches all of them.
# CONFIGURE_ONLY: neither builds nor runs anything, in seconds instead of minutes.
cmake_minimum_required(VERSION 3.23)
if(NOT TESTS)
  set(TESTS "^(core_pose|core_variable_types|factors_variable_types|factors_zero_velocity)_test$")
endif()

# run(what command ...): stops the script with the last lines of the output if the command fails.
function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT result EQUAL 0)
    string(LENGTH "${out}" length)
    if(length GREATER 4000)
      math(EXPR begin "${length} - 4000")
      string(SUBSTRING "${out}" ${begin} -1 out)
    endif()
    message(FATAL_ERROR "core and factors alone: ${what} fails\n${out}")
  endif()
endfunction()

set(absent "")
foreach(package IN ITEMS OpenCV OpenEXR octomap embree yaml-cpp CLI11 fmt nlohmann_json benchmark)
  list(APPEND absent -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
find_program(clang clang++)
if(clang)
  list(APPEND absent -DCMAKE_CXX_COMPILER=${clang})
endif()
file(REMOVE_RECURSE ${BUILD})
run("the configuration" ${CMAKE_COMMAND} -S ${ROOT} -B ${BUILD}/alone -G Ninja
    -DHIGHWALL_MODULES=core,factors ${absent})
run("the configuration of a project with both" ${CMAKE_COMMAND}
    -S ${ROOT}/tests/consumer/add_subdirectory -B ${BUILD} -G Ninja
    -DHIGHWALL_BUILD_TESTS=ON -DHIGHWALL_TESTS=${TESTS} -DCMAKE_UNITY_BUILD=ON ${absent})
if(CONFIGURE_ONLY)
  file(REMOVE_RECURSE ${BUILD})
  return()
endif()
run("the build" ${CMAKE_COMMAND} --build ${BUILD} --target highwall_tests use_core use_factors)
run("a test" ${CMAKE_CTEST_COMMAND} --test-dir ${BUILD}/highwall --output-on-failure
    --no-tests=error -R "^(core|factors)/")
run("use_core" ${BUILD}/use_core)
run("use_factors" ${BUILD}/use_factors)
file(REMOVE_RECURSE ${BUILD})
