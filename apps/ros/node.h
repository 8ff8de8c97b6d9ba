#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "cli/stop_signals.h"
#include "ros/camera_stream.h"
#include "ros/node_options.h"
#include "ros/ros_link.h"
#include "ros/run_publisher.h"

namespace highwall::apps {

// Hands what arrives from ROS to the current run, and the requests of services to the node. Thread-
// safe.
class NodeInlet final : public RosListener {
 public:
  // What the run after the current one does; empty: there is none.
  struct Request {
    bool localize = false;
    bool keep_map = false;  // of the current run
  };

  void OnCamera(const CameraInfo& info) override;
  void OnColour(Stamp stamp, const cv::Mat& bgr) override;
  void OnDepth(Stamp stamp, const cv::Mat& stored) override;
  void OnImu(Stamp stamp, const Eigen::Vector3d& gyroscope,
             const Eigen::Vector3d& accelerometer) override;
  void OnProblem(const std::string& what) override;
  Answer OnSave() override;
  Answer OnReset() override;
  Answer OnLocalize(bool localize) override;

  // Waits for it for a short time.
  std::optional<CameraInfo> WaitForCamera();
  // The run that receives; empty: none does, and images are left out.
  void Connect(std::shared_ptr<CameraStream> stream, std::shared_ptr<RunPublisher> publisher,
               bool localizes);
  // Ends the receiving of the current run, if any, after the images that wait.
  void Close();
  // Returns the request for the next run, once.
  std::optional<Request> TakeRequest();

 private:
  std::shared_ptr<CameraStream> stream();
  Answer Ask(const Request& request, const std::string& answer);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<CameraInfo> camera_;
  std::shared_ptr<CameraStream> stream_;
  std::shared_ptr<RunPublisher> publisher_;
  bool localizes_ = false;
  std::optional<Request> request_;
  std::set<std::string> problems_;  // printed, each once
};

// Runs until ROS or a signal ends it: one run after the other, each in its folder. Returns an
// ExitCode. Throws as RunSlam() and as the checks of its arguments.
int RunNode(RosLink& link, const NodeOptions& options, const StopSignals& signals);

}  // namespace highwall::apps
