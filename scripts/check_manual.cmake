# Builds the manual, and fails if doxygen warns: a class, struct, enumeration, alias or function of
# an installed header without a comment, or a broken formula or link. Members of a type need no
# comment of their own if their names, types and units are sufficient.
# Usage: cmake -D DOXYGEN=<program> -D DOXYFILE=<file> -P scripts/check_manual.cmake
cmake_minimum_required(VERSION 3.23)
execute_process(COMMAND ${DOXYGEN} ${DOXYFILE} ERROR_VARIABLE output RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "doxygen failed:\n${output}")
endif()
string(REGEX REPLACE "[^\n]*: Member [^\n]* of (class|struct) [^\n]* is not documented\\.\n" ""
       warnings "${output}")
if(NOT warnings STREQUAL "")
  string(REPLACE "\n" "\n  " warnings "${warnings}")  # lines as they are
  message(FATAL_ERROR "doxygen warns:\n  ${warnings}")
endif()
