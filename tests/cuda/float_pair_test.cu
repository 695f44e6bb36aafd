// SPDX-License-Identifier: Apache-2.0

// Pairs of floats on a device, whatever it projects in, against the host's. Compiled with fusing on, which
// must not reach into pairs.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include <swiftgs/cuda.cuh>
#include <swiftgs/project/project.hpp>
#include <swiftgs/serial.hpp>

#include "cuda/device.hpp"
#include "reference/hostile_pairs.hpp"
#include "reference/pair_cases.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

constexpr const char* functions[] = {"two_sum", "two_product",  "fast_two_sum", "difference",
                                     "product", "multiply_add", "inverse",      "of_double"};
/// All that pairs compute of three.
struct Computed {
  FloatPair of[std::size(functions)];
};
struct ComputeAll {
  const FloatPair* in;
  Computed* out;

  SWIFTGS_HD void operator()(std::size_t i) const {
    const FloatPair a = in[3 * i], b = in[3 * i + 1], c = in[3 * i + 2];
    const float large = std::fmax(std::fabs(a.high), std::fabs(c.high));
    const float small = std::fmin(std::fabs(a.high), std::fabs(c.high));
    out[i] = {{two_sum(a.high, c.high), two_product(a.high, b.high), fast_two_sum(large, small), a.high - c,
               a * b, multiply_add(a, b, c), inverse(a), FloatPair::from(double(a) + double(c))}};
  }
};

/// Where both forms see a Gaussian.
struct Placed {
  FloatPair in_pairs[3];  ///< in camera space
  double in_double[3];
  ProjectedShape shape_in_pairs, shape_in_double;
};
struct PlaceBoth {
  ViewConstants view;
  const vec3* means;
  const vec3* scales;
  Placed* out;

  SWIFTGS_HD void operator()(std::size_t i) const {
    const Gaussian g{means[i], scales[i], {}, 0.5f};
    const CameraPoint<FloatPair> in_pairs(view, g.mean);
    const CameraPoint<double> in_double(view, g.mean);
    Placed& placed = out[i];
    for (int k = 0; k < 3; ++k) placed.in_pairs[k] = in_pairs.p[k], placed.in_double[k] = in_double.p[k];
    placed.shape_in_pairs = project_through_pinhole<FloatPair>(view, g);
    placed.shape_in_double = project_through_pinhole<double>(view, g);
  }
};

template <class Bits, class T>
bool same(T a, T b) {
  return __builtin_bit_cast(Bits, a) == __builtin_bit_cast(Bits, b) || (a != a && b != b);
}
bool same(float a, float b) { return same<std::uint32_t>(a, b); }
bool same(double a, double b) { return same<std::uint64_t>(a, b); }
bool same(FloatPair a, FloatPair b) { return same(a.high, b.high) && same(a.low, b.low); }

/// Whether two floats are the same or neighbours.
bool adjoin(float a, float b) { return a == b || std::nextafter(a, b) == b; }

}  // namespace

SWIFTGS_DEVICE_CASE("cuda pairs: a device has the host's bits") {
  Hostile hostile(8);
  std::vector<FloatPair> in;
  constexpr std::size_t count = 400'000;
  // Of usual sizes, near the ends of the range and beyond it.
  const int ranges[][2] = {{-30, 30}, {-149, -60}, {60, 127}, {-149, 127}};
  for (std::size_t i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k) in.push_back(hostile.pair(ranges[i % 4][0], ranges[i % 4][1]));
  in[0] = {0, 0}, in[4] = {INFINITY, 0}, in[8] = {NAN, 0}, in[9] = {-0.0f, 0}, in[12] = {-INFINITY, 0};
  std::vector<Computed> expected(count);
  Serial().for_each(count, ComputeAll{in.data(), expected.data()});

  const Cuda cuda;
  const DeviceBuffer<FloatPair> given = to_device(in);
  DeviceBuffer<Computed> computed;
  computed.reset(count);
  cuda.for_each(count, ComputeAll{given.data(), computed.data()});
  const std::vector<Computed> found = to_host(cuda, std::as_const(computed).span());
  for (std::size_t k = 0; k < std::size(functions); ++k) {
    CAPTURE(functions[k]);
    std::size_t different = 0;
    for (std::size_t i = 0; i < count; ++i) different += !same(found[i].of[k], expected[i].of[k]);
    CHECK(different == 0);
  }
}

SWIFTGS_DEVICE_CASE("cuda pairs: a device places Gaussians as the host does in both forms") {
  const Cuda cuda;
  std::size_t visible = 0, apart = 0, other_means = 0;
  for (const PairCase& c : pair_cases()) {
    CAPTURE(c.name);
    CAPTURE(c.severity);
    const std::size_t count = c.scene.size();
    std::vector<Placed> expected(count);
    const PlaceBoth on_host{c.view, c.scene.means.data(), c.scene.scales.data(), expected.data()};
    Serial().for_each(count, on_host);
    const DeviceBuffer<vec3> means = to_device(c.scene.means), scales = to_device(c.scene.scales);
    DeviceBuffer<Placed> placed;
    placed.reset(count);
    cuda.for_each(count, PlaceBoth{c.view, means.data(), scales.data(), placed.data()});
    const std::vector<Placed> found = to_host(cuda, std::as_const(placed).span());

    std::size_t pairs = 0, doubles = 0, shapes = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Placed &a = found[i], &b = expected[i];
      for (int k = 0; k < 3; ++k) {
        pairs += !same(a.in_pairs[k], b.in_pairs[k]);
        doubles += !same(a.in_double[k], b.in_double[k]);
      }
      // A device's logarithm rounds differently, so a splat may touch the image there alone.
      apart += a.shape_in_pairs.visible != b.shape_in_pairs.visible;
      apart += a.shape_in_double.visible != b.shape_in_double.visible;
      if (a.shape_in_pairs.visible && b.shape_in_pairs.visible) {
        ++visible;
        for (int k = 0; k < 2; ++k)
          shapes += !same(a.shape_in_pairs.shape.mean[k], b.shape_in_pairs.shape.mean[k]);
        shapes += !same(a.shape_in_pairs.depth, b.shape_in_pairs.depth);
      }
      // Nor is 1 / z in double the host's to the last bit.
      if (a.shape_in_double.visible && b.shape_in_double.visible) {
        for (int k = 0; k < 2; ++k) {
          const float x = a.shape_in_double.shape.mean[k], y = b.shape_in_double.shape.mean[k];
          other_means += x != y;
          if (std::fabs(y) > 8) shapes += !adjoin(x, y);
        }
        shapes += !same(a.shape_in_double.depth, b.shape_in_double.depth);
      }
    }
    CHECK(pairs == 0);
    CHECK(doubles == 0);
    CHECK(shapes == 0);
  }
  CHECK(visible > 200'000);
  CHECK(apart <= 100);
  CHECK(other_means <= 100);
}
