// SPDX-License-Identifier: Apache-2.0
#include "policies/backends.hpp"

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "pages/pools.hpp"

namespace swiftgs::test::pages_on_backends {
namespace {

SWIFTGS_CONTRACT("pages: a complete cut of goal 0 has the bits of the scene") {
  const Scene scene = ordered_scene(6000);
  const auto whole = backend.upload(scene);
  PagePool<B> pool(backend, open(TestSource::of(scene)));
  const std::vector<View> views = front();
  const Camera camera = builtin_camera(width, height);
  Cut cut = pool.cut(all_of(views), {.pixels = 0});
  pool.wait(cut);
  CHECK(cut.missing() == 0);
  CHECK(cut.pixels() == 0);
  CHECK(cut.scenes().size() > 10);
  const auto check = [&](auto sort, auto bounds) {
    Usual<B, decltype(sort), AxisSharedThreshold<FloatCholesky>, decltype(bounds)> renderer(
        make_backend<B>());
    INFO(std::string(renderer.name));
    CHECK((renderer.render(cut.scenes(), camera).colour == renderer.render(whole, camera).colour));
  };
  for_each_type(AllSorts(), [&](auto sort) { check(sort, Ellipse()); });
  for_each_type(AllBounds(), [&](auto bounds) { check(EarlySort(), bounds); });
}

#if defined(SWIFTGS_TEST_CUDA)
/// Work of a stream that ends when the gate opens: with it, or by itself after five minutes.
class Gate {
 public:
  explicit Gate(const Stream& stream) : stream_(stream) {
    check_cuda(cudaLaunchHostFunc(
                   stream.get(), [](void* gate) { static_cast<Gate*>(gate)->stand(); }, this),
               "cudaLaunchHostFunc");
  }
  ~Gate() {
    open_ = true;
    cudaStreamSynchronize(stream_.get());
  }
  Gate(const Gate&) = delete;
  Gate& operator=(const Gate&) = delete;

  bool is_closed() const { return !open_; }

 private:
  void stand() {
    for (int k = 0; k < 300'000 && !open_; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    open_ = true;
  }

  const Stream& stream_;
  std::atomic<bool> open_ = false;
};

/// Memory in the order of a stream.
MemoryHook memory_of(cudaStream_t stream) {
  return {
      [](void* order, std::size_t bytes) {
        void* memory = nullptr;
        check_cuda(cudaMallocAsync(&memory, bytes, static_cast<cudaStream_t>(order)), "cudaMallocAsync");
        return memory;
      },
      [](void* order, void* memory, std::size_t) { cudaFreeAsync(memory, static_cast<cudaStream_t>(order)); },
      stream};
}

SWIFTGS_CASE_ON("pages: cuts bring and forget pages while the stream is held up", Cuda) {
  const PagedScene pages = open(TestSource::of(ordered_scene(20000)));
  const Stream drawing, uploading;
  Cuda backend_of_frames(drawing.get(), memory_of(drawing.get())),
      uploader(uploading.get(), memory_of(uploading.get()));
  PagePool<Cuda> pool(backend_of_frames, pages, {.bytes = 2'000'000, .waiting = 200'000}, &uploader);
  Gate gate(drawing);
  std::size_t forgotten = 0;
  const std::vector<Camera> cameras = builtin_cameras(40, width, height);
  constexpr int fewest = 200, most = 5000;  // frames; more where reading is slow
  for (int frame = 0; frame < fewest || (frame < most && (pool.uploads() <= 20 || forgotten == 0)); ++frame) {
    const std::vector<View> views{view_of(cameras[std::size_t(frame / 5) % cameras.size()])};
    const std::size_t resident = pool.resident();
    const std::uint64_t uploads = pool.uploads();
    const Cut cut = pool.cut(all_of(views), {.pixels = 0.5});  // waits here, if it does, until the gate opens
    check_no_hole(cut, pages, views);
    forgotten += resident + std::size_t(pool.uploads() - uploads) - pool.resident();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  CHECK(gate.is_closed());
  CHECK(pool.uploads() > 20);
  CHECK(forgotten > 0);
}
#endif

}  // namespace
}  // namespace swiftgs::test::pages_on_backends
