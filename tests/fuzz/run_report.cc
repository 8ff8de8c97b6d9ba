#include "run/posed_frames.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "run.json",
    .seeds =
        [] {
          return std::vector<std::string>{
              R"({"complete": true, "dataset": "/tmp", "options": {"localize_only": false}, "x": [1.5]})",
              R"({"dataset": "nowhere", "options": {"localize_only": true}})",
              R"(["\u00e9\ud83d\ude00", -1e400, 18446744073709551616, null])"};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) { apps::ResolveSource(path.parent_path(), "", ""); },
    .names_file = false,
};

}  // namespace highwall::fuzz
