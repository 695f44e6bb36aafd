// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <future>
#include <memory>
#include <new>
#include <string>

#include <zstd.h>

#include "spz_content.hpp"

namespace swiftgs::io {
namespace {

constexpr std::chrono::milliseconds between_reports(50);

struct StreamSizes {
  std::uint64_t packed, unpacked;
};

/// Reads the table of contents and checks it against the header and the file, before any memory is taken.
std::array<StreamSizes, spz_attributes> read_table(ByteReader& reader, const SpzHeader& header) {
  const auto sizes = spz_sizes(header);
  std::array<StreamSizes, spz_attributes> table{};
  for (int a = 0; a < spz_attributes; ++a) {
    const std::uint64_t expected = header.count * sizes[a];
    if (expected == 0) continue;  // an attribute without bytes has no stream
    table[a] = {reader.read<std::uint64_t>("a stream size"), reader.read<std::uint64_t>("a stream size")};
    if (table[a].unpacked != expected)
      reader.fail("a stream that unpacks to " + std::to_string(expected) + " bytes, found " +
                  std::to_string(table[a].unpacked));
  }
  return table;
}

/// Throws unless a stream is one zstd frame which does not deny its size. Takes no memory.
void check_frame(const Source& source, std::uint64_t offset, StreamSizes size) {
  const std::byte* from = source.bytes.data() + offset;
  if (ZSTD_findFrameCompressedSize(from, size.packed) != size.packed)
    source.fail(offset, "one zstd frame of " + std::to_string(size.packed) + " bytes");
  const unsigned long long stated = ZSTD_getFrameContentSize(from, size.packed);
  if (stated != size.unpacked && stated != ZSTD_CONTENTSIZE_UNKNOWN)
    source.fail(offset, "a zstd frame of " + std::to_string(size.unpacked) + " bytes unpacked, found " +
                            std::to_string(stated));
}

/// Unpacks frames, from several threads and in steps, so that it can be told how far they are, and stopped.
class FrameUnpacker {
 public:
  explicit FrameUnpacker(const Source& source) : source_(source) {}

  /// Unpacks one zstd frame, which must fill `size` bytes of both sides exactly, or until `stop`. `report`
  /// is called after every step.
  template <class Report>
  void unpack(std::uint64_t offset, StreamSizes size, std::byte* to, const Report& report) {
    const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
    if (!context) throw std::bad_alloc();
    // A frame need not look back farther than it is long, and zstd takes no more memory than that for it. Of
    // short ones without a stated size, some look back 8 MB, as decoders are asked to allow.
    const int window = std::clamp(int(std::bit_width(size.unpacked - 1)), 23, 31);
    ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, window);
    ZSTD_inBuffer in{source_.bytes.data() + offset, 0, 0};
    ZSTD_outBuffer out{to, 0, 0};
    for (std::size_t left = 1; left != 0 && !stopped_;) {
      const std::size_t read = in.pos, wrote = out.pos;
      in.size = std::min<std::size_t>(in.pos + step, size.packed);
      out.size = std::min<std::size_t>(out.pos + 8 * step, size.unpacked);
      left = ZSTD_decompressStream(context.get(), &out, &in);
      if (ZSTD_isError(left))
        source_.fail(offset + in.pos, std::string("a valid zstd frame (") + ZSTD_getErrorName(left) + ")");
      if (left != 0 && in.pos == read && out.pos == wrote && in.size == size.packed &&
          out.size == size.unpacked)
        source_.fail(offset,
                     "a zstd frame of " + std::to_string(size.unpacked) + " bytes unpacked, found more");
      done_ += out.pos - wrote;
      report();
    }
    if (!stopped_ && out.pos != size.unpacked)
      source_.fail(offset, "a zstd frame of " + std::to_string(size.unpacked) + " bytes unpacked, found " +
                               std::to_string(out.pos));
  }

  /// Has all threads return after their current steps.
  void stop() { stopped_ = true; }

  std::uint64_t done() const { return done_; }  ///< bytes unpacked

 private:
  static constexpr std::size_t step = 1 << 20;

  const Source& source_;
  std::atomic<std::uint64_t> done_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace

SpzContent unpack_spz_streams(const Source& source, const SpzUnpacking& unpacking) {
  ByteReader reader(source);
  const std::byte* first = reader.take(spz_streams_header_size, "the header of SPZ version 4");
  SpzContent content{.header = parse_spz_header(source, first)};
  const SpzHeader& header = content.header;
  const int streams = std::to_integer<int>(first[15]), expected_streams = header.sh_degree == 0 ? 5 : 6;
  const auto table_offset = load<std::uint32_t>(first + 16);
  // A bound on what zstd may unpack from this file; the format's own.
  if (header.count > source.bytes.size() * 1024 / 9)
    source.fail(8, "a file that can hold " + std::to_string(header.count) + " Gaussians");
  if (streams != expected_streams)
    source.fail(15, std::to_string(expected_streams) + " streams, found " + std::to_string(streams));
  if (table_offset < spz_streams_header_size || table_offset > source.bytes.size())
    source.fail(16, "a table of contents inside the file");
  if (header.has_extensions)
    content.extensions = parse_spz_extensions(
        source, source.bytes.subspan(spz_streams_header_size, table_offset - spz_streams_header_size),
        spz_streams_header_size);

  ByteReader table_reader(source, table_offset);
  const auto table = read_table(table_reader, header);
  std::array<std::uint64_t, spz_attributes> offsets{};
  for (int a = 0; a < spz_attributes; ++a) {
    offsets[a] = table_reader.position();
    table_reader.take(table[a].packed, "a stream");
    if (table[a].unpacked != 0) check_frame(source, offsets[a], table[a]);
  }
  table_reader.expect_end("the last stream");

  // Left uninitialised: pages are taken only as data arrives.
  content.storage = std::make_unique_for_overwrite<std::byte[]>(spz_total(header));
  split_arrays(content, content.storage.get());
  FrameUnpacker unpacker(source);
  const auto unpack = [&](int a, const auto& report) {
    const std::ptrdiff_t at = content.arrays[a].data() - content.storage.get();
    if (table[a].unpacked != 0) unpacker.unpack(offsets[a], table[a], content.storage.get() + at, report);
  };
  const auto report = [&] { unpacking.progress.report(double(unpacker.done()) / double(spz_total(header))); };
  // Harmonics are two thirds of a scene of degree 3, and all else is unpacked meanwhile.
  auto harmonics = std::async(std::launch::async, unpack, int(spz_sh), [] {});
  try {
    report();
    for (int a = 0; a < spz_sh; ++a) unpack(a, report);
    unpacking.unpacked(header);
    while (harmonics.wait_for(between_reports) != std::future_status::ready) report();
  } catch (...) {
    unpacker.stop();  // before the future waits for its thread
    throw;
  }
  harmonics.get();
  report();
  return content;
}

}  // namespace swiftgs::io
