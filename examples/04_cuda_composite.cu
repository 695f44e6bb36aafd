// SPDX-License-Identifier: Apache-2.0

// Composition on a GPU: the host renderer keeps a stream, an RGBA8 image and a depth buffer on the device and
// draws into them by a kernel of its own. The splats follow on that stream, over that image, under that
// depth; no pixel comes to the CPU before the frame is done. The frame is written as PNG to the path that is
// given.
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <vector>

#include <cuda_runtime_api.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/swiftgs.hpp>

#include "analytic_scene.hpp"

using namespace swiftgs;
using analytic::Rgba8;

namespace {

constexpr int width = 1300, height = 730;  // whole numbers neither of tiles nor of what a pitch is rounded to

/// A stream that does not wait for the default one.
struct Stream {
  Stream() {
    check_cuda(cudaStreamCreateWithFlags(&get, cudaStreamNonBlocking), "cudaStreamCreateWithFlags");
  }
  ~Stream() { cudaStreamDestroy(get); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  cudaStream_t get = nullptr;
};

/// An image on the device, its rows as far apart as the device likes them.
template <class T>
struct DeviceImage {
  DeviceImage() {
    std::size_t pitch = 0;
    check_cuda(cudaMallocPitch(&plane.data, &pitch, width * sizeof(T), height), "cudaMallocPitch");
    plane.pitch = std::ptrdiff_t(pitch);
  }
  ~DeviceImage() { cudaFree(plane.data); }
  DeviceImage(const DeviceImage&) = delete;
  DeviceImage& operator=(const DeviceImage&) = delete;

  /// On the CPU, after all that `stream` was given before. Waits.
  std::vector<T> download(cudaStream_t stream) const {
    std::vector<T> to(std::size_t(width) * height);
    check_cuda(cudaMemcpy2DAsync(to.data(), width * sizeof(T), plane.data, std::size_t(plane.pitch),
                                 width * sizeof(T), height, cudaMemcpyDeviceToHost, stream),
               "cudaMemcpy2DAsync");
    check_cuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
    return to;
  }

  Plane<T> plane;
};

/// The host renderer, a thread a pixel.
__global__ void draw(analytic::View view, Plane<Rgba8> image, Plane<float> depth) {
  const int x = int(blockIdx.x * blockDim.x + threadIdx.x), y = int(blockIdx.y * blockDim.y + threadIdx.y);
  if (x >= width || y >= height) return;
  const analytic::Surface surface = analytic::draw_pixel(view, x, y);
  image.row(y)[x] = surface.colour;
  depth.row(y)[x] = surface.depth;
}

/// Splats over `image` and before `surfaces`, with planes of their own alpha and depth.
FrameView composed(Plane<Rgba8> image, Plane<const float> surfaces, Plane<float> alpha, Plane<float> depth) {
  return {.width = width,
          .height = height,
          .colour = {image.data, image.pitch},
          .format = PixelFormat::rgba_8,
          .alpha = alpha,
          .depth = depth,
          .occluder = surfaces,
          .over = true};
}

bool more_than_a_step_apart(Rgba8 a, Rgba8 b) {
  return std::abs(a.r - b.r) > 1 || std::abs(a.g - b.g) > 1 || std::abs(a.b - b.b) > 1 ||
         std::abs(a.a - b.a) > 1;
}

void save(const char* path, const std::vector<Rgba8>& image) {
  Frame frame{.width = width, .height = height, .colour = {}, .alpha = {}, .depth = {}};
  for (const Rgba8 p : image)
    for (const int channel : {p.r, p.g, p.b}) frame.colour.push_back(float(channel) / 255);
  write_png(path, frame);
}

}  // namespace

int main(int argc, char** argv) try {
  if (!Cuda::usable()) {
    std::cout << "skipped: no CUDA device that the kernels of this build run on\n";
    return 77;
  }
  const Scene scene = make_builtin_scene();
  const Camera camera = builtin_camera(width, height);

  // The host's stream and images. `alone` gets no splats: the frame is compared with it at the end.
  const Stream stream;
  const DeviceImage<Rgba8> image, alone;
  const DeviceImage<float> surfaces, alpha, depth;

  // The scene is uploaded once, before the first frame.
  Renderer<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer{Cuda(stream.get)};
  const Cuda::SceneOn uploaded = renderer.backend().upload(scene);

  // A frame: the host draws, the splats follow. The stream keeps them in order, so nothing has to wait.
  const dim3 threads(16, 16), blocks((width + 15) / 16, (height + 15) / 16);
  for (const DeviceImage<Rgba8>* target : {&alone, &image}) {
    draw<<<blocks, threads, 0, stream.get>>>(analytic::view_of(camera), target->plane, surfaces.plane);
    check_cuda(cudaGetLastError(), "draw");
  }
  RenderSettings settings;
  settings.time = true;
  renderer.render_into(
      uploaded.view(), camera, settings,
      composed(image.plane, {surfaces.plane.data, surfaces.plane.pitch}, alpha.plane, depth.plane));

  const std::vector<Rgba8> frame = image.download(stream.get), host = alone.download(stream.get);
  const std::vector<float> ends = surfaces.download(stream.get), a = alpha.download(stream.get),
                           z = depth.download(stream.get);
  if (argc > 1) save(argv[1], frame);

  // The same over the same surfaces by the serial backend.
  Renderer<Serial, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> serial;
  std::vector<Rgba8> expected = host;
  serial.render_into(
      view(scene), camera, {},
      composed({expected.data(), width * sizeof(Rgba8)}, {ends.data(), width * sizeof(float)}, {}, {}));

  // Where no splat is drawn the host's pixel is untouched; where one is it lies before the host's surface,
  // but for the rounding of a mean whose weights add up to as little as 1/255. Backends differ by a step of a
  // channel at most, unless a rounding decides whether a splat is drawn at all.
  std::size_t wrong = 0, hosts = 0, mixed = 0, apart = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    wrong += a[i] == 0 ? frame[i] != host[i] : z[i] >= 1.00001f * ends[i];
    hosts += a[i] == 0, mixed += a[i] > 0 && ends[i] != analytic::nowhere;
    apart += more_than_a_step_apart(frame[i], expected[i]);
  }
  std::cout << hosts << " pixels show the host's surfaces alone, " << mixed << " have splats before them, "
            << wrong << " are wrong, " << apart << " are not those of the serial backend; "
            << renderer.times().total << " ms for " << renderer.statistics().visible
            << " Gaussians in view\n";
  return wrong == 0 && hosts > 10'000 && mixed > 10'000 && apart <= frame.size() / 10'000 ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
