#include <bit>
#include <cstring>
#include <optional>
#include <string>

#include <highwall/mapping/point_cloud_io.h>

#include "text_parser.h"

namespace highwall {
namespace {

using internal::FileCursor;

static_assert(std::endian::native == std::endian::little, "the reader copies memory as it lies");

enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct Property {
  std::string name;
  Scalar type = Scalar::kFloat;
  std::optional<Scalar> count_type;  // type of the length, for a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool binary = false;
  std::vector<Element> elements;
};

std::optional<Scalar> ScalarOf(std::string_view name) {
  if (name == "char" || name == "int8") return Scalar::kInt8;
  if (name == "uchar" || name == "uint8") return Scalar::kUint8;
  if (name == "short" || name == "int16") return Scalar::kInt16;
  if (name == "ushort" || name == "uint16") return Scalar::kUint16;
  if (name == "int" || name == "int32") return Scalar::kInt32;
  if (name == "uint" || name == "uint32") return Scalar::kUint32;
  if (name == "float" || name == "float32") return Scalar::kFloat;
  if (name == "double" || name == "float64") return Scalar::kDouble;
  return std::nullopt;
}

Scalar RequireScalar(std::string_view name, const FileCursor& file) {
  const std::optional<Scalar> scalar = ScalarOf(name);
  if (!scalar) file.Fail("'" + std::string(name) + "' is no type of a property");
  return *scalar;
}

Header ReadHeader(FileCursor& file) {
  if (file.Line() != "ply") file.Fail("expected 'ply'");
  Header header;
  const auto format = SplitWords(file.Line(), internal::kBetweenWords);
  if (format.size() != 3 || format[0] != "format") file.Fail("expected 'format'");
  header.binary = format[1] == "binary_little_endian";
  if (!header.binary && format[1] != "ascii") {
    file.Fail("the format must be ascii or binary_little_endian");
  }
  while (true) {
    const auto words = SplitWords(file.Line(), internal::kBetweenWords);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") return header;
    if (words[0] == "element" && words.size() == 3) {
      Element& element = header.elements.emplace_back();
      element.name = words[1];
      if (!ParseNumber(words[2], &element.count)) file.Fail("expected a number of items");
    } else if (words[0] == "property" && words.size() == 3 && !header.elements.empty()) {
      header.elements.back().properties.push_back(
          {std::string(words[2]), RequireScalar(words[1], file), std::nullopt});
    } else if (words[0] == "property" && words.size() == 5 && words[1] == "list" &&
               !header.elements.empty()) {
      header.elements.back().properties.push_back(
          {std::string(words[4]), RequireScalar(words[3], file), RequireScalar(words[2], file)});
    } else {
      file.Fail("expected 'element', 'property' or 'end_header'");
    }
  }
}

template <typename T>
double TakeBinary(FileCursor& file) {
  T value;
  std::memcpy(&value, file.Bytes(sizeof(T)), sizeof(T));
  return static_cast<double>(value);
}

template <typename T>
double ParseAs(std::string_view word, const FileCursor& file) {
  T value{};
  if (!ParseNumber(word, &value)) {
    file.Fail("'" + std::string(word) + "' is not a number of its property's type");
  }
  return static_cast<double>(value);
}

// Reads the values of an item one by one, from text or bytes.
class ValueReader {
 public:
  ValueReader(FileCursor& file, bool binary) : file_(file), binary_(binary) {}

  void BeginItem() {
    if (binary_) return;
    words_ = SplitWords(file_.Line(), internal::kBetweenWords);
    next_ = 0;
  }
  double Value(Scalar type) {
    std::string_view word;
    if (!binary_) {
      if (next_ == words_.size()) file_.Fail("too few values");
      word = words_[next_++];
    }
    const auto take = [&]<typename T>(T) {
      return binary_ ? TakeBinary<T>(file_) : ParseAs<T>(word, file_);
    };
    switch (type) {
      case Scalar::kInt8:
        return take(std::int8_t{});
      case Scalar::kUint8:
        return take(std::uint8_t{});
      case Scalar::kInt16:
        return take(std::int16_t{});
      case Scalar::kUint16:
        return take(std::uint16_t{});
      case Scalar::kInt32:
        return take(std::int32_t{});
      case Scalar::kUint32:
        return take(std::uint32_t{});
      case Scalar::kFloat:
        return take(float{});
      case Scalar::kDouble:
        break;
    }
    return take(double{});
  }
  void EndItem() const {
    if (!binary_ && next_ != words_.size()) file_.Fail("too many values");
  }

 private:
  FileCursor& file_;
  bool binary_;
  std::vector<std::string_view> words_;
  std::size_t next_ = 0;
};

void Assign(const std::string& name, double value, ColoredPoint& point) {
  const char* const kAxes[] = {"x", "y", "z"};
  const char* const kNormals[] = {"nx", "ny", "nz"};
  const char* const kColours[] = {"red", "green", "blue"};
  const char* const kDiffuse[] = {"diffuse_red", "diffuse_green", "diffuse_blue"};
  for (int i = 0; i < 3; ++i) {
    if (name == kAxes[i]) point.p[i] = static_cast<float>(value);
    if (name == kNormals[i]) point.normal[i] = static_cast<float>(value);
    const bool colour = name == kColours[i] || name == kDiffuse[i];
    if (colour && value >= 0.0 && value <= 255.0) {
      point.rgb[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(value);
    }
  }
}

void AppendFace(const std::vector<double>& indices, const FileCursor& file, TriangleMesh& mesh) {
  for (const double index : indices) {
    if (!(index >= 0.0 && index < static_cast<double>(mesh.vertices.size()))) {
      file.Fail("a face names a vertex that does not exist");
    }
  }
  const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>(indices[i]); };
  for (std::size_t i = 2; i < indices.size(); ++i) {
    mesh.triangles.push_back({at(0), at(i - 1), at(i)});
  }
}

void ReadElement(const Element& element, FileCursor& file, bool binary, TriangleMesh& mesh) {
  const bool vertices = element.name == "vertex", faces = element.name == "face";
  ValueReader reader(file, binary);
  std::vector<double> list;
  for (std::size_t i = 0; i < element.count; ++i) {
    reader.BeginItem();
    ColoredPoint point;
    for (const Property& property : element.properties) {
      if (!property.count_type) {
        const double value = reader.Value(property.type);
        if (vertices) Assign(property.name, value, point);
        continue;
      }
      list.clear();
      const double count = reader.Value(*property.count_type);
      for (double k = 0.0; k < count; ++k) list.push_back(reader.Value(property.type));
      const bool indices = property.name == "vertex_indices" || property.name == "vertex_index";
      if (faces && indices) AppendFace(list, file, mesh);
    }
    reader.EndItem();
    if (vertices) mesh.vertices.push_back(point);
  }
}

}  // namespace

TriangleMesh ReadPlyMesh(const std::filesystem::path& path) {
  FileCursor file(path);
  const Header header = ReadHeader(file);
  TriangleMesh mesh;
  bool has_vertices = false;
  for (const Element& element : header.elements) {
    int axes = 0;
    for (const Property& property : element.properties) {
      axes += property.name == "x" || property.name == "y" || property.name == "z";
    }
    if (element.name == "vertex" && axes == 3) has_vertices = true;
    if (element.properties.empty() && element.count > 0) file.Fail("an element has no property");
    ReadElement(element, file, header.binary, mesh);
  }
  if (!has_vertices) throw IoError(path, "has no vertices with x, y and z");
  return mesh;
}

std::vector<ColoredPoint> ReadPly(const std::filesystem::path& path) {
  return ReadPlyMesh(path).vertices;
}

}  // namespace highwall
