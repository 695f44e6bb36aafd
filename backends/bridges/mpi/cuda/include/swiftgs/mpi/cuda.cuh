// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Definitions behind `<swiftgs/mpi/cuda.hpp>` for code that nvcc compiles: ranks with bounds of your own.
/// Compile with `-fmad=false`, as `<swiftgs/cuda.cuh>` says.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include <swiftgs/cuda.cuh>
#include <swiftgs/cuda/running_sum.cuh>
#include <swiftgs/cuda/view_source.cuh>
#include <swiftgs/mpi/cuda.hpp>

namespace swiftgs {

namespace kernels {

inline constexpr unsigned share_threads = 256, share_warps = share_threads / warp_size;
/// Splats of a thread.
inline constexpr unsigned share_steps = 4, share_splats = share_threads * share_steps;

/// What a block shares out: the splats of one part for one rank.
struct ShareJob {
  SplatsView splats;  ///< as many as the capacity
  const Footprint* footprints;
  LastCounters<FrameCounts> counts;
  const std::uint32_t* cuts;  ///< of the strips @shape{ranks + 1}
  std::uint32_t parts;        ///< for each rank
  ShareArrays to;
  std::uint32_t capacity;  ///< splats beyond it are counted and left out
  std::uint32_t* begins;   ///< in host memory @shape{ranks + 1}
  std::uint32_t* written;  ///< how many there are, up to the capacity
};

/// Writes the splats for one rank behind those of the blocks before. Blocks go by ranks, then by parts, so
/// that one running sum over all tells where the splats for each rank begin.
template <class Bounds, class ViewSource>
__global__ void __launch_bounds__(share_threads)
    share_out(const __grid_constant__ ViewSource views, const __grid_constant__ ShareJob job,
              const Bounds bounds, const EpochsView<NoCounts> epochs) {
  __shared__ std::uint32_t of_warps[share_warps], shared_before;
  await_earlier();
  const std::uint32_t epoch = read_epoch(epochs);
  const std::uint32_t rank = blockIdx.x / job.parts, part = blockIdx.x % job.parts;
  const std::uint32_t first_row = job.cuts[rank], end_row = job.cuts[rank + 1];
  const std::size_t splats = min(std::size_t(job.counts.get().visible), job.splats.size());

  // Find which splats have tiles in the rank's strip. The splats of a warp follow each other.
  const unsigned warp = threadIdx.x / warp_size;
  const std::size_t first = std::size_t(part) * share_splats + warp * warp_size * share_steps + lane_index();
  unsigned lanes[share_steps];
  std::uint32_t mine = 0;
#pragma unroll
  for (unsigned step = 0; step < share_steps; ++step) {
    const std::size_t i = first + step * warp_size;
    TileRun rows;
    if (i < splats)
      rows = atlas_rows(bounds, job.splats.shapes[i], job.footprints[i],
                        views[ViewSource::only ? 0 : job.splats.view(i)].grid);
    const bool goes =
        rows.size() != 0 && std::uint32_t(rows.begin) < end_row && std::uint32_t(rows.end) > first_row;
    lanes[step] = __ballot_sync(whole_warp, goes);
    mine += std::uint32_t(__popc(lanes[step]));
  }
  if (lane_index() == 0) of_warps[warp] = mine;
  __syncthreads();
  std::uint32_t at = 0, all = 0;
  for (unsigned w = 0; w < share_warps; ++w) {
    if (w < warp) at += of_warps[w];
    all += of_warps[w];
  }

  // Find where they are written to.
  if (warp == 0) {
    const RunningSum sum(epochs.words, epoch);
    if (threadIdx.x == 0) sum.add(all);
    const std::uint32_t before = sum.before(all);
    if (threadIdx.x == 0) {
      shared_before = before;
      if (part == 0) job.begins[rank] = before;
      if (blockIdx.x + 1 == gridDim.x) {
        job.begins[rank + 1] = before + all;
        *job.written = min(before + all, job.capacity);
        end_epoch(epochs, epoch, gridDim.x);
      }
      if (part == 0 || blockIdx.x + 1 == gridDim.x) __threadfence_system();  // the host reads it soon
    }
  }
  __syncthreads();

  // Write them.
  at += shared_before;
#pragma unroll
  for (unsigned step = 0; step < share_steps; ++step) {
    const std::uint32_t to = at + std::uint32_t(__popc(lanes[step] & lanes_below()));
    if ((lanes[step] >> lane_index() & 1) != 0 && to < job.capacity)
      job.to.write(to, job.splats, first + step * warp_size);
    at += std::uint32_t(__popc(lanes[step]));
  }
}

template <BoundsPolicy Bounds>
void run_share_out(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, const StripCuts& cuts,
                   Splats<Cuda>& splats, Footprints<Cuda>& footprints, Shares<Cuda>& shares) {
  const PendingProjection pending = std::exchange(splats.pending, {});
  footprints.found_by = {};
  const std::size_t ranks = cuts.size() - 1;
  shares.begins.assign(ranks + 1, 0);
  shares.splats.set_count(0);
  shares.awaited = bool(pending);
  if (!pending) return;  // an empty scene
  if (cuts != shares.stored_cuts) {
    shares.stored_cuts.clear();
    shares.cuts.reset(cuts.size());
    copy_from_host(cuda, cuts.data(), shares.cuts.data(), cuts.size() * sizeof(std::uint32_t));
    shares.stored_cuts = cuts;
  }
  shares.written.reset(1), shares.posted.reset(ranks + 1);
  shares.splats.reset(shares.capacity, plan.views.size());
  SplatsView all = splats.view();
  all.shapes.size = splats.shapes.size();
  const unsigned parts = blocks_for(all.size(), share_splats);
  constexpr std::uint64_t most_blocks = std::numeric_limits<std::int32_t>::max();
  if (parts * ranks > most_blocks)
    throw CapacityError("blocks that share splats out among ranks", parts * ranks, most_blocks);
  const unsigned blocks = parts * unsigned(ranks);
  const EpochsView<NoCounts> epochs = shares.epochs.begin(cuda, blocks);
  const ShareJob job{all,
                     footprints.each.data(),
                     pending.counts,
                     shares.cuts.data(),
                     parts,
                     ShareArrays::of(shares.splats),
                     std::uint32_t(shares.capacity),
                     shares.posted.data(),
                     shares.written.data()};
  with_views(plan.views, [&]<class ViewSource>(const ViewSource& source) {
    launch_early(cuda, "share_out", share_out<Bounds, ViewSource>, blocks, share_threads, source, job, bounds,
                 epochs);
  });
  shares.epochs.end();
  cuda.settle(pending.counts, plan.limits, pending.totals);
  shares.splats.count = shares.capacity, shares.splats.exact = shares.written.data();
}

}  // namespace kernels

template <OwnBounds Bounds>
void share_out(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, const StripCuts& cuts,
               Splats<Cuda>& splats, Footprints<Cuda>& footprints, Shares<Cuda>& shares) {
  kernels::run_share_out(cuda, plan, bounds, cuts, splats, footprints, shares);
}

}  // namespace swiftgs
