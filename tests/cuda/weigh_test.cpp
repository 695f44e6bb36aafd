// SPDX-License-Identifier: Apache-2.0

// The weights of kernels, on the host: against what they blend, and against the serial backend.
#include "weigh.hpp"

#include <cmath>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>
#include <vector_functions.h>

#include <swiftgs/contribution.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/sort/early.hpp>

#include "box_touched.hpp"
#include "exponents.hpp"
#include "policies/random_splats.hpp"
#include "policies/tile_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::kernels;
using namespace swiftgs::test;

namespace {

/// Weight of each splat in a warp block of 8x8 pixels, as the kernel finds it.
std::vector<std::uint64_t> weights_in_warp_block(const SplatSet& splats, Span<const std::uint32_t> ids,
                                                 vec2 first_centre, const BlendRules& rules) {
  std::vector<std::uint64_t> parts(splats.shapes.size());
  for (int lane = 0; lane < 32; ++lane) {
    Pixel pixels[pixels_of_lane];
    for (Pixel& pixel : pixels) pixel.start(rules.stop_below);
    for (const std::uint32_t id : ids) {
      const SplatShape& shape = splats.shapes[id];
      if (!box_touched(shape, first_centre, 8)) continue;
      float4 terms;
      CholeskyExponent::Rest rest;
      CholeskyExponent::prepare(shape, shape.mean - first_centre, relative_log2_opacity(shape, rules), terms,
                                rest);
      float exponents[pixels_of_lane];
      CholeskyExponent::evaluate(terms, rest, float(lane % 4), float(lane / 4), exponents);
      for (unsigned p = 0; p < pixels_of_lane; ++p)
        parts[id] +=
            weight_parts(weigh(pixels[p], relative_alpha<true>(exponents[p], rules), rules.alpha_max));
    }
  }
  return parts;
}

}  // namespace

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

TEST_CASE("cuda arithmetic: weights in the warp blocks of a raster block are those of the serial backend") {
  Serial serial;
  const BlendRules rules = BlendRules::from(Conventions::gsplat());
  double sum = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const SplatSet splats = random_splats(300, raster_block_side, raster_block_side, seed);
    const SortInput job = splats.job(raster_block_side, raster_block_side);
    const TileLists<Serial> lists = build_lists<EarlySort, Ellipse>(serial, job);
    std::vector<std::uint64_t> expected(splats.shapes.size()), parts(splats.shapes.size());
    View view = view_without_camera(raster_block_side, raster_block_side);
    view.rules = rules;
    const RasterJob raster{splats.view(), splats.colours_view(), lists.view(), {&view, 1}};
    add_contributions(serial, ContributionJob{raster, expected.data()});
    for (int part = 0; part < 4; ++part) {
      const vec2 first_centre(float(part % 2) * 8 + 0.5f, float(part / 2) * 8 + 0.5f);
      const auto of_part = weights_in_warp_block(splats, lists.view().ids, first_centre, rules);
      for (std::size_t i = 0; i < parts.size(); ++i) parts[i] += of_part[i];
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
      CAPTURE(i);
      const double weight = weight_of_parts(expected[i]);
      // Terms of needles and giants are large: their exponents are rounded by a few 1e-5. One pixel at the
      // threshold of alpha keeps 1/255 more or less.
      REQUIRE(std::abs(weight_of_parts(parts[i]) - weight) <= 1e-3 * weight + 1.0 / 255);
      sum += weight;
    }
  }
  CHECK(sum > 20 * 200);
}
