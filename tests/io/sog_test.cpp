// SPDX-License-Identifier: Apache-2.0
#include "png_encoder.hpp"
#include "scenes.hpp"
#include "sog_encoder.hpp"

namespace swiftgs::test::sog_test {

using test::read;

namespace {

SceneFile read(const SogParts& parts) { return test::read(sog_bundle(parts)); }

void check_decoded(const Scene& scene, const Scene& read, int version) {
  const Difference apart = difference(scene, read);
  // Means are within 5, so log(1 + |x|) within 1.8, and a step of it is at most 6 times as long in x.
  CHECK(apart.means < 6 * 1.8 / 65535 + 1e-6);
  CHECK(apart.scales < 3.0 / 255 + 1e-5);
  CHECK(apart.sh0 < 1.0 / 255 + 1e-6);
  // Of version 1 opacities are logits, here within 4.6, and a step makes at most a quarter of it.
  CHECK(apart.opacities < (version == 1 ? 4.6 / 4 : 0.5) / 255 + 1e-6);
  CHECK(apart.rotations < std::sqrt(2 * 3e-5));
  for (const Quaternion& q : read.rotations)
    CHECK(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z == doctest::Approx(1).epsilon(1e-6));
  if (scene.sh_degree > 0) CHECK(apart.sh_rest < SogGrid::around(scene.sh_rest).step() / 2 + 1e-6);
}

/// The place of Gaussian `i`, channel `c`, in a picture.
char& at(SogParts& parts, const char* picture, std::size_t i, int c) {
  return parts.pictures[picture].rgba[4 * i + std::size_t(c)];
}

}  // namespace

TEST_CASE("sog: both versions and every degree are decoded within their quantisation") {
  for (int version = 1; version <= 2; ++version)
    for (int degree = 0; degree <= 3; ++degree) {
      CAPTURE(version);
      CAPTURE(degree);
      Scene scene = some_scene(150, degree);
      // What is transparent keeps its colour.
      if (version == 2) scene.opacities[3] = 1, scene.opacities[4] = scene.opacities[5] = 0;
      const SceneFile file = read(encode_sog(scene, version));
      check_whole(file, "SOG version " + std::to_string(version), scene.size());
      CHECK(!file.scene.model.antialiased);
      check_decoded(scene, file.scene, version);
    }
}

TEST_CASE("sog: bytes are decoded to the number that they stand for") {
  SogParts parts = encode_sog(some_scene(5, 1), 2);
  parts.meta["means"]["mins"] = {-2, -1, 0}, parts.meta["means"]["maxs"] = {2, 3, 4};
  for (int c = 0; c < 3; ++c) {
    at(parts, "means_l.webp", 2, c) = char(0x34), at(parts, "means_u.webp", 2, c) = char(0x12);
    at(parts, "quats.webp", 2, c) = char(0);
  }
  at(parts, "quats.webp", 2, 3) = char(255);
  at(parts, "quats.webp", 3, 0) = char(255), at(parts, "quats.webp", 3, 1) = char(127);
  at(parts, "quats.webp", 3, 2) = char(128), at(parts, "quats.webp", 3, 3) = char(253);
  at(parts, "sh0.webp", 2, 3) = char(51);
  parts.meta["scales"]["codebook"][200] = -3, at(parts, "scales.webp", 2, 1) = char(200);
  parts.meta["sh0"]["codebook"][7] = 0.625, at(parts, "sh0.webp", 2, 2) = char(7);
  const Scene scene = read(parts).scene;
  const double part = 4.0 * 0x1234 / 65535;
  CHECK(scene.means[2].x == float(1 - std::exp(2 - part)));
  CHECK(scene.means[2].y == float(1 - std::exp(1 - part)));
  CHECK(scene.means[2].z == float(std::exp(part) - 1));
  CHECK(scene.scales[2].y == float(std::exp(-3.0)));
  CHECK(scene.sh0[2].z == 0.625f);
  CHECK(scene.opacities[2] == 0.2f);
  // The three others leave nothing for z, and are longer than 1 together.
  CHECK(scene.rotations[2].w == doctest::Approx(-1 / std::sqrt(3)).epsilon(1e-6));
  CHECK(scene.rotations[2].z == doctest::Approx(0).epsilon(1e-6));
  CHECK(scene.rotations[3].w == doctest::Approx(std::sqrt(0.5)).epsilon(1e-5));
  CHECK(scene.rotations[3].x == doctest::Approx(std::sqrt(0.5)).epsilon(1e-5));
}

TEST_CASE("sog: a bundle may be deflated or keep its sizes behind its entries") {
  const SogParts parts = encode_sog(some_scene(30, 2), 2);
  const Scene scene = read(parts).scene;
  for (const ZipStyle style : {ZipStyle{.deflate = true}, ZipStyle{.sizes_follow = true},
                               ZipStyle{.deflate = true, .sizes_follow = true}}) {
    const SceneFile file = read(sog_bundle(parts, style));
    CHECK(file.scene.means == scene.means);
    CHECK(file.scene.sh_rest == scene.sh_rest);
  }
}

TEST_CASE("sog: a folder is read by its own path and by that of its meta.json") {
  const TemporaryFolder place;
  for (int version = 1; version <= 2; ++version) {
    const SogParts parts = encode_sog(some_scene(30, 1), version);
    const auto meta = write_sog(place, "scan" + std::to_string(version), parts);
    const Scene bundled = read(parts).scene;
    CHECK(load_scene(meta).means == bundled.means);
    CHECK(load_scene(meta.parent_path()).sh_rest == bundled.sh_rest);
    std::uintmax_t bytes = 0;
    for (const auto& file : std::filesystem::directory_iterator(meta.parent_path()))
      bytes += file.file_size();
    CHECK(read_scene(meta).bytes == bytes);
  }
}

TEST_CASE("sog: images may be PNG and need not be as large as each other") {
  const Scene original = some_scene(6, 0);
  SogParts parts = encode_sog(original, 2);
  const Scene scene = read(parts).scene;
  auto files = sog_files(parts);
  const auto rows_of = [&](const char* name, std::size_t width, bool alpha) {
    std::string rows;
    for (std::size_t i = 0; i < 6; ++i) {
      if (i % width == 0) rows += '\0';
      rows += parts.pictures[name].rgba.substr(4 * i, alpha ? 4 : 3);
    }
    return rows;
  };
  files["means_l.webp"] =
      png({.width = 2, .height = 3, .colour = png_rgb, .rows = rows_of("means_l.webp", 2, false)});
  files["sh0.webp"] =
      png({.width = 6, .height = 1, .colour = png_rgba, .rows = rows_of("sh0.webp", 6, true)});
  const SceneFile file = read(zip(files));
  CHECK(file.scene.means == scene.means);
  CHECK(file.scene.sh0 == scene.sh0);
  CHECK(file.scene.opacities == scene.opacities);
}

TEST_CASE("sog: the render model is kept or noted") {
  SogParts parts = encode_sog(some_scene(5, 0), 2);
  const Scene plain = read(parts).scene;
  parts.meta["model"] = "antialiased";
  CHECK(read(parts).scene.model.antialiased);
  CHECK(read(parts).notes.empty());
  parts.meta["model"] = "2dgs";
  const SceneFile flat = read(parts);
  CHECK(!flat.scene.model.antialiased);
  REQUIRE(flat.notes.size() == 1);
  CHECK(contains(flat.notes[0], "flat"));
  for (std::size_t i = 0; i < plain.size(); ++i)
    CHECK(flat.scene.scales[i] == vec3(plain.scales[i].x, plain.scales[i].y, 0));
  parts.meta["model"] = "4dgs";
  REQUIRE(read(parts).notes.size() == 1);
  CHECK(contains(read(parts).notes[0], "'4dgs'"));
  parts.meta.erase("model"), parts.meta["antialias"] = true;
  CHECK(read(parts).scene.model.antialiased);
}

TEST_CASE(
    "sog: a label without a meaning has no harmonics and a rotation without one leaves its Gaussian out") {
  SogParts parts = encode_sog(some_scene(70, 1), 2);
  const Scene whole = read(parts).scene;
  parts.meta["shN"]["count"] = 68;
  at(parts, "quats.webp", 4, 3) = char(251);
  const SceneFile file = read(parts);
  REQUIRE(file.notes.size() == 2);
  CHECK(contains(file.notes[0], "2 Gaussians"));
  CHECK(file.notes[1] == "Gaussians whose quaternion is no rotation are left out: 1.");
  CHECK(file.left_out.no_rotation == 1);
  REQUIRE(file.scene.size() == 69);
  CHECK(file.scene.rotations[3] == whole.rotations[3]);
  CHECK(file.scene.rotations[4] == whole.rotations[5]);
  const auto last = file.scene.sh_rest.begin() + 67 * 9;
  CHECK(std::equal(whole.sh_rest.begin() + 5 * 9, whole.sh_rest.begin() + 68 * 9,
                   file.scene.sh_rest.begin() + 4 * 9));
  CHECK(std::all_of(last, file.scene.sh_rest.end(), [](float x) { return x == 0; }));
}

TEST_CASE("sog: positions that float cannot hold are relative to an origin") {
  SogParts parts = encode_sog(some_scene(5, 0), 2);
  CHECK(read(parts).notes.empty());
  const double far = std::log1p(5403209.75);
  parts.meta["means"]["mins"][1] = far, parts.meta["means"]["maxs"][1] = far;
  const SceneFile file = read(parts);
  REQUIRE(file.notes.size() == 1);
  CHECK(contains(file.notes[0], "relative to the origin "));
  for (const vec3& mean : file.scene.means)
    CHECK(std::abs(file.scene.origin.y + double(mean.y) - 5403209.75) < 1e-6);
}

TEST_CASE("sog: numbers that are not finite are dropped") {
  SogParts parts = encode_sog(some_scene(20, 0), 2);
  parts.meta["scales"]["codebook"][3] = 1e4, parts.meta["scales"]["codebook"][2] = -1e4;
  for (std::size_t i = 0; i < 20; ++i) at(parts, "scales.webp", i, 0) = char(100);
  at(parts, "scales.webp", 7, 0) = char(3), at(parts, "scales.webp", 8, 0) = char(2);
  for (std::size_t i = 0; i < 20; ++i)
    for (int c = 1; c < 3; ++c) at(parts, "scales.webp", i, c) = char(100);
  const SceneFile file = read(parts);
  CHECK(file.stored == 20);
  CHECK(file.left_out.not_finite == 1);
  CHECK(file.scene.scales[7].x == 0);
}

TEST_CASE("sog: many Gaussians keep their order and progress is told of") {
  const Scene scene = some_scene(40'000, 0);
  const std::string bundle = sog_bundle(encode_sog(scene, 2));
  Listener reading;
  check_decoded(scene, read(bundle, "a", {.progress = reading.progress()}).scene, 2);
  CHECK(reading.told.size() >= 3);
  reading.check_whole();
  for (std::size_t stop = 0; stop < 3; ++stop) {
    std::size_t calls = 0;
    const auto cancel = [&](double) { return calls++ < stop; };
    CHECK_THROWS_AS(read(bundle, "a", {.progress = cancel}), Cancelled);
    CHECK(calls == stop + 1);
  }
}

}  // namespace swiftgs::test::sog_test
