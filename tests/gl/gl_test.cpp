// SPDX-License-Identifier: Apache-2.0

// Frames in buffers and textures of OpenGL, beside frames of the host.
#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <cuda_runtime_api.h>
#include <doctest/doctest.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/gl.hpp>

#include "gl/context.hpp"
#include "support/skip.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// OpenGL and CUDA on one device; null, and the test is skipped, where there is none.
struct Shared : Context {
  Shared() : Context(0) {
    const char* missing = !Cuda::usable() ? "CUDA device that the kernels of this build run on"
                          : !current      ? "EGL that draws on CUDA's first device"
                                          : nullptr;
    usable = !missing;
    if (missing) skip("no " + std::string(missing));
  }
  bool usable;
};

GLuint make_pixel_buffer(std::size_t bytes) {
  GLuint name = 0;
  glGenBuffers(1, &name), glBindBuffer(GL_PIXEL_PACK_BUFFER, name);
  glBufferData(GL_PIXEL_PACK_BUFFER, GLsizeiptr(bytes), nullptr, GL_STREAM_COPY);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  return name;
}

constexpr std::size_t colour_bytes = 4 * pixels, depth_bytes = sizeof(float) * pixels;

/// What the canvas shows, in a pixel buffer: colours, and depths behind them. The host does not see it.
void read_canvas(GLuint pixel_buffer) {
  glBindBuffer(GL_PIXEL_PACK_BUFFER, pixel_buffer);
  const auto at = [](std::size_t byte) { return reinterpret_cast<void*>(byte); };
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, at(0));
  glReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, at(colour_bytes));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
}

Bytes content(GLuint pixel_buffer, std::size_t bytes) {
  Bytes out(bytes);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, pixel_buffer);
  glGetBufferSubData(GL_PIXEL_PACK_BUFFER, 0, GLsizeiptr(bytes), out.data());
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  return out;
}

struct TextureFormat {
  PixelFormat format;
  GLenum storage, type;
};
constexpr TextureFormat texture_formats[] = {{PixelFormat::rgba_8, GL_RGBA8, GL_UNSIGNED_BYTE},
                                             {PixelFormat::rgba_half, GL_RGBA16F, GL_HALF_FLOAT},
                                             {PixelFormat::rgba_float, GL_RGBA32F, GL_FLOAT}};

GLuint make_texture(GLenum storage, const void* texels = nullptr, GLenum type = GL_UNSIGNED_BYTE) {
  GLuint name = 0;
  glGenTextures(1, &name), glBindTexture(GL_TEXTURE_2D, name);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  const GLenum channels = storage == GL_DEPTH_COMPONENT32F ? GL_DEPTH_COMPONENT : GL_RGBA;
  glTexImage2D(GL_TEXTURE_2D, 0, GLint(storage), width, height, 0, channels, type, texels);
  return name;
}

}  // namespace

TEST_CASE("gl: a machine without a device of CUDA says which call failed") {
  if (Cuda::usable()) return skip("there is a CUDA device");
  const Context context;
  if (!context.current) return skip("no EGL device with OpenGL 3.3");
  CHECK_THROWS_WITH_AS(gl::Buffer{1}, doctest::Contains("cudaGLGetDevices: "), DeviceError);
}

TEST_CASE("gl: splats are drawn before and behind a box in a pixel buffer as the host composes them") {
  const Shared shared;
  if (!shared.usable) return;
  CHECK(gl::device() == 0);
  const Canvas canvas;
  HostFrames on_host;
  Renderer<Cuda> renderer;
  const auto scene = renderer.backend().upload(make_builtin_scene());
  const GLuint name = make_pixel_buffer(colour_bytes + depth_bytes);
  const gl::Buffer buffer(name);
  for (int k = 0; k < 6; ++k) {
    CAPTURE(k);
    const Seen seen(k, ClipSpace::opengl);
    canvas.draw_box(seen.matrix);
    read_canvas(name);
    const Bytes box = Canvas::colours();
    const std::vector<float> depth = Canvas::depths();
    {
      const gl::Mapped memory(buffer, renderer.backend().stream());
      CHECK(memory.bytes() == colour_bytes + depth_bytes);
      auto* const first = static_cast<unsigned char*>(memory.data());
      FrameView frame = seen.host.frame(first, reinterpret_cast<const float*>(first + colour_bytes));
      frame.over = true;
      renderer.render_into(scene.view(), seen.host.camera, {}, frame);
    }
    on_host.check(content(name, colour_bytes), seen.host, PixelFormat::rgba_8, box, depth);
  }
}

TEST_CASE("gl: splats in textures of each format are those of the host when OpenGL draws them over a box") {
  const Shared shared;
  if (!shared.usable) return;
  const Canvas canvas;
  HostFrames on_host;
  Renderer<Cuda> renderer;
  const auto scene = renderer.backend().upload(make_builtin_scene());
  const cudaStream_t stream = renderer.backend().stream();
  const GLuint name = make_pixel_buffer(colour_bytes + depth_bytes);
  const gl::Buffer buffer(name);
  DeviceBuffer<unsigned char> image;
  for (const TextureFormat& of : texture_formats)
    for (const int k : {0, 5}) {
      CAPTURE(k);
      CAPTURE(bytes_per_pixel(of.format));
      const Seen seen(k, ClipSpace::opengl);
      canvas.draw_box(seen.matrix);
      read_canvas(name);
      const Bytes before = on_host.draw(seen.host, of.format, {}, Canvas::depths());

      const GLuint on_device = make_texture(of.storage),
                   expected = make_texture(of.storage, before.data(), of.type);
      const gl::Texture texture(on_device, GL_TEXTURE_2D);
      image.reset(before.size());
      {
        const gl::Mapped memory(buffer, stream);
        const auto* const depth = static_cast<const unsigned char*>(memory.data()) + colour_bytes;
        const FrameView frame =
            seen.host.frame(image.data(), reinterpret_cast<const float*>(depth), of.format);
        renderer.render_into(scene.view(), seen.host.camera, {}, frame);
        texture.write(frame, stream);
      }
      canvas.draw_over(on_device);
      const Bytes drawn = Canvas::colours();
      canvas.draw_box(seen.matrix);
      canvas.draw_over(expected);
      CHECK(HostFrames::decibels(drawn, Canvas::colours()) >= 60);
      canvas.draw_box(seen.matrix);
      CHECK(HostFrames::decibels(drawn, Canvas::colours()) < 30);
    }
}

TEST_CASE("gl: a renderbuffer has the bytes of the frame that was written to it") {
  const Shared shared;
  if (!shared.usable) return;
  const Canvas canvas;
  Renderer<Cuda> renderer;
  const auto scene = renderer.backend().upload(make_builtin_scene());
  const Seen seen(2, ClipSpace::opengl);
  GLuint name = 0;
  glGenRenderbuffers(1, &name);
  Canvas::attach(name, GL_RGBA8, GL_COLOR_ATTACHMENT0);
  const gl::Texture target(name, GL_RENDERBUFFER);
  DeviceBuffer<unsigned char> image;
  image.reset(colour_bytes);
  FrameView frame = seen.host.frame(image.data(), nullptr);
  renderer.render_into(scene.view(), seen.host.camera, {}, frame);
  target.write(frame, renderer.backend().stream());
  Bytes expected(colour_bytes);
  renderer.backend().download(std::as_const(image).span(), expected.data());
  CHECK(Canvas::colours() == expected);

  frame.format = PixelFormat::rgba_half;
  CHECK_THROWS_WITH_AS(
      target.write(frame, nullptr),
      "gl::Texture: 640 x 400 pixels of rgba_8, expected those of the frame, 640 x 400 pixels of rgba_half",
      std::invalid_argument);
  frame.format = PixelFormat::bgra_8;
  CHECK_THROWS_WITH_AS(target.write(frame, nullptr), doctest::Contains("pixels of rgba_8, expected "),
                       std::invalid_argument);
  for (const GLenum other : {GL_R32F, GL_RGBA16}) {
    const gl::Texture texture(make_texture(other), GL_TEXTURE_2D);
    CHECK_THROWS_WITH_AS(
        texture.write(frame, nullptr),
        "gl::Texture: the texture has another format, expected GL_RGBA8, GL_RGBA16F or GL_RGBA32F",
        std::invalid_argument);
  }
  frame = {.width = width, .height = height};
  CHECK_THROWS_WITH_AS(target.write(frame, nullptr), "gl::Texture: the frame has no colours, expected some",
                       std::invalid_argument);
}

TEST_CASE("gl: what cannot be registered is refused by the name of the call") {
  const Shared shared;
  if (!shared.usable) return;
  CHECK_THROWS_WITH_AS(gl::Buffer{4711}, doctest::Contains("cudaGraphicsGLRegisterBuffer of buffer 4711: "),
                       DeviceError);
  CHECK_THROWS_WITH_AS(gl::Texture(4711, GL_TEXTURE_2D),
                       doctest::Contains("cudaGraphicsGLRegisterImage of texture 4711: "), DeviceError);
  const GLuint depth = make_texture(GL_DEPTH_COMPONENT32F, nullptr, GL_FLOAT);
  CHECK_THROWS_WITH_AS(gl::Texture(depth, GL_TEXTURE_2D),
                       doctest::Contains("cudaGraphicsGLRegisterImage of texture "), DeviceError);
  CHECK(cudaGetLastError() == cudaSuccess);
}

TEST_CASE("gl: another device than that of the context is refused by its number") {
  const Shared shared;
  if (!shared.usable) return;
  int devices = 0;
  check_cuda(cudaGetDeviceCount(&devices), "cudaGetDeviceCount");
  if (devices < 2) return skip("one CUDA device alone");
  const GLuint name = make_pixel_buffer(100);
  check_cuda(cudaSetDevice(1), "cudaSetDevice");
  CHECK_THROWS_WITH_AS(
      gl::Buffer{name},
      "gl::Buffer: the current CUDA device is 1, expected 0, on which the OpenGL context draws", DeviceError);
  check_cuda(cudaSetDevice(0), "cudaSetDevice");
}

TEST_CASE("gl: frames in a loop take no memory") {
  const Shared shared;
  if (!shared.usable) return;
  const Canvas canvas;
  Renderer<Cuda> renderer;
  const auto scene = renderer.backend().upload(make_builtin_scene());
  const cudaStream_t stream = renderer.backend().stream();
  const GLuint name = make_pixel_buffer(colour_bytes + depth_bytes), texture = make_texture(GL_RGBA8);
  const auto draw = [&](int frames) {
    // Registered anew now and then, as when a window changes its size.
    for (int k = 0; k < frames;) {
      const gl::Buffer buffer(name);
      const gl::Texture splats(texture, GL_TEXTURE_2D);
      for (const int end = std::min(k + 50, frames); k < end; ++k) {
        const Seen seen(k % 20, ClipSpace::opengl);
        canvas.draw_box(seen.matrix);
        read_canvas(name);
        {
          const gl::Mapped memory(buffer, stream);
          auto* const first = static_cast<unsigned char*>(memory.data());
          const FrameView frame =
              seen.host.frame(first, reinterpret_cast<const float*>(first + colour_bytes));
          renderer.render_into(scene.view(), seen.host.camera, {}, frame);
          splats.write(frame, stream);
        }
        canvas.draw_over(texture);
      }
    }
    glFinish();
    check_cuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
  };
  draw(200);
  const std::size_t device = Cuda::memory_use().in_use, process = resident_memory();
  const std::ptrdiff_t files = open_files();
  draw(frames_of_loop());
  CHECK(Cuda::memory_use().in_use <= device);
  CHECK(resident_memory() < process + (std::size_t(4) << 20));
  CHECK(open_files() == files);
}
