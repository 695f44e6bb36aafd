// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Ranks with a device each: `DistributedRenderer<Cuda, ...>`. Splats go from device to device
/// where a `DirectLink` joins them, and by way of the host otherwise.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <tuple>
#include <vector>

#include <swiftgs/cuda.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/memory/growing_buffer.hpp>
#include <swiftgs/mpi.hpp>
#include <swiftgs/mpi/shares.hpp>

namespace swiftgs {

/// Memory of the host that a device copies to and from by itself. Throws `DeviceError`.
struct SWIFTGS_API PinnedMemory {
  static void* allocate(std::size_t bytes);
  static void release(void* memory);
};

SWIFTGS_API void copy_from_host(Cuda& cuda, const void* from, void* to, std::size_t bytes);

/// The array itself, or a copy of it in pinned memory, which is not from the backend's hook.
template <class T>
class Staging<Cuda, T> {
 public:
  void reserve(Cuda&, Span<T> array, bool direct = false) {
    array_ = array, direct_ = direct;
    host_.reset(direct ? 0 : array.size);
  }
  T* seen() { return direct_ ? array_.data : host_.data(); }
  void to_host(Cuda& cuda, std::size_t begin, std::size_t end) {
    if (!direct_) cuda.download(Span<const T>{array_.data + begin, end - begin}, host_.data() + begin);
  }
  void from_host(Cuda& cuda, std::size_t begin, std::size_t end) {
    if (direct_) return;
    copy_from_host(cuda, host_.data() + begin, array_.data + begin, (end - begin) * sizeof(T));
  }

  static std::tuple<> buffers(auto&) { return {}; }

 private:
  Span<T> array_;
  bool direct_ = false;
  GrowingBuffer<T, PinnedMemory> host_;
};

/// The device writes them within `capacity`, and tells the host where those for each rank begin.
template <>
struct Shares<Cuda> {
  Splats<Cuda> splats;
  std::vector<std::uint64_t> begins;  ///< set by `await_shares`
  std::size_t capacity = 0;           ///< of splats; grows
  DeviceBuffer<std::uint32_t> cuts, written;
  StripCuts stored_cuts;  ///< that `cuts` holds
  Epochs<NoCounts> epochs;
  GrowingBuffer<std::uint32_t, PinnedMemory> posted;  ///< `begins` as the device tells them
  bool awaited = false;                               ///< whether a report is due

  std::uint64_t count_for(int rank) const {
    return begins[std::size_t(rank) + 1] - begins[std::size_t(rank)];
  }
  void forget_capacity() { capacity = 0; }
  static auto buffers(auto& self) { return std::tie(self.splats, self.cuts, self.written, self.epochs); }
};

/// One kernel. Does not wait, and leaves the tiles as projection has found them.
/// In the library for `AllBounds`; for others in `<swiftgs/mpi/cuda.cuh>`.
template <BoundsPolicy Bounds>
SWIFTGS_API void share_out(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, const StripCuts& cuts,
                           Splats<Cuda>& splats, Footprints<Cuda>& footprints, Shares<Cuda>& shares);

/// Waits for the device to have shared them out. Grows the capacity for the next `share_out` where this one
/// had too little. Throws `CapacityError`.
SWIFTGS_API FrameReport await_shares(Cuda& cuda, Shares<Cuda>& shares);

/// NCCL, in a build that has it, where `Ranks::direct` holds on all ranks and each has a device of its own,
/// or NCCL_MULTI_RANK_GPU_ENABLE lets them share one (NCCL 2.30).
SWIFTGS_API std::unique_ptr<DirectLink> direct_link(const Ranks& ranks, Cuda& cuda);

/// Makes a device of this machine the current one: the ranks of a machine share its devices. Call it before a
/// `Cuda` is made. Returns the device's number. Collective. Throws `DeviceError` where there is none.
SWIFTGS_API int take_device(const Ranks& ranks);

}  // namespace swiftgs
