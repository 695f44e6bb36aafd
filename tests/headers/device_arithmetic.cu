// SPDX-License-Identifier: Apache-2.0

// Every loop body that the stages share between backends, and the arithmetic of every rasterizer, as a
// kernel. Compiled, never run.
#include <swiftgs/contribution.hpp>
#include <swiftgs/swiftgs.hpp>

#if defined(GLM_FORCE_CUDA) || defined(CUDA_VERSION)
#error "expected the library neither to define a macro of GLM nor to include <cuda.h>"
#endif

namespace {

using namespace swiftgs;

template <class F>
__global__ void for_each(std::size_t n, F f) {
  const std::size_t i = blockIdx.x * std::size_t(blockDim.x) + threadIdx.x;
  if (i < n) f(i);
}

template <class F>
void launch(std::size_t n, const F& f) {
  for_each<<<unsigned((n + 127) / 128), 128>>>(n, f);
}

template <class Bounds>
void emit(std::size_t n, const FindFootprint<Bounds>& find,
          const EmitIntersections<Bounds, std::uint32_t>& by_tile,
          const EmitIntersections<Bounds, std::uint64_t>& by_tile_and_depth) {
  launch(n, find);
  launch(n, by_tile);
  launch(n, by_tile_and_depth);
}

template <class R>
struct EvaluateAlpha {
  SplatsView splats;
  BlendRules rules;
  float* alphas;
  SWIFTGS_HD void operator()(std::size_t i) const {
    typename R::Kernel kernel(splats.shapes[i], vec2(0.5f), rules);
    kernel.start_row(0.5f);
    alphas[i] = kernel.alpha(int(i) % raster_block_side);
  }
};

}  // namespace

void project(std::size_t n, const ProjectShapes& shapes, const CompactSplats& compact) {
  launch(n, shapes);
  launch(n, compact);
}

void contributions(std::size_t n, const ClearSums& clear) { launch(n, clear); }

void shade(std::size_t n, const ClearWord& clear, const ShadeSplats<OneScene>& of_one,
           const ShadeSplats<SeveralScenes>& of_several) {
  launch(1, clear);
  launch(n, of_one);
  launch(n, of_several);
}

void sort(std::size_t n, const CountTiles& count, const DepthPair& depths, const ClearRanges& clear,
          const FindRanges<std::uint32_t>& narrow, const FindRanges<std::uint64_t>& wide) {
  launch(n, count);
  launch(n, depths);
  launch(n, clear);
  launch(n, narrow);
  launch(n, wide);
  for_each_type(AllBounds(), [&]<class Bounds>(Bounds) { emit<Bounds>(n, {}, {}, {}); });
}

void rasterize(std::size_t n, const SplatsView& splats, const BlendRules& rules, float* alphas) {
  for_each_type(AllRasters(), [&]<class Raster>(Raster) {
    launch(n, EvaluateAlpha<Raster>{splats, rules, alphas});
  });
}
