// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Images and depth buffers of OpenGL for frames of `Cuda`, without a copy to the host. Whatever is called
/// here needs the context current, and the device that `device` names.

#include <cstddef>
#include <memory>

#include <swiftgs/cuda/backend.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/frame/api.hpp>

struct cudaGraphicsResource;

namespace swiftgs::gl {

/// CUDA's number of the GPU that the current context draws on. Throws `DeviceError` where CUDA has none, as
/// of a context that draws in software.
SWIFTGS_API int device();

namespace detail {
struct Unregister {
  SWIFTGS_API void operator()(cudaGraphicsResource* resource) const;
};
using Registered = std::unique_ptr<cudaGraphicsResource, Unregister>;

class Mapping {
 public:
  SWIFTGS_API Mapping(cudaGraphicsResource* resource, cudaStream_t stream);
  SWIFTGS_API ~Mapping();
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

 private:
  cudaGraphicsResource* resource_;
  cudaStream_t stream_;
};
}  // namespace detail

/// A buffer object, such as a pixel buffer, that CUDA may write and read. It keeps its storage as long as
/// this lives.
class Buffer {
 public:
  /// By the buffer's name. Throws `DeviceError` on another device than `device()`, or for no buffer with
  /// storage.
  SWIFTGS_API explicit Buffer(unsigned name);

 private:
  friend class Mapped;
  detail::Registered registered_;
};

/// A buffer's memory while CUDA has it, for planes of frames. OpenGL must not use the buffer meanwhile.
///
/// Orders OpenGL's earlier work before the stream's later work, and the stream's work until the destructor
/// before OpenGL's work after it. Memory may move from one mapping to the next. The buffer must outlive this.
class Mapped {
 public:
  SWIFTGS_API Mapped(const Buffer& buffer, cudaStream_t stream);

  void* data() const { return data_; }
  std::size_t bytes() const { return bytes_; }

 private:
  detail::Mapping mapping_;
  void* data_ = nullptr;
  std::size_t bytes_ = 0;
};

/// A texture or renderbuffer that frames are copied to. It keeps its storage as long as this lives.
class Texture {
 public:
  /// By the texture's name and its target, such as GL_TEXTURE_2D or GL_RENDERBUFFER. Its format is GL_RGBA8,
  /// GL_RGBA16F or GL_RGBA32F; CUDA takes no depth, and does not tell GL_RGBA8UI from the first. Throws as
  /// `Buffer`.
  SWIFTGS_API Texture(unsigned name, unsigned target);

  /// Copies the colours of `frame`, in memory of the device, behind all earlier work of `stream`. Later work
  /// of OpenGL sees them. Rows keep their order in memory, while OpenGL's textures begin with the bottom row.
  /// Throws `InvalidArgument` if sizes or formats differ.
  SWIFTGS_API void write(const FrameView& frame, cudaStream_t stream) const;

 private:
  detail::Registered registered_;
};

}  // namespace swiftgs::gl
