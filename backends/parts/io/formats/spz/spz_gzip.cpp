// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <new>
#include <string>

#include <zlib.h>

#include "spz_content.hpp"

namespace swiftgs::io {
namespace {

/// Deflate cannot do better, so a count that needs more than this of the file is a lie.
constexpr std::uint64_t max_ratio = 1032;
constexpr std::size_t max_extension_bytes = 1 << 16;

/// Inflates a file that is one gzip stream, as much at a time as is asked for.
class GzipReader {
 public:
  explicit GzipReader(const Source& source) : source_(source) {
    constexpr int gzip_only = 16 + MAX_WBITS;
    if (inflateInit2(&stream_, gzip_only) != Z_OK) throw std::bad_alloc();
  }
  ~GzipReader() { inflateEnd(&stream_); }
  GzipReader(const GzipReader&) = delete;
  GzipReader& operator=(const GzipReader&) = delete;

  [[noreturn]] void fail(const std::string& expected) const { source_.fail(consumed_, expected); }

  /// Inflates up to `size` bytes; fewer only at the end of the stream.
  std::size_t read(std::byte* to, std::size_t size) {
    std::size_t done = 0;
    while (done < size && !finished_) {
      const uInt input = part(source_.bytes.size() - consumed_), output = part(size - done);
      // zlib's interface is older than const.
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(source_.bytes.data() + consumed_));
      stream_.avail_in = input;
      stream_.next_out = reinterpret_cast<Bytef*>(to + done);
      stream_.avail_out = output;
      const int result = inflate(&stream_, Z_NO_FLUSH);
      consumed_ += input - stream_.avail_in;
      done += output - stream_.avail_out;
      if (result == Z_STREAM_END)
        finished_ = true;
      else if (result == Z_BUF_ERROR ||
               (result == Z_OK && consumed_ == source_.bytes.size() && stream_.avail_out != 0))
        fail("more of the gzip stream, found the end of the file");
      else if (result != Z_OK)
        fail("a valid gzip stream");
    }
    return done;
  }

  void read_exactly(std::byte* to, std::size_t size, const std::string& what, const ProgressMeter& progress) {
    constexpr std::size_t step = 1 << 24;
    for (std::size_t done = 0; done < size;) {
      const std::size_t wanted = std::min(step, size - done), got = read(to + done, wanted);
      done += got;
      if (got != wanted)
        fail(std::to_string(size) + " bytes of " + what + " in the gzip stream, found " +
             std::to_string(done));
      progress.report(double(done) / double(size));
    }
  }

  /// Bytes inflated so far, those before an error included.
  std::size_t inflated() const { return stream_.total_out; }

  /// Throws unless the stream and the file end here.
  void expect_end() {
    std::byte extra;
    if (read(&extra, 1) != 0) fail("the end of the gzip stream after the last Gaussian");
    if (consumed_ != source_.bytes.size()) fail("the end of the file after the gzip stream");
  }

 private:
  static uInt part(std::size_t size) { return uInt(std::min<std::size_t>(size, 1u << 30)); }

  const Source& source_;
  z_stream stream_{};
  std::size_t consumed_ = 0;
  bool finished_ = false;
};

SpzHeader read_header(const Source& source, GzipReader& reader, const ProgressMeter& progress) {
  std::array<std::byte, spz_header_size> first;
  reader.read_exactly(first.data(), first.size(), "header", progress.step(0, 0));
  const SpzHeader header = parse_spz_header(source, first.data());
  if (header.version > 3) source.fail(4, "SPZ version 1 to 3 in a gzip stream");
  return header;
}

}  // namespace

SpzHeader read_spz_gzip_header(const Source& source) {
  GzipReader reader(source);
  const Progress none;
  return read_header(source, reader, ProgressMeter(none, source.name));
}

std::string gzip_beginning(std::string_view file, std::size_t most) {
  const Source source{std::as_bytes(std::span(file)), "gzip"};
  GzipReader reader(source);
  std::string beginning(most, '\0');
  try {
    reader.read(reinterpret_cast<std::byte*>(beginning.data()), most);
  } catch (const FormatError&) {
  }
  beginning.resize(reader.inflated());
  return beginning;
}

bool is_gzip_of_spz(std::string_view file) {
  if (!file.starts_with("\x1f\x8b")) return false;
  const std::string beginning = gzip_beginning(file, 4);
  return beginning.size() < 4 || beginning == "NGSP";
}

SpzContent unpack_spz_gzip(const Source& source, const SpzUnpacking& unpacking) {
  GzipReader reader(source);
  SpzContent content{.header = read_header(source, reader, unpacking.progress)};
  const std::size_t size = spz_total(content.header);
  if (size / max_ratio > source.bytes.size())
    source.fail(8, "a file that can hold " + std::to_string(content.header.count) + " Gaussians");
  // Left uninitialised: pages are taken only as data arrives, so a short stream takes little.
  content.storage = std::make_unique_for_overwrite<std::byte[]>(size);
  const std::size_t others = size - content.header.count * spz_sizes(content.header)[spz_sh];
  const double part = double(others) / double(size);
  reader.read_exactly(content.storage.get(), others, "Gaussians", unpacking.progress.step(0, part));
  unpacking.unpacked(content.header);
  reader.read_exactly(content.storage.get() + others, size - others, "harmonics",
                      unpacking.progress.step(part, 1));
  split_arrays(content, content.storage.get());

  if (content.header.has_extensions) {
    std::array<std::byte, max_extension_bytes> records;
    const std::size_t length = reader.read(records.data(), records.size());
    content.extensions = parse_spz_extensions(source, std::span(records).first(length), {});
  }
  reader.expect_end();
  return content;
}

SpzContent unpack_spz_plain(const Source& source, const SpzUnpacking& unpacking) {
  ByteReader reader(source);
  SpzContent content{.header = parse_spz_header(source, reader.take(spz_header_size, "an SPZ header"))};
  const std::size_t size = spz_total(content.header);
  split_arrays(content, reader.take(size, "Gaussians"));
  if (content.header.has_extensions) {
    const std::uint64_t offset = reader.position();
    content.extensions = parse_spz_extensions(source, source.bytes.subspan(offset), offset);
  } else {
    reader.expect_end("the last Gaussian");
  }
  unpacking.unpacked(content.header);
  return content;
}

}  // namespace swiftgs::io
