# One pkg-config file per module: highwall-core, highwall-factors, ... Ceres has none of its own;
# opencv4.pc names every module of OpenCV, and is therefore not required.
set(pc_core_description "Poses, cameras, factor graph, trajectories")
set(pc_core_requires "eigen3 >= 3.4, libglog")
set(pc_core_libs -lceres)
set(pc_factors_description "Residuals of cameras and IMUs")
set(pc_factors_requires "highwall-core = ${PROJECT_VERSION}")
set(pc_frontend_description "RGB-D-inertial SLAM")
set(pc_frontend_requires "highwall-factors = ${PROJECT_VERSION}")
set(pc_frontend_requires_private yaml-cpp)
if(HIGHWALL_HAS_OPENEXR)
  set(pc_frontend_requires_private "yaml-cpp, OpenEXR")
endif()
set(pc_frontend_libs -lopencv_core)
set(pc_frontend_libs_private
  -lopencv_calib3d -lopencv_features2d -lopencv_imgcodecs -lopencv_imgproc
  -lopencv_videoio)
set(pc_mapping_description "Dense clouds, octrees and grids")
set(pc_mapping_requires "highwall-core = ${PROJECT_VERSION}")
set(pc_mapping_requires_private octomap)
set(pc_mapping_libs -lopencv_core)
foreach(module IN LISTS modules)
  if(BUILD_SHARED_LIBS)  # whose own dependencies come with them
    set(pc_${module}_requires_private "")
    set(pc_${module}_libs_private "")
  endif()
  foreach(field IN ITEMS description requires requires_private libs libs_private)
    list(JOIN pc_${module}_${field} " " pc_${field})
  endforeach()
  set(pc_cflags "")
  if(module MATCHES "frontend|mapping")
    list(TRANSFORM OpenCV_INCLUDE_DIRS PREPEND -I OUTPUT_VARIABLE pc_cflags)
    list(JOIN pc_cflags " " pc_cflags)
  endif()
  configure_file(${CMAKE_CURRENT_LIST_DIR}/highwall.pc.in
                 ${PROJECT_BINARY_DIR}/highwall-${module}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/highwall-${module}.pc
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT ${module})
endforeach()
