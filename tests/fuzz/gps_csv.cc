#include <highwall/core/error.h>
#include <highwall/frontend/input/gps.h>

#include <cmath>

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "gps.csv",
    .seeds =
        [] {
          return std::vector<std::string>{
              "# stamp, x, y, z, sigma_x, sigma_y, sigma_z\n1.5,455.1,-396.4,60.2,0.5,0.5,1\n"
              "2.5,455.2,-396.3,60.1,0.5,0.5,1\n",
              "stamp lat lon alt\n1.5 48.1 11.5 520\n2.5 48.2 -179.9 nan\n3.5 nan 11.5 520\r\n",
              "\xef\xbb\xbf"
              "1,2,3,4\n\n2,3,4,5,1e-3,1,1\n"};
        },
    .file = nullptr,
    // Every fix can be turned into a factor.
    .read =
        [](const std::filesystem::path& path) {
          for (const GpsFix& fix : ReadGps(path)) {
            HIGHWALL_REQUIRE(fix.p_G.allFinite() && (fix.sigma.array() > 0.0).all() &&
                                 fix.sigma.cwiseInverse().allFinite(),
                             "a fix that no factor can be made of");
          }
        },
};

}  // namespace highwall::fuzz
