// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "ply_text.hpp"
#include "scenes.hpp"
#include "spz_encoder.hpp"

namespace swiftgs::test::archives_test {

namespace {

const std::string start = "a file: byte 0: expected a scene of Gaussians, found ";

/// A tar archive as GNU tar 1.34 writes it, without the owner.
std::string tar(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string archive;
  for (const auto& [name, content] : files) {
    std::string header(512, '\0');
    header.replace(0, name.size(), name);
    char size[12];
    std::snprintf(size, sizeof size, "%011o", unsigned(content.size()));
    header.replace(124, 11, size);
    header.replace(257, 7, "ustar  ");
    archive += header + content + std::string((512 - content.size() % 512) % 512, '\0');
  }
  return archive + std::string(1024, '\0');
}

const std::string scene = ply(plain_gaussian(), {.repeat = 20});

/// Files that are no scenes, and what they are said to be.
using Cases = std::vector<std::pair<std::string, std::string>>;

void check_found(const Cases& cases) {
  for (const auto& [content, found] : cases) CHECK(complaint_about(content) == start + found);
}

}  // namespace

TEST_CASE("archives: a ZIP is told by the scenes in it and with what to do") {
  check_found({{zip({{"point_cloud.ply", scene}}),
                "a ZIP archive with point_cloud.ply in it; unpack it and give that file"},
               {zip({{"a.ply", scene}, {"b.spz", ""}, {"cfg_args", ""}}, {.deflate = true}),
                "a ZIP archive with a.ply, b.spz in it; unpack it and give one of these files"},
               {zip({{"a.txt", ""}, {"b.txt", ""}}), "a ZIP archive of other files: a.txt, b.txt"},
               {zip({{"a.ply", scene}}).substr(0, 90), "a ZIP archive"},
               {zip({{"0/meta.json", "{}"}, {"lod-meta.json", "{}"}}),
                "a ZIP archive of a streamed SOG; unpack it and give lod-meta.json"},
               {zip({{"means.npy", "x"}, {"quats.npy", "x"}}), "arrays of NumPy (.npz); write a PLY of them"},
               // gsplat 1.5.3, ckpt_29999_rank0.pt; torch.save of PyTorch 2 names the folder after the file.
               {zip({{"ckpt_29999_rank0/data.pkl", "x"}, {"ckpt_29999_rank0/data/0", "x"}}),
                "a checkpoint of PyTorch; export a PLY with the program that trained it"}});
  CHECK(
      contains(complaint_about(zip({{"scan/meta.json", "{}"}})), "'meta.json' in it, found scan/meta.json"));
}

TEST_CASE("archives: a tar is told by the scenes in it") {
  const std::string archive = tar({{"model/cfg_args", "x"}, {"model/point_cloud.ply", scene}});
  const std::string with = " with model/point_cloud.ply in it; unpack it and give that file";
  check_found({{archive, "a tar archive" + with},
               {gzip(archive), "a gzip file of a tar archive" + with},
               {tar({{"a.txt", ""}}), "a tar archive of other files: a.txt"}});
  for (const std::size_t length : {512, 700, 1024, 1500})
    CHECK(contains(complaint_about(archive.substr(0, length)), "of other files: model/cfg_args"));
}

// bsdtar 3.5 on macOS, and any tar with --format=pax.
TEST_CASE("archives: what tar and macOS store beside a file is no scene") {
  std::string archive = tar({{"PaxHeaders/x.ply", "30 mtime=1\n"}, {"._x.ply", "x"}, {"x.ply", scene}});
  archive[156] = 'x';
  const std::string with = " with x.ply in it; unpack it and give that file";
  check_found({{archive, "a tar archive" + with},
               {zip({{"__MACOSX/._x.ply", "x"}, {"x.ply", scene}}), "a ZIP archive" + with}});
}

TEST_CASE("archives: gzip is told by what is in it") {
  const std::string unpack = "; unpack it with gunzip", file = gzip(scene);
  check_found({{file, "a gzip file of a PLY" + unpack},
               {file.substr(0, file.size() - 9), "a gzip file of a PLY" + unpack},
               {gzip("glTF 2"), "a gzip file of a glTF" + unpack},
               {gzip("<html>"), "a gzip file of a page of HTML"},
               {gzip(R"({"asset": {}, "buffers": []})"), "a gzip file of a glTF" + unpack},
               {gzip(std::string("\0\1\0\0\1\0\0\0\1", 9) + std::string(6000, '\0')),
                "a gzip file of a .ksplat" + unpack},
               {gzip("something"), "a gzip file of something else; if it is a .splat, unpack it with gunzip"},
               // A gzip file that unpacks to itself would otherwise never end.
               {gzip(file), "a gzip file of a gzip file" + unpack},
               {gzip(gzip(gzip(file))), "a gzip file of a gzip file" + unpack}});
  CHECK(contains(complaint_about(gzip("a")), "header in the gzip stream"));
}

TEST_CASE("archives: those that are not listed are named") {
  check_found({{"7z\xbc\xaf\x27\x1c", "a 7z archive; unpack it and give the scene in it"},
               {"Rar!\x1a\x07", "a RAR archive; unpack it and give the scene in it"}});
  CHECK(contains(complaint_about("\x28\xb5\x2f\xfd"), "packed by zstd; unpack it"));
  CHECK(contains(complaint_about("\3757zXZ"), "packed by xz; unpack it"));
  CHECK(contains(complaint_about("BZh9"), "packed by bzip2; unpack it"));
}

TEST_CASE("archives: the ending .splat makes no scene of a file that says what it is") {
  const auto padded = [](std::string text) { return text.resize((text.size() / 32 + 1) * 32), text; };
  for (const std::string& content :
       {padded(zip({{"a.splat", std::string(32, 'x')}})),
        padded("version https://git-lfs.github.com/spec/v1"), padded("<!DOCTYPE html>"),
        padded("7z\xbc\xaf\x27\x1c"), padded(gzip(scene))})
    CHECK(contains(complaint_about(content, "a.splat"), "expected a scene of Gaussians, found a"));
  CHECK(complaint_about(padded("{}"), "a.splat") == "");  // a coordinate may begin so
}

}  // namespace swiftgs::test::archives_test
