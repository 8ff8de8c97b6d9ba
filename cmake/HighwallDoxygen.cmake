# The manual, built if doxygen and Python are available: target highwall_manual,
# manual/html/index.html.
set(HIGHWALL_MATHJAX file:///usr/share/javascript/mathjax CACHE STRING
    "Where the pages of the manual find MathJax")
find_package(Doxygen 1.9 QUIET)
find_package(Python3 QUIET COMPONENTS Interpreter)
if(NOT DOXYGEN_FOUND OR NOT Python3_FOUND)
  return()
endif()
set(HIGHWALL_MANUAL ${PROJECT_BINARY_DIR}/manual)
# Uses the interpreter itself, which is started once per file: the program found may be a script
# that selects an interpreter and takes longer than the filter.
execute_process(COMMAND ${Python3_EXECUTABLE} -c "import sys; print(sys.executable)"
                OUTPUT_VARIABLE HIGHWALL_PYTHON OUTPUT_STRIP_TRAILING_WHITESPACE
                COMMAND_ERROR_IS_FATAL ANY)
configure_file(${CMAKE_CURRENT_LIST_DIR}/Doxyfile.in ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)
# A warning is an error, see scripts/check_manual.cmake.
set(HIGHWALL_MANUAL_COMMAND ${CMAKE_COMMAND} -D DOXYGEN=${DOXYGEN_EXECUTABLE}
  -D DOXYFILE=${PROJECT_BINARY_DIR}/Doxyfile -P ${PROJECT_SOURCE_DIR}/scripts/check_manual.cmake)
file(MAKE_DIRECTORY ${HIGHWALL_MANUAL})
if(BUILD_SHARED_LIBS)  # for packages
  add_custom_target(highwall_manual ALL COMMAND ${HIGHWALL_MANUAL_COMMAND} VERBATIM)
  install(DIRECTORY ${HIGHWALL_MANUAL}/html DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT docs)
else()
  add_custom_target(highwall_manual COMMAND ${HIGHWALL_MANUAL_COMMAND} VERBATIM)
endif()
if(HIGHWALL_BUILD_TESTS)
  if(NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize")
    add_test(NAME package/manual_has_every_public_symbol COMMAND ${HIGHWALL_MANUAL_COMMAND})
  endif()
endif()
