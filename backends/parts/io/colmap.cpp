// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <string>

#include "camera_parsing.hpp"
#include "colmap_models.hpp"
#include "text.hpp"

namespace swiftgs::io {
namespace {

/// Lines of a file, which end as in any system. The last one needs no line break.
class Lines {
 public:
  explicit Lines(const Source& source) : Lines(source, mark_bytes(source.text())) { expect_utf8(source); }
  Lines(const Source& source, std::uint64_t offset) : source_(source), position_(offset) {}

  /// The next line that is neither empty nor a comment. False at the end.
  bool next(std::string_view& line) {
    while (next_any(line))
      if (const std::string_view words = Tokens(line).rest(); !words.empty() && words.front() != '#')
        return true;
    return false;
  }

  /// The next line, whatever it holds. False at the end.
  bool next_any(std::string_view& line) {
    const std::string_view text = source_.text();
    if (position_ == text.size()) return false;
    start_ = position_, ++number_;
    line = text.substr(start_, text.find_first_of("\r\n", start_) - start_);
    position_ = start_ + line.size();
    const std::size_t line_break = text.substr(position_).starts_with("\r\n") ? 2 : 1;
    position_ = std::min(position_ + line_break, text.size());
    return true;
  }

  std::uint64_t start() const { return start_; }
  std::string number() const { return std::to_string(number_); }
  [[noreturn]] void fail(const std::string& expected) const { source_.fail(start_, expected); }

 private:
  const Source& source_;
  std::size_t position_, start_ = 0, number_ = 0;
};

template <class T>
T number(const Lines& lines, Tokens& tokens, const char* what) {
  T value{};
  if (!to_number(tokens.next(), value)) lines.fail(std::string("a number for ") + what);
  return value;
}

Camera camera_of_line(const Source& source, std::uint64_t offset) {
  Lines lines(source, offset);
  std::string_view line;
  lines.next(line);
  Tokens tokens(line);
  tokens.next();  // its id
  const std::string_view name = tokens.next();
  const ColmapModel* model = colmap_model(name);
  if (!model) refuse_model(source, offset, listed({std::string(name)}));
  Camera camera;
  camera.width = to_side(source, offset, number<double>(lines, tokens, "a width"));
  camera.height = to_side(source, offset, number<double>(lines, tokens, "a height"));
  std::array<double, ColmapModel::most_parameters> parameters{};
  for (int p = 0; p < model->parameters; ++p)
    parameters[p] = number<double>(lines, tokens, "a camera parameter");
  if (!tokens.at_end()) lines.fail(std::to_string(model->parameters) + " camera parameters, found more");
  set_intrinsics(camera, *model, parameters, source, offset);
  return camera;
}

ColmapCameras find_lines_of_cameras(const Source& source) {
  ColmapCameras cameras(source, camera_of_line);
  Lines lines(source);
  for (std::string_view line; lines.next(line);) {
    Tokens tokens(line);
    cameras.add(number<std::uint32_t>(lines, tokens, "a camera id"), lines.start());
  }
  return cameras;
}

/// Reads the line of 2D points behind that of an image. It is empty for an image without any, and the last
/// one may be missing. Throws `FormatError` for a line of anything else, such as the next image.
void skip_points(Lines& lines) {
  const std::string image = lines.number();
  std::string_view line;
  if (!lines.next_any(line)) return;
  const auto fail = [&](std::string_view found) {
    std::string expected = "the 2D points of the image of line " + image + " in line " + lines.number();
    lines.fail(expected.append(", X Y POINT3D_ID each, or an empty line, found ").append(found));
  };
  std::size_t count = 0;
  double value;
  for (Tokens tokens(line); !tokens.at_end(); ++count)
    if (const std::string_view word = tokens.next(); !to_number(word, value)) fail(word.substr(0, 40));
  if (count % 3 != 0) fail(std::to_string(count) + " numbers");
}

}  // namespace

std::vector<Camera> parse_colmap_text(const Source& cameras, const Source& images) {
  const ColmapCameras known = find_lines_of_cameras(cameras);
  std::vector<Camera> result;
  Lines lines(images);
  for (std::string_view line; lines.next(line);) {
    Tokens tokens(line);
    number<std::uint32_t>(lines, tokens, "an image id");
    std::array<double, 7> numbers;
    for (double& value : numbers) value = number<double>(lines, tokens, "a pose");
    const auto [w, x, y, z, tx, ty, tz] = numbers;
    const auto camera_id = number<std::uint32_t>(lines, tokens, "a camera id");
    const std::string_view name = tokens.rest();  // may hold blanks
    if (name.empty()) lines.fail("an image name");
    result.push_back(known.place(images, lines.start(), {w, x, y, z, dvec3(tx, ty, tz), camera_id}, name));
    skip_points(lines);
  }
  return result;
}

namespace {

/// What a camera's record begins with.
struct Head {
  std::uint32_t id;
  const ColmapModel* model;
};

/// Throws `FormatError` for a model that is not known: nobody can tell where its record ends.
Head read_head(const Source& source, ByteReader& reader) {
  const auto id = reader.read<std::uint32_t>("a camera id");
  const std::uint64_t start = reader.position();
  const auto number = reader.read<std::int32_t>("a camera model");
  const ColmapModel* model = colmap_model(number);
  if (!model) refuse_model(source, start, "number " + std::to_string(number));
  return {id, model};
}

Camera camera_at(const Source& source, std::uint64_t offset) {
  ByteReader reader(source, offset);
  const ColmapModel& model = *read_head(source, reader).model;
  Camera camera;
  camera.width = to_side(source, offset, double(reader.read<std::uint64_t>("a width")));
  camera.height = to_side(source, offset, double(reader.read<std::uint64_t>("a height")));
  std::array<double, ColmapModel::most_parameters> parameters{};
  for (int p = 0; p < model.parameters; ++p) parameters[p] = reader.read<double>("a camera parameter");
  set_intrinsics(camera, model, parameters, source, offset);
  return camera;
}

ColmapCameras find_cameras(const Source& source) {
  ColmapCameras cameras(source, camera_at);
  ByteReader reader(source);
  const auto count = reader.read<std::uint64_t>("the number of cameras");
  constexpr std::uint64_t least_bytes = 4 + 4 + 8 + 8 + 2 * 8;
  reader.expect(count, least_bytes, "cameras");
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t start = reader.position();
    const Head head = read_head(source, reader);
    reader.take(std::uint64_t(8 + 8 + 8 * head.model->parameters), "a camera's size and parameters");
    cameras.add(head.id, start);
  }
  reader.expect_end("the last camera");
  return cameras;
}

}  // namespace

std::vector<Camera> parse_colmap_binary(const Source& cameras, const Source& images) {
  const ColmapCameras known = find_cameras(cameras);
  ByteReader reader(images);
  const auto count = reader.read<std::uint64_t>("the number of images");
  constexpr std::uint64_t least_bytes = 4 + 7 * 8 + 4 + 1 + 8, point_bytes = 24;
  reader.expect(count, least_bytes, "images");
  std::vector<Camera> result;
  result.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t start = reader.position();
    reader.read<std::uint32_t>("an image id");
    std::array<double, 7> numbers;
    for (double& number : numbers) number = reader.read<double>("a pose");
    const auto [w, x, y, z, tx, ty, tz] = numbers;
    const auto camera_id = reader.read<std::uint32_t>("a camera id");
    const std::string_view name = reader.c_string("an image name");
    const auto points = reader.read<std::uint64_t>("the number of points");
    reader.expect(points, point_bytes, "points");
    reader.take(points * point_bytes, "points");
    result.push_back(known.place(images, start, {w, x, y, z, dvec3(tx, ty, tz), camera_id}, name));
  }
  reader.expect_end("the last image");
  return result;
}

}  // namespace swiftgs::io
