// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <numeric>
#include <system_error>

#include <unistd.h>

#include "mapped_file.hpp"
#include "ply_text.hpp"
#include "scenes.hpp"

namespace swiftgs::test::scene_file_test {

using namespace std::literals;

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
      {R"([{"file": "a.ply"}])", "a list of scenes"},
      {R"({"camera_path": []})", "JSON of cameras (camera_path.json)"},
      {"{}", "a JSON object with no keys"},
      {R"({"b": 1, "a": 2})", "a JSON object with the keys a, b"},
      {"[1]", "a JSON array; a list of scenes has objects with 'file'"},
      {"{'a': 1}", "a text that begins as JSON does and is none"},
      {"// made by hand\n{}", "a text that begins with a comment, which JSON has not"},
      {"\xff\xfe{\0}\0"s, "a text in UTF-16; save it in UTF-8"},
      {"\0{\0}"s, "a text in UTF-16; save it in UTF-8"},
      {"\xff\xfe\0\0{\0\0\0"s, "a text in UTF-32; save it in UTF-8"},
      {"\x89PNG\r\n", "a PNG image"},
      {"<!DOCTYPE html><html>", "a page of HTML"},
      {"version https://git-lfs.github.com/spec/v1\noid", "a pointer of Git LFS, whose content is not there"},
      {"\xff\xd8\xff\xe0", "a JPEG image"},
      {std::string(6000, '\0'), "something else"},
      {"plywood\n", "something else"}};
  for (const auto& [content, found] : cases)
    CHECK(complaint_about(content) == "a file: byte 0: expected a scene of Gaussians, found " + found);
}

// Each begins as the program writes it.
TEST_CASE("scene file: scenes that no reader takes are refused with what to give in their place") {
  const std::string lcc = "an LCC scene of XGRIDS; export a PLY with the program that made it",
                    checkpoint = "a checkpoint of PyTorch; export a PLY with the program that trained it";
  const std::string root =
      R"({"asset": {"version": "1.1"}, "geometricError": 500, "root": {"geometricError": 0, "content": )";
  const std::string extension =
      R"(, "extensions": {"3DTILES_content_gltf": {"extensionsUsed": ["KHR_gaussian_splatting"]}}})";
  const std::string cases[][3] = {
      {root + R"({"uri": "t.glb"}}})", "tileset.json", "a 3D Tiles tileset; give t.glb"},
      {root + R"({"uri": "t.glb"}})" + extension, "a", "a 3D Tiles tileset; give t.glb"},
      {root + R"({"url" : "a.glb"}, "children": [{"content": {"uri": "b/c.glb"}}]}})", "a",
       "a 3D Tiles tileset; give one of its files: a.glb, b/c.glb"},
      {root + "{}}}", "a", "a 3D Tiles tileset; give one of its .glb files"},
      {R"({"version": "5.0", "totalSplats": 9, "fileType": "Portable"})", "a.lcc", lcc},
      {R"({"version": "5.0", "totalSplats": 9, "fileType": "Portable"})", "a", lcc},
      {R"({"a": 1})", "a.LCC2", lcc},
      {R"({"means": {"mins": [0]}, "scales": {}, "quats": {}, "opacities": {}, "sh0": {}, "shN": {}})",
       "meta.json", "the meta.json of gsplat's PngCompression; write a PLY with gsplat's export_splats"},
      {"RAD0\1\0\0\0"s, "a.rad", "a .rad of Spark; give the scene that it was made of"},
      {"\x80\2\x8a\n", "a.pt", checkpoint},
      {"\x80\2\x8a\n", "a.pth", checkpoint},
      {"\x40\0\0\0\0\0\0\0{\"means\""s, "a.safetensors",
       "a file of weights; export a PLY with the program that trained them"},
      {"\x93NUMPY\1\0"s, "a.npy", "an array of NumPy; write a PLY of it"},
      {"\xabKTX 20\xbb", "a.ktx2", "a KTX texture"},
      {"ASTM-E57\1", "a.e57", "an E57 point cloud, which holds no Gaussians"},
      {"LASF\0\0"s, "a.laz", "a LAS point cloud, which holds no Gaussians"},
      {"# Blender 4.2\nv 0 0 0\n", "a.obj", "an OBJ mesh, which holds no Gaussians"},
      {"Kaydara FBX Binary  \0"s, "a.fbx", "an FBX mesh, which holds no Gaussians"},
      {"<?xml version=\"1.0\"?>\n<COLLADA>", "a.dae", "a COLLADA mesh, which holds no Gaussians"},
      {"\xef\xbb\xbf<?xml version=\"1.0\"?><a>", "a.xml", "a file of XML"},
      {"\0\5\x16\7\0\2\0\0"s, "._a.ply",
       "what macOS stores beside a file; give the file whose name lacks the ._"},
      {"RIFF....WEBPVP8L", "a.webp", "a WebP image"},
      {"# Camera list\n", "sparse/0/cameras.txt", "a file of a COLMAP model, which is read by its folder"}};
  for (const auto& [content, name, found] : cases)
    CHECK(complaint_about(content, name) == name + ": byte 0: expected a scene of Gaussians, found " + found);
  // Some bytes say what a file is, whatever its name.
  CHECK(contains(complaint_about("LASF" + std::string(28, '\0'), "a.splat"), "found a LAS point cloud"));
  CHECK(contains(complaint_about("RAD0" + std::string(28, '\0'), "a.ksplat"), "found a .rad of Spark"));
}

// Editors of Windows and PowerShell write the mark.
TEST_CASE("scene file: a byte order mark before a text is skipped") {
  const std::string mark = "\xef\xbb\xbf", gltf = "expected a glTF with Gaussians";
  const std::string cases[][3] = {
      {R"({"asset": 1, "meshes": []})", "a", gltf},
      {" {}", "a.gltf", gltf},
      {R"({"means": 1, "quats": 1})", "meta.json", "found JSON of a SOG in memory"},
      {R"({"lodLevels": 1, "filenames": []})", "lod-meta.json", "found JSON of a SOG in memory"},
      {R"({"fl_x": 1})", "a.json", "found JSON of cameras (transforms.json)"},
      {R"([{"img_name": 1}])", "a.json", "found JSON of cameras (cameras.json)"},
      {"<!DOCTYPE html>", "a.html", "found a page of HTML"},
      {"SGPAGES\n", "a.sgp", "found a page file; draw it by 'swiftgs render'"}};
  for (const auto& [content, name, expected] : cases) {
    CHECK(contains(complaint_about(content, name), expected));
    CHECK(contains(complaint_about(mark + content, name), expected));
  }
  CHECK(complaint_about(mark, "a") == "a: byte 0: expected a scene of Gaussians, found something else");
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

}  // namespace swiftgs::test::scene_file_test
