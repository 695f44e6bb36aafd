// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vector>

#include "policies/rasterizers.hpp"
#include "stability/search.hpp"
#include "stability/targets.hpp"
#include "stability/ulps.hpp"

namespace swiftgs::test {
namespace {

/// Layers of `alphas` in turn, from front to back.
struct Candidate {
  float alphas[8];
  int period;  ///< 1: all layers are equal
};

/// Transmittance after `layers` layers of each candidate, by a whole rasterization: one row of pixels, a tile
/// a candidate, black splats in front of a white background. Splats are flat, so alpha is their opacity.
template <class B>
std::vector<float> transmittances(B& backend, const std::vector<Candidate>& candidates, int layers) {
  const int width = int(candidates.size()) * raster_block_side;
  std::vector<SplatShape> shapes;
  std::vector<SplatColour> colours;
  std::vector<std::uint32_t> ids;
  std::vector<TileRange> ranges;
  for (const Candidate& c : candidates) {
    const auto first = std::uint32_t(shapes.size()), begin = std::uint32_t(ids.size());
    for (int k = 0; k < c.period; ++k) {
      SplatShape shape;
      shape.opacity = c.alphas[k], shape.cutoff = 20;
      shapes.push_back(shape), colours.push_back({vec3(0), 1});
    }
    for (int k = 0; k < layers; ++k) ids.push_back(first + std::uint32_t(k % c.period));
    ranges.push_back({begin, std::uint32_t(ids.size())});
  }
  FrameOn<B> frame(width, 1);
  const auto shapes_on = to_backend(backend, shapes);
  const auto colours_on = to_backend(backend, colours);
  const auto ids_on = to_backend(backend, ids);
  const auto ranges_on = to_backend(backend, ranges);
  const SplatsView splats{shapes_on.span(), {}, {}};  // rasterizers read no more of them
  const TileListsView lists{ids_on.span(), ranges_on.span()};
  const View view{.rules = {1e-6f, 0.99f, 0},
                  .background = vec3(1),
                  .grid = TileGrid::covering(width, 1),
                  .frame = frame.view()};
  rasterize(backend, PerPixel(), RasterJob{splats, {colours_on.span()}, lists, {&view, 1}});
  const std::vector<float> drawn = frame.colours(backend);
  std::vector<float> found;
  for (std::size_t i = 0; i < candidates.size(); ++i) found.push_back(drawn[3 * raster_block_side * i]);
  return found;
}

Real exactly(const Candidate& c, int layers) {
  Real t = 1;
  for (int k = 0; k < layers; ++k) t *= 1 - Real(c.alphas[k % c.period]);
  return t;
}

/// What the result moves by, as a part of itself, if every alpha moves by one ulp.
Real moved(const Candidate& c, int layers) {
  Real sum = 0;
  for (int k = 0; k < layers; ++k) sum += ulp(c.alphas[k % c.period]) / (1 - Real(c.alphas[k % c.period]));
  return sum;
}

/// The largest alpha of `layers` layers that leaves 1e-30.
double largest_alpha(int layers) { return std::fmin(0.98, -std::expm1(-69.0 / layers)); }

Candidate draw_alphas(Random& random, int layers, int period) {
  Candidate c{};
  c.period = period;
  for (float& a : c.alphas) a = float(random.scale(1.0 / 255, largest_alpha(layers)));
  return c;
}

std::string text_of(const Candidate& c) {
  std::string line = "alphas";
  for (int k = 0; k < c.period; ++k) line += text(" %.9g", double(c.alphas[k]));
  return line;
}

/// Mean error over a fixed number of draws, in 2^-23 of the result: rounding that leans to one side would
/// grow with the layers.
template <class B>
double bias(B& backend, int layers, int period) {
  Random random(std::uint64_t(600 + layers + period));
  std::vector<Candidate> candidates;
  for (int i = 0; i < 256; ++i) candidates.push_back(draw_alphas(random, layers, period));
  const std::vector<float> found = transmittances(backend, candidates, layers);
  Real sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Real exact = exactly(candidates[i], layers);
    sum += (found[i] - exact) / (0x1p-23L * exact);
  }
  return double(std::abs(sum) / Real(found.size()));
}

/// Searches for the alphas, between `least` and `most`, after which the transmittance errs most, in units of
/// `allowed(candidate, exact transmittance)`. Each target has an objective.
template <class Draw, class Allowed>
Search<Candidate> search_layers(Targets& targets, int effort, std::uint64_t seed, std::size_t size,
                                int layers, float least, float most, const Draw& draw,
                                const Allowed& allowed) {
  Search<Candidate> search(targets.size(), 12, effort, seed);
  const auto judge = [&](const std::vector<Candidate>& candidates, const auto& offer) {
    std::vector<Real> exact, scales;
    for (const Candidate& c : candidates) {
      exact.push_back(exactly(c, layers));
      scales.push_back(allowed(c, exact.back()));
    }
    for (std::size_t t = 0; t < targets.size(); ++t) {
      std::vector<float> found;
      targets.on(t, [&](auto& backend) { found = transmittances(backend, candidates, layers); });
      for (std::size_t i = 0; i < found.size(); ++i)
        offer(t, candidates[i], double(std::abs(found[i] - exact[i]) / scales[i]));
    }
  };
  const auto nudge_all = [&](Random& random, Candidate& c) {
    for (float& a : c.alphas) nudge(random, a), a = std::clamp(a, least, most);
  };
  search.run(size, draw, nudge_all, judge);
  return search;
}

Worst worst_of(const Search<Candidate>& search, std::size_t target, const std::string& stage,
               const char* yardstick, const std::string& name) {
  return {stage, yardstick, name, search.value(target), text_of(search.best()[target].candidate)};
}

}  // namespace

std::vector<Worst> search_transmittance(int effort) {
  Targets targets;
  std::vector<Worst> worst;
  // Alphas above 1/2 are exact inputs here, so only the result is rounded. Plain ulps show that rounding;
  // conditioned ones do not, because an ulp of such an alpha is many ulps of the transmittance left.
  const auto draw_opaque = [](Random& random) {
    Candidate c{};
    c.period = 4;
    for (float& a : c.alphas) a = random.f(0.5, 0.99);
    return c;
  };
  const Search<Candidate> opaque = search_layers(targets, effort, 521, 256, 4, 0.5f, 0.99f, draw_opaque,
                                                 [](const Candidate&, Real exact) { return ulp(exact); });
  for (std::size_t t = 0; t < targets.size(); ++t)
    worst.push_back(
        worst_of(opaque, t, "transmittance after 4 nearly opaque layers", "ulps", targets.name(t)));

  for (const int layers : {10, 100, 1000, 10000}) {
    for (const int period : {1, 8}) {
      const Search<Candidate> search = search_layers(
          targets, effort, std::uint64_t(500 + layers + period), 64, layers, 1.0f / 255,
          float(largest_alpha(layers)), [&](Random& random) { return draw_alphas(random, layers, period); },
          [&](const Candidate& c, Real exact) { return ulp(exact) + exact * moved(c, layers); });
      const std::string of =
          text("transmittance after %d %s layers", layers, period == 1 ? "equal" : "unequal");
      for (std::size_t t = 0; t < targets.size(); ++t) {
        worst.push_back(worst_of(search, t, of, "conditioned ulps", targets.name(t)));
        Worst mean{"mean error of " + of, "2^-23 of it", targets.name(t), 0, "256 draws"};
        targets.on(t, [&](auto& backend) { mean.ulps = bias(backend, layers, period); });
        worst.push_back(mean);
      }
    }
  }
  return worst;
}

}  // namespace swiftgs::test
