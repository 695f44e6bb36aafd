// SPDX-License-Identifier: Apache-2.0

// Splats in a window of SDL, with a box that Vulkan draws; the knot of the built-in scene winds
// around and through it. SDL shows the memory in which they are composed. Drag to turn.
//
//     19_vulkan [--screenshot OUT.png]  writes the first frame and ends
#include <iostream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <SDL.h>
#include <vulkan/vulkan_raii.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/camera_matrices.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/orbit.hpp>
#include <swiftgs/swiftgs.hpp>

#include "19_vulkan.frag.hpp"
#include "19_vulkan.vert.hpp"

namespace {

using namespace vk;
using Stage = ShaderStageFlagBits;
using Use = ImageUsageFlagBits;

constexpr int width = 960, height = 540;
constexpr unsigned plane = 4 * width * height;  // bytes
constexpr auto bgra = Format::eB8G8R8A8Unorm, d32 = Format::eD32Sfloat;
constexpr auto general = ImageLayout::eGeneral;
constexpr ImageSubresourceRange colour_part(ImageAspectFlagBits::eColor, 0, 1, 0, 1);
constexpr ImageSubresourceRange depth_part(ImageAspectFlagBits::eDepth, 0, 1, 0, 1);

raii::Pipeline make_pipeline(const raii::Device& device, PipelineLayout layout) {
  const raii::ShaderModule vert(device, {{}, sizeof box_vert, box_vert});
  const raii::ShaderModule frag(device, {{}, sizeof box_frag, box_frag});
  const PipelineShaderStageCreateInfo stages[] = {{{}, Stage::eVertex, *vert, "main"},
                                                  {{}, Stage::eFragment, *frag, "main"}};
  const PipelineVertexInputStateCreateInfo no_vertex_input;
  const PipelineInputAssemblyStateCreateInfo shapes({}, PrimitiveTopology::eTriangleList);
  const Viewport viewport(0, 0, width, height, 0, 1);
  const Rect2D window({}, {width, height});
  const PipelineViewportStateCreateInfo viewports({}, viewport, window);
  const auto raster = PipelineRasterizationStateCreateInfo().setLineWidth(1);
  const PipelineMultisampleStateCreateInfo multisampling;
  const PipelineDepthStencilStateCreateInfo depth({}, true, true, CompareOp::eLess);
  const auto rgba = PipelineColorBlendAttachmentState().setColorWriteMask(ColorComponentFlags(15));
  const PipelineColorBlendStateCreateInfo blend({}, false, {}, rgba);
  const PipelineRenderingCreateInfo targets({}, bgra, d32);
  GraphicsPipelineCreateInfo info({}, stages, &no_vertex_input, &shapes, {}, &viewports, &raster,
                                  &multisampling, &depth, &blend, {}, layout);
  return {device, nullptr, info.setPNext(&targets)};
}

void write(const char* path, const unsigned char* image) {
  swiftgs::Frame frame{width, height, {}, {}, {}};
  for (unsigned i = 0; i < 3 * width * height; ++i)
    frame.colour.push_back(float(image[i / 3 * 4 + 2 - i % 3]) / 255);
  swiftgs::write_png(path, frame);
}

void run(const char* screenshot) {
  SDL_SetHint(SDL_HINT_VIDEODRIVER, "x11");  // never one that shows nothing
  SDL_Window* const window = SDL_CreateWindow("Splats in Vulkan", 0, 0, width, height, 0);
  if (!window) throw std::runtime_error(SDL_GetError());
  const raii::Context context;
  const ApplicationInfo application({}, {}, {}, {}, VK_API_VERSION_1_3);
  const raii::Instance instance(context, {{}, &application});
  const raii::PhysicalDevice gpu = std::move(raii::PhysicalDevices(instance).at(0));
  const float priority = 1;
  const DeviceQueueCreateInfo queues({}, 0, 1, &priority);
  const PhysicalDeviceDynamicRenderingFeatures features(true);
  const raii::Device device(gpu, {{}, queues, {}, {}, {}, &features});
  const raii::Queue queue(device, 0, 0);
  const raii::CommandPool pool(device, {CommandPoolCreateFlagBits::eResetCommandBuffer, 0});
  const auto commands = std::move(raii::CommandBuffers(device, {*pool, {}, 1}).front());
  const PushConstantRange push(Stage::eVertex, 0, sizeof(glm::mat4));
  const raii::PipelineLayout layout(device, {{}, {}, push});
  const raii::Pipeline pipeline = make_pipeline(device, *layout);

  ImageCreateInfo info({}, ImageType::e2D, bgra, {width, height, 1}, 1, 1);
  const raii::Image colour(device, info.setUsage(Use::eColorAttachment | Use::eTransferSrc));
  info.setFormat(d32).setUsage(Use::eDepthStencilAttachment | Use::eTransferSrc);
  const raii::Image depth(device, info);
  const raii::Buffer buffer(device, {{}, 2 * plane, BufferUsageFlagBits::eTransferDst});
  const auto allocate = [&](const auto& resource, MemoryPropertyFlags wanted) {
    const MemoryRequirements need = resource.getMemoryRequirements();
    const auto types = gpu.getMemoryProperties().memoryTypes;
    unsigned i = 0;
    while (!(need.memoryTypeBits >> i & 1) || (types[i].propertyFlags & wanted) != wanted) ++i;
    raii::DeviceMemory memory(device, MemoryAllocateInfo(need.size, i));
    resource.bindMemory(*memory, 0);
    return memory;
  };
  const auto in_colour = allocate(colour, {}), in_depth = allocate(depth, {});
  const auto memory = allocate(buffer, MemoryPropertyFlagBits::eHostCoherent);
  auto* const image = static_cast<unsigned char*>(memory.mapMemory(0, 2 * plane));
  const raii::ImageView colours(device, {{}, *colour, ImageViewType::e2D, bgra, {}, colour_part});
  const raii::ImageView depths(device, {{}, *depth, ImageViewType::e2D, d32, {}, depth_part});
  RenderingAttachmentInfo to_colour(*colours, general), to_depth(*depths, general);
  to_colour.loadOp = to_depth.loadOp = AttachmentLoadOp::eClear;
  to_depth.clearValue.depthStencil.depth = 1;
  const auto order = [&](ImageLayout from) {  // what is before and what is after
    const auto all = PipelineStageFlagBits::eAllCommands | PipelineStageFlagBits::eHost;
    const auto any = AccessFlagBits::eMemoryRead | AccessFlagBits::eMemoryWrite;
    const ImageMemoryBarrier barriers[] = {{any, any, from, general, 0, 0, *colour, colour_part},
                                           {any, any, from, general, 0, 0, *depth, depth_part}};
    commands.pipelineBarrier(all, all, {}, MemoryBarrier(any, any), {}, barriers);
  };

  using namespace swiftgs;
  Renderer<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
  const Cpu::SceneOn scene = renderer.backend().upload(make_builtin_scene());
  const dvec3 target(0.02, -1.16, 0.02), up(0, -1, 0);
  const Camera start = look_at(target - dvec3(0, 0, 3), target, up, 0.76, width, height);
  double turn = -0.26, rise = 0.2;
  for (SDL_Event event{}; event.type != SDL_QUIT; SDL_WaitEvent(&event)) {
    if (event.type == SDL_MOUSEMOTION && event.motion.state)
      turn -= event.motion.xrel / 200.0, rise += event.motion.yrel / 200.0;
    const Camera seen = orbit({start, target, up}, turn, rise);
    const auto [view, projection] = matrices(seen, 0.1, 500, ClipSpace::vulkan);

    commands.begin({});
    order(ImageLayout::eUndefined);
    commands.beginRendering({{}, {{}, {width, height}}, 1, 0, to_colour, &to_depth});
    commands.bindPipeline(PipelineBindPoint::eGraphics, *pipeline);
    commands.pushConstants<glm::mat4>(*layout, Stage::eVertex, 0, glm::mat4(projection * view));
    commands.draw(36, 1, 0, 0);
    commands.endRendering();
    order(general);
    BufferImageCopy copy(0, 0, 0, {ImageAspectFlagBits::eColor, 0, 0, 1}, {}, {width, height, 1});
    commands.copyImageToBuffer(*colour, general, *buffer, copy);
    copy.setBufferOffset(plane).imageSubresource.aspectMask = ImageAspectFlagBits::eDepth;
    commands.copyImageToBuffer(*depth, general, *buffer, copy);
    order(general);
    commands.end();
    queue.submit(SubmitInfo({}, {}, *commands));
    queue.waitIdle();

    const HostCamera host = camera_from(view, projection, width, height, ClipSpace::vulkan);
    const auto* const stored = reinterpret_cast<float*>(image + plane);
    FrameView frame = host.frame(image, stored, PixelFormat::bgra_8);
    frame.over = true;
    renderer.render_into(scene.view(), host.camera, {}, frame);

    if (screenshot) return write(screenshot, image);
    SDL_Surface* const shown = SDL_GetWindowSurface(window);
    SDL_ConvertPixels(width, height, SDL_PIXELFORMAT_BGRA32, image, 4 * width,  // to the screen's
                      shown->format->format, shown->pixels, shown->pitch);
    SDL_UpdateWindowSurface(window);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc == 3 && std::string_view(argv[1]) == "--screenshot" ? argv[2] : nullptr);
  } catch (const std::exception& error) {
    std::cerr << "19_vulkan: " << error.what() << "; expected a display and Vulkan 1.3\n";
    return 1;
  }
}
