// Runs the program of docs/tutorial_lines.md over an image twice; exits 0 if each line is itself.
#include <lines/match_lines.h>

int main() {
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(40));
  image(cv::Rect(60, 50, 180, 120)).setTo(cv::Scalar(200));
  const std::vector<LineMatch> matches = MatchLines(image, image);
  for (const LineMatch& match : matches) {
    if (match.first.s != match.second.s || match.distance != 0) return 1;
  }
  return matches.size() == 4 ? 0 : 1;
}
