// SPDX-License-Identifier: Apache-2.0

// Several views on a GPU: a stereo pair and an overview, back to back on one stream, into regions of one
// buffer, from Gaussians that the program has brought to the device itself. The program waits once, for the
// last of them. No code of its own runs on the device, so this needs no nvcc. The buffer is written as PNG to
// the path that is given.
#include <cmath>
#include <cstddef>
#include <cstring>
#include <exception>
#include <iostream>
#include <memory>
#include <type_traits>
#include <vector>

#include <cuda_runtime_api.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/frame/half.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

namespace {

// The atlas: an eye beside the other, the overview below, nothing in the gaps.
constexpr int eye_width = 640, eye_height = 480, gap = 12;
constexpr int atlas_width = 2 * eye_width + gap, atlas_height = 2 * eye_height + gap;

struct Destroy {
  void operator()(cudaStream_t stream) const { cudaStreamDestroy(stream); }
  void operator()(void* memory) const { cudaFree(memory); }
};
using Stream = std::unique_ptr<std::remove_pointer_t<cudaStream_t>, Destroy>;
using Memory = std::unique_ptr<void, Destroy>;

/// The program's own Gaussians: plain arrays on the device, which the library only reads.
struct Gaussians {
  /// Copies in the order of `stream`, which may go on when this returns: `from` must outlive that.
  Gaussians(const Scene& from, cudaStream_t stream) {
    view = {.means = send(from.means, stream),
            .scales = send(from.scales, stream),
            .rotations = send(from.rotations, stream),
            .opacities = send(from.opacities, stream),
            .sh0 = send(from.sh0, stream),
            .sh_rest = {send(from.sh_rest, stream).data, from.size(),
                        sizeof(vec3) * std::size_t(sh_rest_count(from.sh_degree))},
            .sh_degree = from.sh_degree};
  }

  SceneView view;

 private:
  template <class T>
  Span<const T> send(const std::vector<T>& from, cudaStream_t stream) {
    void* to = nullptr;
    check_cuda(cudaMalloc(&to, from.size() * sizeof(T)), "cudaMalloc");
    memory_.emplace_back(to);
    check_cuda(cudaMemcpyAsync(to, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice, stream),
               "cudaMemcpyAsync");
    return {static_cast<const T*>(to), from.size()};
  }

  std::vector<Memory> memory_;
};

/// A view, and the place of its first pixel in the atlas.
struct Region {
  Camera camera;
  std::size_t x = 0, y = 0;
};

/// An eye, `side` of -1 or 1 from the middle. The axes of both are parallel; their principal points are moved
/// so that what is as far away as the still life lies at the same pixel in both.
Camera eye(double side) {
  constexpr double aside = 0.032, distance = 4.0;  // in metres
  Camera camera = builtin_camera(eye_width, eye_height);
  camera.translation.x -= side * aside;
  camera.cx += camera.fx * side * aside / distance;
  return camera;
}

/// From above; y points down.
Camera overview() {
  return look_at(dvec3(5.5, -5.0, -8.0), dvec3(0, -0.6, 0), dvec3(0, -1, 0), 0.6, atlas_width, eye_height);
}

/// Half pixels on the host, with the bits that fill the gaps.
struct Atlas {
  struct Pixel {
    Half r, g, b, a;
  };
  /// Memory of bytes 0xff is a NaN, which no rendered pixel holds.
  static constexpr int unwritten_byte = 0xff;
  static bool written(const Pixel& p) { return !std::isnan(to_float(p.a)); }

  const Pixel& at(std::size_t x, std::size_t y) const { return pixels[y * atlas_width + x]; }

  std::vector<Pixel> pixels = std::vector<Pixel>(std::size_t(atlas_width) * atlas_height);
};

/// The gaps, being NaN, become black.
void save(const char* path, const Atlas& atlas) {
  Frame frame;
  frame.width = atlas_width, frame.height = atlas_height;
  for (const Atlas::Pixel& p : atlas.pixels)
    for (const Half channel : {p.r, p.g, p.b}) frame.colour.push_back(to_float(channel));
  write_png(path, frame);
}

}  // namespace

int main(int argc, char** argv) try {
  if (!Cuda::usable()) {
    std::cout << "skipped: no CUDA device that the kernels of this build run on\n";
    return 77;
  }
  cudaStream_t made = nullptr;
  check_cuda(cudaStreamCreateWithFlags(&made, cudaStreamNonBlocking), "cudaStreamCreateWithFlags");
  const Stream stream(made);

  const Scene scene = make_builtin_scene();
  const Gaussians gaussians(scene, stream.get());

  constexpr std::size_t row = atlas_width * sizeof(Atlas::Pixel);
  void* memory = nullptr;
  std::size_t pitch = 0;
  check_cuda(cudaMallocPitch(&memory, &pitch, row, atlas_height), "cudaMallocPitch");
  const Memory owner(memory);
  check_cuda(cudaMemset2DAsync(memory, pitch, Atlas::unwritten_byte, row, atlas_height, stream.get()),
             "cudaMemset2DAsync");

  // One renderer for all: its memory serves each view in turn.
  Renderer<Cuda> renderer{Cuda(stream.get())};
  const Region regions[] = {{eye(-1), 0, 0}, {eye(1), eye_width + gap, 0}, {overview(), 0, eye_height + gap}};
  RenderSettings settings;
  settings.time = true;
  for (const Region& region : regions) {
    const Plane<Atlas::Pixel> atlas{static_cast<Atlas::Pixel*>(memory), std::ptrdiff_t(pitch)};
    renderer.render_into(gaussians.view, region.camera, settings,
                         {.width = region.camera.width,
                          .height = region.camera.height,
                          .colour = {atlas.row(region.y) + region.x, atlas.pitch},
                          .format = PixelFormat::rgba_half});
  }

  Atlas atlas;
  check_cuda(cudaMemcpy2DAsync(atlas.pixels.data(), row, memory, pitch, row, atlas_height,
                               cudaMemcpyDeviceToHost, stream.get()),
             "cudaMemcpy2DAsync");
  check_cuda(cudaStreamSynchronize(stream.get()), "cudaStreamSynchronize");
  if (argc > 1) save(argv[1], atlas);

  // Every pixel of the three regions is written and none between them, and the eyes do not see the same.
  std::size_t wrong = 0, apart = 0;
  for (std::size_t y = 0; y < atlas_height; ++y)
    for (std::size_t x = 0; x < atlas_width; ++x) {
      const bool above = y < eye_height, below = y >= eye_height + gap;
      const bool inside = below || (above && (x < eye_width || x >= eye_width + gap));
      wrong += inside != Atlas::written(atlas.at(x, y));
      if (above && x < eye_width)
        apart += std::memcmp(&atlas.at(x, y), &atlas.at(x + eye_width + gap, y), sizeof(Atlas::Pixel)) != 0;
    }
  // The times of a frame are known when it is done.
  const StageTimes times = renderer.times();
  std::cout << apart << " pixels tell the eyes apart, " << wrong
            << " are wrong; overview: " << renderer.statistics().visible << " Gaussians in view, "
            << times.total << " ms (project " << times.project << ", sort " << times.sort << ", raster "
            << times.raster << ")\n";
  return wrong == 0 && apart > 10'000 && times.total > 0 ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
