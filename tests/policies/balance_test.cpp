// SPDX-License-Identifier: Apache-2.0

// The balanced time of a raster stage: how long its raster blocks took, divided by the threads that run at
// once.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Balanced time over raster time, largest of some frames: a thread that is kept from running between two
/// raster blocks makes it less.
template <class Raster, class B>
double evenness(B& backend, const SplatSet& splats, int width, int height) {
  const TileLists<B> lists = build_lists<EarlySort, Ellipse>(backend, splats.job(width, height));
  Frame frame;
  const View view = view_into(prepare(frame, width, height, {}));
  std::vector<RasterCounts> counts(RasterBlocks(tiles_of_frame(view)).size());
  double largest = 0;
  for (int i = 0; i < 5; ++i) {
    const auto begin = backend.now();
    rasterize(backend, Raster{},
              RasterJob{splats.view(), splats.colours_view(), lists.view(), {&view, 1}, counts.data()});
    const double raster = backend.milliseconds(begin, backend.now()).value();
    Statistics statistics;
    for (const RasterCounts& block : counts) statistics.raster += block;
    CHECK(statistics.balanced_ms() <= raster);
    largest = std::max(largest, statistics.balanced_ms() / raster);
  }
  return largest;
}

}  // namespace

TEST_CASE_TEMPLATE("balance: one thread at least is at work throughout and all of them at most", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = faint_splats(2000, 160, 96);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    CHECK(evenness<Raster>(backend, splats, 160, 96) > 0.8 / threads_at_once(backend));
  });
}

TEST_CASE_TEMPLATE("balance: one raster block has one thread at work", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = faint_splats(2000, 16, 16);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const double of_threads = evenness<Raster>(backend, splats, 16, 16) * threads_at_once(backend);
    CHECK(of_threads > 0.8);
    CHECK(of_threads <= 1);
  });
}

TEST_CASE("balance: threads that oneTBB does not let run are not waited for") {
  Cpu backend(4);
  CHECK(backend.threads_at_once() == 4);
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  CHECK(backend.threads_at_once() == 2);
}
