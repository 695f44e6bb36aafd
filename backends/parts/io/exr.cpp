// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>

#include <swiftgs/error.hpp>

#include "image_parsing.hpp"
#include "output_file.hpp"

namespace swiftgs {
namespace io {
namespace {

/// Lets OpenEXR read from memory.
class MemoryStream : public Imf::IStream {
 public:
  explicit MemoryStream(const Source& source) : Imf::IStream(source.name.c_str()), bytes_(source.bytes) {}

  bool read(char to[], int size) override {
    if (size < 0 || std::size_t(size) > bytes_.size() - position_)
      throw std::runtime_error("the file ends too early");
    std::memcpy(to, bytes_.data() + position_, std::size_t(size));
    position_ += std::size_t(size);
    return position_ < bytes_.size();
  }

  std::uint64_t tellg() override { return position_; }

  void seekg(std::uint64_t position) override {
    if (position > bytes_.size()) throw std::runtime_error("an offset lies outside the file");
    position_ = position;
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
};

/// Lets OpenEXR write to memory: it goes back to fill in a table, which a pipe does not allow.
class MemoryOutput : public Imf::OStream {
 public:
  MemoryOutput() : Imf::OStream("memory") {}

  void write(const char from[], int size) override {
    const std::size_t end = position_ + std::size_t(size);
    if (bytes_.size() < end) bytes_.resize(end);
    std::memcpy(bytes_.data() + position_, from, std::size_t(size));
    position_ = end;
  }

  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }

  const std::vector<char>& bytes() const { return bytes_; }

 private:
  std::vector<char> bytes_;
  std::size_t position_ = 0;
};

std::vector<const char*> channels_of(const Source& source, const Imf::ChannelList& channels) {
  std::vector<const char*> names;
  if (channels.findChannel("R") && channels.findChannel("G") && channels.findChannel("B"))
    names = {"R", "G", "B"};
  else if (channels.findChannel("Y"))
    names = {"Y"};
  else
    source.fail(0, "an EXR with channels R, G, B or Y");
  for (const char* name : names)
    if (const auto* channel = channels.findChannel(name); channel->xSampling != 1 || channel->ySampling != 1)
      source.fail(0, "an EXR without subsampled channels");
  if (channels.findChannel("A")) names.push_back("A");
  return names;
}

Image parse(const Source& source) {
  MemoryStream stream(source);
  Imf::InputFile file(stream);
  const Imath::Box2i window = file.header().dataWindow();
  const std::int64_t width = std::int64_t(window.max.x) - window.min.x + 1;
  const std::int64_t height = std::int64_t(window.max.y) - window.min.y + 1;
  // The densest compression is deflate's, over two bytes a pixel.
  expect_plausible_size(source, 0, std::uint64_t(std::max<std::int64_t>(width, 0)),
                        std::uint64_t(std::max<std::int64_t>(height, 0)), 1032);
  const auto names = channels_of(source, file.header().channels());
  Image image{.width = int(width), .height = int(height), .channels = int(names.size())};
  image.pixels.resize(std::size_t(width * height) * names.size());

  const std::size_t x_stride = names.size() * sizeof(float), y_stride = x_stride * std::size_t(width);
  const Imath::Box2i pixels = window;
  Imf::FrameBuffer target;
  for (std::size_t c = 0; c < names.size(); ++c)
    target.insert(names[c],
                  Imf::Slice::Make(Imf::FLOAT, image.pixels.data() + c, pixels, x_stride, y_stride));
  file.setFrameBuffer(target);
  file.readPixels(window.min.y, window.max.y);
  return image;
}

std::string channel_name(const PlaneRow& plane, std::size_t c) {
  return plane.channels != 0 ? plane.channel_names[c] : plane.channel_names[0] + std::to_string(c);
}

}  // namespace

Image parse_exr(const Source& source) {
  try {
    return parse(source);
  } catch (const FormatError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    std::string reason = error.what();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    source.fail(0, "a valid EXR (" + reason + ")");
  }
}

}  // namespace io

void write_exr(const std::filesystem::path& path, const Frame& frame) {
  io::expect_colour(frame);
  Imf::Header header(frame.width, frame.height);
  Imf::FrameBuffer source;
  const auto add = [&]<class T>(std::size_t channels, const std::vector<T>& values, const PlaneRow& plane) {
    const Imf::PixelType type = std::is_same_v<T, float> ? Imf::FLOAT : Imf::UINT;
    for (std::size_t c = 0; values.size() == channels * frame.pixels() && c < channels; ++c) {
      const std::string name = io::channel_name(plane, c);
      header.channels().insert(name, Imf::Channel(type));
      // OpenEXR's slices are mutable even where it only reads.
      char* base = reinterpret_cast<char*>(const_cast<T*>(values.data() + c));
      const std::size_t stride = channels * sizeof(T);
      source.insert(name, Imf::Slice(type, base, stride, stride * std::size_t(frame.width)));
    }
  };
  for_each_plane(add, frame, plane_table);
  io::MemoryOutput encoded;
  try {
    Imf::OutputFile file(encoded, header);
    file.setFrameBuffer(source);
    file.writePixels(frame.height);
  } catch (const std::exception& error) {
    throw Unavailable(path.string() + ": EXR encoder: " + error.what());
  }
  io::OutputFile file(path);
  file.write(encoded.bytes().data(), encoded.bytes().size());
  file.close();
}

}  // namespace swiftgs
