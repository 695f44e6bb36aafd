// SPDX-License-Identifier: Apache-2.0

// Frames in memory that Vulkan exports, in the order of its semaphores, beside frames of the host.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <cuda_runtime_api.h>
#include <doctest/doctest.h>
#include <fcntl.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/cuda_vulkan.hpp>

#include "cuda_vulkan/gpu.hpp"
#include "support/skip.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// CUDA's number of a Vulkan device; -1 where it has none.
int number_of(const vk::raii::PhysicalDevice& physical) {
  try {
    return cuda_vulkan::Device(uuid_of(physical)).number();
  } catch (const DeviceError&) {
    return -1;
  }
}

/// The device of Vulkan that is CUDA's first; null, and the test is skipped, where there is none.
struct Shared {
  Shared() {
    const bool usable = Cuda::usable();
    for (const vk::raii::PhysicalDevice& physical : instance.devices())
      if (usable && !gpu && number_of(physical) == 0) gpu.emplace(physical);
    if (!gpu)
      skip(usable ? "no Vulkan that draws on CUDA's first device"
                  : "no CUDA device that the kernels of this build run on");
  }

  Instance instance;
  std::optional<Gpu> gpu;
};

/// A semaphore with a value that Vulkan and CUDA raise.
class Timeline {
 public:
  explicit Timeline(const Gpu& gpu) : device_(&gpu.device) {
    const vk::SemaphoreTypeCreateInfo timeline(vk::SemaphoreType::eTimeline, 0);
    const vk::ExportSemaphoreCreateInfo exporting(semaphore_fd, &timeline);
    semaphore_ = {gpu.device, vk::SemaphoreCreateInfo({}, &exporting)};
  }

  int export_fd() const { return device_->getSemaphoreFdKHR({*semaphore_, semaphore_fd}); }
  void signal(std::uint64_t value) const { device_->signalSemaphore({*semaphore_, value}); }
  /// Has the queue wait for one value, run `commands` and set another.
  void submit(const vk::raii::Queue& queue, const vk::raii::CommandBuffer& commands, std::uint64_t from,
              std::uint64_t to) const {
    const vk::PipelineStageFlags all = vk::PipelineStageFlagBits::eAllCommands;
    const vk::TimelineSemaphoreSubmitInfo values(from, to);
    queue.submit(vk::SubmitInfo(*semaphore_, all, *commands, *semaphore_, &values));
  }

 private:
  const vk::raii::Device* device_;
  vk::raii::Semaphore semaphore_{nullptr};
};

cuda_vulkan::ExportedMemory exported(const Gpu& gpu, const vk::raii::DeviceMemory& memory,
                                     const auto& resource, bool dedicated = true) {
  return {gpu.device.getMemoryFdKHR({*memory, opaque_fd}), resource.getMemoryRequirements().size, dedicated};
}

/// Boxes of Vulkan with splats of CUDA. Of frame k the box is drawn at 3 k + 1 of the timeline, the splats at
/// 3 k + 2, and the host may read it at 3 k + 3.
class Together {
 public:
  explicit Together(const Gpu& gpu)
      : gpu_(&gpu),
        canvas_(gpu),
        timeline_(gpu),
        device_(uuid_of(gpu.physical)),
        planes_(device_, exported(gpu, canvas_.memory, canvas_.planes)),
        reached_(device_, timeline_.export_fd()),
        scene_(renderer_.backend().upload(make_builtin_scene())),
        before_(gpu.make_commands()),
        after_(gpu.make_commands()),
        box(gpu, colour_bytes + depth_bytes),
        drawn(gpu, colour_bytes) {
    const View view = view_of(Seen(0, ClipSpace::vulkan));
    renderer_.reserve(scene_.view(), {&view, 1}, {scene_.view().size(), 4'000'000});
    report_.reset(1);
  }

  /// Gives CUDA its part of a frame first, and Vulkan only then what CUDA waits for.
  void draw(int frame, const Seen& seen) {
    const std::uint64_t k = std::uint64_t(frame);
    const cudaStream_t stream = renderer_.backend().stream();
    const View view = view_of(seen);
    renderer_.set_views({&view, 1});
    renderer_.record(scene_.view(), report_.data(), [&] { reached_.wait(3 * k + 1, stream); });
    reached_.signal(3 * k + 2, stream);

    const auto copy = [&](const vk::raii::CommandBuffer& commands, const HostCopy& to) {
      commands.copyBuffer(*canvas_.planes, *to.buffer, vk::BufferCopy(0, 0, to.bytes));
      order(commands, {});
    };
    wait();  // the commands are free again
    before_.begin({});
    canvas_.draw_box(before_, seen.matrix);
    copy(before_, box);
    order(before_, {}, gpu_->pass(*canvas_.planes, true));
    before_.end();
    after_.begin({});
    order(after_, {}, gpu_->pass(*canvas_.planes, false));
    copy(after_, drawn);
    after_.end();
    timeline_.submit(gpu_->queue, before_, 3 * k, 3 * k + 1);
    timeline_.submit(gpu_->queue, after_, 3 * k + 2, 3 * k + 3);
  }
  /// Until all frames are drawn. Validation layers do not see who waits for a semaphore that was exported.
  void wait() const { gpu_->queue.waitIdle(); }

  bool fitted() const {
    FrameReport report;
    renderer_.backend().download(std::as_const(report_).span(), &report);
    return report.overflowed == 0 && report.visible != 0;
  }

 private:
  View view_of(const Seen& seen) const {
    auto* const first = static_cast<unsigned char*>(planes_.data());
    FrameView frame =
        seen.host.frame(first, reinterpret_cast<const float*>(first + colour_bytes), PixelFormat::bgra_8);
    frame.over = true;
    return make_view(seen.host.camera, Conventions(), frame);
  }

  const Gpu* gpu_;
  Canvas canvas_;
  Timeline timeline_;
  cuda_vulkan::Device device_;
  cuda_vulkan::Buffer planes_;
  cuda_vulkan::Semaphore reached_;
  Renderer<Cuda> renderer_;
  Cuda::SceneOn scene_;
  DeviceBuffer<FrameReport> report_;
  vk::raii::CommandBuffer before_, after_;

 public:
  HostCopy box, drawn;  ///< after `wait`
};

std::vector<float> floats_of(const Bytes& bytes) {
  std::vector<float> out(bytes.size() / sizeof(float));
  std::memcpy(out.data(), bytes.data(), bytes.size());
  return out;
}

}  // namespace

TEST_CASE("cuda_vulkan: a UUID that no device of CUDA has is refused with those that there are") {
  std::array<std::uint8_t, 16> uuid;
  uuid.fill(0x7a);
  const char* const expected =
      Cuda::usable()
          ? "cuda_vulkan::Device: no device of CUDA has the UUID 7a7a7a7a7a7a7a7a7a7a7a7a7a7a7a7a, expected "
          : "cuda_vulkan::Device: cudaGetDeviceCount: ";
  CHECK_THROWS_WITH_AS(cuda_vulkan::Device{uuid}, doctest::Contains(expected), DeviceError);
}

TEST_CASE(
    "cuda_vulkan: splats are drawn before and behind a box that Vulkan submits later on the same thread") {
  const Shared shared;
  if (!shared.gpu) return;
  Together together(*shared.gpu);
  HostFrames on_host;
  for (int k = 0; k < 6; ++k) {
    CAPTURE(k);
    const Seen seen(k, ClipSpace::vulkan);
    together.draw(k, seen);
    together.wait();
    CHECK(together.fitted());
    on_host.check(together.drawn.content(0, colour_bytes), seen.host, PixelFormat::bgra_8,
                  together.box.content(0, colour_bytes),
                  floats_of(together.box.content(colour_bytes, depth_bytes)));
  }
}

TEST_CASE("cuda_vulkan: a frame is sorted before its occluder is there") {
  const Shared shared;
  if (!shared.gpu) return;
  const Timeline timeline(*shared.gpu);
  const cuda_vulkan::Device device(uuid_of(shared.gpu->physical));
  const cuda_vulkan::Semaphore reached(device, timeline.export_fd());
  Renderer<Cuda> renderer;
  const cudaStream_t stream = renderer.backend().stream();
  const auto scene = renderer.backend().upload(make_builtin_scene());
  DeviceBuffer<unsigned char> image;
  image.reset(colour_bytes);
  const Seen seen(3, ClipSpace::vulkan);
  const View view =
      make_view(seen.host.camera, Conventions(), seen.host.frame(image.data(), nullptr, PixelFormat::rgba_8));
  renderer.reserve(scene.view(), {&view, 1});
  FrameReport* pinned = nullptr;
  check_cuda(cudaMallocHost(reinterpret_cast<void**>(&pinned), sizeof(FrameReport)), "cudaMallocHost");
  const std::unique_ptr<FrameReport, decltype([](FrameReport* p) { cudaFreeHost(p); })> report(pinned);
  *report = {};

  renderer.record(scene.view(), report.get(), [&] { reached.wait(1, stream); });
  const volatile std::uint64_t& visible = report->visible;
  for (int tries = 0; visible == 0 && tries < 1000; ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  CHECK(visible != 0);
  CHECK(cudaStreamQuery(stream) == cudaErrorNotReady);
  timeline.signal(1);
  CHECK(cudaStreamSynchronize(stream) == cudaSuccess);
  CHECK(report->overflowed == 0);
}

TEST_CASE("cuda_vulkan: an optimal image has the bytes of the frame that was written to it in each format") {
  const Shared shared;
  if (!shared.gpu) return;
  const Gpu& gpu = *shared.gpu;
  const cuda_vulkan::Device device(uuid_of(gpu.physical));
  Renderer<Cuda> renderer;
  const cudaStream_t stream = renderer.backend().stream();
  const auto scene = renderer.backend().upload(make_builtin_scene());
  const std::pair<PixelFormat, vk::Format> formats[] = {
      {PixelFormat::rgba_8, vk::Format::eR8G8B8A8Unorm},
      {PixelFormat::bgra_8, vk::Format::eB8G8R8A8Unorm},
      {PixelFormat::rgba_half, vk::Format::eR16G16B16A16Sfloat},
      {PixelFormat::rgba_float, vk::Format::eR32G32B32A32Sfloat}};
  for (const auto& both : formats)
    for (const bool attachment : {false, true}) {
      const auto format = both.first;
      const auto of_vulkan = both.second;
      CAPTURE(vk::to_string(of_vulkan));
      CAPTURE(attachment);
      const Camera camera = builtin_camera(333, 217);
      const std::size_t bytes = bytes_per_pixel(format) * 333 * 217;
      auto use = vk::ImageUsageFlagBits::eSampled | vk::ImageUsageFlagBits::eTransferSrc;
      if (attachment) use |= vk::ImageUsageFlagBits::eColorAttachment;
      vk::ImageCreateInfo info({}, vk::ImageType::e2D, of_vulkan, {333, 217, 1}, 1, 1);
      const vk::ExternalMemoryImageCreateInfo exporting(opaque_fd);
      const vk::raii::Image image(gpu.device, info.setUsage(use).setPNext(&exporting));
      const auto memory =
          gpu.allocate(image, vk::MemoryPropertyFlagBits::eDeviceLocal, Gpu::Export::dedicated);
      const cuda_vulkan::Image target(device, exported(gpu, memory, image), {333, 217, format, attachment});
      const Timeline timeline(gpu);
      const cuda_vulkan::Semaphore reached(device, timeline.export_fd());

      const auto pass = [&](vk::ImageLayout from, bool to_others) {
        const auto any = vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite;
        vk::ImageMemoryBarrier barrier(any, any, from, general, 0, VK_QUEUE_FAMILY_EXTERNAL, *image,
                                       colour_part);
        if (!to_others) std::swap(barrier.srcQueueFamilyIndex, barrier.dstQueueFamilyIndex);
        return barrier;
      };
      const auto before = gpu.make_commands(), after = gpu.make_commands();
      before.begin({});
      order(before, pass(vk::ImageLayout::eUndefined, true));
      before.end();
      const HostCopy found(gpu, bytes);
      after.begin({});
      order(after, pass(general, false));
      after.copyImageToBuffer(
          *image, general, *found.buffer,
          vk::BufferImageCopy(0, 0, 0, {vk::ImageAspectFlagBits::eColor, 0, 0, 1}, {}, {333, 217, 1}));
      order(after, {});
      after.end();

      DeviceBuffer<unsigned char> drawn;
      drawn.reset(bytes);
      timeline.submit(gpu.queue, before, 0, 1);
      reached.wait(1, stream);
      FrameView frame{.width = 333,
                      .height = 217,
                      .colour = {drawn.data(), std::ptrdiff_t(bytes / 217)},
                      .format = format};
      renderer.render_into(scene.view(), camera, {}, frame);
      target.write(frame, stream);
      reached.signal(2, stream);
      timeline.submit(gpu.queue, after, 2, 3);
      gpu.queue.waitIdle();
      Bytes expected(bytes);
      renderer.backend().download(std::as_const(drawn).span(), expected.data());
      CHECK((found.content(0, bytes) == expected));
      frame.height = 216;
      CHECK_THROWS_WITH_AS(target.write(frame, stream),
                           doctest::Contains("cuda_vulkan::Image: 333 x 217 pixels of "),
                           std::invalid_argument);
      frame.height = 217;
      frame.format = format == PixelFormat::rgba_8 ? PixelFormat::bgra_8 : PixelFormat::rgba_8;
      CHECK_THROWS_WITH_AS(target.write(frame, stream),
                           doctest::Contains("expected those of the frame, 333 x 217 pixels of "),
                           std::invalid_argument);
    }
}

TEST_CASE("cuda_vulkan: what cannot be imported is refused by the name of the call and closed") {
  const Shared shared;
  if (!shared.gpu) return;
  const cuda_vulkan::Device device(uuid_of(shared.gpu->physical));
  const auto check = [&](const char* expected, const auto& take) {
    const int fd = open("/dev/null", O_RDWR);
    REQUIRE(fd >= 0);
    CHECK_THROWS_WITH_AS(take(fd), doctest::Contains(expected), DeviceError);
    CHECK(fcntl(fd, F_GETFD) == -1);
  };
  check("cuda_vulkan::Buffer: cudaImportExternalMemory: ", [&](int fd) {
    cuda_vulkan::Buffer buffer(device, {fd, 4096});
  });
  check("cuda_vulkan::Image: cudaImportExternalMemory: ", [&](int fd) {
    cuda_vulkan::Image image(device, {fd, 4096}, {16, 16});
  });
  check("cuda_vulkan::Semaphore: cudaImportExternalSemaphore: ",
        [&](int fd) { cuda_vulkan::Semaphore semaphore(device, fd); });
  CHECK(cudaGetLastError() == cudaSuccess);

  const Canvas canvas(*shared.gpu);
  const cuda_vulkan::ExportedMemory memory = exported(*shared.gpu, canvas.memory, canvas.planes);
  CHECK_THROWS_WITH_AS(cuda_vulkan::Image(device, memory, {16, 16, PixelFormat::rgb_float}),
                       "cuda_vulkan::Image: the format has three channels, expected four",
                       std::invalid_argument);

  int devices = 0;
  check_cuda(cudaGetDeviceCount(&devices), "cudaGetDeviceCount");
  if (devices < 2) return;  // the next test says so
  check_cuda(cudaSetDevice(1), "cudaSetDevice");
  check("cuda_vulkan::Buffer: the current CUDA device is 1, expected 0, the GPU of the Vulkan device",
        [&](int fd) {
          cuda_vulkan::Buffer buffer(device, {fd, 4096});
        });
  check("cuda_vulkan::Semaphore: the current CUDA device is 1, expected 0, the GPU of the Vulkan device",
        [&](int fd) { cuda_vulkan::Semaphore semaphore(device, fd); });
  check_cuda(cudaSetDevice(0), "cudaSetDevice");
}

TEST_CASE("cuda_vulkan: each of two GPUs is found by its UUID") {
  const Shared shared;
  if (!shared.gpu) return;
  int devices = 0;
  check_cuda(cudaGetDeviceCount(&devices), "cudaGetDeviceCount");
  if (devices < 2) return skip("one CUDA device alone");
  std::vector<int> numbers;
  for (const vk::raii::PhysicalDevice& physical : shared.instance.devices())
    if (const int number = number_of(physical); number >= 0) numbers.push_back(number);
  std::sort(numbers.begin(), numbers.end());
  std::vector<int> expected(static_cast<std::size_t>(devices));
  std::iota(expected.begin(), expected.end(), 0);
  CHECK(numbers == expected);
}

TEST_CASE("cuda_vulkan: frames in a loop take no memory") {
  const Shared shared;
  if (!shared.gpu) return;
  Together together(*shared.gpu);
  int next = 0;
  const auto draw = [&](int frames) {
    for (const int end = next + frames; next < end; ++next)
      together.draw(next, Seen(next % 20, ClipSpace::vulkan));
    together.wait();
  };
  draw(200);
  const std::size_t device = Cuda::memory_use().in_use, process = resident_memory();
  const std::ptrdiff_t files = open_files();
  draw(frames_of_loop());
  CHECK(together.fitted());
  CHECK(Cuda::memory_use().in_use <= device);
  CHECK(resident_memory() < process + (std::size_t(4) << 20));
  CHECK(open_files() == files);
}

TEST_CASE("cuda_vulkan: what was imported is given back") {
  const Shared shared;
  if (!shared.gpu) return;
  const Gpu& gpu = *shared.gpu;
  const cuda_vulkan::Device device(uuid_of(gpu.physical));
  const auto one = [&] {
    const Canvas canvas(gpu);
    const Timeline timeline(gpu);
    const cuda_vulkan::Buffer dedicated(device, exported(gpu, canvas.memory, canvas.planes));
    const vk::ExternalMemoryBufferCreateInfo exporting(opaque_fd);
    const vk::raii::Buffer bytes(
        gpu.device,
        vk::BufferCreateInfo({}, 1 << 20, vk::BufferUsageFlagBits::eTransferDst).setPNext(&exporting));
    const auto memory = gpu.allocate(bytes, vk::MemoryPropertyFlagBits::eDeviceLocal, Gpu::Export::yes);
    const cuda_vulkan::Buffer other(device, exported(gpu, memory, bytes, false));
    const cuda_vulkan::Semaphore semaphore(device, timeline.export_fd());
  };
  for (int i = 0; i < 20; ++i) one();
  const std::size_t memory = Cuda::memory_use().in_use;
  const std::ptrdiff_t files = open_files();
  for (int i = 0; i < 100; ++i) one();
  CHECK(Cuda::memory_use().in_use <= memory);
  CHECK(open_files() == files);
}
