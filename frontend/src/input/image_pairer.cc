#include <highwall/frontend/input/image_pairer.h>

#include <cstdlib>
#include <utility>

namespace highwall {

bool ImagePairer::Add(Stamp stamp, cv::Mat image, std::optional<Stamp>* last,
                      std::deque<Waiting>* waiting) {
  if (*last && stamp <= **last) {
    ++out_of_order_;
    return false;
  }
  *last = stamp;
  waiting->push_back({stamp, std::move(image)});
  return true;
}

std::vector<RgbdImage> ImagePairer::AddColour(Stamp stamp, cv::Mat bgr) {
  if (!Add(stamp, std::move(bgr), &last_colour_, &colours_)) return {};
  if (colours_.size() > kMostWaiting) {
    colours_.pop_front();
    ++unpaired_;
  }
  return Pair();
}

std::vector<RgbdImage> ImagePairer::AddDepth(Stamp stamp, cv::Mat depth) {
  if (!Add(stamp, std::move(depth), &last_depth_, &depths_)) return {};
  if (depths_.size() > kMostWaiting) depths_.pop_front();
  return Pair();
}

std::vector<RgbdImage> ImagePairer::Pair() {
  std::vector<RgbdImage> pairs;
  while (!colours_.empty() && !depths_.empty()) {
    const Stamp colour = colours_.front().stamp;
    const auto difference = [&](std::size_t i) { return std::abs(depths_[i].stamp - colour); };
    while (depths_.size() > 1 && difference(1) <= difference(0)) depths_.pop_front();
    if (depths_.size() == 1 && depths_.front().stamp < colour) break;  // the next may be nearer
    if (difference(0) <= max_difference_) {
      RgbdImage pair{.stamp = colour,
                     .bgr = std::move(colours_.front().image),
                     .depth = std::move(depths_.front().image)};
      if (depths_.front().stamp != colour) pair.depth_stamp = depths_.front().stamp;
      pairs.push_back(std::move(pair));
      depths_.pop_front();
    } else {
      ++unpaired_;
    }
    colours_.pop_front();
  }
  return pairs;
}

}  // namespace highwall
