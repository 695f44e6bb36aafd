// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <cuda_gl_interop.h>

#include <swiftgs/cuda/check.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/gl.hpp>

#include "copy_to_array.hpp"

namespace swiftgs::gl {

namespace {

void require_device(const char* caller) {
  const int expected = device();
  int current = 0;
  check_cuda(cudaGetDevice(&current), "cudaGetDevice");
  if (current != expected)
    throw DeviceError(caller, "the current CUDA device is " + std::to_string(current) + ", expected " +
                                  std::to_string(expected) + ", on which the OpenGL context draws");
}

PixelFormat format_of(cudaArray_t texture) {
  cudaChannelFormatDesc of{};
  check_cuda(cudaArrayGetInfo(&of, nullptr, nullptr, texture), "cudaArrayGetInfo");
  const bool is_float = of.f == cudaChannelFormatKindFloat;
  if (of.w == 8 && !is_float) return PixelFormat::rgba_8;
  if (of.w == 16 && is_float) return PixelFormat::rgba_half;
  if (of.w == 32 && is_float) return PixelFormat::rgba_float;
  throw InvalidArgument(
      "gl::Texture: the texture has another format, expected GL_RGBA8, GL_RGBA16F or GL_RGBA32F");
}

}  // namespace

int device() {
  unsigned count = 0;
  int found = 0;
  check_cuda(cudaGLGetDevices(&count, &found, 1, cudaGLDeviceListAll), "cudaGLGetDevices");
  if (count == 0)
    throw DeviceError("cudaGLGetDevices",
                      "the OpenGL context draws on no device of CUDA, expected an NVIDIA GPU");
  return found;
}

void detail::Unregister::operator()(cudaGraphicsResource* resource) const {
  cudaGraphicsUnregisterResource(resource);
}

detail::Mapping::Mapping(cudaGraphicsResource* resource, cudaStream_t stream)
    : resource_(resource), stream_(stream) {
  check_cuda(cudaGraphicsMapResources(1, &resource_, stream_), "cudaGraphicsMapResources");
}

detail::Mapping::~Mapping() { cudaGraphicsUnmapResources(1, &resource_, stream_); }

Buffer::Buffer(unsigned name) {
  require_device("gl::Buffer");
  cudaGraphicsResource* registered = nullptr;
  check_cuda(cudaGraphicsGLRegisterBuffer(&registered, name, cudaGraphicsRegisterFlagsNone),
             ("gl::Buffer: cudaGraphicsGLRegisterBuffer of buffer " + std::to_string(name)).c_str());
  registered_.reset(registered);
}

Mapped::Mapped(const Buffer& buffer, cudaStream_t stream) : mapping_(buffer.registered_.get(), stream) {
  check_cuda(cudaGraphicsResourceGetMappedPointer(&data_, &bytes_, buffer.registered_.get()),
             "cudaGraphicsResourceGetMappedPointer");
}

Texture::Texture(unsigned name, unsigned target) {
  require_device("gl::Texture");
  cudaGraphicsResource* registered = nullptr;
  check_cuda(cudaGraphicsGLRegisterImage(&registered, name, target, cudaGraphicsRegisterFlagsWriteDiscard),
             ("gl::Texture: cudaGraphicsGLRegisterImage of texture " + std::to_string(name)).c_str());
  registered_.reset(registered);
}

void Texture::write(const FrameView& frame, cudaStream_t stream) const {
  const detail::Mapping mapping(registered_.get(), stream);
  cudaArray_t array = nullptr;
  check_cuda(cudaGraphicsSubResourceGetMappedArray(&array, registered_.get(), 0, 0),
             "cudaGraphicsSubResourceGetMappedArray");
  copy_to_array(frame, array, format_of(array), stream, "gl::Texture");
}

}  // namespace swiftgs::gl
