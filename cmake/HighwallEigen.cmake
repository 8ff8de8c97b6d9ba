# Accepts Eigen of any version from 3.4 on. Eigen's version file calls every other major version
# incompatible, even in ranges: asked for 3.4, it refuses 5. So the version is checked here.
find_package(Eigen3 REQUIRED NO_MODULE)
if(Eigen3_VERSION VERSION_LESS 3.4)
  message(FATAL_ERROR "Eigen ${Eigen3_VERSION} in ${Eigen3_DIR} is too old: Highwall needs 3.4 or "
                      "newer (-DEigen3_DIR=...)")
endif()
