// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <cuda_fp16.h>
#include <cuda_pipeline_primitives.h>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/cuda/view_source.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/project/colour.hpp>
#include <swiftgs/project/project.hpp>

#include "sh_words.hpp"

namespace swiftgs {

namespace kernels {
inline constexpr unsigned shade_threads = 128, shade_warps = shade_threads / warp_size;

/// Blocks for each multiprocessor: enough to keep a device's memory busy, and few enough to leave resources
/// to what runs beside them.
/// Measured on an H100: frames of `builtin:4000000` take 1.47 ms with one, 1.43 with two and 1.415 with
/// three. On an H200 when chosen: the sort of garden takes 143 us with four and 155 with eight.
inline constexpr int shade_blocks = 3;

/// Starts copying the SH coefficients of the warp's Gaussians, `Word` by `Word`: lanes read neighbouring
/// words, where a lane a Gaussian would touch 32 lines with each load. All copies are under way at once. The
/// first word begins `lead` floats before the coefficients.
template <class Word>
__device__ void stage_rest(const HarmonicRows& rows, std::uint32_t row, unsigned gaussians, unsigned words,
                           unsigned lead, unsigned pitch, Word* rest) {
  constexpr unsigned floats = sizeof(Word) / sizeof(float);
  unsigned gaussian = lane_index() / words, word = lane_index() % words;
  const unsigned gaussian_step = warp_size / words, word_step = warp_size % words;
  while (__any_sync(whole_warp, gaussian < gaussians)) {
    const std::uint32_t theirs = __shfl_sync(whole_warp, row, int(gaussian % warp_size));
    const float* from = reinterpret_cast<const float*>(rows.row(theirs)) + int(word * floats - lead);
    if (gaussian < gaussians) __pipeline_memcpy_async(rest + gaussian * pitch + word, from, sizeof(Word));
    gaussian += gaussian_step, word += word_step;
    if (word >= words) word -= words, ++gaussian;
  }
  __pipeline_commit();
}

/// Waits for the copies of the warp.
__device__ inline void await_rest() {
  __pipeline_wait_prior(0);
  __syncwarp();
}

/// How the coefficients of a warp's Gaussians are copied: by quadruples where all begin as many floats behind
/// a multiple of 16 bytes, 0 as `Cuda::upload` stores them or 3 where band 0 lies with the others. Others are
/// copied one by one, and so are those of the last Gaussian, behind which nothing may be read. Packed rows
/// end with a quadruple.
struct RestLead {
  unsigned words = 0;   ///< quadruples of a Gaussian; 0: one by one
  unsigned floats = 0;  ///< before the coefficients

  __device__ RestLead(const SceneView& scene, std::uint32_t id) {
    const auto begin = unsigned(reinterpret_cast<std::uintptr_t>(scene.sh_rest.data) % sizeof(float4));
    const bool last = __any_sync(whole_warp, id + 1 == scene.size());  // by all lanes, of any scenes
    if (scene.sh_rest.is_packed()) {
      words = packed_words(scene.sh_rest.format, scene.sh_degree);
      return;
    }
    if (last || scene.sh_rest.stride % sizeof(float4) != 0 || (begin != 0 && begin != sizeof(vec3))) return;
    floats = begin / unsigned(sizeof(float));
    words = rest_words(scene.sh_degree, floats);
  }
};

/// Starts copying the SH coefficients of the warp's Gaussians.
__device__ inline void stage_rest(const SceneView& scene, const RestLead& lead, std::uint32_t id,
                                  unsigned gaussians, float4* rest) {
  const unsigned count = 3 * unsigned(sh_rest_count(scene.sh_degree)), pitch = rest_pitch(scene.sh_degree);
  const HarmonicRows& rows = scene.sh_rest;
  const std::uint32_t row = rows.row_of(id);
  if (lead.words != 0)
    stage_rest<float4>(rows, row, gaussians, lead.words, lead.floats, pitch, rest);
  else
    stage_rest<float>(rows, row, gaussians, count, 0, 4 * pitch, reinterpret_cast<float*>(rest));
}

/// What quadruples hold: `lead` floats, and coefficients behind them.
template <unsigned lead_floats>
struct FloatWords {
  static constexpr unsigned values = 4, lead = lead_floats;
  __device__ void unpack(float4 word, float* to) const {
    to[0] = word.x, to[1] = word.y, to[2] = word.z, to[3] = word.w;
  }
};
struct HalfWords {
  static constexpr unsigned values = 8, lead = 0;
  __device__ void unpack(float4 word, float* to) const {
    const float quarters[] = {word.x, word.y, word.z, word.w};
#pragma unroll
    for (unsigned k = 0; k < 4; ++k) {
      const unsigned bits = __float_as_uint(quarters[k]);
      const float2 two = __half22float2(
          __halves2half2(__ushort_as_half(std::uint16_t(bits)), __ushort_as_half(std::uint16_t(bits >> 16))));
      to[2 * k] = two.x, to[2 * k + 1] = two.y;
    }
  }
};
struct ByteWords {
  static constexpr unsigned values = 16, lead = 0;
  float scale;
  /// A byte, its sign turned, becomes the last of 2^23 + 128 + value; all of this is exact.
  __device__ void unpack(float4 word, float* to) const {
    const float quarters[] = {word.x, word.y, word.z, word.w};
#pragma unroll
    for (unsigned k = 0; k < 4; ++k) {
      const unsigned turned = __float_as_uint(quarters[k]) ^ 0x80808080u;
#pragma unroll
      for (unsigned i = 0; i < 4; ++i) {
        const float shifted = __uint_as_float(__byte_perm(turned, 0x4b000000u, 0x7440u | i));
        to[4 * k + i] = fmaf(shifted, scale, -8388736.0f * scale);
      }
    }
  }
};

/// `sh_colour` with a degree and words that the compiler knows, so that coefficients and basis stay in
/// registers.
template <int degree, class Words>
__device__ vec3 colour_of(const Words& packed, vec3 sh0, const float4* words, vec3 direction) {
  constexpr unsigned count = (Words::lead + 3 * sh_rest_count(degree) + Words::values - 1) / Words::values;
  float rest[Words::values * count];
#pragma unroll
  for (unsigned k = 0; k < count; ++k) packed.unpack(words[k], rest + Words::values * k);
  return sh_colour(degree, sh0, rest + Words::lead, direction);
}
template <class Words>
__device__ vec3 colour_of(int degree, const Words& packed, vec3 sh0, const float4* words, vec3 direction) {
  switch (degree) {
    case 0:
      return sh_colour(0, sh0, static_cast<const float*>(nullptr), direction);
    case 1:
      return colour_of<1>(packed, sh0, words, direction);
    case 2:
      return colour_of<2>(packed, sh0, words, direction);
    default:
      return colour_of<3>(packed, sh0, words, direction);
  }
}
/// Of rows as they were staged.
__device__ inline vec3 colour_of(const SceneView& scene, const RestLead& lead, vec3 sh0, const float4* words,
                                 vec3 direction) {
  switch (scene.sh_rest.format) {
    case HarmonicFormat::halves:
      return colour_of(scene.sh_degree, HalfWords(), sh0, words, direction);
    case HarmonicFormat::bytes:
      return colour_of(scene.sh_degree, ByteWords{scene.sh_rest.scale}, sh0, words, direction);
    default:
      return lead.floats != 0 ? colour_of(scene.sh_degree, FloatWords<3>(), sh0, words, direction)
                              : colour_of(scene.sh_degree, FloatWords<0>(), sh0, words, direction);
  }
}

/// Whether all lanes see the same scene.
__device__ inline bool of_one_scene(const SceneView* scene) {
  const auto address = reinterpret_cast<unsigned long long>(scene);
  return __all_sync(whole_warp, address == __shfl_sync(whole_warp, address, 0));
}

/// Evaluates the colours of all splats, a warp 32 at a time and a lane one of them. Where the device has not
/// counted them there are as many as there may be.
template <class ViewSource, class Scenes>
__global__ void __launch_bounds__(shade_threads)
    shade(const __grid_constant__ ViewSource views, const __grid_constant__ Scenes scenes,
          const LastCounters<FrameCounts> counts, const __grid_constant__ SplatsView all,
          SplatColour* colours, std::uint32_t* colourless) {
  __shared__ float4 shared[shade_warps][warp_size * rest_pitch(max_sh_degree)];
  float4* const rest = shared[threadIdx.x / warp_size];
  const std::size_t splats =
      counts.copies ? min(std::size_t(counts.get().visible), all.size()) : all.count().get();
  const std::size_t step = std::size_t(gridDim.x) * shade_threads;
  std::size_t first = blockIdx.x * shade_threads + threadIdx.x - lane_index();
  if (first >= splats) return;
  // Lanes beyond the splats see the last one. Their colours are dropped.
  const auto gaussian_at = [&](std::size_t at) { return all.gaussians[min(at, splats - 1)]; };
  std::uint32_t next_id = gaussian_at(first + lane_index());
  for (; first < splats; first += step) {
    const std::uint32_t id = next_id;  // loaded one step ahead, so that copies start at once
    if (first + step < splats) next_id = gaussian_at(first + step + lane_index());
    const std::size_t at = min(first + lane_index(), splats - 1);
    const auto seen = scenes.see(views[ViewSource::only ? 0 : all.view(at)].camera, id);
    const SceneView& scene = seen.scene;
    const std::uint32_t i = std::uint32_t(seen.i);
    // Splats follow the order of the placed scenes, so nearly all warps have those of one. In others each
    // lane copies its own coefficients as floats: all colours are summed by the same instructions.
    const bool of_one = Scenes::only || of_one_scene(&scene);
    const RestLead lead(scene, i);
    const unsigned pitch = rest_pitch(of_one ? scene.sh_degree : max_sh_degree);
    float4* const own = rest + lane_index() * pitch;
    if (of_one && scene.sh_degree > 0)
      stage_rest(scene, lead, i, unsigned(min(splats - first, std::size_t(warp_size))), rest);
    else if (!of_one)
      scene.sh_rest.load(i, scene.sh_degree, reinterpret_cast<float*>(own));
    // Load what else a colour takes while harmonics are copied. With ids loaded where they are used and this
    // after the copies, frames of `builtin:4000000` take 1.44 ms, not 1.415 (H100).
    const vec3 sh0 = sh0_of(scene, i), direction = view_direction(seen.camera, scene.means[i]);
    const float depth = drawn_depth(seen.camera, scene, i, all.depths[at]);
    await_rest();
    const vec3 rgb = of_one ? colour_of(scene, lead, sh0, own, direction)
                            : colour_of(scene.sh_degree, FloatWords<0>(), sh0, own, direction);
    SplatColour colour = splat_colour(rgb, depth);
    if (is_colourless(colour)) colour = large_splat_colour(seen.camera, scene, i, depth);
    if (first + lane_index() < splats) {
      colours[at] = tinted(colour, seen.tint);
      if (is_colourless(colour)) *colourless = 1;
    }
    __syncwarp();  // before the coefficients are overwritten
  }
}
}  // namespace kernels

Shading<Cuda> shade(Cuda& cuda, const FramePlan& plan, const Splats<Cuda>& splats, Colours<Cuda>& colours) {
  const std::size_t most = splats.pending ? splats.shapes.size() : splats.count;
  SplatsView all = splats.view();
  all.shapes.size = most;
  colours.each.reset(most), colours.colourless.reset(1);
  std::uint32_t* colourless = splats.pending.colourless;
  if (!colourless) {
    colourless = colours.colourless.data();
    cuda.clear(colourless, sizeof *colourless);
  }
  const unsigned blocks = std::min(blocks_for(most, kernels::shade_threads),
                                   unsigned(cuda.multiprocessors() * kernels::shade_blocks));
  Cuda::Fork fork = cuda.fork();
  if (blocks != 0)
    kernels::with_views_and_scenes(
        plan.views, plan.scenes,
        [&]<class ViewSource, class Scenes>(const ViewSource& views, const Scenes& scenes) {
          launch("shade", kernels::shade<ViewSource, Scenes>, blocks, kernels::shade_threads, fork.stream(),
                 views, scenes, splats.pending.counts, all, colours.each.data(), colourless);
        });
  return Shading<Cuda>(std::move(fork), splats, colours.each.data(), colourless);
}

}  // namespace swiftgs
