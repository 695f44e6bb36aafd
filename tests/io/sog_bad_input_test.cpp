// SPDX-License-Identifier: Apache-2.0
#include <system_error>

#include <swiftgs/io/scene_file.hpp>

#include "png_encoder.hpp"
#include "scenes.hpp"
#include "sog_encoder.hpp"

using namespace swiftgs;
using namespace swiftgs::test;
using nlohmann::json;

namespace {

using Files = std::map<std::string, std::string>;

void read_bundle(const std::string& bundle) { read_scene(as_bytes(bundle), "test.sog"); }

std::string complaint_about(const std::string& bundle) {
  return complaint([&] { read_bundle(bundle); });
}
std::string complaint_about(const Files& files) { return complaint_about(zip(files)); }

SogParts parts_of(int version, int degree = 1) { return encode_sog(some_scene(5, degree), version); }

/// What is said when the value at `place` of the description is another, or is not there.
std::string with(const SogParts& parts, const char* place, const json& value) {
  SogParts changed = parts;
  changed.meta[json::json_pointer(place)] = value;
  return complaint_about(sog_bundle(changed));
}
std::string without(const SogParts& parts, const char* object, const char* key) {
  SogParts changed = parts;
  changed.meta.at(json::json_pointer(object)).erase(key);
  return complaint_about(sog_bundle(changed));
}

/// The files of a SOG, one of which is another.
Files with_file(const SogParts& parts, const char* name, const std::string& content) {
  Files files = sog_files(parts);
  files[name] = content;
  return files;
}

/// As many pixels, all of them alike: such an image has a few bytes, however large it is.
SogPicture blank(int width, int height) {
  return {width, height, std::string(4 * std::size_t(width) * height, '\0')};
}

}  // namespace

TEST_CASE("sog: a bundle that ends early is refused wherever it ends") {
  check_every_truncation(sog_bundle(parts_of(2)), read_bundle);
  check_every_truncation(sog_bundle(parts_of(1, 0), {.deflate = true, .sizes_follow = true}), read_bundle);
}

TEST_CASE("sog: an image or a description that ends early is refused wherever it ends") {
  const Files files = sog_files(parts_of(2));
  for (const auto& [name, content] : files) {
    CAPTURE(name);
    check_every_truncation(content, [&, &name = name](const std::string& part) {
      Files changed = files;
      changed[name] = part;
      read_bundle(zip(changed));
    });
  }
}

TEST_CASE("sog: archives that are damaged or hold something else are refused") {
  const SogParts parts = parts_of(2);
  const std::string bundle = sog_bundle(parts);
  CHECK(contains(complaint_about("PK\3\4 meta.json"), "test.sog: byte 0: expected a whole ZIP archive"));
  std::string damaged = bundle;
  damaged[bundle.find("VP8L") + 20] ^= 1;
  CHECK(contains(complaint_about(damaged), "checksum"));
  Files files = sog_files(parts);
  files.erase("quats.webp");
  CHECK(contains(complaint_about(files), "test.sog: byte 0: expected a ZIP archive with 'quats.webp' in it"));
  files = {{"scan/meta.json", "{}"}};
  CHECK(contains(complaint_about(files), "a ZIP archive with 'meta.json' in it"));
  for (std::size_t i = 0; i < bundle.size(); ++i) {
    std::string changed = bundle;
    changed[i] ^= 0x55;
    CHECK_NOTHROW(complaint_about(changed));
  }
}

TEST_CASE("sog: an archive that unpacks to much more than it takes is refused") {
  SogParts parts = parts_of(2);
  const std::string image = webp(parts.pictures["quats.webp"]);
  Files files = with_file(parts, "quats.webp", image + std::string(10'000'000, '\0'));
  CHECK(contains(complaint_about(zip(files, {.deflate = true})), "at most 16 times its size"));
}

TEST_CASE("sog: a count that the files cannot hold is refused before memory is taken") {
  for (const int version : {1, 2}) {
    const char* count = version == 1 ? "/means/shape/0" : "/count";
    CHECK(
        contains(with(parts_of(version), count, 2'000'000'000), "files that can hold 2000000000 Gaussians"));
    CHECK(contains(with(parts_of(version), count, 10'000), "about as many pixels"));
    CHECK(with(parts_of(version), count, 0) != "");
    CHECK(with(parts_of(version), count, 1e300) != "");
    CHECK(with(parts_of(version), count, -5) != "");
    CHECK(with(parts_of(version), count, 4.5) != "");
    CHECK(with(parts_of(version), count, "5") != "");
  }
}

TEST_CASE("sog: images of other sizes than the Gaussians need are refused") {
  const SogParts parts = parts_of(2);
  CHECK(contains(
      complaint_about(with_file(parts, "sh0.webp", webp(blank(2, 2)))),
      "test.sog: sh0.webp: byte 0: expected about as many pixels as there are Gaussians, 5, found 2x2"));
  CHECK(contains(complaint_about(with_file(parts, "sh0.webp", webp(blank(4000, 4000)))), "found 4000x4000"));
  CHECK(
      contains(complaint_about(with_file(parts, "shN_centroids.webp", webp(blank(191, 1)))), "found 191x1"));
  CHECK(
      contains(complaint_about(with_file(parts, "shN_centroids.webp", webp(blank(512, 1)))), "found 512x1"));
  CHECK(contains(complaint_about(with_file(parts, "shN_centroids.webp", webp(blank(192, 1025)))),
                 "found 192x1025"));
  CHECK(contains(with(parts, "/shN/count", 65), "a palette of 65 entries"));
  CHECK(contains(with(parts_of(1), "/shN/files/0", "sh0.webp"), "192, 512 or 960 pixels wide"));
}

TEST_CASE("sog: images that are none or not lossless are refused") {
  const SogParts parts = parts_of(2);
  const auto about = [&](const std::string& image) {
    return complaint_about(with_file(parts, "scales.webp", image));
  };
  CHECK(contains(about("no image"), "test.sog: scales.webp: byte 0: expected a WebP or a PNG image"));
  CHECK(contains(about("\xff\xd8\xff"), "a WebP or a PNG image"));
  CHECK(contains(about(webp(parts.pictures.at("scales.webp"), false)), "a lossless WebP, found a lossy one"));
  CHECK(contains(about("\x89PNG\r\n\x1a\n"), "a valid PNG"));
  const std::string image = webp(parts.pictures.at("scales.webp"));
  Files files = sog_files(parts);
  for (std::size_t i = 0; i < image.size(); ++i) {
    files["scales.webp"] = image;
    files["scales.webp"][i] ^= 0x55;
    CHECK_NOTHROW(complaint_about(files));
  }
}

TEST_CASE("sog: descriptions that lack something are refused where it is missing") {
  for (const int version : {1, 2}) {
    const SogParts parts = parts_of(version);
    for (const std::string key : {"means", "scales", "quats", "sh0"}) {
      CHECK(contains(without(parts, "", key.c_str()), "meta.json of a SOG with '" + key));
      CHECK(contains(without(parts, std::string("/").append(key).c_str(), "files"), "with 'files'"));
    }
    CHECK(contains(without(parts, "/means", "mins"), "means with 'mins'"));
    CHECK(contains(without(parts, "/shN", version == 1 ? "maxs" : "codebook"), "shN with"));
    CHECK(contains(without(parts, "/scales", version == 1 ? "mins" : "codebook"), "scales with"));
  }
  CHECK(contains(without(parts_of(1), "/means", "shape"), "means with 'shape'"));
  CHECK(contains(without(parts_of(2), "", "count"), "with 'count'"));
  CHECK(contains(without(parts_of(2), "/shN", "bands"), "with 'bands'"));
}

TEST_CASE("sog: descriptions with values that cannot be are refused") {
  const SogParts parts = parts_of(2);
  for (const json& version : {json(0), json(3), json(1.5)})
    CHECK(contains(with(parts, "/version", version), "SOG version 1 or 2"));
  CHECK(contains(with(parts, "/version", "2"), "a number in 'version'"));
  CHECK(contains(with(parts, "/means/mins", json::array({1, 2})), "'mins' to be 3 numbers"));
  CHECK(contains(with(parts, "/means/maxs/1", "x"), "'maxs' to be 3 numbers"));
  CHECK(contains(with(parts, "/scales/codebook", json::array({1, 2})), "'codebook' to be 256 numbers"));
  CHECK(contains(with(parts, "/scales/codebook/255", nullptr), "'codebook' to be 256 numbers"));
  CHECK(contains(with(parts, "/shN/bands", 4), "'bands' to be a whole number from 1 to 3"));
  CHECK(contains(with(parts, "/shN/count", 65537), "'count' to be a whole number from 1 to 65536"));
  CHECK(contains(with(parts, "/means/files", json::array({"means_l.webp"})), "'files' to be 2 names"));
  CHECK(contains(with(parts, "/model", 3), "'model' to be a string"));
  CHECK(contains(with(parts, "/means", 3), "means (a JSON object)"));
}

TEST_CASE("sog: names that leave the folder are refused") {
  const TemporaryFolder place;
  SogParts parts = parts_of(2);
  write_sog(place, "scan", parts);
  write_sog(place, "other", parts);
  const auto about = [&](const std::string& name) {
    parts.meta["quats"]["files"][0] = name;
    const auto meta = place.write("scan/meta.json", parts.meta.dump());
    return complaint([&] { read_scene(meta); });
  };
  CHECK(about("quats.webp") == "");
  CHECK(about("./quats.webp") == "");
  for (const std::string& name :
       {std::string("../other/quats.webp"), std::string("x/../quats.webp"), std::string(".."),
        (place / "other/quats.webp").string(), std::string(""), std::string("quats.webp\0", 11)})
    CHECK(contains(about(name), "'files' to be 1 names of files in the same folder"));
  CHECK_THROWS_AS(about("absent.webp"), std::system_error);
  CHECK_THROWS_AS(about("."), std::system_error);
}

TEST_CASE("sog: a folder's description cannot be read from memory") {
  const std::string text = parts_of(2).meta.dump();
  CHECK(
      contains(complaint([&] { read_scene(as_bytes(text), "meta.json"); }), "found JSON of a SOG in memory"));
}
