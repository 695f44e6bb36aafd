// SPDX-License-Identifier: Apache-2.0
/// @file
/// What holds for the readers of all scenes, each with small files.
#include "compressed_ply_text.hpp"
#include "gltf_encoder.hpp"
#include "ply_text.hpp"
#include "sog_encoder.hpp"
#include "spz_encoder.hpp"

namespace swiftgs::test::formats_test {

namespace {

struct File {
  std::string name, content;
};

std::vector<File> plys() {
  PlyParts list{.after = "element extra 1\nproperty list ushort double values\n"};
  append_value(list.after_rows, "ushort", 2);
  append_value(list.after_rows, "double", 1), append_value(list.after_rows, "double", 2);
  CompressedPly compressed;
  compressed.harmonics = 9, compressed.sh = "123456789";
  return {{"PLY", ply(plain_gaussian(), {.repeat = 2})},
          {"big PLY", ply(plain_gaussian(), {.format = "binary_big_endian", .line_break = "\r\n"})},
          {"PLY with a list", ply(plain_gaussian(), list)},
          {"compressed PLY", compressed.text()}};
}

/// Of every version, packed and, where that may be, not.
std::vector<File> spzs(const Scene& scene) {
  std::vector<File> files;
  for (std::uint32_t version = 1; version <= 4; ++version) {
    SpzParts parts = encode_spz(scene, version);
    const std::string name = "SPZ " + std::to_string(version);
    files.push_back({name, pack_spz(parts)});
    if (version < 4) files.push_back({name + " unpacked", plain_spz(parts)});
    parts.flags = 2, parts.extensions = coordinate_system(4);
    if (version == 4) files.push_back({name + " with an extension", pack_spz(parts)});
  }
  return files;
}

std::vector<File> all_files() {
  std::vector<File> files = plys();
  for (File& file : spzs(some_scene(3, 1))) files.push_back(std::move(file));
  const GltfParts gltf_parts = encode_gltf(some_scene(3, 1));
  const GltfParts spz_inside =
      gltf_with_spz(gzip_spz(encode_spz(some_scene(9, 1), 2)), "KHR_gaussian_splatting_compression_spz_2");
  files.push_back({"glb", glb(gltf_parts)});
  files.push_back({"gltf", gltf(gltf_parts)});
  files.push_back({"glb with SPZ", glb(spz_inside)});
  files.push_back({"SOG", sog_bundle(encode_sog(some_scene(5, 1), 2))});
  files.push_back(
      {"SOG 1", sog_bundle(encode_sog(some_scene(5, 0), 1), {.deflate = true, .sizes_follow = true})});
  return files;
}

}  // namespace

TEST_CASE("formats: a file that ends early is refused wherever it ends") {
  for (const auto& [name, content] : all_files()) {
    CAPTURE(name);
    check_every_truncation(content, [](const std::string& part) { read(part); });
  }
}

TEST_CASE("formats: damaged bytes never do more than throw") {
  for (const auto& [name, content] : all_files()) {
    CAPTURE(name);
    check_every_damage(content, 0x55, [](const std::string& damaged) { read(damaged); });
  }
}

TEST_CASE("formats: reading can be watched and cancelled") {
  for (const auto& [name, content] : all_files()) {
    CAPTURE(name);
    Listener reading;
    read(content, "a.spz", {.progress = reading.progress()});  // the content decides and not the name
    CHECK(std::is_sorted(reading.told.begin(), reading.told.end()));
    CHECK(reading.told.back() == 1);
    // Cancelled at once, while it unpacks, and while it decodes.
    for (const double at : {0.0, 0.5, 0.7}) {
      const Progress until = [&](double part) { return part < at; };
      CHECK_THROWS_AS(read(content, "a.spz", {.progress = until}), Cancelled);
    }
  }
}

}  // namespace swiftgs::test::formats_test
