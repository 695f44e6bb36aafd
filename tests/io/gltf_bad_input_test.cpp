// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/io/scene_file.hpp>

#include "gltf_encoder.hpp"
#include "scenes.hpp"

using namespace swiftgs;
using namespace swiftgs::test;
using nlohmann::json;

namespace {

void read_file(const std::string& content) { read_scene(as_bytes(content), "test.gltf"); }

std::string complaint_about(const std::string& content) {
  return complaint([&] { read_file(content); });
}

std::string complaint_about(const GltfParts& parts) { return complaint_about(glb(parts)); }

GltfParts some_parts(int degree = 0) { return encode_gltf(some_scene(3, degree)); }

template <class T>
std::string with(std::string content, std::size_t offset, T value) {
  std::string raw;
  append(raw, value);
  return content.replace(offset, raw.size(), raw);
}

}  // namespace

TEST_CASE("gltf: a file that ends early is refused wherever it ends") {
  check_every_truncation(glb(some_parts(1)), read_file);
  check_every_truncation(gltf(some_parts(1)), read_file);
}

TEST_CASE("gltf: damaged bytes never do more than throw") {
  const std::string binary = glb(some_parts(1)), text = gltf(some_parts(1));
  for (const std::string& file : {binary, text})
    for (std::size_t i = 0; i < file.size(); ++i)
      for (const char byte : {'\0', '9', '"', '}', char(0xff)}) {
        std::string damaged = file;
        damaged[i] = byte;
        CHECK_NOTHROW(complaint_about(damaged));
      }
}

TEST_CASE("gltf: the header and chunks of a binary file are checked") {
  const std::string file = glb(some_parts());
  CHECK(contains(complaint_about(with(file, 4, 1u)),
                 "byte 4: expected version 2 of binary glTF, found version 1"));
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
  CHECK(contains(complaint_about(std::string("[]")), "expected"));
  CHECK(contains(complaint_about(std::string("{}")), "a glTF with Gaussians"));
  GltfParts parts = some_parts();
  parts.primitive().erase("extensions");
  CHECK(contains(complaint_about(parts), "a glTF with Gaussians (KHR_gaussian_splatting)"));
  parts = some_parts();
  parts.root["scenes"][0]["nodes"] = json::array();
  CHECK(contains(complaint_about(parts), "a glTF with Gaussians"));
  for (const char* key : {"accessors", "bufferViews", "buffers", "meshes", "nodes", "scenes"}) {
    CAPTURE(key);
    parts = some_parts();
    parts.root[key] = 7;
    CHECK(contains(complaint_about(parts), std::string("'") + key + "' to be an array"));
    parts.root[key] = json::array({7});
    CHECK(contains(complaint_about(parts), "(a JSON object)"));
    parts.root.erase(key);
    if (std::string(key) != "scenes") CHECK(complaint_about(parts) != "");
  }
}

TEST_CASE("gltf: accessors and views that do not fit are refused before memory is taken") {
  const auto complaint_of_accessor = [](const char* key, const json& value) {
    GltfParts parts = some_parts();
    parts.accessor_of("SCALE")[key] = value;
    return complaint_about(parts);
  };
  CHECK(contains(complaint_of_accessor("count", 0), "at least one Gaussian"));
  CHECK(contains(complaint_of_accessor("count", 2), "of 3 Gaussians, as 'POSITION' has, found 2"));
  CHECK(contains(complaint_of_accessor("count", 4), "of 4 Gaussians inside its buffer view of 36 bytes"));
  CHECK(contains(complaint_of_accessor("count", 18446744073709551615u), "inside its buffer view"));
  CHECK(contains(complaint_of_accessor("count", -1), "'count' to be a whole number"));
  CHECK(contains(complaint_of_accessor("count", 2.5), "'count' to be a whole number"));
  CHECK(complaint_of_accessor("count", 3.0) == "");
  CHECK(contains(complaint_of_accessor("byteOffset", 1), "inside its buffer view"));
  CHECK(contains(complaint_of_accessor("byteOffset", 18446744073709551615u), "inside its buffer view"));
  CHECK(contains(complaint_of_accessor("componentType", 5125),
                 "'componentType' of 5120 to 5123 or 5126, found 5125"));
  CHECK(contains(complaint_of_accessor("type", "VEC4"), "to be of type VEC3, found \"VEC4\""));
  CHECK(contains(complaint_of_accessor("sparse", json::object()), "'sparse', which is not supported"));
  CHECK(contains(complaint_of_accessor("normalized", 1), "true or false"));
  CHECK(contains(complaint_of_accessor("bufferView", 99), "an index below 5 into 'bufferViews', found 99"));
  GltfParts parts = some_parts();
  parts.accessor_of("SCALE").erase("bufferView");
  CHECK(contains(complaint_about(parts), "'KHR_gaussian_splatting:SCALE' with a 'bufferView'"));

  const auto complaint_of_view = [](const char* key, const json& value) {
    GltfParts changed = some_parts();
    changed.root["bufferViews"][changed.accessor_of("SCALE")["bufferView"].get<int>()][key] = value;
    return complaint_about(changed);
  };
  CHECK(contains(complaint_of_view("byteStride", 8), "'byteStride' of at least that, found 8"));
  CHECK(contains(complaint_of_view("byteStride", 18446744073709551615u), "inside its buffer view"));
  CHECK(contains(complaint_of_view("byteOffset", 18446744073709551600u), "inside its buffer of"));
  CHECK(contains(complaint_of_view("byteLength", 18446744073709551615u), "inside its buffer of"));
  CHECK(contains(complaint_of_view("byteLength", 35), "buffer view of 35 bytes"));
  CHECK(contains(complaint_of_view("buffer", 1), "an index below 1 into 'buffers'"));
  parts = some_parts();
  parts.root["buffers"][0]["byteLength"] = parts.buffer.size() + 5;
  CHECK(contains(complaint_about(parts), "('byteLength'), found"));
}

TEST_CASE("gltf: primitives that are no Gaussians of the extension are refused") {
  const auto complaint_without = [](const std::string& attribute, int degree) {
    GltfParts parts = some_parts(degree);
    parts.primitive()["attributes"].erase(attribute);
    return complaint_about(parts);
  };
  const std::string prefix = "KHR_gaussian_splatting:";
  CHECK(contains(complaint_without("POSITION", 0), "attribute 'POSITION'"));
  for (const char* name : {"ROTATION", "SCALE", "OPACITY", "SH_DEGREE_0_COEF_0"})
    CHECK(contains(complaint_without(prefix + name, 0), "attribute '" + prefix + name + "'"));
  CHECK(contains(complaint_without(prefix + "SH_DEGREE_1_COEF_2", 3),
                 "attribute '" + prefix + "SH_DEGREE_1_COEF_2'"));
  CHECK(contains(complaint_without(prefix + "SH_DEGREE_3_COEF_6", 3),
                 "attribute '" + prefix + "SH_DEGREE_3_COEF_6'"));
  GltfParts parts = some_parts();
  parts.primitive()["mode"] = 4;
  CHECK(contains(complaint_about(parts), "primitive of points"));
  parts.primitive().erase("mode");
  CHECK(contains(complaint_about(parts), "primitive of points"));
  parts.primitive()["mode"] = 0;
  parts.primitive()["indices"] = 0;
  CHECK(contains(complaint_about(parts), "'indices', which are not supported"));
  parts = some_parts();
  parts.accessor_of("OPACITY")["componentType"] = 5121;
  CHECK(contains(complaint_about(parts), "opacities of integers to be 'normalized'"));
  parts = some_parts();
  parts.extension()["extensions"]["KHR_gaussian_splatting_compression_spz_2"] = json::object();
  CHECK(contains(complaint_about(parts), "with the index 'bufferView'"));
}

TEST_CASE("gltf: an extension that is required and not known is refused by its name") {
  GltfParts parts = some_parts();
  parts.root["extensionsRequired"] = {"KHR_gaussian_splatting", "EXT_unheard_of"};
  CHECK(contains(complaint_about(parts), "found \"EXT_unheard_of\""));
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
