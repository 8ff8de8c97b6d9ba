# Writes OUT, a C++ source with FILES (separated by |) as highwall::apps::FUNCTION(), which HEADER
# declares.
string(REPLACE "|" ";" files "${FILES}")
set(arrays "")
set(entries "")
set(i 0)
foreach(file IN LISTS files)
  file(READ ${file} hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  get_filename_component(name ${file} NAME)
  string(APPEND arrays "constexpr unsigned char kFile${i}[] = {${bytes}};\n")
  string(APPEND entries "      {\"${name}\", kFile${i}},\n")
  math(EXPR i "${i} + 1")
endforeach()
file(WRITE ${OUT} "// Made by embed.cmake.
#include \"${HEADER}\"

namespace highwall::apps {
namespace {
${arrays}}  // namespace

std::span<const Resource> ${FUNCTION}() {
  static constexpr Resource kResources[] = {
${entries}  };
  return kResources;
}

}  // namespace highwall::apps
")
