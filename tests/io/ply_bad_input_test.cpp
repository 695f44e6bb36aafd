// SPDX-License-Identifier: Apache-2.0
#include "ply_text.hpp"
#include "scenes.hpp"

namespace swiftgs::test::ply_bad_input_test {

TEST_CASE("ply: an ascii file that ends early never crashes") {
  const std::string file = ply(plain_gaussian(), {.format = "ascii", .repeat = 2});
  const std::size_t last_row = file.rfind("1 2 -3");
  for (std::size_t length = 0; length <= last_row; ++length)
    CHECK(complaint_about(file.substr(0, length)) != "");
  for (std::size_t length = last_row; length < file.size(); ++length)
    CHECK_NOTHROW(complaint_about(file.substr(0, length)));
}

TEST_CASE("ply: the first line is ply alone") {
  for (const std::string line_break : {"\r", " \r"})
    CHECK(complaint_about(ply(plain_gaussian(), {.format = "ascii", .line_break = line_break})) ==
          "a file: byte 0: expected header lines that end in LF or CR LF, found CR alone, as old Macs wrote");
  const std::string file = ply(plain_gaussian());
  for (const std::string first : {"ply x\n", "plyx\n", "PLY\n", "\nply\n", " ply\n"})
    CHECK(complaint_about(with(file, "ply\n", first)) ==
          "a file: byte 0: expected a scene of Gaussians, found something else");
}

TEST_CASE("ply: a count that the file cannot hold is refused before memory is taken") {
  const std::string file = ply(plain_gaussian()), ascii = ply(plain_gaussian(), {.format = "ascii"});
  const auto counted = [](const std::string& content, const std::string& count) {
    return complaint_about(with(content, "vertex 1", "vertex " + count));
  };
  for (const char* count : {"2", "13000000", "4294967296", "18446744073709551615"}) {
    CAPTURE(count);
    CHECK(contains(counted(file, count), "a file: byte "));
    CHECK(contains(counted(file, count), "56 bytes"));
  }
  for (const char* count : {"-1", "18446744073709551616", "1.5", "x", ""})
    CHECK(contains(counted(file, count), "COUNT"));
  CHECK(contains(counted(file, "0"), "56 more bytes"));
  CHECK(contains(complaint_about(file + "x"), "1 more bytes"));
  CHECK(contains(counted(ascii, "4000000000"), "rows of 'vertex'"));
  CHECK(complaint_about(ascii + "7") != "");
}

TEST_CASE("ply: lengths of lists are checked") {
  const struct {
    std::string type;
    double length;
    const char* expected;
  } cases[] = {{"int", -1, "list length"},
               {"char", -1, "list length"},
               {"short", -1, "list length"},
               {"uint", 4294967295.0, "34359738360 bytes"},
               {"float", 0, "integer type"}};
  for (const auto& [type, length, expected] : cases) {
    PlyParts parts{.before = "element e 1\nproperty list " + type + " double v\n"};
    append_value(parts.before_rows, type, length);
    CHECK(contains(complaint_about(ply(plain_gaussian(), parts)), expected));
  }
}

TEST_CASE("ply: a missing property is named") {
  for (const char* name :
       {"x", "y", "z", "opacity", "scale_0", "scale_1", "rot_0", "rot_3", "f_dc_0", "f_dc_2"}) {
    auto gaussian = plain_gaussian();
    remove(gaussian, name);
    CHECK(contains(complaint_about(ply(gaussian)), std::string("'") + name + "'"));
  }
  CHECK(contains(complaint_about(ply({{"uint", "packed_position", 0}})), "an element 'chunk'"));
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

TEST_CASE("ply: a header line that means nothing is refused") {
  const std::string file = ply(plain_gaussian());
  const std::string place = "byte " + std::to_string(file.find("element vertex"));
  const std::string cases[][3] = {
      {"element vertex", "elephant vertex", place + ": expected a PLY header line"},
      {"binary_little_endian", "binary_middle", "binary_big_endian"},
      {" 1.0", " 2.0", "version 1.0"},
      {"float x", "quad x", "a PLY type"},
      {"float x", "float y", "once"},
      {"property float x", "property float", "TYPE NAME"},
      {"format", "comment", "'format' line"},
      {"ply\n", "ply\nproperty float x\n", "element before"},
      {"element vertex", "element vertices", "'vertex'"},
      {"element vertex 1", "element vertex 0\nelement vertex 1", "once"},
      {"property float x", "property list int float x", "list 'x'"}};
  for (const auto& [from, to, expected] : cases)
    CHECK_MESSAGE(contains(complaint_about(with(file, from, to)), expected), to);
}

TEST_CASE("ply: a last line needs no line break in a header or in text") {
  const std::string text = ply(plain_gaussian(), {.format = "ascii"});
  const std::string rows = text.substr(0, text.find_last_not_of(" \r\n") + 1);
  CHECK(complaint_about(rows) == "");
  CHECK(complaint_about(rows + "\n") == "");
  const std::string header = text.substr(0, text.find("end_header") + 10);
  CHECK(complaint_about(with(header, "element vertex 1", "element vertex 0")) == "");
  CHECK(contains(complaint_about(header), "1 rows of 'vertex'"));
  CHECK(contains(complaint_about(header.substr(0, header.size() - 11)), "ends in a line 'end_header'"));
}

TEST_CASE("ply: a word that is no number is placed") {
  const std::string file = ply(plain_gaussian(), {.format = "ascii"});
  const std::string message = complaint_about(with(file, "0.25", "0,25"));
  CHECK(contains(message, "byte " + std::to_string(file.find("0.25")) + ": expected a number for 'f_dc_0'"));
}

}  // namespace swiftgs::test::ply_bad_input_test
