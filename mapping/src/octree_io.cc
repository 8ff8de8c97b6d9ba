#include "octree_io.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall::internal {
namespace {

constexpr unsigned kTreeDepth = 16;
constexpr std::string_view kBinaryTitle = "# Octomap OcTree binary file";
constexpr std::string_view kFullTitle = "# Octomap OcTree file";

// Checks a payload by walking its nodes as OctoMap would read them, without building anything.
class PayloadChecker {
 public:
  PayloadChecker(const std::filesystem::path& path, const OctreeFile& file)
      : path_(path), bytes_(file.payload), binary_(file.binary), expected_(file.size) {}

  void Check() {
    if (expected_ > 0) {
      nodes_ = 1;
      binary_ ? CheckBinaryNode(0) : CheckFullNode(0);
    }
    if (at_ != bytes_.size()) throw IoError(path_, "bytes follow the last node of the octree");
    if (nodes_ != expected_) {
      throw IoError(path_, "the header promises " + std::to_string(expected_) +
                               " nodes, the file holds " + std::to_string(nodes_));
    }
  }

 private:
  // Two bits per child: 00 unknown, 01 free, 10 occupied, 11 inner node (children 0-3, then 4-7).
  void CheckBinaryNode(unsigned depth) {
    const std::string_view pair = Take(2);
    const unsigned codes = static_cast<unsigned char>(pair[0]) |
                           static_cast<unsigned>(static_cast<unsigned char>(pair[1])) << 8;
    if (codes != 0) RequireInner(depth);
    for (unsigned i = 0; i < 8; ++i) nodes_ += (codes >> (2 * i) & 3u) != 0;
    for (unsigned i = 0; i < 8; ++i) {
      if ((codes >> (2 * i) & 3u) == 3u) CheckBinaryNode(depth + 1);
    }
  }

  // A float, then one bit per child.
  void CheckFullNode(unsigned depth) {
    float log_odds;
    std::memcpy(&log_odds, Take(sizeof(log_odds)).data(), sizeof(log_odds));
    if (!std::isfinite(log_odds)) throw IoError(path_, "a node has a value that is not finite");
    const unsigned children = static_cast<unsigned char>(Take(1)[0]);
    if (children != 0) RequireInner(depth);
    for (unsigned i = 0; i < 8; ++i) {
      if ((children >> i & 1u) == 0) continue;
      ++nodes_;
      CheckFullNode(depth + 1);
    }
  }

  void RequireInner(unsigned depth) const {
    if (depth >= kTreeDepth) throw IoError(path_, "the octree is deeper than 16 levels");
  }

  std::string_view Take(std::size_t count) {
    if (bytes_.size() - at_ < count) {
      throw IoError(path_, "truncated: the file ends inside of the octree");
    }
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }

  const std::filesystem::path& path_;
  std::string_view bytes_;
  bool binary_;
  std::size_t expected_;
  std::size_t at_ = 0;
  std::size_t nodes_ = 0;
};

template <typename T>
T NumberIn(const std::filesystem::path& path, std::int64_t line, std::string_view text) {
  T value{};
  if (!ParseNumber(text, &value)) {
    throw IoError(path, line, "expected a number, found '" + std::string(text) + "'");
  }
  return value;
}

void WriteHeader(std::string_view title, const ScanOctree& tree, std::ostream& out) {
  out << title << "\nid OcTree\nsize " << std::to_string(tree.size()) << "\nres "
      << NumberText(tree.getResolution()) << "\ndata\n";
}

// Removes the colours of a ColorOcTree, three bytes between the value and the children of each
// node.
void RemoveColours(const std::filesystem::path& path, std::string* payload) {
  constexpr std::size_t kValue = 4, kColour = 3, kNode = kValue + kColour + 1;
  if (payload->size() % kNode != 0) {
    throw IoError(path, "truncated: the file ends inside of the octree");
  }
  std::string nodes;
  nodes.reserve(payload->size() / kNode * (kValue + 1));
  for (std::size_t at = 0; at < payload->size(); at += kNode) {
    nodes.append(*payload, at, kValue);
    nodes += (*payload)[at + kNode - 1];
  }
  *payload = std::move(nodes);
}

}  // namespace

OctreeFile LoadOctreeFile(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw IoError(path, "cannot be read");
  OctreeFile file;
  std::string line;
  std::getline(stream, line);
  file.binary = line.starts_with(kBinaryTitle);
  if (!file.binary && !line.starts_with(kFullTitle)) {
    throw IoError(path, 1, "not an OctoMap file (.bt or .ot)");
  }
  bool colours = false;
  bool has_id = false, has_size = false, has_data = false;
  for (std::int64_t number = 2; !has_data; ++number) {
    if (!std::getline(stream, line)) throw IoError(path, number, "truncated inside of the header");
    const std::size_t space = line.find(' ');
    const std::string key = line.substr(0, space);
    const std::string value = space == std::string::npos ? "" : line.substr(space + 1);
    if (key == "id") {
      colours = value == "ColorOcTree";
      if (value != "OcTree" && !colours) {
        throw IoError(path, number, "holds a " + value + ", not an OcTree or a ColorOcTree");
      }
      has_id = true;
    } else if (key == "size") {
      file.size = NumberIn<std::size_t>(path, number, value);
      has_size = true;
    } else if (key == "res") {
      file.resolution = NumberIn<double>(path, number, value);
    } else if (key == "data") {
      has_data = true;
    } else if (!key.empty() && key.front() != '#') {
      throw IoError(path, number, "unknown header field '" + key + "'");
    }
  }
  if (!has_id || !has_size || !(file.resolution > 0.0) || !std::isfinite(file.resolution)) {
    throw IoError(path, "the header needs id, size and a positive res");
  }
  file.payload.assign(std::istreambuf_iterator<char>(stream), {});
  if (colours && !file.binary) RemoveColours(path, &file.payload);
  PayloadChecker(path, file).Check();
  return file;
}

void ReadPayload(const OctreeFile& file, ScanOctree& tree) {
  if (file.size == 0) return;
  TextReader stream(file.payload);
  file.binary ? tree.readBinaryData(stream) : tree.readData(stream);
}

void WriteTree(const std::filesystem::path& path, const ScanOctree& tree) {
  AtomicFile file(path);
  WriteHeader(kFullTitle, tree, file.stream());
  tree.writeData(file.stream());
  file.Commit();
}

void WriteBinaryTree(const std::filesystem::path& path, const ScanOctree& tree) {
  AtomicFile file(path);
  WriteHeader(kBinaryTitle, tree, file.stream());
  tree.writeBinaryData(file.stream());
  file.Commit();
}

}  // namespace highwall::internal
