// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/io/scene_file.hpp>

#include "ply_text.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

std::string complaint_about(const std::string& content) {
  return complaint([&] { read_scene(as_bytes(content), "test.ply"); });
}

/// `content` with its first `from` replaced.
std::string with(std::string content, const std::string& from, const std::string& to) {
  return content.replace(content.find(from), from.size(), to);
}

}  // namespace

TEST_CASE("ply: a file that ends early is refused wherever it ends") {
  const auto read = [](const std::string& content) { read_scene(as_bytes(content), "test.ply"); };
  check_every_truncation(ply(plain_gaussian(), {.repeat = 2}), read);
  check_every_truncation(ply(plain_gaussian(), {.format = "binary_big_endian", .line_break = "\r\n"}), read);
  std::string list;
  append_value(list, "ushort", 2);
  append_value(list, "double", 1), append_value(list, "double", 2);
  check_every_truncation(
      ply(plain_gaussian(),
          {.after = "element extra 1\nproperty list ushort double values\n", .after_rows = list}),
      read);
}

TEST_CASE("ply: an ascii file that ends early never crashes") {
  const std::string file = ply(plain_gaussian(), {.format = "ascii", .repeat = 2});
  const std::size_t last_row = file.rfind("1 2 -3");
  for (std::size_t length = 0; length <= last_row; ++length)
    CHECK(complaint_about(file.substr(0, length)) != "");
  for (std::size_t length = last_row; length < file.size(); ++length)
    CHECK_NOTHROW(complaint_about(file.substr(0, length)));
}

TEST_CASE("ply: a count that the file cannot hold is refused before memory is taken") {
  const std::string file = ply(plain_gaussian());
  for (const char* count : {"2", "13000000", "4294967296", "18446744073709551615"}) {
    const std::string message = complaint_about(with(file, "vertex 1", std::string("vertex ") + count));
    CAPTURE(count);
    CHECK(contains(message, "test.ply: byte "));
    CHECK(contains(message, "56 bytes"));
  }
  CHECK(contains(complaint_about(with(file, "vertex 1", "vertex 0")), "56 more bytes"));
  CHECK(contains(complaint_about(file + "x"), "1 more bytes"));
  for (const char* count : {"-1", "18446744073709551616", "1.5", "x", ""})
    CHECK(contains(complaint_about(with(file, "vertex 1", std::string("vertex ") + count)), "COUNT"));
  const std::string ascii = ply(plain_gaussian(), {.format = "ascii"});
  CHECK(contains(complaint_about(with(ascii, "vertex 1", "vertex 4000000000")), "rows of 'vertex'"));
  CHECK(complaint_about(ascii + "7") != "");
}

TEST_CASE("ply: lengths of lists are checked") {
  const auto file = [](const char* type, double length) {
    std::string rows;
    append_value(rows, type, length);
    return ply(plain_gaussian(), {.before = std::string("element e 1\nproperty list ") + type + " double v\n",
                                  .before_rows = rows});
  };
  CHECK(contains(complaint_about(file("int", -1)), "list length"));
  CHECK(contains(complaint_about(file("char", -1)), "list length"));
  CHECK(contains(complaint_about(file("short", -1)), "list length"));
  CHECK(contains(complaint_about(file("uint", 4294967295.0)), "34359738360 bytes"));
  CHECK(contains(complaint_about(file("float", 0)), "integer type"));
}

TEST_CASE("ply: a missing property is named") {
  for (const char* name :
       {"x", "y", "z", "opacity", "scale_0", "scale_1", "rot_0", "rot_3", "f_dc_0", "f_dc_2"}) {
    auto gaussian = plain_gaussian();
    remove(gaussian, name);
    CHECK(contains(complaint_about(ply(gaussian)), std::string("'") + name + "'"));
  }
}

TEST_CASE("ply: SH coefficients must be as many as a degree has and be numbered") {
  auto gaussian = plain_gaussian();
  for (int i = 0; i < 9; ++i) gaussian.push_back({"float", "f_rest_" + std::to_string(i), 0});
  CHECK(complaint_about(ply(gaussian)) == "");
  gaussian.back().name = "f_rest_9";
  CHECK(contains(complaint_about(ply(gaussian)), "f_rest_8"));
  gaussian.pop_back();
  CHECK(contains(complaint_about(ply(gaussian)), "found 8"));
}

TEST_CASE("ply: a header line that means nothing is placed") {
  const std::string file = ply(plain_gaussian());
  const std::size_t at = file.find("element vertex");
  CHECK(contains(complaint_about(with(file, "element vertex", "elephant vertex")),
                 "byte " + std::to_string(at) + ": expected a PLY header line"));
  CHECK(contains(complaint_about(with(file, "binary_little_endian", "binary_middle")), "binary_big_endian"));
  CHECK(contains(complaint_about(with(file, " 1.0", " 2.0")), "version 1.0"));
  CHECK(contains(complaint_about(with(file, "float x", "quad x")), "a PLY type"));
  CHECK(contains(complaint_about(with(file, "float x", "float y")), "once"));
  CHECK(contains(complaint_about(with(file, "property float x", "property float")), "TYPE NAME"));
  CHECK(contains(complaint_about(with(file, "format", "comment")), "'format' line"));
  CHECK(contains(complaint_about(with(file, "ply\n", "ply\nproperty float x\n")), "element before"));
  CHECK(contains(complaint_about(with(file, "element vertex", "element vertices")), "'vertex'"));
  CHECK(contains(complaint_about(with(file, "element vertex 1", "element vertex 0\nelement vertex 1")),
                 "once"));
  CHECK(contains(complaint_about(with(file, "property float x", "property list int float x")), "list 'x'"));
}

TEST_CASE("ply: a last line needs no line break in a header or in text") {
  const std::string text = ply(plain_gaussian(), {.format = "ascii"});
  const std::string rows = text.substr(0, text.find_last_not_of(" \r\n") + 1);
  CHECK(complaint_about(rows) == "");
  CHECK(complaint_about(rows + "\n") == "");
  const std::string header = text.substr(0, text.find("end_header") + 10);
  CHECK(complaint_about(with(header, "element vertex 1", "element vertex 0")) == "");
  CHECK(contains(complaint_about(header), "1 rows of 'vertex'"));
  CHECK(contains(complaint_about(header.substr(0, header.size() - 11)),
                 "expected a PLY header that ends in a line 'end_header'"));
}

TEST_CASE("ply: packed vertices without chunks are refused") {
  CHECK(contains(complaint_about(ply({{"uint", "packed_position", 0}})), "an element 'chunk'"));
}

TEST_CASE("ply: a word that is no number is placed") {
  const std::string file = ply(plain_gaussian(), {.format = "ascii"});
  const std::string message = complaint_about(with(file, "0.25", "0,25"));
  CHECK(contains(message, "byte " + std::to_string(file.find("0.25")) + ": expected a number for 'f_dc_0'"));
}
