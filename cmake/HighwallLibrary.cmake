# highwall_warnings(target): adds the project's warnings, which are errors only if CI asks for it.
function(highwall_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow)
  # g++ 12 warns of overlaps inside std::string's own operator+ (GCC bug 105651).
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
  if(CMAKE_UNITY_BUILD)  # where g++ takes sources for headers, in which unnamed namespaces are a fault
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
  if(HIGHWALL_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  target_compile_definitions(${target} PRIVATE $<$<CONFIG:Debug>:EIGEN_INITIALIZE_MATRICES_BY_NAN>)
endfunction()

# highwall_unity(target): if CMAKE_UNITY_BUILD is on (the presets), compiles up to eight sources of
# a folder as one, which parses headers and instantiates Eigen's templates once for all of them.
# Therefore each name in an unnamed namespace must be unique in its folder. A source with its own
# options is compiled alone.
function(highwall_unity target)
  if(NOT CMAKE_UNITY_BUILD)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    get_filename_component(folder ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER "in_${folder}" folder)
    list(APPEND ${folder} ${source})
    list(LENGTH ${folder} count)
    math(EXPR batch "(${count} - 1) / 8")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${target}_${folder}_${batch})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()

# highwall_compile_quickly(target): for tests and for code that reads options, calls the libraries
# and writes results. With -O1 they compile in three quarters of the time that -O3 takes.
function(highwall_compile_quickly target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# highwall_library(name SOURCES ... PUBLIC_LINK ... PRIVATE_LINK ...)
# One module: target highwall_<name>, alias highwall::<name>, installed with its headers in the
# export set highwall_<name> and the install component <name>. Its public headers are the files
# below include/; a separate list could only deviate from them. Those below internal/ are for the
# other modules of Highwall and are not installed. A shared library exports the declarations in both
# kinds of headers (scripts/check_visibility.cmake); its file and its pkg-config file are named
# highwall_<name> and highwall-<name>.
function(highwall_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC_LINK;PRIVATE_LINK" ${ARGN})
  add_library(highwall_${name} ${ARG_SOURCES})
  add_library(highwall::${name} ALIAS highwall_${name})
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS include/*.h)
  target_sources(highwall_${name} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${headers})
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/internal)
    target_include_directories(highwall_${name}
      PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/internal>)
  endif()
  target_compile_features(highwall_${name} PUBLIC cxx_std_20)
  target_link_libraries(highwall_${name} PUBLIC ${ARG_PUBLIC_LINK} PRIVATE ${ARG_PRIVATE_LINK})
  set_target_properties(highwall_${name} PROPERTIES EXPORT_NAME ${name}
    VERSION ${PROJECT_VERSION} SOVERSION ${HIGHWALL_SOVERSION})
  highwall_warnings(highwall_${name})
  highwall_unity(highwall_${name})
  install(TARGETS highwall_${name} EXPORT highwall_${name}
          LIBRARY COMPONENT runtime NAMELINK_COMPONENT ${name} ARCHIVE COMPONENT ${name}
          FILE_SET HEADERS COMPONENT ${name})
endfunction()
