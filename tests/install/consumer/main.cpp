// SPDX-License-Identifier: Apache-2.0

// Renders one Gaussian in the middle of an image with every backend that can run here, and fails unless it is
// there, also in a file where there are files.
#include <array>
#include <cstdint>
#include <iostream>
#include <memory>
#include <string_view>

#include <swiftgs/reference.hpp>
#include <swiftgs/swiftgs.hpp>

#if defined(CONSUMER_USES_CPU)
#include <swiftgs/cpu.hpp>
#endif
#if defined(CONSUMER_USES_CUDA)
#include <swiftgs/contribution.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#endif
#if defined(CONSUMER_USES_GL)
#include <swiftgs/gl.hpp>
#endif
#if defined(CONSUMER_USES_CUDA_VULKAN)
#include <swiftgs/cuda_vulkan.hpp>
#endif
#if defined(CONSUMER_USES_VULKAN)
#include <own_box_shaders.hpp>

#include <swiftgs/vulkan.hpp>
#endif
#if defined(CONSUMER_USES_TABLE)
#include <swiftgs/any_renderer.hpp>
#endif
#if defined(CONSUMER_USES_IO)
#include <swiftgs/io/image.hpp>
#endif

#if defined(CONSUMER_USES_VULKAN)
/// Bounds of the program's own, with a shader of its own.
struct OwnBox : swiftgs::OpacityBox {
  static constexpr std::string_view name = "own-box";
};
template <>
inline constexpr const auto* swiftgs::vulkan::shaders<OwnBox> = &own_box_shaders;
#endif

template <class Backend, class Bounds = swiftgs::OpacityBox>
bool renders() {
  swiftgs::Scene scene;
  scene.means = {{0, 0, 2}};
  scene.scales = {{0.1f, 0.1f, 0.1f}};
  scene.rotations = {{1, 0, 0, 0}};
  scene.opacities = {0.9f};
  scene.sh0 = {{1, 1, 1}};
  const swiftgs::Camera camera = swiftgs::look_at({0, 0, 0}, {0, 0, 1}, {0, -1, 0}, 1, 64, 48);

  swiftgs::Renderer<Backend, swiftgs::EarlySort, swiftgs::AxisSharedThreshold<swiftgs::FloatSplit>, Bounds>
      renderer;
  const swiftgs::Frame frame = renderer.render(renderer.backend().upload(scene), camera);

  const float centre = frame.colour[3 * (24 * 64 + 32)], corner = frame.colour[0];
  std::cout << "swiftgs " << swiftgs::version << " " << renderer.name << ": centre " << centre << ", corner "
            << corner << "\n";
#if defined(CONSUMER_USES_IO)
  // `read_image` needs every image library that the package was built with.
  write_png("frame.png", frame);
  const swiftgs::Image image = swiftgs::read_image("frame.png");
  if (image.width != 64 || image.height != 48 || !(image.pixels[3 * (24 * 64 + 32)] > 0.5f)) return false;
#endif
  const swiftgs::ReferenceFrame reference = swiftgs::render_reference(scene, camera, {});
  return centre > 0.5f && corner == 0 && reference.visible == 1;
}

#if defined(CONSUMER_USES_CUDA)
/// Where a device or what it should share is missing, the library throws what a program knows by its type.
template <class Ask>
bool reports_the_lack_of_a_device(const Ask& ask) {
  try {
    ask();
  } catch (const swiftgs::DeviceError& error) {
    std::cout << "not here: " << error.what() << "\n";
    return true;
  }
  return false;
}
#endif

int main() {
  bool good = renders<swiftgs::Serial>();
#if defined(CONSUMER_USES_CPU)
  good = renders<swiftgs::Cpu>() && good;
  // One upload is compiled into the program and one into a library that may be shared.
  const auto scene = std::make_shared<const swiftgs::Scene>();
  const auto here = swiftgs::Serial().upload(scene).view().identity;
  const auto there = swiftgs::Cpu(1).upload(scene).view().identity;
  good = good && here != 0 && there == here + 1;
#endif
#if defined(CONSUMER_USES_CUDA)
  if (swiftgs::Cuda::usable()) {
    swiftgs::check_cuda(cudaSetDevice(0), "cudaSetDevice");
    good = renders<swiftgs::Cuda>() && good;
  } else {
    good = reports_the_lack_of_a_device([] {
             swiftgs::Contributions<swiftgs::Cuda> contributions(std::make_shared<const swiftgs::Scene>());
           }) &&
           good;
  }
#endif
#if defined(CONSUMER_USES_GL)
  good = reports_the_lack_of_a_device([] { swiftgs::gl::device(); }) && good;  // without a context
#endif
#if defined(CONSUMER_USES_CUDA_VULKAN)
  good = reports_the_lack_of_a_device([] { swiftgs::cuda_vulkan::Device(std::array<std::uint8_t, 16>{}); }) &&
         good;
#endif
#if defined(CONSUMER_USES_VULKAN)
  if (swiftgs::Vulkan::usable()) good = renders<swiftgs::Vulkan, OwnBox>() && good;
#endif
#if defined(CONSUMER_USES_TABLE)
  std::cout << swiftgs::renderers().size() << " renderers\n";
  good = good && !swiftgs::renderers().empty();
#endif
  return good ? 0 : 1;
}
