#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <memory>
#include <type_traits>

#include <ceres/manifold.h>
#include <Eigen/Core>

#include <highwall/core/manifolds.h>

namespace [[gnu::visibility("default")]] highwall {

// A point in space [m], as a variable of a graph.
using Point = Eigen::Vector3d;

// Conversion of a value to a parameter block of a FactorGraph:
//   kSize                            doubles in the block
//   Write(value, double*), Read(const double*)
//   MakeManifold()                   null if the block is Euclidean
// A user type either has the members listed below or specializes this template.
template <class T>
struct VariableTraits;

// Types that are stored as their own block: kSize contiguous doubles at data(), and T::Manifold,
// derived from ceres::Manifold, unless the block is Euclidean.
template <class T>
requires requires(T value) {
  { T::kSize } -> std::convertible_to<int>;
  { value.data() } -> std::same_as<double*>;
}
struct VariableTraits<T> {
  static constexpr int kSize = T::kSize;
  static void Write(const T& value, double* block) { std::copy_n(value.data(), kSize, block); }
  static T Read(const double* block) {
    T value;
    std::copy_n(block, kSize, value.data());
    return value;
  }
  static std::unique_ptr<ceres::Manifold> MakeManifold() {
    if constexpr (requires { typename T::Manifold; }) {
      return std::make_unique<typename T::Manifold>();
    } else {
      return nullptr;
    }
  }
};

// A vector is its own block.
template <int N>
requires(N > 0) struct VariableTraits<Eigen::Matrix<double, N, 1>> {
  using Vector = Eigen::Matrix<double, N, 1>;
  static constexpr int kSize = N;
  static void Write(const Vector& value, double* block) { std::copy_n(value.data(), N, block); }
  static Vector Read(const double* block) { return Eigen::Map<const Vector>(block); }
  static std::unique_ptr<ceres::Manifold> MakeManifold() { return nullptr; }
};

// A scalar is its own block.
template <>
struct VariableTraits<double> {
  static constexpr int kSize = 1;
  static void Write(double value, double* block) { *block = value; }
  static double Read(const double* block) { return *block; }
  static std::unique_ptr<ceres::Manifold> MakeManifold() { return nullptr; }
};

// Handle of a variable of one FactorGraph. A handle whose variable was removed, or that belongs to
// another graph, is recognised as such.
struct VariableId {
  std::uint32_t index = 0;
  std::uint32_t generation = 0;  // 0: no variable
  std::uint32_t graph = 0;       // unique number of the graph

  bool operator==(const VariableId&) const = default;
};

// A VariableId with the type of its block: Variable<Pose>, Variable<Point>, Variable<double>.
template <class T>
struct Variable : VariableId {};

// The block types that a factor takes, in order. A factor that declares
//   using Variables = highwall::VariableList<Pose, Point>;
// can be added to a FactorGraph with exactly these handles; anything else does not compile.
template <class... Ts>
struct VariableList {};

// Satisfied if F accepts variables of types Ts: it declares exactly these, or declares nothing
// (then only the number and the sizes of the blocks are checked, when the factor is added).
template <class F, class... Ts>
concept AcceptsVariables = !requires {
  typename F::Variables;
}
|| std::is_same_v<typename F::Variables, VariableList<Ts...>>;

}  // namespace highwall
