#include "files/trajectory_file.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "poses.csv",
    .seeds =
        [] {
          return std::vector<std::string>{
              "#timestamp, p_RS_R_x [m]\n1403715273262142976,1,-2,0.5,1,0,0,0,9,9\n",
              "%time,field.header.stamp,field.pose.position.x,field.pose.position.y,"
              "field.pose.position.z,field.pose.orientation.x,field.pose.orientation.y,"
              "field.pose.orientation.z,field.pose.orientation.w\n"
              "1403715273262142976,1403715273262142976,1,2,3,0,0,0,1\n",
              "1403715273,262142976,map,1,2,3,0,0,0,1\r\n1403715274,0,map,base,1,2,3,0,0,0,1\n",
              "1 0 0 0 0 1 0 0 0 0 1 0\n0 -1 0 1 1 0 0 2 0 0 1 3e0\n",
              "1305031102.175304 1 2 3 0 0 0 1\n",
              "t [s]; x; y; z; qw; qx; qy; qz; id\n1.5;1;2;3;1;0;0;0;7\n2.5;1;2;3;1;0;0;0;8\n",
              "1.403636580e18 1 2 3 0 0 0 1\n1403636580100000000.5 1 2 3 0 0 0 1\n",
              "0 -1 0 1 1 0 0 2 0 0 1 3 0 0 0 1\n"};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const Trajectory poses = apps::ReadTrajectoryFile(path).poses;
          MatchByStamp(poses, poses, 20'000'000);
        },
};

}  // namespace highwall::fuzz
