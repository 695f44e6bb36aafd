// SPDX-License-Identifier: Apache-2.0
#include <system_error>

#include "scenes.hpp"
#include "sog_encoder.hpp"

namespace swiftgs::test::sog_bad_input_test {

using nlohmann::json;
using test::complaint_about;

namespace {

using Files = std::map<std::string, std::string>;

std::string complaint_about(const Files& files) { return test::complaint_about(zip(files)); }

SogParts parts_of(int version, int degree = 1) { return encode_sog(some_scene(5, degree), version); }

/// What is said when the value at `place` of the description is another, or is not there.
std::string with(const SogParts& parts, const std::string& place, const json& value) {
  SogParts changed = parts;
  changed.meta[json::json_pointer(place)] = value;
  return test::complaint_about(sog_bundle(changed));
}
std::string without(const SogParts& parts, const std::string& object, const std::string& key) {
  SogParts changed = parts;
  changed.meta.at(json::json_pointer(object)).erase(key);
  return test::complaint_about(sog_bundle(changed));
}

/// The files of a SOG, one of which is another.
Files with_file(const SogParts& parts, const char* name, const std::string& content) {
  Files files = sog_files(parts);
  files[name] = content;
  return files;
}

}  // namespace

TEST_CASE("sog: an image or a description that ends early is refused wherever it ends") {
  const Files files = sog_files(parts_of(2));
  for (const auto& file : files) {
    CAPTURE(file.first);
    // Each file is decoded with all the others.
    check_every_truncation(
        file.second,
        [&](const std::string& part) {
          Files changed = files;
          changed[file.first] = part;
          read(zip(changed));
        },
        13);
  }
}

TEST_CASE("sog: archives that are damaged or hold something else are refused") {
  const SogParts parts = parts_of(2);
  std::string damaged = sog_bundle(parts);
  CHECK(contains(complaint_about(std::string("PK\3\4 meta.json")), "byte 0: expected a whole ZIP archive"));
  damaged[damaged.find("VP8L") + 20] ^= 1;
  CHECK(contains(complaint_about(damaged), "checksum"));
  Files files = sog_files(parts);
  files.erase("quats.webp");
  CHECK(contains(complaint_about(files), "a file: byte 0: expected a ZIP archive with 'quats.webp' in it"));
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
    CHECK(contains(with(parts_of(version), count, 2'000'000'000), "can hold 2000000000 Gaussians"));
    CHECK(contains(with(parts_of(version), count, 10'000), "about as many pixels"));
    for (const json& none : {json(0), json(1e300), json(-5), json(4.5), json("5")})
      CHECK(with(parts_of(version), count, none) != "");
  }
}

TEST_CASE("sog: images of other sizes than the Gaussians need are refused") {
  const SogParts parts = parts_of(2);
  const struct {
    const char* name;
    int width, height;
    const char* expected;
  } cases[] = {
      {"sh0.webp", 2, 2, ": byte 0: expected about as many pixels as there are Gaussians, 5, found 2x2"},
      {"sh0.webp", 4000, 4000, "found 4000x4000"},
      {"shN_centroids.webp", 191, 1, "found 191x1"},
      {"shN_centroids.webp", 512, 1, "found 512x1"},
      {"shN_centroids.webp", 192, 1025, "found 192x1025"}};
  for (const auto& [name, width, height, expected] : cases) {
    // All pixels alike: such an image has a few bytes, however large it is.
    const SogPicture blank{width, height, std::string(4 * std::size_t(width) * height, '\0')};
    const std::string message = complaint_about(with_file(parts, name, webp(blank)));
    CHECK(contains(message, expected));
    CHECK(contains(message, std::string("a file: ") + name));
  }
  CHECK(contains(with(parts, "/shN/count", 65), "a palette of 65 entries"));
  CHECK(contains(with(parts_of(1), "/shN/files/0", "sh0.webp"), "192, 512 or 960 pixels wide"));
}

TEST_CASE("sog: images that are none or not lossless are refused") {
  const SogParts parts = parts_of(2);
  const auto about = [&](const std::string& image) {
    return complaint_about(with_file(parts, "scales.webp", image));
  };
  CHECK(contains(about("no image"), "a file: scales.webp: byte 0: expected a WebP or a PNG image"));
  CHECK(contains(about("\xff\xd8\xff"), "a WebP or a PNG image"));
  CHECK(contains(about(webp(parts.pictures.at("scales.webp"), false)), "a lossless WebP, found a lossy one"));
  CHECK(contains(about("\x89PNG\r\n\x1a\n"), "a valid PNG"));
  check_every_damage(webp(parts.pictures.at("scales.webp")), 0x55,
                     [&](const std::string& image) { read(zip(with_file(parts, "scales.webp", image))); });
}

TEST_CASE("sog: descriptions that lack something are refused where it is missing") {
  for (const int version : {1, 2}) {
    const SogParts parts = parts_of(version);
    for (const std::string key : {"means", "scales", "quats", "sh0"}) {
      CHECK(contains(without(parts, "", key), "meta.json of a SOG with '" + key));
      CHECK(contains(without(parts, "/" + key, "files"), "with 'files'"));
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
  const struct {
    const char* place;
    json value;
    const char* expected;
  } cases[] = {{"/version", "2", "a number in 'version'"},
               {"/means/mins", {1, 2}, "'mins' to be 3 numbers"},
               {"/means/maxs/1", "x", "'maxs' to be 3 numbers"},
               {"/scales/codebook", {1, 2}, "'codebook' to be 256 numbers"},
               {"/scales/codebook/255", nullptr, "'codebook' to be 256 numbers"},
               {"/shN/bands", 4, "'bands' to be a whole number from 1 to 3"},
               {"/shN/count", 65537, "'count' to be a whole number from 1 to 65536"},
               {"/means/files", json::array({"means_l.webp"}), "'files' to be 2 names"},
               {"/model", 3, "'model' to be a string"},
               {"/means", 3, "means (a JSON object)"}};
  for (const auto& [place, value, expected] : cases) CHECK(contains(with(parts, place, value), expected));
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
  CHECK(contains(complaint_about(parts_of(2).meta.dump(), "meta.json"), "found JSON of a SOG in memory"));
}

}  // namespace swiftgs::test::sog_bad_input_test
