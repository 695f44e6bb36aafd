// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/io/scene_file.hpp>

#include "scenes.hpp"
#include "spz_encoder.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

void read_file(const std::string& content) { read_scene(as_bytes(content), "test.spz"); }

std::string complaint_about(const std::string& content) {
  return complaint([&] { read_file(content); });
}

SpzParts parts_of(std::uint32_t version, int degree = 1) {
  return encode_spz(some_scene(3, degree), version);
}

template <class T>
std::string with(std::string content, std::size_t offset, T value) {
  std::string raw;
  append(raw, value);
  return content.replace(offset, raw.size(), raw);
}

}  // namespace

TEST_CASE("spz: a file that ends early is refused wherever it ends") {
  for (std::uint32_t version = 1; version <= 3; ++version) {
    check_every_truncation(gzip_spz(parts_of(version)), read_file);
    check_every_truncation(plain_spz(parts_of(version)), read_file);
  }
  check_every_truncation(stream_spz(parts_of(4)), read_file);
  SpzParts parts = parts_of(4);
  parts.flags = 2, parts.extensions = coordinate_system(4);
  check_every_truncation(stream_spz(parts), read_file);
}

TEST_CASE("spz: bytes after the end are refused") {
  for (std::uint32_t version = 1; version <= 4; ++version) {
    CHECK(contains(complaint_about(pack_spz(parts_of(version)) + "x"), "end of the file"));
    if (version < 4) {
      CHECK(contains(complaint_about(gzip(plain_spz(parts_of(version)) + "x")), "after the last Gaussian"));
      CHECK(contains(complaint_about(plain_spz(parts_of(version)) + "x"), "after the last Gaussian"));
    }
  }
}

TEST_CASE("spz: a header that lies is refused before memory is taken") {
  for (const std::uint32_t version : {1u, 2u, 3u, 4u}) {
    CAPTURE(version);
    for (const std::uint32_t count : {2147483647u, 5000000u, 4u, 2u}) {
      SpzParts parts = parts_of(version);
      parts.count = count;
      CHECK(complaint_about(pack_spz(parts)) != "");
      if (version < 4) CHECK(complaint_about(plain_spz(parts)) != "");
    }
    SpzParts parts = parts_of(version);
    parts.count = 0;
    CHECK(contains(complaint_about(pack_spz(parts)), "byte 8: expected 1 to 2147483647 Gaussians"));
    parts.count = 0x80000000;
    CHECK(contains(complaint_about(pack_spz(parts)), "byte 8: expected 1 to 2147483647 Gaussians"));
    parts = parts_of(version), parts.sh_degree = 5;
    CHECK(contains(complaint_about(pack_spz(parts)), "byte 12: expected SH degree"));
    parts = parts_of(version), parts.fractional_bits = 31;
    CHECK(contains(complaint_about(pack_spz(parts)), "byte 13") == (version != 1));  // halves have none
  }
}

TEST_CASE("spz: versions that do not exist are refused") {
  for (const std::uint32_t version : {0u, 5u, 4294967295u}) {
    SpzParts parts = parts_of(2);
    parts.version = version;
    CHECK(contains(complaint_about(gzip_spz(parts)), "SPZ version 1 to 4"));
    CHECK(contains(complaint_about(plain_spz(parts)), "SPZ version 1 to 4"));
  }
  CHECK(contains(complaint_about(gzip_spz(parts_of(4))), "version 1 to 3 in a gzip stream"));
}

TEST_CASE("spz: gzip around something else is refused") {
  CHECK(
      contains(complaint_about(gzip("a text that is not a scene at all")), "a gzip file of something else"));
  CHECK(contains(complaint_about(gzip("sho")), "header"));
  std::string damaged = gzip_spz(parts_of(3));
  damaged[damaged.size() - 6] ^= 1;  // in the checksum
  CHECK(contains(complaint_about(damaged), "valid gzip stream"));
}

TEST_CASE("spz: a bomb unpacks no further than its header says") {
  SpzParts parts = parts_of(3, 0);
  parts.extensions = std::string(100'000'000, '\0');
  CHECK(contains(complaint_about(gzip_spz(parts)), "after the last Gaussian"));
  parts.flags = 2;
  CHECK(contains(complaint_about(gzip_spz(parts)), "after the last Gaussian"));
}

TEST_CASE("spz: damaged streams of version 4 are refused") {
  const std::string file = stream_spz(parts_of(4));
  CHECK(contains(complaint_about(with(file, 15, std::uint8_t(5))), "6 streams, found 5"));
  CHECK(contains(complaint_about(with(file, 16, std::uint32_t(31))), "table of contents"));
  CHECK(contains(complaint_about(with(file, 16, std::uint32_t(1) << 31)), "table of contents"));
  CHECK(contains(complaint_about(with(file, 32, ~std::uint64_t(0))), "for a stream"));
  CHECK(contains(complaint_about(with(file, 32, std::uint64_t(3))), "one zstd frame of 3 bytes"));
  CHECK(contains(complaint_about(with(file, 40, std::uint64_t(1) << 40)), "unpacks to 27 bytes"));
  // All that stands outside of the frames claims a fourth Gaussian.
  std::string longer = with(file, 8, std::uint32_t(4));
  for (const auto& [stream, size] : {std::pair{0u, 9u}, {1u, 1u}, {2u, 3u}, {3u, 3u}, {4u, 4u}, {5u, 9u}})
    longer = with(longer, 40 + 16 * stream, std::uint64_t(4 * size));
  CHECK(contains(complaint_about(longer), "a zstd frame of 36 bytes unpacked, found 27"));
  const std::size_t first_frame = 32 + 6 * 16;
  CHECK(contains(complaint_about(with(file, first_frame, std::uint32_t(0))), "zstd frame"));
  for (std::size_t i = first_frame; i < file.size(); ++i)
    CHECK_NOTHROW(complaint_about(with(file, i, char(file[i] ^ 0x55))));
}

TEST_CASE("spz: damaged extensions are refused") {
  for (const std::uint32_t version : {3u, 4u}) {
    SpzParts parts = parts_of(version);
    parts.flags = 2;
    parts.extensions = spz_extension(1, "payload");
    parts.extensions.pop_back();
    CHECK(contains(complaint_about(pack_spz(parts)), "extension of at most 6 bytes"));
    parts.extensions = "short";
    CHECK(contains(complaint_about(pack_spz(parts)), "at least 8 bytes"));
    parts.extensions = spz_extension(0xADBE0003, "12345");
    CHECK(contains(complaint_about(pack_spz(parts)), "4 bytes"));
    parts.extensions = coordinate_system(17);
    CHECK(contains(complaint_about(pack_spz(parts)), "0 to 16, found 17"));
    parts.extensions = spz_extension(1, "payload") + coordinate_system(4294967295);
    // The header of version 4 has 32 bytes, that of an extension 8; version 3 is unpacked first.
    const std::string place = version == 4 ? "byte 55: " : "byte 0: ";
    CHECK(contains(complaint_about(pack_spz(parts)), place + "expected an SPZ coordinate system"));
  }
}
