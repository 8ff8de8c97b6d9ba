#include <highwall/core/pose_graph.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/se3.h>
#include "planar_pose.h"
#include "pose_information.h"

namespace highwall {
namespace {

constexpr std::string_view kWhitespace = " \t\r\v\f";

// The words of one line, with path and line number for the messages.
class Line {
 public:
  Line(const std::filesystem::path& path, std::int64_t number, std::string_view text)
      : path_(path), number_(number), rest_(text.substr(0, text.find('#'))) {}

  [[noreturn]] void Fail(const std::string& what) const { throw IoError(path_, number_, what); }
  std::int64_t number() const { return number_; }
  bool AtEnd() const { return rest_.find_first_not_of(kWhitespace) == std::string_view::npos; }

  // Returns the next word; empty at the end.
  std::string_view Word() {
    const std::size_t begin = std::min(rest_.find_first_not_of(kWhitespace), rest_.size());
    rest_.remove_prefix(begin);
    const std::size_t length = std::min(rest_.find_first_of(kWhitespace), rest_.size());
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return word;
  }

  std::int64_t Id(const std::string& tag) {
    const std::string_view word = Word();
    std::int64_t id = 0;
    if (word.empty()) Fail(tag + " lacks an id");
    if (!ParseNumber(word, &id) || id < 0) {
      Fail(tag + ": '" + std::string(word) + "' is no id, a whole number from 0");
    }
    return id;
  }

  template <std::size_t kCount>
  std::array<double, kCount> Numbers(const std::string& tag) {
    std::array<double, kCount> values;
    for (std::size_t k = 0; k < kCount; ++k) {
      const std::string_view word = Word();
      if (word.empty()) {
        Fail(tag + " needs " + std::to_string(kCount) + " numbers behind its ids, has " +
             std::to_string(k));
      }
      const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
      const char* const stop = digits.data() + digits.size();
      const auto [end, error] = std::from_chars(digits.data(), stop, values[k]);
      // A value too small for a double is treated as zero.
      const bool tiny = error == std::errc::result_out_of_range && IsTiny(digits);
      if (tiny) values[k] = 0.0;
      if ((error != std::errc() && !tiny) || end != stop || !std::isfinite(values[k])) {
        Fail(tag + ": '" + std::string(word) + "' is not a finite number");
      }
    }
    if (!Word().empty()) {
      Fail(tag + " has more than " + std::to_string(kCount) + " numbers behind its ids");
    }
    return values;
  }

 private:
  static bool IsTiny(std::string_view digits) {
    return digits.find("e-") != std::string_view::npos ||
           digits.find("E-") != std::string_view::npos;
  }

  const std::filesystem::path& path_;
  const std::int64_t number_;
  std::string_view rest_;
};

Pose ParsePose(const Line& line, const double* values) {
  const Eigen::Map<const Eigen::Quaterniond> q(values + 3);
  if (q.norm() < 1e-6) line.Fail("the quaternion qx qy qz qw is zero, which is no rotation");
  if (!std::isfinite(q.norm())) line.Fail("the quaternion qx qy qz qw is too large to normalise");
  return Pose::FromBlock(values);
}

// values: the upper triangle by rows.
PoseInformation ParseInformation(const Line& line, int size, const double* values) {
  PoseInformation information(size, size);
  for (int row = 0; row < size; ++row) {
    for (int column = row; column < size; ++column) {
      information(row, column) = information(column, row) = *values++;
    }
  }
  if (!internal::IsPositiveSemidefinite(information)) {
    line.Fail("the information matrix is not positive definite, nor semidefinite");
  }
  return information;
}

class G2oReader {
 public:
  explicit G2oReader(const std::filesystem::path& path) : path_(path) {}

  void Read(Line line) {
    const std::string tag(line.Word());
    if (tag == "PARAMS_SE3OFFSET") {
      const std::int64_t id = line.Id(tag);
      offsets_.insert_or_assign(id, ParsePose(line, line.Numbers<7>(tag).data()));
      return;
    }
    if (tag.empty() || tag.starts_with("PARAMS_")) return;
    if (tag == "VERTEX_SE3:QUAT") {
      SetSpace(PoseGraphSpace::kSe3, line);
      const std::int64_t id = line.Id(tag);
      AddNode(line, id, ParsePose(line, line.Numbers<7>(tag).data()));
    } else if (tag == "VERTEX_SE2") {
      SetSpace(PoseGraphSpace::kSe2, line);
      const std::int64_t id = line.Id(tag);
      AddNode(line, id, internal::FromPlanar(Eigen::Vector3d(line.Numbers<3>(tag).data())));
    } else if (tag == "EDGE_SE3:QUAT") {
      SetSpace(PoseGraphSpace::kSe3, line);
      const auto [i, j] = ReadEnds(tag, &line);
      const auto values = line.Numbers<28>(tag);
      AddEdge(line, {i, j, KindBetween(i, j), ParsePose(line, values.data()),
                     ParseInformation(line, 6, values.data() + 7)});
    } else if (tag == "EDGE_SE2") {
      SetSpace(PoseGraphSpace::kSe2, line);
      const auto [i, j] = ReadEnds(tag, &line);
      const auto values = line.Numbers<9>(tag);
      AddEdge(line, {i, j, KindBetween(i, j), internal::FromPlanar(Eigen::Vector3d(values.data())),
                     ParseInformation(line, 3, values.data() + 3)});
    } else if (tag == "EDGE_SE3_PRIOR") {
      SetSpace(PoseGraphSpace::kSe3, line);
      const std::int64_t id = line.Id(tag), offset = line.Id(tag);
      const auto values = line.Numbers<28>(tag);
      priors_.push_back({line.number(), id, offset, ParsePose(line, values.data()),
                         ParseInformation(line, 6, values.data() + 7)});
    } else if (tag == "EDGE_PRIOR_SE2") {
      SetSpace(PoseGraphSpace::kSe2, line);
      const std::int64_t id = line.Id(tag);
      const auto values = line.Numbers<9>(tag);
      priors_.push_back({line.number(), id, 0, internal::FromPlanar(Eigen::Vector3d(values.data())),
                         ParseInformation(line, 3, values.data() + 3)});
    } else if (tag == "EDGE_PRIOR_SE2_XY") {
      SetSpace(PoseGraphSpace::kSe2, line);
      const std::int64_t id = line.Id(tag);
      const auto v = line.Numbers<5>(tag);
      const std::array<double, 6> information = {v[2], v[3], 0.0, v[4], 0.0, 0.0};
      priors_.push_back({line.number(), id, 0, internal::FromPlanar({v[0], v[1], 0.0}),
                         ParseInformation(line, 3, information.data())});
    } else if (tag == "FIX") {
      ReadFix(tag, &line);
    } else {
      line.Fail("'" + tag + "' is not understood: VERTEX_SE3:QUAT, EDGE_SE3:QUAT, VERTEX_SE2, " +
                "EDGE_SE2, their priors and FIX are");
    }
  }

  PoseGraph Finish() {
    if (graph_.nodes.empty() && graph_.edges.empty() && priors_.empty()) {
      throw IoError(path_, "holds no pose graph: neither vertices nor edges");
    }
    graph_.has_poses = !graph_.nodes.empty();
    if (!graph_.has_poses) AddNodesOfEdges();
    for (std::size_t e = 0; e < graph_.edges.size(); ++e) {
      for (const std::int64_t id : {graph_.edges[e].i, graph_.edges[e].j}) {
        RequireNode(edge_lines_[e], "edge to", id);
      }
    }
    for (const auto& [line, id] : fixed_) {
      RequireNode(line, "FIX of", id);
      graph_.nodes[index_of_.at(id)].fixed = true;
    }
    AddPriors();
    return std::move(graph_);
  }

 private:
  // Prior on the pose of a vertex in the world, as written in the file.
  struct Prior {
    std::int64_t line, id, offset;
    Pose Z;
    PoseInformation information;
  };

  void SetSpace(PoseGraphSpace space, const Line& line) {
    if (!space_known_) graph_.space = space;
    space_known_ = true;
    if (graph_.space != space) line.Fail("SE(2) and SE(3) are mixed in one file");
  }

  static std::pair<std::int64_t, std::int64_t> ReadEnds(const std::string& tag, Line* line) {
    const std::int64_t i = line->Id(tag);
    const std::int64_t j = line->Id(tag);
    if (i == j) line->Fail("edge from vertex " + std::to_string(i) + " to itself");
    return {i, j};
  }

  // The format does not state the kind: programs number the poses of a motion consecutively.
  static PoseGraphEdgeKind KindBetween(std::int64_t i, std::int64_t j) {
    return j - i == 1 || i - j == 1 ? PoseGraphEdgeKind::kOdometry : PoseGraphEdgeKind::kLoop;
  }

  void ReadFix(const std::string& tag, Line* line) {
    fixed_.emplace_back(line->number(), line->Id(tag));
    while (!line->AtEnd()) fixed_.emplace_back(line->number(), line->Id(tag));
  }

  void AddNode(const Line& line, std::int64_t id, const Pose& pose) {
    if (!index_of_.emplace(id, graph_.nodes.size()).second) {
      line.Fail("vertex " + std::to_string(id) + " is there twice");
    }
    graph_.nodes.push_back({id, pose});
  }

  void AddEdge(const Line& line, const PoseGraphEdge& edge) {
    graph_.edges.push_back(edge);
    edge_lines_.push_back(line.number());
  }

  void AddNodesOfEdges() {
    std::vector<std::int64_t> ids;
    for (const PoseGraphEdge& edge : graph_.edges) ids.insert(ids.end(), {edge.i, edge.j});
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    for (const std::int64_t id : ids) {
      index_of_.emplace(id, graph_.nodes.size());
      graph_.nodes.push_back({id, Pose()});
    }
  }

  void AddPriors() {
    if (priors_.empty()) return;
    std::int64_t largest = 0;
    for (const PoseGraphNode& node : graph_.nodes) largest = std::max(largest, node.id);
    if (largest > std::numeric_limits<std::int64_t>::max() - 1) {
      throw IoError(path_, priors_.front().line, "the ids leave none for the world of the priors");
    }
    graph_.world = largest + 1;
    for (Prior& prior : priors_) {
      RequireNode(prior.line, "prior of", prior.id);
      if (graph_.space == PoseGraphSpace::kSe3) RemoveOffset(&prior);
      TakeRotation(graph_.nodes[index_of_.at(prior.id)].pose, &prior);
      graph_.edges.push_back({*graph_.world, prior.id, PoseGraphEdgeKind::kLoop, prior.Z,
                              prior.information,
                              /*trusted=*/true});
    }
    graph_.nodes.push_back({*graph_.world, Pose(), /*fixed=*/true});
  }

  // The error of the prior is that of Z^-1 T P with the offset P: P (Z^-1 T P) P^-1 equals (Z
  // P^-1)^-1 T.
  void RemoveOffset(Prior* prior) const {
    const auto offset = offsets_.find(prior->offset);
    if (offset == offsets_.end()) return;
    const Pose P_inverse = offset->second.Inverse();
    const se3::Matrix6 Ad = se3::Adjoint(P_inverse);
    prior->Z = prior->Z * P_inverse;
    const se3::Matrix6 information = Ad.transpose() * prior->information * Ad;
    prior->information = 0.5 * (information + information.transpose());
  }

  // A prior on the position only, such as GPS, has no information about the rotation stored with
  // it: with the rotation of the vertex the error is the same, and as small as possible.
  static void TakeRotation(const Pose& vertex, Prior* prior) {
    const Eigen::Index d = prior->information.rows() == 3 ? 2 : 3;
    const Eigen::Index angles = prior->information.rows() - d;
    if (!prior->information.rightCols(angles).isZero(0.0)) return;
    const Eigen::Matrix3d A = vertex.R().transpose() * prior->Z.R();
    const Eigen::MatrixXd turned = A.topLeftCorner(d, d) * prior->information.topLeftCorner(d, d) *
                                   A.topLeftCorner(d, d).transpose();
    prior->information.topLeftCorner(d, d) = 0.5 * (turned + turned.transpose());
    prior->Z = Pose(vertex.q(), prior->Z.p());
  }

  void RequireNode(std::int64_t line, const char* what, std::int64_t id) const {
    if (!index_of_.contains(id)) {
      throw IoError(path_, line,
                    std::string(what) + " vertex " + std::to_string(id) + ", which is not there");
    }
  }

  const std::filesystem::path& path_;
  PoseGraph graph_;
  bool space_known_ = false;
  std::unordered_map<std::int64_t, std::size_t> index_of_;
  std::vector<std::int64_t> edge_lines_;
  std::vector<std::pair<std::int64_t, std::int64_t>> fixed_;  // line, id
  std::vector<Prior> priors_;
  std::unordered_map<std::int64_t, Pose> offsets_;
};

// Appends words to lines of text; numbers with the fewest digits that read back equal.
class G2oText {
 public:
  G2oText& operator<<(const char* word) {
    text_ += word;
    return *this;
  }
  template <class T>
  requires std::is_arithmetic_v<T> G2oText& operator<<(T value) {
    std::array<char, 32> digits;
    const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    text_ += ' ';
    text_.append(digits.data(), result.ptr);
    return *this;
  }
  G2oText& operator<<(const Eigen::Ref<const Eigen::VectorXd>& values) {
    for (const double value : values) *this << value;
    return *this;
  }

  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

Eigen::VectorXd Numbers(PoseGraphSpace space, const Pose& pose) {
  if (space == PoseGraphSpace::kSe2) return internal::ToPlanar(pose);
  return Eigen::Map<const Eigen::Matrix<double, Pose::kSize, 1>>(pose.data());
}

}  // namespace

PoseGraph ReadG2o(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) throw IoError(path, "is a folder; expected a g2o file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw IoError(path, "cannot be opened: no such g2o file, or not readable");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) throw IoError(path, "could not be read to its end");
  G2oReader reader(path);
  std::string_view rest = text;
  if (rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3);  // byte-order mark of UTF-8
  for (std::int64_t number = 1; !rest.empty(); ++number) {
    const std::size_t length = std::min(rest.find('\n'), rest.size());
    reader.Read(Line(path, number, rest.substr(0, length)));
    rest.remove_prefix(std::min(length + 1, rest.size()));
  }
  return reader.Finish();
}

void WriteG2o(const std::filesystem::path& path, const PoseGraph& graph) {
  if (!graph.edges.empty()) graph.Validate();
  const bool planar = graph.space == PoseGraphSpace::kSe2;
  G2oText text;
  // Priors refer to a sensor offset, here the identity.
  if (graph.world && !planar)
    text << "PARAMS_SE3OFFSET" << 0 << Numbers(graph.space, Pose()) << "\n";
  if (graph.has_poses) {
    for (const PoseGraphNode& node : graph.nodes) {
      if (node.id == graph.world) continue;
      text << (planar ? "VERTEX_SE2" : "VERTEX_SE3:QUAT") << node.id
           << Numbers(graph.space, node.pose) << "\n";
    }
  }
  for (const PoseGraphNode& node : graph.nodes) {
    if (node.fixed && node.id != graph.world) text << "FIX" << node.id << "\n";
  }
  for (const PoseGraphEdge& edge : graph.edges) {
    if (edge.i == graph.world) {
      text << (planar ? "EDGE_PRIOR_SE2" : "EDGE_SE3_PRIOR") << edge.j;
      if (!planar) text << 0;
    } else {
      text << (planar ? "EDGE_SE2" : "EDGE_SE3:QUAT") << edge.i << edge.j;
    }
    text << Numbers(graph.space, edge.Z);
    for (Eigen::Index row = 0; row < edge.information.rows(); ++row) {
      text << edge.information.row(row).tail(edge.information.rows() - row).transpose().eval();
    }
    text << "\n";
  }
  AtomicFile file(path);
  file.stream() << text.text();
  file.Commit();
}

}  // namespace highwall
