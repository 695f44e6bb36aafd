// SPDX-License-Identifier: Apache-2.0
#include "gltf_encoder.hpp"

namespace swiftgs::test::gltf_bad_input_test {

using nlohmann::json;
using test::complaint_about;

namespace {

std::string complaint_about(const GltfParts& parts) { return test::complaint_about(glb(parts)); }

GltfParts some_parts(int degree = 0) { return encode_gltf(some_scene(3, degree)); }

/// What is said when the value of `parts` at `place` is another, or is not there.
std::string changed(GltfParts parts, const std::string& place, const json& value) {
  const json::json_pointer at(place);
  if (value.is_discarded())
    parts.root[at.parent_pointer()].erase(at.back());
  else
    parts.root[at] = value;
  return complaint_about(parts);
}

const json absent(json::value_t::discarded);

}  // namespace

TEST_CASE("gltf: the header and chunks of a binary file are checked") {
  const std::string file = glb(some_parts());
  CHECK(contains(complaint_about(with(file, 4, 1u)), "byte 4: expected version 2 of binary glTF, found"));
  CHECK(contains(complaint_about(file + "x"), "byte 8: expected a length of"));
  CHECK(contains(complaint_about(with(file, 12, 0xffffffffu)), "bytes for a chunk"));
  CHECK(contains(complaint_about(with(file, 16, 0x004e4942u)), "byte 16: expected a first chunk of JSON"));
  std::string empty = "glTF";
  append(empty, 2u), append(empty, 12u);
  CHECK(contains(complaint_about(empty), "byte 12: expected a chunk of JSON"));
}

TEST_CASE("gltf: errors in JSON are placed in the file, past data URIs, too") {
  std::string binary = glb(some_parts());
  binary[binary.find("\"mesh\"")] = '!';
  CHECK(contains(complaint_about(binary),
                 "byte " + std::to_string(binary.find('!')) + ": expected valid JSON"));
  GltfParts parts = some_parts();
  std::string text = gltf(parts);  // members are sorted: buffers come before nodes
  const std::size_t place = text.find("\"mesh\"");
  REQUIRE(text.find("base64,") < place);
  text[place] = '!';
  CHECK(contains(complaint_about(text), "byte " + std::to_string(place) + ": expected valid JSON"));
  parts.root["nodes"][0]["mesh"] = 5;
  text = gltf(parts);
  CHECK(contains(complaint_about(text), "byte " + std::to_string(text.find("{\"mesh\":5}")) +
                                            ": expected an index below 1 into 'meshes', found 5"));
  parts = some_parts();
  parts.root["bufferViews"][1]["byteLength"] = 1;
  text = gltf(parts);
  CHECK(contains(complaint_about(text), "of 3 Gaussians inside its buffer view of 1 bytes"));
}

TEST_CASE("gltf: text that is not a glTF of Gaussians is refused") {
  CHECK(contains(complaint_about("[]", "a.gltf"), "expected"));
  CHECK(contains(complaint_about("{}", "a.gltf"), "a glTF with Gaussians"));
  GltfParts parts = some_parts();
  parts.primitive().erase("extensions");
  CHECK(contains(complaint_about(parts), "a glTF with Gaussians (KHR_gaussian_splatting)"));
  parts = some_parts();
  parts.root["scenes"][0]["nodes"] = json::array();
  CHECK(contains(complaint_about(parts), "a glTF with Gaussians"));
  for (const std::string key : {"accessors", "bufferViews", "buffers", "meshes", "nodes", "scenes"}) {
    CAPTURE(key);
    CHECK(contains(changed(some_parts(), "/" + key, 7), "'" + key + "' to be an array"));
    CHECK(contains(changed(some_parts(), "/" + key, json::array({7})), "(a JSON object)"));
    if (key != "scenes") CHECK(changed(some_parts(), "/" + key, absent) != "");
  }
}

TEST_CASE("gltf: accessors and views that do not fit are refused before memory is taken") {
  const std::uint64_t huge = 18446744073709551615u;
  GltfParts parts = some_parts();
  const auto& attributes = parts.primitive()["attributes"];
  const std::string accessor =
      "/accessors/" + std::to_string(attributes["KHR_gaussian_splatting:SCALE"].get<int>()) + "/";
  const std::string view =
      "/bufferViews/" + std::to_string(parts.accessor_of("SCALE")["bufferView"].get<int>()) + "/";
  const struct {
    std::string place;
    json value;
    std::string expected;
  } cases[] = {{accessor + "count", 0, "at least one Gaussian"},
               {accessor + "count", 2, "of 3 Gaussians, as 'POSITION' has, found 2"},
               {accessor + "count", 4, "of 4 Gaussians inside its buffer view of 36 bytes"},
               {accessor + "count", huge, "inside its buffer view"},
               {accessor + "count", -1, "'count' to be a whole number"},
               {accessor + "count", 2.5, "'count' to be a whole number"},
               {accessor + "byteOffset", 1, "inside its buffer view"},
               {accessor + "byteOffset", huge, "inside its buffer view"},
               {accessor + "componentType", 5125, "'componentType' of 5120 to 5123 or 5126, found 5125"},
               {accessor + "type", "VEC4", "to be of type VEC3, found \"VEC4\""},
               {accessor + "sparse", json::object(), "'sparse', which is not supported"},
               {accessor + "normalized", 1, "true or false"},
               {accessor + "bufferView", 99, "an index below 5 into 'bufferViews', found 99"},
               {accessor + "bufferView", absent, "'KHR_gaussian_splatting:SCALE' with a 'bufferView'"},
               {view + "byteStride", 8, "'byteStride' of at least that, found 8"},
               {view + "byteStride", huge, "inside its buffer view"},
               {view + "byteOffset", huge - 15, "inside its buffer of"},
               {view + "byteLength", huge, "inside its buffer of"},
               {view + "byteLength", 35, "buffer view of 35 bytes"},
               {view + "buffer", 1, "an index below 1 into 'buffers'"},
               {"/buffers/0/byteLength", parts.buffer.size() + 5, "('byteLength'), found"}};
  for (const auto& [place, value, expected] : cases)
    CHECK_MESSAGE(contains(changed(parts, place, value), expected), expected);
  CHECK(changed(parts, accessor + "count", 3.0) == "");
}

TEST_CASE("gltf: primitives that are no Gaussians of the extension and extensions not known are refused") {
  const std::string primitive = "/meshes/0/primitives/0", prefix = "KHR_gaussian_splatting:";
  for (const std::string& name :
       {std::string("POSITION"), prefix + "ROTATION", prefix + "SCALE", prefix + "OPACITY",
        prefix + "SH_DEGREE_0_COEF_0", prefix + "SH_DEGREE_1_COEF_2", prefix + "SH_DEGREE_3_COEF_6"})
    CHECK(contains(changed(some_parts(3), primitive + "/attributes/" + name, absent), "'" + name + "'"));
  CHECK(contains(changed(some_parts(), primitive + "/mode", 4), "primitive of points"));
  CHECK(contains(changed(some_parts(), primitive + "/mode", absent), "primitive of points"));
  CHECK(contains(changed(some_parts(), primitive + "/indices", 0), "'indices', which are not supported"));
  GltfParts parts = some_parts();
  parts.accessor_of("OPACITY")["componentType"] = 5121;
  CHECK(contains(complaint_about(parts), "opacities of integers to be 'normalized'"));
  parts = some_parts();
  parts.extension()["extensions"]["KHR_gaussian_splatting_compression_spz_2"] = json::object();
  CHECK(contains(complaint_about(parts), "with the index 'bufferView'"));
  CHECK(
      contains(changed(some_parts(), "/extensionsRequired", {"EXT_unheard_of"}), "found \"EXT_unheard_of\""));
}

TEST_CASE("gltf: buffers in the text must be base64") {
  const auto complaint_about_uri = [](const std::string& uri) {
    GltfParts parts = some_parts();
    parts.root["buffers"][0]["uri"] = uri;
    return complaint_about(parts.root.dump());
  };
  const std::string base64 = to_base64(some_parts().buffer);
  CHECK(complaint_about_uri("data:;base64," + base64) == "");
  CHECK(complaint_about_uri("data:application/octet-stream;base64," + base64 + "====") != "");
  CHECK(contains(complaint_about_uri("data:," + base64), "a data URI in base64"));
  CHECK(contains(complaint_about_uri("data:7"), "a data URI in base64"));
  CHECK(contains(complaint_about_uri("data:;base64,A"), "whole bytes in base64"));
  CHECK(contains(complaint_about_uri("data:;base64," + base64.substr(4)), "('byteLength')"));
  std::string damaged = base64;
  damaged[9] = '-';
  GltfParts parts = some_parts();
  parts.root["buffers"][0]["uri"] = "data:;base64," + damaged;
  const std::string text = parts.root.dump();
  CHECK(contains(complaint_about(text),
                 "byte " + std::to_string(text.find(damaged) + 9) + ": expected a character of base64"));
  // Some programs escape slashes.
  parts.root["buffers"][0]["uri"] = "@";
  std::string escaped = parts.root.dump(), uri = "data:application\\/octet-stream;base64,";
  for (const char c : base64) uri += c == '/' ? std::string("\\/") : std::string(1, c);
  CHECK(complaint_about(escaped.replace(escaped.find('@'), 1, uri)) == "");
}

}  // namespace swiftgs::test::gltf_bad_input_test
