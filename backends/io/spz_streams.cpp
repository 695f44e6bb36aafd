// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <future>
#include <string>

#include <zstd.h>

#include "spz_content.hpp"

namespace swiftgs::io {
namespace {

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

/// Unpacks one zstd frame, which must fill `size` bytes of both sides exactly.
void unpack_frame(const Source& source, std::uint64_t offset, StreamSizes size, std::byte* to) {
  const std::byte* from = source.bytes.data() + offset;
  const std::size_t unpacked = ZSTD_decompress(to, size.unpacked, from, size.packed);
  if (ZSTD_isError(unpacked))
    source.fail(offset, std::string("a valid zstd frame (") + ZSTD_getErrorName(unpacked) + ")");
  if (unpacked != size.unpacked)
    source.fail(offset, "a zstd frame of " + std::to_string(size.unpacked) + " bytes unpacked, found " +
                            std::to_string(unpacked));
}

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

  unpacking.begins(header);
  // Left uninitialised: pages are taken only as data arrives.
  content.storage = std::make_unique_for_overwrite<std::byte[]>(spz_total(header));
  split_arrays(content, content.storage.get());
  const auto unpack = [&](int a) {
    const std::ptrdiff_t at = content.arrays[a].data() - content.storage.get();
    if (table[a].unpacked != 0) unpack_frame(source, offsets[a], table[a], content.storage.get() + at);
  };
  // Harmonics are two thirds of a scene of degree 3, and all else is unpacked meanwhile.
  auto harmonics = std::async(std::launch::async, unpack, spz_sh);
  for (int a = 0; a < spz_sh; ++a) {
    unpacking.progress.report(double(a) / int(spz_attributes));
    unpack(a);
  }
  harmonics.get();
  unpacking.progress.report(1);
  return content;
}

}  // namespace swiftgs::io
