// SPDX-License-Identifier: Apache-2.0

/// @file
/// Files made to take as much memory as they can. Counted is what C++ takes, which scenes are, and not what
/// libraries of C take for themselves.

#include <atomic>
#include <cstdlib>
#include <new>

#include <malloc.h>

#include <swiftgs/edit/select.hpp>

#include "gltf_encoder.hpp"
#include "memory_factors.hpp"
#include "ply_text.hpp"
#include "sog_encoder.hpp"
#include "spz_encoder.hpp"

namespace {

std::atomic<std::ptrdiff_t> held = 0, most_held = 0;

void* counted(void* memory) {
  if (!memory) throw std::bad_alloc();
  const std::ptrdiff_t now = held += std::ptrdiff_t(malloc_usable_size(memory));
  for (std::ptrdiff_t most = most_held; now > most && !most_held.compare_exchange_weak(most, now);) {
  }
  return memory;
}

void release(void* memory) {
  if (memory) held -= std::ptrdiff_t(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) { return counted(std::malloc(size)); }
void* operator new[](std::size_t size) { return counted(std::malloc(size)); }
void operator delete(void* memory) noexcept { release(memory); }
void operator delete[](void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t) noexcept { release(memory); }

using namespace swiftgs;
using namespace swiftgs::test;
using nlohmann::json;

namespace {

/// The most memory that reading holds at a time, whether it throws or not.
double memory_of(const std::string& content, const std::string& name) {
  const std::ptrdiff_t before = held;
  most_held = before;
  complaint_about(content, name);
  return double(most_held - before);
}

/// Checks what a file in memory takes.
void check_memory(const std::string& content, const std::string& name, const MemoryFactor& factor) {
  const double memory = memory_of(content, name);
  CAPTURE(name);
  CAPTURE(memory / double(content.size()));
  CHECK(memory <= factor.bytes_of(content.size()));
}

std::string repeated(const std::string& text, std::size_t times) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

/// All numbers bytes, so that a Gaussian takes as little as it can.
std::vector<PlyValue> small_gaussian() {
  std::vector<PlyValue> values = plain_gaussian();
  for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2"}) remove(values, name);
  for (PlyValue& value : values) value.type = "char", value.value = 1;
  for (const char* name : {"red", "green", "blue"}) values.push_back({"uchar", name, 1});
  return values;
}

/// A scene of accessors that all share the bytes of one view, `count` times four.
GltfParts shared_bytes(std::size_t count, int degree) {
  GltfParts parts = encode_gltf(some_scene(1, degree));
  parts.buffer = std::string(4 * count, '\1');
  parts.root["buffers"][0]["byteLength"] = parts.buffer.size();
  parts.root["bufferViews"] = json::array({{{"buffer", 0}, {"byteLength", parts.buffer.size()}}});
  for (json& accessor : parts.root["accessors"]) {
    accessor["bufferView"] = 0, accessor["count"] = count;
    accessor["componentType"] = 5121, accessor["normalized"] = true;
  }
  return parts;
}

GltfParts with_instances(GltfParts parts, int instances, const json& node) {
  parts.root["nodes"] = json::array(), parts.root["scenes"][0]["nodes"] = json::array();
  for (int i = 0; i < instances; ++i) {
    parts.root["nodes"].push_back(node);
    parts.root["scenes"][0]["nodes"].push_back(i);
  }
  return parts;
}

/// Bytes that repeat, of as many Gaussians as version 4 allows.
SpzParts repeating_spz(std::uint32_t version, std::uint32_t count, int degree) {
  SpzParts parts{.version = version, .count = count, .sh_degree = std::uint8_t(degree)};
  const std::size_t positions = version == 1 ? 6 : 9, rotations = version < 3 ? 3 : 4;
  const auto rest = 3 * std::size_t(sh_rest_count(degree));
  for (const std::size_t size : {positions, std::size_t(1), std::size_t(3), std::size_t(3), rotations, rest})
    parts.arrays.emplace_back(size * count, '\0');
  return parts;
}

std::string zstd_frame_of_unknown_size(const std::string& content) {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
  std::string packed(ZSTD_compressBound(content.size()), '\0');
  packed.resize(ZSTD_compress2(context, packed.data(), packed.size(), content.data(), content.size()));
  ZSTD_freeCCtx(context);
  return packed;
}

}  // namespace

TEST_CASE("memory: a .splat takes no more than its factor") {
  check_memory(std::string(32 * 100'000, '\1'), "a.splat", splat_memory);
}

TEST_CASE("memory: a .ksplat whose sections differ in degree takes no more than its factor") {
  constexpr std::uint32_t count = 100'000;
  std::string file(4096 + 2 * 1024, '\0');
  file[1] = 1;
  set(file, 4, 2u), set(file, 8, 2u), set(file, 16, count + 1), set(file, 20, std::uint16_t(2));
  for (const auto& [section, gaussians] : {std::pair{4096u, 1u}, {5120u, count}}) {
    for (const std::size_t at : {0, 4, 8}) set(file, section + at, gaussians);
    set(file, section + 12, 1u), set(file, section + 20, std::uint16_t(12)), set(file, section + 32, 1u);
  }
  set(file, 4096 + 40, std::uint16_t(3));
  file += std::string(12 + 24 + 45, '\1') + std::string(12 + 24 * std::size_t(count), '\1');
  CHECK(read(file).scene.size() == count + 1);
  check_memory(file, "a.ksplat", ksplat_memory);
}

TEST_CASE("memory: a PLY takes no more than its factor") {
  for (const char* format : {"binary_little_endian", "ascii"})
    check_memory(ply(small_gaussian(), {.format = format, .repeat = 100'000}), format, ply_memory);
  std::string properties = "element a 0\n", elements;
  for (int i = 0; i < 131'100; ++i) {
    properties += "property int " + std::to_string(i) + "\n";
    elements += "element " + std::to_string(i) + " 0\n";
  }
  check_memory(ply(plain_gaussian(), {.before = properties}), "properties", ply_memory);
  check_memory(ply(plain_gaussian(), {.before = elements}), "elements", ply_memory);
  check_memory(ply(plain_gaussian(), {.before = repeated("comment\n", 262'200)}), "comments", ply_memory);
  auto wide = plain_gaussian();
  for (int i = 0; i < 50'000; ++i) wide.push_back({"int", std::to_string(i), 1});
  check_memory(ply(wide, {.format = "ascii"}), "a wide row", ply_memory);
}

TEST_CASE("memory: an SPZ takes no more than its factor") {
  for (const std::uint32_t version : {1u, 2u, 3u})
    for (const int degree : {0, 3, 4}) {
      CAPTURE(version);
      check_memory(gzip_spz(repeating_spz(version, 100'000, degree)), "gzip", spz_memory);
    }
  for (const int degree : {0, 3, 4}) {
    const std::string file = stream_spz(repeating_spz(4, 20'000, degree));
    CHECK(read(file).scene.size() == 20'000);
    check_memory(file, "streams", spz_streams_memory);
  }
}

TEST_CASE("memory: an SPZ that holds less than it says takes no memory for a scene") {
  constexpr std::uint32_t count = 30'000;
  SpzParts parts = repeating_spz(3, count, 3);
  for (std::size_t i = 0; i < 10'000; ++i) parts.arrays[0][i] = char(i * i * i >> 8);
  parts.arrays[4].resize(parts.arrays[4].size() / 2), parts.arrays[5].clear();
  const std::string gzipped = gzip_spz(parts);
  CHECK(contains(complaint_about(gzipped), "bytes of Gaussians"));
  // No more than the place for the unpacked bytes, of which none is touched before it is needed.
  CHECK(memory_of(gzipped, "a.spz") < 65.0 * count + 1e6);

  parts = repeating_spz(4, count, 3);
  std::string table, streams;
  for (std::size_t a = 0; a < 6; ++a) {
    const std::string half = parts.arrays[a].substr(0, parts.arrays[a].size() / (a == 4 ? 2 : 1));
    const std::string frame = zstd_frame_of_unknown_size(half);
    append(table, std::uint64_t(frame.size())), append(table, std::uint64_t(parts.arrays[a].size()));
    streams += frame;
  }
  std::string file = spz_header(parts, 6);
  append(file, std::uint32_t(32));
  file += std::string(12, '\0') + table + streams;
  CHECK(contains(complaint_about(file), "of 120000 bytes unpacked, found 60000"));
  CHECK(memory_of(file, "a.spz") < 65.0 * count + 1e6);
}

TEST_CASE("memory: a glTF takes no more than its factor") {
  for (const int degree : {0, 3})
    for (const json& node : {json{{"mesh", 0}}, json{{"mesh", 0}, {"translation", {1, 2, 3}}}})
      for (const int instances : {1, 7, 31}) {
        CAPTURE(instances);
        const GltfParts parts = with_instances(shared_bytes(20'000, degree), instances, node);
        CHECK(read(glb(parts)).scene.size() == std::size_t(20'000 * instances));
        check_memory(glb(parts), "a.glb", gltf_memory);
      }
  const GltfParts many = with_instances(shared_bytes(20'000, 3), 70, {{"mesh", 0}});
  CHECK(contains(complaint_about(glb(many)), "at most 8 Gaussians"));
  CHECK(memory_of(glb(many), "a.glb") < 1e6);
}

TEST_CASE("memory: the parts of a glTF are not held twice") {
  const GltfParts parts = with_instances(encode_gltf(some_scene(50'000, 3)), 4, {{"mesh", 0}});
  const double scene = 4 * 50'000 * 236.0;
  CHECK(memory_of(glb(parts), "a.glb") < 1.1 * scene);
}

TEST_CASE("memory: JSON takes no more than its factor") {
  const std::string start = "{\"asset\": {}, \"meshes\": ";
  for (const std::string& rest :
       {repeated("[", 500'000), repeated("[", 200'000) + repeated("]", 200'000) + "}",
        "[" + repeated("[],", 300'000) + "[]]}", "[" + repeated("{},", 300'000) + "{}]}",
        repeated("{\"\":", 200'000) + "1" + repeated("}", 200'000) + "}"})
    check_memory(start + rest, "a.gltf", {100, 1});
  GltfParts nodes = with_instances(encode_gltf(some_scene(1, 0)), 50'000, {{"mesh", 0}});
  nodes.buffer += std::string(6'400, '\0');
  check_memory(glb(nodes), "a.glb", {100, 1});
}

TEST_CASE("memory: a SOG takes no more than its factor") {
  constexpr std::size_t count = 60'000;
  const Scene scene = subset(some_scene(1, 3), std::vector<std::uint32_t>(count, 0));
  const std::string file = sog_bundle(encode_sog(scene, 2));
  CHECK(read(file).scene.size() == count);
  check_memory(file, "a.sog", sog_memory);
}
