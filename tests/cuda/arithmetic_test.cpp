// SPDX-License-Identifier: Apache-2.0

// The arithmetic of kernels, on the host: alphas at their thresholds, boxes that splats touch and tiles that
// list them, bits of footprints.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/cuda/epochs.hpp>
#include <swiftgs/cuda/find_bit.hpp>
#include <swiftgs/tools/policy_lists.hpp>

#include "blending.hpp"
#include "cuda/exact_square.hpp"
#include "other_exponents.hpp"
#include "policies/random_splats.hpp"
#include "sh_words.hpp"

using namespace swiftgs;
using namespace swiftgs::kernels;
using namespace swiftgs::test;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

/// A power of two as threshold, so that the exponential meets it exactly.
constexpr BlendRules rules{1.0f / 256, 0.75f, 0.25f, -8, -7.5849625f};

float above(float x) { return std::nextafter(x, infinity); }
float below(float x) { return std::nextafter(x, -infinity); }

}  // namespace

TEST_CASE("cuda arithmetic: alpha is kept from its least on and cut at its largest") {
  // In units of alpha_max: 1/256 is 1/192.
  const float least = rules.log2_relative_min, alpha_min = std::exp2(least);
  CHECK(alpha_min * rules.alpha_max == doctest::Approx(double(rules.alpha_min)).epsilon(1e-6));
  const float alphas[][2] = {{least, alpha_min}, {-1, 0.5f},     {0, 1},        {1e-6f, 1},       {3, 1},
                             {infinity, 1},      {-infinity, 0}, {-1000.0f, 0}, {not_a_number, 0}};
  for (const auto& pair : alphas) {
    const float exponent = pair[0], alpha = pair[1];
    CAPTURE(exponent);
    CHECK(relative_alpha<false>(exponent, rules) == alpha);
    CHECK(relative_alpha<true>(exponent, rules) == alpha);
  }
  CHECK(relative_alpha<false>(least - 1e-5f, rules) == 0);
  CHECK(relative_alpha<true>(below(least), rules) == 0);
}

TEST_CASE("cuda arithmetic: alpha of a square is kept up to the cutoff and cut at its largest") {
  // Opacity 1/2 and the threshold 1/256: seven halvings.
  const auto plain = [](float s) { return alpha_of_square<false>(s, 7, 0.5f, rules); };
  const auto decided = [](float s) { return alpha_of_square<true>(s, 7, 0.5f, rules); };
  const float alphas[][2] = {{7, rules.alpha_min}, {0, 0.5f},     {-0.0f, 0.5f},    {-1e-6f, 0},
                             {-infinity, 0},       {infinity, 0}, {not_a_number, 0}};
  for (const auto& pair : alphas) {
    const float square = pair[0], alpha = pair[1];
    CAPTURE(square);
    CHECK(plain(square) == alpha);
    CHECK(decided(square) == alpha);
  }
  CHECK(plain(7.00001f) == 0);
  CHECK(decided(above(7)) == 0);
  CHECK(alpha_of_square<false>(0, 8, 1, rules) == rules.alpha_max);
  CHECK(alpha_of_square<true>(0, 8, 1, rules) == rules.alpha_max);
  CHECK(decided(-1) == 0);
  CHECK(alpha_of_square<true>(0, -1, 0, rules) == 0);  // room of a batch without a splat
}

TEST_CASE("cuda arithmetic: splats that fill a group up show nothing") {
  const auto check = [&]<class Exponent>(Exponent) {
    float4 terms;
    typename Exponent::Rest rest;
    Exponent::clear(terms, rest);
    float exponents[pixels_of_lane];
    Exponent::evaluate(terms, rest, 7, 3, exponents);
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      CHECK(relative_alpha<false>(exponents[p], rules) == 0);
      CHECK(relative_alpha<true>(exponents[p], rules) == 0);
    }
  };
  check(CholeskyExponent());
  check(SplitExponent());
}

namespace {

/// Least s of a splat in the box of `side` pixels whose first centre is `first`: over the centres, and over
/// all points between them.
struct LeastSquares {
  double of_centres = INFINITY, of_box = INFINITY, error = 0;

  LeastSquares(const SplatShape& shape, vec2 first, int side) {
    const double x0 = double(first.x), y0 = double(first.y), x1 = x0 + side - 1, y1 = y0 + side - 1;
    for (int i = 0; i < side * side; ++i)
      of_centres = std::min(of_centres, ExactSquare(shape, x0 + i % side, y0 + i / side).s);
    const double l0 = double(shape.l0), l1 = double(shape.l1), l2 = double(shape.l2);
    const double mx = shape.exact_mean().x, my = shape.exact_mean().y;
    const auto take = [&](double x, double y) {
      const ExactSquare exact(shape, std::clamp(x, x0, x1), std::clamp(y, y0, y1));
      of_box = std::min(of_box, exact.s), error = std::max(error, 4 * exact.error);
    };
    // At the mean, or where an edge has its least.
    if (mx >= x0 && mx <= x1 && my >= y0 && my <= y1) take(mx, my);
    for (const double x : {x0, x1}) take(x, my - l0 * l1 * (x - mx) / (l1 * l1 + l2 * l2));
    for (const double y : {y0, y1}) take(mx - l1 * (y - my) / l0, y);
  }
};

}  // namespace

TEST_CASE(
    "cuda arithmetic: a box is touched where the ellipse meets it or a pixel keeps the splat, nowhere else") {
  Random random(9);
  int touched_wrongly = 0, refused_wrongly = 0, decided = 0, near = 0, kept = 0;
  for (int i = 0; i < 60'000; ++i) {
    const int side = i % 3 == 2 ? 16 : 8;
    const SplatShape shape = i % 2 ? usual_splat(random, 32, 32) : random_splat(random, 32, 32);
    const auto begin = [&] { return float(side * int(random.in(-1, 40.0 / side))) + 0.5f; };
    const float x = begin();
    const vec2 first(x, begin());
    const bool touched = box_touched(shape, first, float(side));
    const LeastSquares least(shape, first, side);
    const double cutoff = double(shape.cutoff);
    const bool keeps = least.of_centres <= cutoff;
    kept += keeps, refused_wrongly += keeps && !touched;
    if (least.of_box + least.error <= cutoff)
      refused_wrongly += !touched, ++decided;
    else if (least.of_box - least.error > 1.0001 * cutoff)
      touched_wrongly += touched, ++decided, near += least.of_box < 1.5 * cutoff;
  }
  CHECK(refused_wrongly == 0);
  CHECK(touched_wrongly == 0);
  CHECK(kept > 5000);
  CHECK(decided > 58'000);
  CHECK(near > 500);
}

namespace {

/// Whether no row of pixel centres meets the ellipse of a splat.
bool lies_between_rows(const SplatShape& shape) {
  const double height = std::sqrt(double(shape.cutoff)) / double(shape.l2), y = shape.exact_mean().y;
  return std::ceil(y - height - 0.5) > std::floor(y + height - 0.5);
}

}  // namespace

TEST_CASE("cuda arithmetic: conservative bounds list every tile of which a box is touched") {
  // Segments of long lists are made of the splats that touch a warp block, so all conservative bounds must
  // list them. A splat that lies between two rows of pixel centres is the exception: none of them may list it
  // anywhere.
  const int width = 192, height = 128;
  int between_rows_of_all = -1;
  for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
    if constexpr (Bounds::conservative) {
      CAPTURE(Bounds::name);
      for (const int tile_side : {16, 32, 64}) {
        CAPTURE(tile_side);
        const TileGrid grid = TileGrid::covering(width, height, tile_side);
        Random random(11);
        int missed = 0, touched = 0, touched_only = 0, between_rows = 0;
        for (int i = 0; i < 6000; ++i) {
          const SplatShape shape =
              i % 3 == 0 ? random_splat(random, width, height) : usual_splat(random, width, height);
          const auto found = bounds.tiles(shape, grid);
          std::vector<bool> listed(grid.size());
          for (int row = found.rect.rows.begin; row < found.rect.rows.end; ++row) {
            const TileRun run = found.row(row);
            for (int column = run.begin; column < run.end; ++column) listed[grid.number(column, row)] = true;
          }
          for (const int side : {8, 16})
            for (int y = 0; y < height; y += side)
              for (int x = 0; x < width; x += side) {
                const vec2 first(float(x) + 0.5f, float(y) + 0.5f);
                if (!box_touched(shape, first, float(side))) continue;
                ++touched;
                if (found.rect.rows.size() == 0 && lies_between_rows(shape))
                  ++between_rows;
                else
                  missed += !listed[grid.tile_at(x, y)];
                // What keeping pixels alone would not ask for.
                if (side == 8 && i % 3 != 0)
                  touched_only += LeastSquares(shape, first, side).of_centres > double(shape.cutoff);
              }
        }
        CHECK(missed == 0);
        CHECK(touched > 100'000);
        CHECK(touched_only > 10);
        if (between_rows_of_all < 0) between_rows_of_all = between_rows;
        CHECK(between_rows == between_rows_of_all);
      }
    }
  });
}

TEST_CASE("cuda arithmetic: each bit of a mask is found in its turn") {
  for (unsigned bit = 0; bit < 64; ++bit) CHECK(find_bit(std::uint64_t(1) << bit, 0) == bit);
  for (unsigned n = 0; n < 64; ++n) CHECK(find_bit(~std::uint64_t(0), n) == n);
  Random random(10);
  int wrong = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::uint64_t mask = random.bits();
    for (int thinner = i % 5; thinner > 0; --thinner) mask &= random.bits();
    unsigned n = 0;
    for (unsigned bit = 0; bit < 64; ++bit)
      if (mask >> bit & 1) wrong += find_bit(mask, n++) != bit;
  }
  CHECK(wrong == 0);
}

TEST_CASE("cuda arithmetic: harmonics fit their words and lanes read them from different banks") {
  for (int degree = 0; degree <= max_sh_degree; ++degree) {
    CAPTURE(degree);
    const unsigned floats = 3 * unsigned(sh_rest_count(degree));
    CHECK(4 * rest_words(degree) >= floats);
    CHECK(4 * rest_words(degree) < floats + 4);
    CHECK(rest_pitch(degree) >= rest_words(degree));
    // Eight lanes read quadruples at a time, from 32 banks of a float.
    std::set<unsigned> banks;
    for (unsigned lane = 0; lane < 8; ++lane) banks.insert(lane * rest_pitch(degree) % 8);
    CHECK(banks.size() == 8);
  }
}

TEST_CASE("cuda arithmetic: operations in a row have other tags and alternate between copies") {
  const std::uint32_t begins[] = {0, 12'345, epochs_in_all - 5};
  for (std::uint32_t epoch : begins) {
    std::set<std::uint32_t> tags;
    for (int i = 0; i < 10; ++i) {
      CAPTURE(epoch);
      for (std::uint32_t pass = 0; pass < most_passes; ++pass) {
        const std::uint32_t tag = tag_of(epoch, pass);
        CHECK(tag != 0);  // as cleared memory
        CHECK(tag < 1u << 30);
        CHECK(tags.insert(tag).second);
      }
      const std::uint32_t next = epoch_after(epoch);
      CHECK(next < epochs_in_all);
      CHECK(copy_of(next) != copy_of(epoch));
      const int copies[] = {0, 1};
      CHECK(LastCounters<int>{copies, &next}.get() == int(copy_of(epoch)));
      epoch = next;
    }
    CHECK(tags.size() == 10 * most_passes);
  }
  const int alone = 7;
  CHECK(LastCounters<int>{&alone}.get() == 7);
}

TEST_CASE("cuda arithmetic: no word is older than a few rounds of sweeping") {
  struct Words {
    std::uint32_t row, capacity, mask;
  };
  for (const Words& words : {Words{1, 37, 63}, Words{1, 64, 63}, Words{4, 150, 255}})
    for (std::uint32_t epoch : {0u, epochs_in_all - 100}) {
      CAPTURE(words.capacity);
      Random random(epoch);
      const std::uint32_t rows = words.capacity / words.row;
      std::vector<int> written(words.capacity);  // in which operation; 0: cleared
      int oldest = 0;
      for (int operation = 1; operation < 1000; ++operation) {
        const std::uint32_t used =
            words.row * (operation % 50 == 1 ? rows : 1 + std::uint32_t(random.bits() % 5));
        std::fill_n(written.begin(), used, operation);
        const std::uint32_t swept = swept_word(epoch, words.row, words.mask);
        if (swept >= used && swept + words.row <= words.capacity)
          std::fill_n(written.begin() + swept, words.row, 0);
        for (const int age : written)
          if (age != 0) oldest = std::max(oldest, operation - age);
        epoch = epoch_after(epoch);
      }
      CHECK(oldest > 10);
      CHECK(oldest <= 2 * 64);
    }
}
