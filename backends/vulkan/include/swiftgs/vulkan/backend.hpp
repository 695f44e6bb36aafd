// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <swiftgs/frame.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/memory/growing_buffer.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/vulkan/device.hpp>

namespace swiftgs {

/// Memory of a Vulkan device that grows: `data()` is its device address.
template <class T>
using VulkanBuffer = GrowingBuffer<T, VulkanMemory>;

/// A scene in the memory of a Vulkan device. Copies share it.
class VulkanScene {
 public:
  struct Arrays;
  VulkanScene(std::shared_ptr<Arrays> arrays, const SceneView& view)
      : arrays_(std::move(arrays)), view_(view) {}

  /// Arrays of the caller by their device addresses. They outlive all frames, and may change between them.
  static VulkanScene borrow(const SceneView& view) { return {nullptr, view}; }

  SceneView view() const { return view_; }

 private:
  friend class Vulkan;

  std::shared_ptr<Arrays> arrays_;
  SceneView view_;
};

/// What a program's command buffer reads beside memory of the renderer, from `Vulkan::record`. Keep it until
/// the commands are done or dropped: memory of the device that is released meanwhile is freed behind it.
class SWIFTGS_API VulkanRecording {
 public:
  struct Kept;

  explicit VulkanRecording(std::unique_ptr<Kept> kept);
  ~VulkanRecording();
  VulkanRecording(VulkanRecording&&) noexcept;
  VulkanRecording& operator=(VulkanRecording&&) noexcept;

 private:
  std::unique_ptr<Kept> kept_;
};

/// A GPU by Vulkan's compute shaders. Its stages run no functors of C++, and pointers that they take are
/// device addresses. Frames have the same bits from run to run.
///
/// Functions return when their work is submitted to the device's queue, unless they say that they wait. They
/// may throw `DeviceError`, and `CapacityError` where the device's memory does not suffice.
class SWIFTGS_API Vulkan {
 public:
  struct State;

  static constexpr std::string_view name = "vulkan";
  template <class T>
  using Buffer = VulkanBuffer<T>;
  using SceneOn = VulkanScene;
  static constexpr bool reaches_host_memory = false;

  /// A point in stream order. It can be read until 255 later points have been taken.
  struct TimePoint {
    std::uint64_t serial = 0;
  };

  /// Whether `VulkanDevice::own()` can be had. Asks once.
  static bool usable();
  std::string device_name() const;

  /// Works on `device`, with memory of `memory` where that is given: device addresses, aligned to 256 bytes,
  /// of buffers with the usage VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT. It must not hand memory out again
  /// before the queue has done what was submitted before its release.
  explicit Vulkan(const VulkanDevice& device = VulkanDevice::own(),
                  const std::optional<MemoryHook>& memory = {});
  ~Vulkan();
  /// A moved-from backend may only be assigned or destroyed.
  Vulkan(Vulkan&&) noexcept;
  Vulkan& operator=(Vulkan&&) noexcept;

  const MemoryHook& memory_hook() const;

  /// Copies `scene` to the device, by default with harmonics in the fewest bytes that hold them exactly.
  /// Waits. Throws `InvalidArgument` as `validate`, `validate_numbers` and `HarmonicPacking`.
  SceneOn upload(const Scene& scene, HarmonicsKept kept = HarmonicsKept::smallest) const;
  SceneOn upload(std::shared_ptr<const Scene> scene, HarmonicsKept kept = HarmonicsKept::smallest) const;

  /// Copies arrays that lie in memory of the device, in the memory of `reuse` if nobody else has that scene.
  /// Does not wait. Throws `InvalidArgument` as `validate`.
  SceneOn upload(const SceneArrays& arrays, std::optional<VulkanScene>& reuse) const;
  /// Replaces Gaussians from number `first` on by those of `arrays`, which are in memory of the device; null
  /// arrays keep the scene's values. Copies of `scene` change too. Does not wait. Throws `InvalidArgument`,
  /// and changes nothing, as `validate_update` and `require_replaceable`, and for a borrowed scene.
  void update(VulkanScene& scene, std::size_t first, const SceneArrays& arrays) const;

  /// Copies from the host or to it after all work submitted before, and waits. Addresses on the device are
  /// multiples of 4.
  void write(const void* from, void* to, std::size_t bytes) const;
  void read(const void* from, void* to, std::size_t bytes) const;
  template <class T>
  void download(Span<const T> from, T* to) const {
    read(from.data, to, from.size * sizeof(T));
  }

  /// Returns when all work submitted before is done.
  void wait() const;

  /// Sorts the first `n` pairs by the low `bits` bits of their keys, ascending and stably, into `keys` and
  /// `values`, using the spare arrays. The next function that submits or waits submits the sort too.
  void sort_pairs(Pairs<Vulkan, std::uint32_t>& pairs, Count n, int bits);
  void sort_pairs(Pairs<Vulkan, std::uint64_t>& pairs, Count n, int bits);

  /// Calls `draw`, which records a reserved frame of a renderer on this backend, and puts the frame into
  /// `commands` instead of submitting it: commands that the program has begun, outside of a render pass, for
  /// the device's queue. It neither submits nor waits. The frame sees what all commands before it wrote, and
  /// all commands behind it see the frame; `record` changes the compute pipeline, push constants and
  /// descriptor sets 0 and 1. The renderer stays as it is until the commands are done. The recording keeps
  /// views and placed scenes as they were: `set_views` and `set_scenes` change later recordings alone. If
  /// `draw` throws, drop the commands.
  VulkanRecording record(VkCommandBuffer_T* commands, const std::function<void()>& draw);

  /// Copies the colours of `frame` to an image of the program, or from it, so that a frame is drawn over it.
  /// `image` is a view of one level of an image of two dimensions, as large as the frame or larger, in the
  /// layout VK_IMAGE_LAYOUT_GENERAL, with the usage STORAGE for `store` and SAMPLED for `load`. `store`
  /// throws `Unavailable` where the device was made without shaderStorageImageWriteWithoutFormat.
  /// All three throw `InvalidArgument` for null and as `validate` of a frame.
  void store(const FrameView& frame, VkImageView_T* image);
  void load(VkImageView_T* image, const FrameView& frame);
  /// Copies the depths of an image, which is one as of `load`, for an occluder. @shape{height, width}
  void load_depth(VkImageView_T* image, float* to, int width, int height);

  /// The device's timeline semaphore, and its value when all work begun so far is done, which this submits.
  struct Signal {
    VkSemaphore_T* semaphore = nullptr;
    std::uint64_t value = 0;
  };
  Signal last_signal() const;

  /// Gives back the memory that sorts, long lists and constants of commands keep. Waits.
  void trim();

  TimePoint now();
  /// @units{milliseconds}
  std::optional<double> milliseconds(TimePoint from, TimePoint to) const;

  /// A kernel that ran, and how long. @units{milliseconds}
  struct KernelTime {
    std::string_view name;
    double milliseconds = 0;
  };
  /// Calls `draw`, and runs its kernels one after the other. Returns their times in this order: of the first
  /// 1,000 kernels, or none on a device without timestamps. Waits.
  std::vector<KernelTime> profile(const std::function<void()>& draw);

  State& state() const { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

inline Vulkan make_backend(std::type_identity<Vulkan>, const BackendOptions& options) {
  return Vulkan(VulkanDevice::own(), options.memory);
}

static_assert(BackendPolicy<Vulkan> && !FunctorBackend<Vulkan>);

}  // namespace swiftgs
