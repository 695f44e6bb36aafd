// SPDX-License-Identifier: Apache-2.0

// A stereo frame as one CUDA graph: the program draws a window for both eyes, the splats follow where the
// panes are, and a kernel makes a red-cyan image of the pair. All of it is captured once and replayed while
// the eyes fly towards the scene: the CPU launches one graph a frame and waits for none. Now and then it
// looks whether the splats were within the capacity. The last image is written as PNG to the path that is
// given.
#include <cmath>
#include <cstddef>
#include <exception>
#include <iostream>
#include <memory>
#include <type_traits>
#include <vector>

#include <cuda_runtime_api.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;
using Splatter = Renderer<Cuda>;

namespace {

constexpr int width = 640, height = 480,
              pair_width = 2 * width;  // the right eye's image beside the left one's
constexpr int frames = 240, frames_a_look = 30;

struct Destroy {
  void operator()(cudaStream_t stream) const { cudaStreamDestroy(stream); }
  void operator()(cudaGraph_t graph) const { cudaGraphDestroy(graph); }
  void operator()(cudaGraphExec_t graph) const { cudaGraphExecDestroy(graph); }
  void operator()(FrameReport* report) const { cudaFreeHost(report); }
};
template <class Handle>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Destroy>;

/// Planes on the device, whose places are part of the graph.
struct Planes {
  Planes() { pair.reset(pair_width * height), depth.reset(pair_width * height), image.reset(width * height); }

  DeviceBuffer<uchar4> pair, image;
  DeviceBuffer<float> depth;
};

/// The window: nothing shows before its bars, everything behind its panes.
__global__ void draw_window(uchar4* pair, float* depth) {
  const int x = int(blockIdx.x * blockDim.x + threadIdx.x), y = int(blockIdx.y), across = x % width;
  const bool bar = across < 16 || across >= width - 16 || y < 16 || y >= height - 16 || across / 8 == 39;
  pair[y * pair_width + x] = bar ? uchar4{92, 64, 44, 255} : uchar4{0, 0, 0, 255};
  depth[y * pair_width + x] = bar ? 0 : INFINITY;
}

/// Red from the left eye, green and blue from the right.
__global__ void join_eyes(const uchar4* pair, uchar4* image) {
  const int x = int(blockIdx.x * blockDim.x + threadIdx.x), y = int(blockIdx.y);
  const uchar4 left = pair[y * pair_width + x], right = pair[y * pair_width + width + x];
  image[y * width + x] = {left.x, right.y, right.z, 255};
}

/// Gives `stream` a frame, its splats by `draw_splats`.
template <class DrawSplats>
void enqueue(cudaStream_t stream, Planes& planes, const DrawSplats& draw_splats) {
  draw_window<<<dim3(pair_width / 128, height), 128, 0, stream>>>(planes.pair.data(), planes.depth.data());
  check_cuda(cudaGetLastError(), "draw_window");
  draw_splats();
  join_eyes<<<dim3(width / 128, height), 128, 0, stream>>>(planes.pair.data(), planes.image.data());
  check_cuda(cudaGetLastError(), "join_eyes");
}

/// Both eyes in frame k, each over its half of the pair. They fly towards the still life and sway; what is
/// four metres away keeps its place in the window.
std::vector<View> eyes(int k, Planes& planes) {
  const double way = double(k) / (frames - 1), sway = 0.4 * std::sin(6.28 * way);
  std::vector<View> views;
  for (const int eye : {0, 1}) {
    Camera camera = builtin_camera(width, height);
    const double aside = sway + 0.064 * eye - 0.032;  // in metres
    camera.translation.x -= aside, camera.translation.z += 16 - 17 * way;
    camera.cx += camera.fx * aside / 4;
    views.push_back(make_view(camera, Conventions(),
                              {.width = width,
                               .height = height,
                               .colour = {planes.pair.data() + eye * width, pair_width * sizeof(uchar4)},
                               .format = PixelFormat::rgba_8,
                               .occluder = {planes.depth.data() + eye * width, pair_width * sizeof(float)},
                               .over = true}));
  }
  return views;
}

/// The image, after all that `stream` was given before. Waits.
Frame download(cudaStream_t stream, const Planes& planes) {
  std::vector<uchar4> pixels(planes.image.size());
  check_cuda(cudaMemcpyAsync(pixels.data(), planes.image.data(), pixels.size() * sizeof(uchar4),
                             cudaMemcpyDeviceToHost, stream),
             "cudaMemcpyAsync");
  check_cuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
  Frame frame;
  frame.width = width, frame.height = height;
  for (const uchar4 p : pixels)
    for (const int channel : {p.x, p.y, p.z}) frame.colour.push_back(float(channel) / 255);
  return frame;
}

}  // namespace

int main(int argc, char** argv) try {
  if (!Cuda::usable()) {
    std::cout << "skipped: no CUDA device that the kernels of this build run on\n";
    return 77;
  }
  cudaStream_t made = nullptr;
  check_cuda(cudaStreamCreateWithFlags(&made, cudaStreamNonBlocking), "cudaStreamCreateWithFlags");
  const Owned<cudaStream_t> stream(made);
  // The device writes the report to memory of the host, where it is read without a copy.
  FrameReport* memory = nullptr;
  check_cuda(cudaMallocHost(&memory, sizeof(FrameReport)), "cudaMallocHost");
  const Owned<FrameReport*> report(memory);
  Planes planes;

  // This renderer serves the graph and nothing else, because its memory must stay where it is.
  Splatter recorder{Cuda(stream.get())};
  const Cuda::SceneOn scene = recorder.backend().upload(make_builtin_scene());
  Owned<cudaGraphExec_t> graph;
  int captures = 0;
  const auto capture = [&](int k, Capacity capacity) {
    graph.reset();  // it must not run again once the renderer's memory has grown
    const std::vector<View> views = eyes(k, planes);
    recorder.reserve(scene.view(), {views.data(), views.size()}, capacity);

    check_cuda(cudaStreamBeginCapture(stream.get(), cudaStreamCaptureModeThreadLocal),
               "cudaStreamBeginCapture");
    enqueue(stream.get(), planes, [&] { recorder.record(scene.view(), report.get()); });
    cudaGraph_t captured = nullptr;
    check_cuda(cudaStreamEndCapture(stream.get(), &captured), "cudaStreamEndCapture");
    const Owned<cudaGraph_t> owner(captured);
    cudaGraphExec_t instantiated = nullptr;
    check_cuda(cudaGraphInstantiate(&instantiated, captured, 0), "cudaGraphInstantiate");
    graph.reset(instantiated), ++captures;
  };
  const auto replay = [&](int k) {
    const std::vector<View> views = eyes(k, planes);
    recorder.set_views({views.data(), views.size()});
    check_cuda(cudaGraphLaunch(graph.get(), stream.get()), "cudaGraphLaunch");
  };

  capture(0, {});  // capacity for what the first frame shows, and an eighth more
  for (int k = 0; k < frames; ++k) {
    replay(k);
    if (k % frames_a_look != frames_a_look - 1) continue;
    check_cuda(cudaStreamSynchronize(stream.get()), "cudaStreamSynchronize");
    if (report->overflowed == 0) continue;
    // This frame shows the window alone, and the report says which capacity it needs. Take twice as much.
    capture(k, {std::size_t(2 * report->visible), std::size_t(2 * report->intersections)});
    replay(k);
  }
  const Frame image = download(stream.get(), planes);
  if (argc > 1) write_png(argv[1], image);

  // The last frame by another renderer, without a graph, has the same bits.
  Splatter renderer{Cuda(stream.get())};
  const std::vector<View> views = eyes(frames - 1, planes);
  enqueue(stream.get(), planes, [&] { renderer.render_into(scene.view(), {views.data(), views.size()}); });
  const bool same = download(stream.get(), planes).colour == image.colour;
  std::cout << frames << " frames from " << captures << " captures, the last of " << report->visible
            << " splats and " << report->intersections << " intersections; its bits are "
            << (same ? "" : "not ") << "those of a frame without a graph\n";
  return same && captures > 1 && report->overflowed == 0 ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
