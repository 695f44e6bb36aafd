// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <swiftgs/cuda/epochs.hpp>
#include <swiftgs/cuda/memory.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>

/// A stream as `<cuda_runtime_api.h>` declares it, so that this header needs no toolkit.
using cudaStream_t = struct CUstream_st*;

namespace swiftgs {

struct Scene;
struct SceneArrays;

/// Counts of a frame that projection adds up.
struct FrameCounts {
  std::uint64_t visible = 0;
  std::uint64_t intersections = 0;
};

/// Counts that later stages read, in device memory.
struct FrameTotals {
  FrameReport report;
  std::uint32_t splats = 0, intersections = 0;  ///< 0 where the frame overflowed
};

/// One NVIDIA GPU. Everything runs in the order of one stream, and frames have the same bits from run to run.
/// This header compiles without CUDA; policies of your own also need `<swiftgs/cuda.cuh>` and nvcc.
///
/// A backend belongs to the device that was current when it was made; that device must be current wherever it
/// is used. Its functions return when their work is in stream order, unless they say that they wait.
/// All functions may throw `DeviceError`, and `CapacityError` where the device's memory does not suffice.
///
/// A recorded frame (`AnyRenderer::record`) may be captured into a CUDA graph, as may `for_each`, `clear`,
/// `update`, and `sort_pairs` and `sort_positions` of no more pairs than before. What waits, takes the time
/// or copies from the host's memory throws `DeviceError` while the stream is being captured, before it calls
/// CUDA, and the capture stays valid. CUDA does not allow to free memory then, so do not destroy or grow a
/// buffer either. A graph holds addresses of the backend's memory: do not replay it once the backend is gone
/// or its memory has grown.
class SWIFTGS_API Cuda {
  struct State;

 public:
  static constexpr std::string_view name = "cuda";
  template <class T>
  using Buffer = DeviceBuffer<T>;
  using SceneOn = DeviceScene;
  static constexpr bool reaches_host_memory = false;

  /// A point in stream order. It can be read until 255 later points have been taken.
  struct TimePoint {
    std::uint64_t serial = 0;
  };

  /// Whether kernels of this build run on the device that is current when this is first asked.
  static bool usable();

  /// Name of the current device.
  std::string device_name() const;

  /// Works on the caller's `stream`, which outlives it; by default on the default stream of the device.
  ///
  /// `memory` may work in the order of that stream, as `cudaMallocFromPoolAsync` does: memory is used by work
  /// that is submitted to the stream, or to a fork of it, between the calls of `allocate` and of `release`,
  /// and forks are joined before `release`. So `release` may be called while work that uses the memory is
  /// still under way. It must not hand the memory out again before that work is done. A scene is released
  /// with its last copy: streams other than this one must have drawn it by then. Pinned host memory, about
  /// 128 KiB, is not from `memory`.
  explicit Cuda(cudaStream_t stream = nullptr, const MemoryHook& memory = hook_of<DeviceMemory>());
  ~Cuda();
  /// A moved-from backend may only be assigned or destroyed.
  Cuda(Cuda&&) noexcept;
  Cuda& operator=(Cuda&&) noexcept;

  const MemoryHook& memory_hook() const;

  /// Stream that orders all work except that of a fork not yet joined.
  cudaStream_t stream() const;

  /// Work beside that of the backend. Its stream begins behind all work submitted before the fork; whatever
  /// is submitted to the backend after `join` comes after the fork's. The destructor joins.
  class SWIFTGS_API Fork {
   public:
    Fork(Fork&& other) noexcept : state_(std::exchange(other.state_, nullptr)) {}
    Fork& operator=(Fork&&) = delete;
    ~Fork();

    cudaStream_t stream() const;
    /// Does nothing the second time. A fork and its join become part of a graph that captures the stream.
    void join();

   private:
    friend Cuda;
    explicit Fork(State* state) : state_(state) {}
    State* state_;  ///< null once joined
  };

  /// Starts a fork. A backend outlives it and has one at a time: throws `OrderError` where the one
  /// before is not joined.
  [[nodiscard]] Fork fork();

  /// Throws `DeviceError` for `call` while the stream is being captured into a CUDA graph.
  void check_not_captured(const char* call) const;

  /// Copies `scene` to the device in stream order, without trailing SH bands of zeros, and by default with
  /// harmonics in the fewest bytes that hold them exactly. Waits for the stream, so that other streams may
  /// read the scene. Throws `InvalidArgument` as `validate`, `validate_numbers` and `HarmonicPacking`.
  SceneOn upload(const Scene& scene, HarmonicsKept kept = HarmonicsKept::smallest) const;
  SceneOn upload(std::shared_ptr<const Scene> scene, HarmonicsKept kept = HarmonicsKept::smallest) const;

  /// Copies arrays within the device, in stream order; harmonics stay floats. Does not wait: other streams
  /// must, before they read the scene or overwrite the arrays. Does not check numbers. Throws
  /// `InvalidArgument` as `validate` does.
  SceneOn upload(const SceneArrays& arrays) const;
  /// As above, into the memory of `reuse`, a scene of this backend that is empty afterwards; if it was ever
  /// copied, it is released instead. `arrays` do not lie in it. Waits for the device if memory has to grow.
  /// If arguments are refused or the stream is being captured, `reuse` stays.
  SceneOn upload(const SceneArrays& arrays, std::optional<SceneOn>& reuse) const;

  /// Replaces Gaussians of `scene` from number `first` on by those of `arrays`, within the device and in
  /// stream order; arrays that are null stay as they are. Does not wait or allocate, so a CUDA graph may
  /// capture it. Arrays stay where they are: views and copies of the scene, and recorded work that runs
  /// again, show the update. Other streams must have drawn the scene before, and wait before they draw it
  /// again or overwrite the arrays, which do not lie in the scene. Does not check numbers. `sh_rest` has the
  /// bands that the device stores, `view().sh_degree`. Throws `InvalidArgument` as `validate_update`
  /// and `require_replaceable` do.
  void update(SceneOn& scene, std::size_t first, const SceneArrays& arrays) const;

  /// Copies after all work submitted before, and waits for the copy.
  template <class T>
  void download(Span<const T> from, T* to) const {
    download_bytes(from.data, to, from.size * sizeof(T));
  }

  /// Returns when the stream has done all work submitted before.
  void wait() const;

  /// Memory of the current device, whoever uses it.
  static MemoryUse memory_use();

  /// Number of the device's multiprocessors, which is asked once.
  int multiprocessors() const;
  /// Most shared memory that a thread block can ask for; likewise. @units{bytes}
  std::size_t shared_memory() const;

  /// f(i) for every i in [0, n), a thread each. `f` is copied to the device, and its call is `SWIFTGS_HD`.
  /// Defined in `<swiftgs/cuda.cuh>`.
  template <class F>
  void for_each(Count n, const F& f) const;

  /// Replaces each count by the sum before it and returns the sum of all, for which it waits.
  std::uint64_t exclusive_scan(Span<std::uint32_t> counts);

  /// Sorts the first `n` pairs by the low `bits` bits of their keys, ascending and stably, into `keys` and
  /// `values`, using the spare arrays. The host needs only an upper bound of `n`. Throws `CapacityError`
  /// beyond 2^32 - 1 pairs.
  void sort_pairs(Pairs<Cuda, std::uint16_t>& pairs, Count n, int bits);
  void sort_pairs(Pairs<Cuda, std::uint32_t>& pairs, Count n, int bits);
  void sort_pairs(Pairs<Cuda, std::uint64_t>& pairs, Count n, int bits);

  /// As `sort_pairs` of the first `n` keys with their positions, by one bit at least. `keys` are not of
  /// `pairs`, and stay as they are.
  void sort_positions(const std::uint32_t* keys, Count n, int bits, Pairs<Cuda, std::uint32_t>& pairs);

  /// Waits, and gives back the memory that scans, sorts and rasterizers keep.
  void trim();

  /// A point after all work submitted so far, forked work excluded.
  TimePoint now();
  /// From one point to a later one; nothing where `to` has not been reached or `from` is too old. Does not
  /// wait. @units{milliseconds}
  std::optional<double> milliseconds(TimePoint from, TimePoint to) const;

  /// Fills `bytes` bytes of device memory with zero.
  void clear(void* memory, std::size_t bytes) const;

  /// The device decides whether a frame of so many splats and intersections fits `limits`, keeps the numbers
  /// in `totals` and reports them. Does not wait.
  void settle(LastCounters<FrameCounts> counts, const Limits& limits, FrameTotals* totals) const;

  /// The report of the last `settle` whose limits name no memory for it: the one place where a renderer waits
  /// for its device.
  FrameReport await_report() const;

 private:
  friend struct RasterMemory;
  void download_bytes(const void* from, void* to, std::size_t bytes) const;

  std::unique_ptr<State> state_;
};

inline void check_ready(const Cuda& cuda) { cuda.check_not_captured("a frame"); }

inline Cuda make_backend(std::type_identity<Cuda>, const BackendOptions& options) {
  return options.memory ? Cuda(options.stream, *options.memory) : Cuda(options.stream);
}

static_assert(FunctorBackend<Cuda>);

}  // namespace swiftgs
