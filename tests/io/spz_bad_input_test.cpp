// SPDX-License-Identifier: Apache-2.0
#include "scenes.hpp"
#include "spz_encoder.hpp"

namespace swiftgs::test::spz_bad_input_test {

namespace {

SpzParts parts_of(std::uint32_t version, int degree = 1) {
  return encode_spz(some_scene(3, degree), version);
}

}  // namespace

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
    for (const std::uint32_t count : {0u, 0x80000000u}) {
      parts.count = count;
      CHECK(contains(complaint_about(pack_spz(parts)), "byte 8: expected 1 to 2147483647 Gaussians"));
    }
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
  CHECK(contains(complaint_about(gzip("a text that is not a scene at all")), "gzip file of something else"));
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
  const std::pair<std::string, const char*> cases[] = {
      {with(file, 15, std::uint8_t(5)), "6 streams, found 5"},
      {with(file, 16, 31u), "table of contents"},
      {with(file, 16, 1u << 31), "table of contents"},
      {with(file, 32, ~std::uint64_t(0)), "for a stream"},
      {with(file, 32, std::uint64_t(3)), "one zstd frame of 3 bytes"},
      {with(file, 40, std::uint64_t(1) << 40), "unpacks to 27 bytes"},
      {with(file, 32 + 6 * 16, 0u), "zstd frame"}};
  for (const auto& [damaged, expected] : cases) CHECK(contains(complaint_about(damaged), expected));
  // All that stands outside of the frames claims a fourth Gaussian.
  std::string longer = with(file, 8, std::uint32_t(4));
  for (const auto& [stream, size] : {std::pair{0u, 9u}, {1u, 1u}, {2u, 3u}, {3u, 3u}, {4u, 4u}, {5u, 9u}})
    longer = with(longer, 40 + 16 * stream, std::uint64_t(4 * size));
  CHECK(contains(complaint_about(longer), "a zstd frame of 36 bytes unpacked, found 27"));
}

TEST_CASE("spz: damaged extensions are refused") {
  for (const std::uint32_t version : {3u, 4u}) {
    // The header of version 4 has 32 bytes, that of an extension 8; version 3 is unpacked first.
    const std::string place = version == 4 ? "byte 55: " : "byte 0: ";
    const std::string whole = spz_extension(1, "payload");
    const std::pair<std::string, std::string> cases[] = {
        {whole.substr(0, whole.size() - 1), "extension of at most 6 bytes"},
        {"short", "at least 8 bytes"},
        {spz_extension(0xADBE0003, "12345"), "4 bytes"},
        {coordinate_system(17), "0 to 16, found 17"},
        {whole + coordinate_system(4294967295), place + "expected an SPZ coordinate system"}};
    SpzParts parts = parts_of(version);
    parts.flags = 2;
    for (const auto& [extensions, expected] : cases) {
      parts.extensions = extensions;
      CHECK(contains(complaint_about(pack_spz(parts)), expected));
    }
  }
}

}  // namespace swiftgs::test::spz_bad_input_test
