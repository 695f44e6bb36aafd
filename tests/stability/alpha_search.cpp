// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vector>

#include "policies/rasterizers.hpp"
#include "stability/search.hpp"
#include "stability/targets.hpp"
#include "stability/ulps.hpp"

namespace swiftgs::test {
namespace {

// The tile that is drawn: not the first, so that coordinates round.
constexpr int tile_x = 4, tile_y = 2, width = (tile_x + 1) * raster_block_side,
              height = (tile_y + 1) * raster_block_side;
constexpr Real ln_2 = 0.693147180559945309417232121458176568L;

/// s of a pixel, and the scales that errors of s are measured by.
struct Exponent {
  Real s, moved, split, half;

  Exponent(const SplatShape& shape, Real x, Real y) {
    const Real mx = shape.exact_mean().x, my = shape.exact_mean().y, l0 = shape.l0, l1 = shape.l1,
               l2 = shape.l2;
    const Real dx = x - mx, dy = y - my, u = l0 * dx + l1 * dy, v = l2 * dy;
    s = u * u + v * v;
    // What s moves by if each number of the splat moves by one ulp.
    const Real du = ulp(l0) * std::abs(dx) + l0 * ulp(mx) + ulp(l1) * std::abs(dy) + std::abs(l1) * ulp(my);
    const Real dv = ulp(l2) * std::abs(dy) + l2 * ulp(my);
    moved = 2 * std::abs(u) * du + du * du + 2 * std::abs(v) * dv + dv * dv;
    // The scale of the bound that `FloatSplit` states; the bound is 64 of these.
    const Real wide = std::abs(u) + 16 * (l0 + std::abs(l1)), high = std::abs(v) + 16 * l2;
    split = 0x1p-24L * (wide * wide + high * high);
    // One rounding to half of the largest term, and what subnormal halves lose.
    const Real mixed = 2 * l0 * l1 * dx;
    const Real largest = std::max({l0 * l0 * dx * dx, (l1 * l1 + l2 * l2) * dy * dy, std::abs(mixed * dy)});
    half = 0x1p-11L * largest + 0x1p-24L * (1 + std::abs(dy) + std::abs(mixed));
  }
};

template <class Name>
const char* yardstick(Name name) {
  if (name.find("half") != name.npos) return "ulps, s by roundings of its largest term to half";
  if (name.find("split") != name.npos) return "ulps, s by 1/64 of its stated bound";
  return "conditioned ulps";
}
template <class Name>
Real scale_of(Name name, const Exponent& e) {
  return name.find("half") != name.npos ? e.half : name.find("split") != name.npos ? e.split : e.moved;
}

SplatShape draw_shape(Random& random) {
  const double across = random.scale(0.5478, 60), along = across * random.scale(1, 100);
  const double middle_x = tile_x * raster_block_side + 8, middle_y = tile_y * raster_block_side + 8;
  const double angle = random.in(0, 3.14159265), t = random.in(-2, 2), w = random.in(-2, 2);
  SplatShape shape = make_splat(middle_x + t * along * std::cos(angle) - w * across * std::sin(angle),
                                middle_y + t * along * std::sin(angle) + w * across * std::cos(angle), along,
                                across, angle, random.scale(1.0 / 250, 1));
  shape.low = 0;  // the yardstick counts units of a float mean
  return shape;
}

void nudge_all(Random& random, SplatShape& s) {
  nudge(random, s.mean.x), nudge(random, s.mean.y), nudge(random, s.l0), nudge(random, s.l1);
  nudge(random, s.l2), nudge(random, s.opacity);
  s.l0 = std::abs(s.l0), s.l2 = std::abs(s.l2);
  // No splat is narrower than the blur.
  s.l0 = std::fmin(s.l0, 1.5506f), s.l2 = std::fmin(s.l2, 1.5506f);
  s.opacity = std::fmin(1.0f, std::abs(s.opacity));
  s.cutoff = float(std::log2(double(s.opacity) / double(Conventions().alpha_min)));
}

/// Draws single splats on one backend; alpha is the colour of a white splat on black.
template <class B>
class Drawer {
 public:
  explicit Drawer(B& backend) : backend_(backend) {}
  template <class Raster>
  void draw(Raster raster, const SplatShape& shape) {
    const auto one = to_backend(backend_, std::vector{shape});
    const SplatsView splats{one.span(), {}, {}};  // rasterizers read no more of them
    const TileListsView lists{id_.span(), ranges_.span()};
    rasterize(backend_, raster, RasterJob{splats, {white_.span()}, lists, {&view_, 1}});
    colours_ = frame_.colours(backend_);
  }
  float alpha(int x, int y) const { return colours_[3 * std::size_t(y * width + x)]; }

 private:
  /// The last tile lists the only splat.
  static std::vector<TileRange> last_tile(TileGrid grid) {
    std::vector<TileRange> ranges(grid.size());
    ranges.back() = {0, 1};
    return ranges;
  }

  template <class T>
  using Buffer = typename B::template Buffer<T>;

  B& backend_;
  Buffer<TileRange> ranges_ = to_backend(backend_, last_tile(TileGrid::covering(width, height)));
  Buffer<SplatColour> white_ = to_backend(backend_, std::vector<SplatColour>{{vec3(1), 1}});
  Buffer<std::uint32_t> id_ = to_backend(backend_, std::vector<std::uint32_t>{0});
  FrameOn<B> frame_{width, height};
  std::vector<float> colours_;
  View view_{
      .rules = blend_rules(Conventions()), .grid = TileGrid::covering(width, height), .frame = frame_.view()};
};

/// All pixels of the tile, exactly.
struct Tile {
  std::vector<Exponent> exponents;
  std::vector<Real> alphas;

  explicit Tile(const SplatShape& shape) {
    for (int y = 0; y < raster_block_side; ++y)
      for (int x = 0; x < raster_block_side; ++x) {
        exponents.emplace_back(shape, Real(tile_x * raster_block_side + x) + 0.5L,
                               Real(tile_y * raster_block_side + y) + 0.5L);
        alphas.push_back(Real(shape.opacity) * std::exp2(-exponents.back().s));
      }
  }
};

/// The largest error of log2 of a kept alpha that is not cut, over what one ulp of alpha, opacity and reach
/// and the scale of s explain.
template <class Raster, class B>
double error(Drawer<B>& drawer, const SplatShape& shape, const Tile& tile) {
  drawer.draw(Raster(), shape);
  Real worst = 0;
  for (std::size_t i = 0; i < tile.alphas.size(); ++i) {
    const float alpha = drawer.alpha(tile_x * raster_block_side + int(i) % raster_block_side,
                                     tile_y * raster_block_side + int(i) / raster_block_side);
    const Real exact = tile.alphas[i];
    if (alpha == 0 || alpha == 0.99f || exact > 0.99L) continue;
    const Real by_alpha = (ulp(exact) / exact + ulp(shape.opacity) / shape.opacity) / ln_2;
    const Real explained = by_alpha + ulp(shape.cutoff) + scale_of(Raster::name, tile.exponents[i]);
    worst = std::max(worst, std::abs(std::log2(alpha / exact)) / explained);
  }
  return double(worst);
}

/// The largest error of s itself, by the scale of its exponent representation and one ulp.
template <class Representation>
double exponent_error(const SplatShape& shape, const Tile& tile) {
  const vec2 centre(float(tile_x * raster_block_side + 8), float(tile_y * raster_block_side + 8));
  const Representation terms(shape, centre);
  Real worst = 0;
  for (std::size_t i = 0; i < tile.alphas.size(); ++i) {
    const Exponent& e = tile.exponents[i];
    if (e.s > Real(shape.cutoff)) continue;
    const float x = float(tile_x * raster_block_side) + float(i % raster_block_side) + 0.5f;
    const float y = float(tile_y * raster_block_side) + float(i / raster_block_side) + 0.5f;
    const float s = Representation::exponent(terms.x_term(x), terms.y_term(y));
    if (std::isfinite(s))
      worst = std::max(worst, std::abs(s - e.s) / (ulp(e.s) + scale_of(Representation::name, e)));
  }
  return double(worst);
}

}  // namespace

std::vector<Worst> search_alpha(int effort) {
  Targets targets;
  std::vector<Worst> worst;
  const auto add = [&](const std::string& stage, const char* by, const std::string& target) {
    worst.push_back({stage, by, target, 0, ""});
  };
  const auto each_terms = [](const auto& f) {
    f(FloatCholesky::name), f(FloatSplit::name), f(HalfSplit::name);
  };
  each_terms([&](auto name) { add("exponent `" + std::string(name) + "`", yardstick(name), "serial"); });
  for (std::size_t t = 0; t < targets.size(); ++t)
    for_each_raster([&]<class Raster>(Raster) {
      add("alpha `" + std::string(Raster::name) + "`", yardstick(Raster::name), targets.name(t));
    });
  Search<SplatShape> search(worst.size(), 40, effort, 400);
  const auto judge = [&](const std::vector<SplatShape>& candidates, const auto& offer) {
    std::vector<Tile> tiles;
    for (const SplatShape& shape : candidates) {
      tiles.emplace_back(shape);
      offer(0, shape, exponent_error<FloatCholesky>(shape, tiles.back()));
      offer(1, shape, exponent_error<FloatSplit>(shape, tiles.back()));
      offer(2, shape, exponent_error<HalfSplit>(shape, tiles.back()));
    }
    for (std::size_t t = 0, at = 3; t < targets.size(); ++t)
      targets.on(t, [&]<class B>(B& backend) {
        Drawer<B> drawer(backend);
        for_each_raster([&]<class Raster>(Raster) {
          for (std::size_t i = 0; i < candidates.size(); ++i)
            offer(at, candidates[i], error<Raster>(drawer, candidates[i], tiles[i]));
          ++at;
        });
      });
  };
  search.run(128, draw_shape, nudge_all, judge);
  for (std::size_t i = 0; i < worst.size(); ++i) {
    const SplatShape& s = search.best()[i].candidate;
    worst[i].ulps = search.value(i);
    worst[i].at = text("mean %.9g %.9g l0 %.9g l1 %.9g l2 %.9g opacity %.9g", s.exact_mean().x,
                       s.exact_mean().y, double(s.l0), double(s.l1), double(s.l2), double(s.opacity));
  }
  return worst;
}

}  // namespace swiftgs::test
