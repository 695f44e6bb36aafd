// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <numeric>
#include <system_error>

#include <unistd.h>

#include "mapped_file.hpp"
#include "ply_text.hpp"
#include "scenes.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Bytes of files that lie in this process's memory.
long resident_of_files() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0, shared = 0;
  statm >> total >> resident >> shared;
  return shared * ::sysconf(_SC_PAGESIZE);
}

long sum(std::span<const std::byte> bytes) {
  return std::accumulate(bytes.begin(), bytes.end(), 0L, [](long s, std::byte b) { return s + long(b); });
}

}  // namespace

TEST_CASE("scene file: foreign files are refused at byte 0 and named where they are well known") {
  const std::string cases[][2] = {
      {"", "an empty file"},
      {"PK\3\4", "a ZIP archive"},
      {"PK\3\4 scene.usdc", "a USD archive"},
      {"PXR-USDC", "a USD scene"},
      {"#usda 1.0\n", "a USD scene"},
      {R"({"frames": [{"transform_matrix": []}]})", "JSON of cameras (transforms.json)"},
      {R"({"frames": [], "camera_angle_x": 0.7})", "JSON of cameras (transforms.json)"},
      {R"([{"img_name": 1}])", "JSON of cameras (cameras.json)"},
      {"{}", "JSON"},
      {"\x89PNG\r\n", "a PNG image"},
      {"<!DOCTYPE html><html>", "a page of HTML"},
      {"version https://git-lfs.github.com/spec/v1\noid", "a pointer of Git LFS, whose content is not there"},
      {"\xff\xd8\xff\xe0", "a JPEG image"},
      {std::string(6000, '\0'), "something else"},
      {"plywood\n", "something else"}};
  for (const auto& [content, found] : cases)
    CHECK(complaint_about(content) == "a file: byte 0: expected a scene of Gaussians, found " + found);
}

TEST_CASE("scene file: formats without a beginning of their own go by the ending") {
  const std::string record(64, '\1'), gltf = "expected a glTF with Gaussians";
  CHECK(complaint_about(record, "a.splat") == "");
  CHECK(complaint_about(record, "a.SPLAT") == "");
  CHECK(read(ply(plain_gaussian()), "a.splat").format == "INRIA PLY (binary_little_endian)");
  const std::string cases[][3] = {{record, "a.KSplat", "headers of a .ksplat scene"},
                                  {record, "a.splats", "found something else"},
                                  {"glTF", "a", "byte 4: expected 4 bytes for a version"},
                                  {R"({"asset": 1, "meshes": []})", "a", gltf},
                                  {"\n {\"asset\": 1, \"accessors\": []}", "a", gltf},
                                  {R"({"extensionsUsed": ["KHR_gaussian_splatting"]})", "a", gltf},
                                  {"{}", "a.gltf", gltf},
                                  {"{}", "a.GLTF", gltf},
                                  {R"({"fl_x": 1})", "a.json", "found JSON of cameras (transforms.json)"}};
  for (const auto& [content, name, expected] : cases)
    CHECK(contains(complaint_about(content, name), expected));
}

TEST_CASE("scene file: what cannot be opened is an error with its path and reason") {
  const TemporaryFolder folder;
  const std::string missing = (folder / "missing.ply").string() + ": No such file or directory",
                    empty = folder.path().string() + "/: expected a capture, a folder with one .spz, .ply";
  CHECK_THROWS_WITH_AS(read_scene(folder / "missing.ply"), missing.c_str(), std::system_error);
  CHECK_THROWS_WITH_AS(read_scene(folder / ""), doctest::Contains(empty.c_str()), std::invalid_argument);
  CHECK_THROWS_WITH_AS(read_scene("/dev/null"), "/dev/null: expected a regular file", std::system_error);
}

TEST_CASE("mapped file: bytes that are let go of leave the memory and can be read again") {
  const TemporaryFolder folder;
  const long size = 16 << 20;
  const io::MappedFile file(folder.write("a", std::string(std::size_t(size), '\3')));
  const long before = resident_of_files();
  CHECK(sum(file.bytes()) == 3 * size);
  REQUIRE(resident_of_files() - before > size / 2);
  io::let_go({file.bytes(), "a", folder.path(), true}, 1000, std::uint64_t(size) - 1000);
  CHECK(resident_of_files() - before < size / 2);
  CHECK(sum(file.bytes()) == 3 * size);
}

TEST_CASE("mapped file: bytes from elsewhere stay when they are let go of") {
  const std::string content(1 << 20, '\3');
  io::let_go({as_bytes(content), "a"}, 0, content.size());
  CHECK(sum(as_bytes(content)) == 3 << 20);
}

TEST_CASE("mapped file: a scene's file does not stay in memory beside the scene") {
  const TemporaryFolder folder;
  for (const char* ending : {".ply", ".compressed.ply", ".splat"}) {
    CAPTURE(ending);
    const auto path = folder / (std::string("a") + ending);
    const auto size = long(write_scene(path, some_scene(60'000, 3)).bytes);
    const long before = resident_of_files();
    long at_end = -1;
    read_scene(path, {.progress = [&](double part) {
                 if (part == 1) at_end = resident_of_files() - before;
                 return true;
               }});
    REQUIRE(at_end != -1);
    CHECK(at_end < size / 2);
  }
}
