#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

// The few ONNX messages needed for a network of convolutions, in protobuf's wire format (onnx.proto
// of version 7, protobuf.dev/programming-guides/encoding).
namespace highwall::testing {

class ProtoMessage {
 public:
  ProtoMessage& Int(int field, std::uint64_t value) {
    Varint(static_cast<std::uint64_t>(field) << 3);
    Varint(value);
    return *this;
  }
  ProtoMessage& Bytes(int field, std::string_view bytes) {
    Varint((static_cast<std::uint64_t>(field) << 3) | 2);
    Varint(bytes.size());
    bytes_ += bytes;
    return *this;
  }
  ProtoMessage& Message(int field, const ProtoMessage& message) {
    return Bytes(field, message.bytes_);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void Varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_ += static_cast<char>((value & 0x7F) | 0x80);
    bytes_ += static_cast<char>(value);
  }

  std::string bytes_;
};

// A convolution of the image "image" with `channels` square kernels.
struct OnnxConvolution {
  std::string output;
  int channels = 0, side = 0, stride = 1, padding = 0;
  std::vector<float> weights;  // channels x side x side
  std::vector<float> bias;     // channels
};

// Returns the file of a network with a single-channel input image and these outputs.
inline std::string OnnxFile(const std::vector<OnnxConvolution>& convolutions, int height,
                            int width) {
  constexpr int kFloat = 1, kInts = 7;
  const auto value_info = [&](const std::string& name, const std::vector<int>& size) {
    ProtoMessage shape;
    for (const int s : size) shape.Message(1, ProtoMessage().Int(1, static_cast<std::uint64_t>(s)));
    const ProtoMessage type =
        ProtoMessage().Message(1, ProtoMessage().Int(1, kFloat).Message(2, shape));
    return ProtoMessage().Bytes(1, name).Message(2, type);
  };
  const auto tensor = [&](const std::string& name, const std::vector<int>& size,
                          const std::vector<float>& values) {
    ProtoMessage message;
    for (const int s : size) message.Int(1, static_cast<std::uint64_t>(s));
    std::string raw(values.size() * sizeof(float), '\0');
    std::memcpy(raw.data(), values.data(), raw.size());
    return message.Int(2, kFloat).Bytes(8, name).Bytes(9, raw);
  };
  const auto ints = [&](const std::string& name, const std::vector<int>& values) {
    ProtoMessage message;
    message.Bytes(1, name);
    for (const int v : values) message.Int(8, static_cast<std::uint64_t>(v));
    return message.Int(20, kInts);
  };
  ProtoMessage graph;
  for (const OnnxConvolution& c : convolutions) {
    graph.Message(1, ProtoMessage()
                         .Bytes(1, "image")
                         .Bytes(1, c.output + "_weights")
                         .Bytes(1, c.output + "_bias")
                         .Bytes(2, c.output)
                         .Bytes(3, c.output + "_node")
                         .Bytes(4, "Conv")
                         .Message(5, ints("kernel_shape", {c.side, c.side}))
                         .Message(5, ints("strides", {c.stride, c.stride}))
                         .Message(5, ints("pads", std::vector<int>(4, c.padding))));
  }
  graph.Bytes(2, "points");
  for (const OnnxConvolution& c : convolutions) {
    graph.Message(5, tensor(c.output + "_weights", {c.channels, 1, c.side, c.side}, c.weights));
    graph.Message(5, tensor(c.output + "_bias", {c.channels}, c.bias));
  }
  graph.Message(11, value_info("image", {1, 1, height, width}));
  for (const OnnxConvolution& c : convolutions) {
    const auto cells = [&](int size) { return (size + 2 * c.padding - c.side) / c.stride + 1; };
    graph.Message(12, value_info(c.output, {1, c.channels, cells(height), cells(width)}));
  }
  return ProtoMessage()
      .Int(1, 7)
      .Message(7, graph)
      .Message(8, ProtoMessage().Bytes(1, "").Int(2, 11))
      .bytes();
}

}  // namespace highwall::testing
