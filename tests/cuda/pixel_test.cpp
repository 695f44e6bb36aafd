// SPDX-License-Identifier: Apache-2.0

// The blending of kernels, on the host: one splat against a group, and segments apart against segments in
// turn.
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include <doctest/doctest.h>
#include <vector_functions.h>

#include "blending.hpp"
#include "policies/random_splats.hpp"
#include "segment_picks.hpp"
#include "weigh.hpp"

using namespace swiftgs;
using namespace swiftgs::kernels;
using namespace swiftgs::test;

namespace {

float above(float x) { return std::nextafter(x, 1.0f); }

/// alpha_max of most tests here, by which alphas are divided before kernels blend them. A power of two rounds
/// nothing. Alphas may be larger.
constexpr float exact_unit = 0.5f;

/// A splat of a pixel.
struct Layer {
  float alpha;
  vec3 rgb;
  float depth;

  float4 colour() const { return make_float4(rgb.x, rgb.y, rgb.z, depth); }
};

std::vector<Layer> random_layers(Random& random, std::size_t count, double largest) {
  std::vector<Layer> layers;
  for (std::size_t i = 0; i < count; ++i) {
    const float alpha = random.in(0, 1) < 0.3 ? 0.0f : random.f(1.0 / 255, largest);
    layers.push_back({alpha, {random.f(0, 1), random.f(0, 1), random.f(0, 1)}, float(i) + 1});
  }
  return layers;
}

/// Blends a layer as kernels do with extras.
template <bool extras>
void blend_one(Pixel& pixel, const Layer& layer, float occluder, float unit = exact_unit) {
  const float alpha = layer.alpha / unit;
  const float left = Pixel::dimmed_relative(pixel.transmittance, alpha * pixel.transmittance, unit);
  blend<extras>(pixel, alpha, left, layer.colour(), occluder);
}

bool same_bits(const Pixel& a, const Pixel& b) {
  static_assert(sizeof(Pixel) == 6 * sizeof(float));
  return std::memcmp(&a, &b, sizeof(Pixel)) == 0;
}

/// Blends four layers from `first` on as kernels do without extras.
void blend_together(Pixel& pixel, const Layer* first, float unit = exact_unit) {
  Pixel pixels[] = {pixel};
  float alphas[1][group_size], weights[1][group_size], left[1][group_size + 1];
  for (unsigned k = 0; k < group_size; ++k) alphas[0][k] = first[k].alpha / unit;
  weigh_group(pixels, alphas, unit, weights, left);
  pixel = pixels[0];
  for (unsigned k = 0; k < group_size; ++k)
    pixel.add(weights[0][k], first[k].rgb.x, first[k].rgb.y, first[k].rgb.z);
}

}  // namespace

TEST_CASE("cuda arithmetic: a group is blended as its splats one by one wherever the pixel stops") {
  Random random(2);
  constexpr float stop_below = 1e-4f;
  std::array<int, group_size + 1> stops{};  ///< at each place of a group; none
  int differences = 0;
  for (int i = 0; i < 40'000; ++i) {
    std::vector<Layer> layers = random_layers(random, group_size, 0.9);
    const unsigned place = unsigned(i) % (group_size + 1);
    const float unit = i % 2 ? 0.99f : exact_unit;
    if (place < group_size) layers[place].alpha = random.f(0.9, 1);
    Pixel together, single;
    together.start(stop_below);
    together.transmittance = random.f(stop_below, i % 3 ? 1.2e-3 : 1);
    together.red = random.f(0, 1);
    single = together;
    blend_together(together, layers.data(), unit);
    unsigned stopped_at = group_size;
    for (unsigned k = 0; k < group_size; ++k) {
      blend_one<false>(single, layers[k], INFINITY, unit);
      if (stopped_at == group_size && !single.live()) stopped_at = k;
    }
    ++stops[stopped_at];
    differences += !same_bits(together, single);
  }
  CHECK(differences == 0);
  for (const int count : stops) CHECK(count > 1000);
}

TEST_CASE("cuda arithmetic: a group meets the limit exactly as its splats one by one") {
  const std::vector<Layer> halves(group_size, Layer{0.5f, {1, 0.5f, 0.25f}, 3});
  for (unsigned place = 0; place < group_size; ++place) {
    CAPTURE(place);
    const float limit = std::exp2(-float(place + 1));  // what the splat at this place leaves
    for (const float stop_below : {limit, above(limit)}) {
      Pixel together, single;
      together.start(stop_below), single.start(stop_below);
      blend_together(together, halves.data());
      for (const Layer& layer : halves) blend_one<false>(single, layer, INFINITY);
      CHECK(same_bits(together, single));
      CHECK(together.blended().transmittance == (stop_below == limit ? limit : 2 * limit));
      CHECK(together.live() == (stop_below == limit && place == group_size - 1));
    }
  }
}

TEST_CASE("cuda arithmetic: a weight is what the pixel is dimmed by until it stops") {
  const float unit = 0.75f;
  Random random(1);
  int stopped = 0;
  for (int i = 0; i < 5000; ++i) {
    Pixel weighed, blended;
    weighed.start(1e-4f), blended.start(1e-4f);
    for (int k = 0; k < 40; ++k) {
      const float alpha = random.in(0, 1) < 0.3 ? 0.0f : random.f(1.0 / 255, i % 2 ? 0.99 : 0.05);
      const float before = blended.transmittance;
      blend<false>(blended, alpha, Pixel::dimmed_relative(before, alpha * before, unit),
                   make_float4(0, 0, 0, 1), INFINITY);
      const float weight = weigh(weighed, alpha, unit);
      REQUIRE(weighed.transmittance == blended.transmittance);
      REQUIRE(weighed.live() == blended.live());
      REQUIRE(weight == (blended.live() ? alpha * before * unit : 0.0f));
    }
    stopped += !blended.live();
  }
  CHECK(stopped > 2000);
}

TEST_CASE("cuda arithmetic: a pixel outside of the image takes nothing") {
  Random random(4);
  const std::vector<Layer> layers = random_layers(random, 8, 0.9);
  Pixel pixel;
  for (const Layer& layer : layers) blend_one<true>(pixel, layer, 2);
  for (std::size_t k = 0; k < layers.size(); k += group_size) blend_together(pixel, &layers[k]);
  CHECK(same_bits(pixel, Pixel()));
}

namespace {

/// Segment k of a pixel's layers, with transmittance `before` in front of it.
BlendedPixel blend_segment(const std::vector<Layer>& layers, std::uint32_t k, float stop_below, float before,
                           bool& live) {
  Pixel pixel;
  start_segment(pixel, stop_below, before, k);
  for (std::size_t i = begin_of_segment(k); i < begin_of_segment(k + 1); i += group_size)
    blend_together(pixel, &layers[i]);
  live = pixel.live();
  return pixel.blended();
}

/// One segment behind the other.
JoinedPixel blend_in_turn(const std::vector<Layer>& layers, float stop_below) {
  JoinedPixel all;
  bool live = true;
  for (std::uint32_t k = 0; begin_of_segment(k) < layers.size() && live; ++k)
    all.join(blend_segment(layers, k, stop_below, all.total.w, live), k);
  return all;
}

/// All segments as if little lay in front of them. The one in which the pixel stops is blended again.
JoinedPixel blend_apart(const std::vector<Layer>& layers, float stop_below, int& again) {
  JoinedPixel all;
  for (std::uint32_t k = 0; begin_of_segment(k) < layers.size(); ++k) {
    bool live = true;
    BlendedPixel segment = blend_segment(layers, k, stop_below, most_before(1), live);
    const float left = mark_stopped(segment.transmittance, !live);
    const bool stops = stops_in_segment(left, stop_below, all.total.w, k);
    if (stops) segment = blend_segment(layers, k, stop_below, all.total.w, live), ++again;
    CHECK(live == !stops);
    all.join(segment, k);
    if (stops) break;
  }
  return all;
}

std::vector<Layer> faint_layers(Random& random, std::uint32_t segments, double largest) {
  std::vector<Layer> layers = random_layers(random, begin_of_segment(segments), 0.02);
  for (Layer& layer : layers) layer.alpha = std::min(layer.alpha, float(largest));
  return layers;
}

}  // namespace

TEST_CASE("cuda arithmetic: segments that are blended apart have the bits of segments in turn") {
  Random random(5);
  int again = 0, differences = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::vector<Layer> layers =
        faint_layers(random, 1 + std::uint32_t(i) % 20, random.scale(1.0 / 255, 0.9));
    const JoinedPixel in_turn = blend_in_turn(layers, 1e-4f), apart = blend_apart(layers, 1e-4f, again);
    differences += std::memcmp(&in_turn.total, &apart.total, sizeof in_turn.total) != 0;
  }
  CHECK(differences == 0);
  CHECK(again > 300);
}

namespace {

/// What a pixel picks from layers, whose ids are their places.
struct Picked {
  JoinedPicks picks;
  JoinedPixel pixel;
  int again = 0;
};

/// Picks of segment k, by limits in its units, as kernels find them.
JoinedPicks pick_segment(const std::vector<Layer>& layers, std::uint32_t k, float stop_below, float before,
                         const PickLimits& limits, float& left) {
  Pixel pixel;
  start_segment(pixel, stop_below, before, k);
  JoinedPicks picks;
  for (std::size_t i = begin_of_segment(k); i < begin_of_segment(k + 1) && pixel.live(); ++i) {
    const float in_front = pixel.transmittance, weight = layers[i].alpha / exact_unit * in_front;
    const float behind = Pixel::dimmed_relative(in_front, weight, exact_unit);
    if (behind < pixel.stop_below) {
      pixel.stop();
      break;
    }
    const auto id = std::uint32_t(i);
    if (weight > picks.weight) picks.weight = weight, picks.largest = id;
    if (in_front >= limits.first) picks.first = id;
    if (in_front >= limits.median) picks.median = id;
    pixel.transmittance = behind;
  }
  left = pixel.blended().transmittance;
  if (!(left < limits.first)) picks.first = SplatPicks::none;
  if (!(left < limits.median)) picks.median = SplatPicks::none;
  left = mark_stopped(left, !pixel.live());
  return picks;
}

/// One segment behind the other, or each at first as if it passed no limit.
Picked pick(const std::vector<Layer>& layers, const PickLimits& limits, bool apart) {
  const float stop_below = 1e-4f;
  Picked out;
  bool live = true;
  for (std::uint32_t k = 0; begin_of_segment(k) < layers.size() && live; ++k) {
    const float before = out.pixel.total.w;
    const PickLimits open = limits.behind(out.picks).in_segment(before, k);
    float left = 0;
    JoinedPicks segment = pick_segment(layers, k, stop_below, apart ? most_before(1) : before,
                                       apart ? PickLimits() : open, left);
    if (apart && (stops_in_segment(left, stop_below, before, k) || open.some_above(std::fabs(left)))) {
      segment = pick_segment(layers, k, stop_below, before, open, left);
      ++out.again;
    }
    out.picks.join(segment, before * scale_of_segment(k));
    live = !std::signbit(left);
    out.pixel.join({vec3(0), std::fabs(left), 0}, k);
  }
  return out;
}

}  // namespace

TEST_CASE("cuda arithmetic: picks of segments that are blended apart are those of segments in turn") {
  Random random(7);
  int again = 0, medians = 0, differences = 0, near_limits = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::vector<Layer> layers =
        faint_layers(random, 1 + std::uint32_t(i) % 20, random.scale(1.0 / 255, 0.3));
    const PickLimits limits{0.95f, median_below};
    const Picked in_turn = pick(layers, limits, false), apart = pick(layers, limits, true);
    differences += std::memcmp(&in_turn.picks, &apart.picks, sizeof in_turn.picks) != 0;
    again += apart.again, medians += in_turn.picks.median != SplatPicks::none;

    // In double, where no decision is close.
    double transmittance = 1, most = 0, next = 0, nearest = 1;
    SplatPicks exact;
    for (std::size_t k = 0; k < layers.size(); ++k) {
      const double weight = double(layers[k].alpha) * transmittance;
      if (transmittance - weight < 1e-4) break;
      transmittance -= weight;
      for (const double limit : {double(0.95f), 0.5})
        nearest = std::min(nearest, std::abs(transmittance - limit));
      if (exact.first == SplatPicks::none && transmittance < double(0.95f)) exact.first = std::uint32_t(k);
      if (exact.median == SplatPicks::none && transmittance < 0.5) exact.median = std::uint32_t(k);
      if (weight > most)
        next = most, most = weight, exact.largest = std::uint32_t(k);
      else
        next = std::max(next, weight);
    }
    if (nearest < 1e-5 || most - next < 1e-5 * most) {
      ++near_limits;
      continue;
    }
    CHECK(in_turn.picks.first == exact.first);
    CHECK(in_turn.picks.median == exact.median);
    CHECK(in_turn.picks.largest == exact.largest);
  }
  CHECK(differences == 0);
  CHECK(again > 1000);
  CHECK(medians > 300);
  CHECK(near_limits < 200);
}

TEST_CASE("cuda arithmetic: limits that are passed or absent pick nothing") {
  const PickLimits none;
  for (const float left : {0.0f, 0.5f, 1.0f, INFINITY}) CHECK(!none.some_above(left));
  for (const float before : {1.0f, 1e-30f, 0.0f}) CHECK(!none.in_segment(before, 3).some_above(0));
  const PickLimits both{0.95f, median_below};
  // Behind a pixel that lets nothing through, or less than the limit, only a splat passes it.
  for (const float before : {0.3f, 1e-30f, 0.0f}) {
    const PickLimits in = both.in_segment(before, 5);
    CHECK(in.first == 1 / scale_of_segment(5));
    CHECK(in.median == 1 / scale_of_segment(5));
    CHECK(!in.some_above(1 / scale_of_segment(5)));
  }
  JoinedPicks picks;
  picks.first = 7;
  CHECK(std::isnan(both.behind(picks).first));
  CHECK(both.behind(picks).median == median_below);
}

TEST_CASE("cuda arithmetic: a pixel in segments is as exact as a pixel at once") {
  Random random(6);
  for (int i = 0; i < 300; ++i) {
    const std::vector<Layer> layers = faint_layers(random, 16, random.scale(1.0 / 255, 0.02));
    double transmittance = 1, red = 0;
    for (const Layer& layer : layers) {
      const double next = transmittance * (1 - double(layer.alpha));
      if (next < 1e-4) break;
      red += double(layer.alpha) * transmittance * double(layer.rgb.x), transmittance = next;
    }
    const JoinedPixel joined = blend_in_turn(layers, 1e-4f);
    CHECK(double(joined.total.x * exact_unit) == doctest::Approx(red).epsilon(4e-6));
    CHECK(double(joined.total.w) ==
          doctest::Approx(transmittance).epsilon(0.03));  // may stop a splat earlier
  }
}

TEST_CASE("cuda arithmetic: errors of equal segments do not add up") {
  double sum = 0;
  int judged = 0;
  for (int i = 0; i < 500; ++i) {
    const float alpha = float(std::exp(-6.0 - 4.0 * i / 500));
    const std::vector<Layer> layers(begin_of_segment(78), Layer{alpha, {1, 1, 1}, 1});
    const double exact = std::pow(1 - double(alpha), double(layers.size()));
    if (exact < 1e-4) continue;
    const double error = (double(blend_in_turn(layers, 0).total.w) / exact - 1) * 0x1p23;
    sum += error * error, ++judged;
  }
  CHECK(judged > 200);
  CHECK(std::sqrt(sum / judged) < 30);  // 18 ulps; segments that all begin with 1 have 109
}

TEST_CASE("cuda arithmetic: a segment stops where the limit is reached by all segments") {
  CHECK(scale_of_segment(0) == 1);
  for (std::uint32_t k = 0; k < 10'000; ++k) {
    REQUIRE(scale_of_segment(k) >= 1);
    REQUIRE(scale_of_segment(k) < 2);
  }
  CHECK(stop_of_segment(1e-4f, 1, 0) == 1e-4f);
  CHECK(stop_of_segment(0.25f, 0.5f, 0) == 0.5f);
  CHECK(stop_of_segment(0.25f, 0.2f, 0) == 1);
  CHECK(stop_of_segment(0, 0.5f, 3) == 0);
  CHECK(stop_of_segment(0, 0, 3) == 0);
  for (std::uint32_t k = 0; k < 100; ++k) {
    Pixel pixel;
    start_segment(pixel, 0.25f, 0.2f, k);  // below the limit, but not yet dimmed in the segment
    blend_together(pixel, std::vector<Layer>(group_size, Layer{0, {1, 1, 1}, 3}).data());
    REQUIRE(pixel.live());
    blend_together(pixel, std::vector<Layer>(group_size, Layer{0.01f, {1, 1, 1}, 3}).data());
    REQUIRE(!pixel.live());
    REQUIRE(pixel.red == 0);
  }
  std::vector<Layer> layers(begin_of_segment(2), Layer{0, {1, 1, 1}, 3});
  layers[3].alpha = layers[first_segment_size + 7].alpha = 0.5f;
  for (const float limit : {0.24f, 0.26f}) {
    const JoinedPixel joined = blend_in_turn(layers, limit);
    CHECK(joined.total.w == doctest::Approx(limit < 0.25f ? 0.25 : 0.5).epsilon(3e-7));
    CHECK(joined.total.x * exact_unit == doctest::Approx(1 - double(joined.total.w)).epsilon(3e-7));
  }
}
