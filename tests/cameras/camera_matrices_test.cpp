// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <doctest/doctest.h>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <swiftgs/camera_matrices.hpp>

using namespace swiftgs;

namespace {

constexpr int width = 640, height = 360;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Where a graphics library draws a point, by the words of its specification: columns and rows from the top
/// left, and what its depth buffer holds.
dvec3 drawn(const dmat4& view, const dmat4& projection, ClipSpace clip, const dvec3& point) {
  const auto at = projection * (view * glm::dvec4(point, 1));
  const dvec3 ndc(at.x / at.w, at.y / at.w, at.z / at.w);
  const bool y_down = clip == ClipSpace::vulkan;
  return {(ndc.x + 1) / 2 * width, (y_down ? ndc.y + 1 : 1 - ndc.y) / 2 * height,
          clip == ClipSpace::opengl ? (ndc.z + 1) / 2 : ndc.z};
}

/// Where the library does, with depth z.
dvec3 seen(const Camera& camera, const dvec3& point) {
  const dvec3 p = camera.rotation * point + camera.translation;
  return {camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy, p.z};
}

/// Greatest errors over points before the camera: of their pixels, and of their stored depths in units of the
/// depth buffer.
struct Apart {
  double pixels = 0, depth = 0;
};
Apart apart(const HostCamera& host, const dmat4& view, const dmat4& projection, ClipSpace clip) {
  Apart worst;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> in(-1, 1);
  const dvec3 centre = host.camera.centre();
  for (int i = 0; i < 50; ++i) {
    const dvec3 ahead =
        glm::transpose(host.camera.rotation) * dvec3(in(random), in(random), 1.5 + in(random));
    const dvec3 point = centre + 5.0 * ahead;
    const dvec3 theirs = drawn(view, projection, clip, point), ours = seen(host.camera, point);
    worst.pixels = std::max({worst.pixels, std::abs(theirs.x - ours.x), std::abs(theirs.y - ours.y)});
    const StoredDepth& stored = host.stored_depth;
    const double value = (1 / ours.z - stored.s) / stored.r;  // q is 1, p is 0
    worst.depth = std::max(worst.depth, std::abs(value - theirs.z));
    // A float holds the value to half a unit of its last place.
    CHECK(1 / stored.depth(float(theirs.z)) ==
          doctest::Approx(1 / ours.z).epsilon(1e-6 + 1e-7 * std::abs(stored.r) * ours.z));
  }
  CHECK(host.stored_depth.p == 0);
  CHECK(host.stored_depth.q == 1);
  return worst;
}

const dvec3 eye(3, 2, 5), target(0.5, -0.25, 0.1), up(0.1, 1, 0.2);

}  // namespace

TEST_CASE("camera matrices: what GLM makes for each library is drawn at the same pixels and depths") {
  const dmat4 right = glm::lookAtRH(eye, target, up), left = glm::lookAtLH(eye, target, up);
  const double fov = 0.9, ratio = double(width) / height, n = 0.1, f = 50;
  const double x = 0.05, y = 0.03;  // half sides of the near plane
  struct Case {
    const char* name;
    dmat4 view, projection;
    ClipSpace clip;
  };
  dmat4 flipped = glm::perspectiveRH_ZO(fov, ratio, n, f);
  flipped[1][1] *= -1;
  dmat4 upside_down = glm::perspectiveRH_NO(fov, ratio, n, f);
  upside_down[1][1] *= -1;
  dmat4 jittered = glm::perspectiveRH_NO(fov, ratio, n, f);
  jittered = glm::translate(dmat4(1.0), dvec3(0.37 / width, -0.21 / height, 0)) * jittered;
  dmat4 infinite_reversed(0.0);
  infinite_reversed[0][0] = 1.2, infinite_reversed[1][1] = 2.1;
  infinite_reversed[2][3] = -1, infinite_reversed[3][2] = n;
  const Case cases[] = {
      {"OpenGL", right, glm::perspectiveRH_NO(fov, ratio, n, f), ClipSpace::opengl},
      {"OpenGL, left-handed", left, glm::perspectiveLH_NO(fov, ratio, n, f), ClipSpace::opengl},
      {"OpenGL, reversed", right, glm::perspectiveRH_NO(fov, ratio, f, n), ClipSpace::opengl},
      {"OpenGL, infinite", right, glm::infinitePerspective(fov, ratio, n), ClipSpace::opengl},
      {"OpenGL, off-centre", right, glm::frustumRH_NO(-x, 2 * x, -3 * y, y, n, f), ClipSpace::opengl},
      {"OpenGL, upside down", right, upside_down, ClipSpace::opengl},
      {"OpenGL, jittered", right, jittered, ClipSpace::opengl},
      {"Vulkan, flipped", right, flipped, ClipSpace::vulkan},
      {"Vulkan, off-centre", left, glm::frustumLH_ZO(-x, 2 * x, -3 * y, y, n, f), ClipSpace::vulkan},
      {"Vulkan, reversed", left, glm::perspectiveLH_ZO(fov, ratio, f, n), ClipSpace::vulkan},
      {"Direct3D", left, glm::perspectiveLH_ZO(fov, ratio, n, f), ClipSpace::direct3d},
      {"Direct3D, right-handed", right, glm::perspectiveRH_ZO(fov, ratio, n, f), ClipSpace::direct3d},
      {"Direct3D, off-centre", left, glm::frustumLH_ZO(-x, 2 * x, -3 * y, y, n, f), ClipSpace::direct3d},
      {"Direct3D, reversed, infinite", right, infinite_reversed, ClipSpace::direct3d}};
  for (const Case& each : cases) {
    CAPTURE(each.name);
    const HostCamera host = camera_from(each.view, each.projection, width, height, each.clip);
    const Apart worst = apart(host, each.view, each.projection, each.clip);
    CHECK(worst.pixels < 1e-9);
    CHECK(worst.depth < 1e-12);
  }
  const Camera centred = camera_from(right, cases[0].projection, width, height, ClipSpace::opengl).camera;
  CHECK(glm::length(centred.centre() - eye) < 1e-12);
  CHECK(centred.fy == doctest::Approx(height / 2 / std::tan(fov / 2)));
  // Clip space is two units wide, so 0.37 / width of it is half of 0.37 pixels.
  const Camera moved = camera_from(right, jittered, width, height, ClipSpace::opengl).camera;
  CHECK(moved.cx - centred.cx == doctest::Approx(0.37 / 2));
  CHECK(moved.cy - centred.cy == doctest::Approx(0.21 / 2));
}

TEST_CASE("camera matrices: the camera that they are of comes back") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> in(-1, 1);
  for (int i = 0; i < 300; ++i) {
    Camera camera = look_at(10.0 * dvec3(in(random), in(random), in(random)), dvec3(in(random)),
                            dvec3(in(random), 2, in(random)), 1 + 0.8 * in(random), 1 + int(random() % 4096),
                            1 + int(random() % 4096));
    camera.fx *= 1.2 + in(random), camera.cx += camera.width * in(random),
        camera.cy += camera.height * in(random);
    if (i % 5 == 0)
      for (int column = 0; column < 3; ++column) camera.rotation[column][i % 3] *= -1;
    if (i % 5 == 0) camera.translation[i % 3] *= -1;
    const double near = std::pow(10, 2 * in(random)), span = std::pow(10, 3.6 + 3.4 * in(random));  // to 1e7
    for (const double far : {near * span, infinity})
      for (const bool reversed : {false, true})
        for (const ClipSpace clip : {ClipSpace::opengl, ClipSpace::vulkan, ClipSpace::direct3d}) {
          const double at_0 = reversed ? far : near, at_1 = reversed ? near : far;
          const CameraMatrices m = matrices(camera, at_0, at_1, clip);
          CAPTURE(i);
          CAPTURE(at_0);
          CAPTURE(at_1);
          CAPTURE(int(clip));
          const auto compare = [&](const HostCamera& host, double digits, double depth_digits) {
            const Camera& back = host.camera;
            for (int column = 0; column < 3; ++column)
              CHECK(glm::length(back.rotation[column] - camera.rotation[column]) < digits);
            CHECK(glm::length(back.translation - camera.translation) <= digits * 20);
            CHECK(std::abs(back.fx - camera.fx) <= digits * camera.fx);
            CHECK(std::abs(back.fy - camera.fy) <= digits * camera.fy);
            CHECK(std::abs(back.cx - camera.cx) <= 4 * digits * camera.width);
            CHECK(std::abs(back.cy - camera.cy) <= 4 * digits * camera.height);
            CHECK(back.width == camera.width);
            CHECK(back.height == camera.height);
            const StoredDepth wanted = StoredDepth::perspective(at_0, at_1);
            CHECK(std::abs(host.stored_depth.r - wanted.r) <= depth_digits * std::abs(wanted.r));
            CHECK(std::abs(host.stored_depth.s - wanted.s) <= depth_digits / near);
          };
          compare(camera_from(m.view, m.projection, camera.width, camera.height, clip), 1e-13, 1e-9);
          // In float too, and clip space of OpenGL loses a bit: far itself is not among what a float keeps.
          compare(camera_from(glm::mat4(m.view), glm::mat4(m.projection), camera.width, camera.height, clip),
                  2e-7, 5e-7);
        }
  }
}

TEST_CASE("camera matrices: a frame lies as the program's images do") {
  const Camera camera = look_at(eye, target, up, 0.9, width, height);
  std::vector<unsigned char> image(8 * width * height);
  std::vector<float> depth(width * height);
  for (const ClipSpace clip : {ClipSpace::opengl, ClipSpace::vulkan, ClipSpace::direct3d}) {
    CAPTURE(int(clip));
    const CameraMatrices m = matrices(camera, 0.1, 50, clip);
    const HostCamera host = camera_from(m.view, m.projection, width, height, clip);
    const FrameView frame = host.frame(image.data(), depth.data(), PixelFormat::rgba_half);
    CHECK(frame.width == width);
    CHECK(frame.height == height);
    CHECK(frame.format == PixelFormat::rgba_half);
    CHECK(!frame.over);
    const int top = clip == ClipSpace::opengl ? height - 1 : 0;
    for (const int y : {0, 1, height - 1}) {
      const int row = std::abs(top - y);
      CHECK(frame.colour.row(std::size_t(y)) == &image[std::size_t(8 * width * row)]);
      CHECK(frame.occluder.row(std::size_t(y)) == &depth[std::size_t(width * row)]);
    }
    depth[std::size_t(width * std::abs(top - 2) + 3)] = 1;
    CHECK(frame.occluder_at(3, 2) == doctest::Approx(50));
    CHECK(host.frame(image.data(), nullptr).occluder.data == nullptr);
    CHECK(bytes_per_pixel(host.frame(image.data(), nullptr).format) == 4);
  }
}

TEST_CASE("camera matrices: the near plane of a float matrix stays where it is") {
  // A depth of 0 or 1, at a ratio of 1e7 and whatever the far plane has become.
  const Camera camera = look_at(eye, target, up, 0.9, width, height);
  for (const ClipSpace clip : {ClipSpace::opengl, ClipSpace::vulkan, ClipSpace::direct3d})
    for (const bool reversed : {false, true}) {
      const double near = 0.01, far = 1e5;
      const CameraMatrices m = matrices(camera, reversed ? far : near, reversed ? near : far, clip);
      const StoredDepth stored =
          camera_from(glm::mat4(m.view), glm::mat4(m.projection), width, height, clip).stored_depth;
      CHECK(stored.depth(reversed ? 1.0f : 0.0f) == doctest::Approx(near).epsilon(1e-6));
      // OpenGL's own clip space loses the digits of reversed depth.
      if (reversed && clip != ClipSpace::opengl)
        CHECK(stored.depth(0.0f) == doctest::Approx(far).epsilon(1e-5));
    }
}

TEST_CASE("camera matrices: matrices of any library are the same") {
  const CameraMatrices m = matrices(look_at(eye, target, up, 0.9, width, height), 0.1, 50, ClipSpace::opengl);
  const auto of = [](const auto& view, const auto& projection) {
    const HostCamera host = camera_from(view, projection, width, height, ClipSpace::opengl);
    const Camera& c = host.camera;
    return std::tuple(c.translation, c.rotation, c.fx, c.fy, c.cx, c.cy, host.stored_depth.r);
  };
  const auto wanted = of(m.view, m.projection);
  using RowMajor = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const Eigen::Map<const Eigen::Matrix4d> view(&m.view[0][0]), projection(&m.projection[0][0]);
  CHECK(of(view, projection) == wanted);
  CHECK(of(RowMajor(view), RowMajor(projection)) == wanted);
  CHECK(of(Eigen::Isometry3d(Eigen::Matrix4d(view)), projection * 1.0) == wanted);
  CHECK(of(view.data(), projection.data()) == wanted);
  double plain[4][4];
  std::array<double, 16> array{};
  std::copy_n(view.data(), 16, plain[0]), std::copy_n(projection.data(), 16, array.data());
  CHECK(of(plain, array) == wanted);
  CHECK(of(plain, std::vector<double>(array.begin(), array.end())) == wanted);
  CHECK(of([&](int row, int column) { return view(row, column); }, projection) == wanted);
  // As of XMFLOAT4X4 and osg::Matrix, for vectors that are rows.
  const auto row_vectors = [&](int row, int column) { return view(column, row); };
  CHECK_THROWS_WITH_AS(of(row_vectors, projection),
                       doctest::Contains("osg::Matrix, is passed as a pointer to its numbers"),
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(of(plain, std::vector<double>(12)),
                       "camera_from: projection has 12 numbers, expected 16", std::invalid_argument);
}

TEST_CASE("camera matrices: what is no camera is refused by name") {
  const CameraMatrices good = matrices(look_at(dvec3(0, 0, 4), dvec3(0), dvec3(0, 1, 0), 0.9, width, height),
                                       0.1, 50, ClipSpace::opengl);
  CHECK_NOTHROW(camera_from(good.view, good.projection, width, height, ClipSpace::opengl));
  const auto refused = [&](const char* text, const auto& change) {
    CameraMatrices m = good;
    change(m.view, m.projection);
    CHECK_THROWS_WITH_AS(camera_from(m.view, m.projection, width, height, ClipSpace::opengl),
                         doctest::Contains(text), std::invalid_argument);
  };
  using M = dmat4&;
  refused("camera_from: projection: row 3 is (0, 0, 0, 1), expected (0, 0, -1, 0) or (0, 0, 1, 0): ",
          [](M, M p) { p = glm::ortho(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0); });
  refused("the projection is orthographic", [](M, M p) { p = glm::ortho(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0); });
  refused("camera_from: projection: row 3 is (0, 0, -0.2004", [](M, M p) { p = glm::transpose(p); });
  refused("camera_from: projection: row 0 is (1.1", [](M, M p) { p[1][0] = 0.01; });
  refused("0 in column 1: the projection is sheared", [](M, M p) { p[1][0] = 0.01; });
  refused("projection: row 1 is (0.3, 2.07016, 0, 0), expected 0 in column 0: the projection is",
          [](M, M p) { p[0][1] = 0.3; });
  refused("projection: row 0 is (1.16446, 0, 0, 0.5), expected 0 in column 3: the projection moves",
          [](M, M p) { p[3][0] = 0.5; });
  refused("camera_from: projection: row 2 is (0.1, 0, ", [](M, M p) { p[0][2] = 0.1; });
  refused("camera_from: projection: row 2 is (0, 0, ", [](M, M p) { p[3][2] = 0; });
  refused("camera_from: projection: row 1 is (0, nan, ", [](M, M p) { p[1][1] = std::nan(""); });
  refused("camera: expected focal lengths", [](M, M p) { p[1][1] = 0; });
  refused("view: row 3 is (0, 0, -4, 1), expected (0, 0, 0, 1); numbers are read column by column",
          [](M v, M) { v = glm::transpose(v); });
  refused("camera_from: view: row 0 is (2, 0, 0) of length 2, expected length 1: the view is scaled",
          [](M v, M) { v[0][0] = 2; });
  refused("view: row 0 is (1, 0, 0) and row 1 is (0.6, 0.8, 0) of product 0.6, expected rows at right angles",
          [](M v, M) { v[0][1] = 0.6, v[1][1] = 0.8; });
  refused("camera_from: view: the determinant of its rotation is -1, expected 1: the view is mirrored",
          [](M v, M) { v[0][0] = -1; });
  refused("camera_from: view: row 1 is (0, 1, 0, inf)", [](M v, M) { v[3][1] = infinity; });
  CHECK_THROWS_WITH_AS(camera_from(good.view, good.projection, 0, height, ClipSpace::opengl),
                       "camera: expected a width and a height above 0", std::invalid_argument);
}

TEST_CASE("camera matrices: what the message on a mirrored view says draws the mirrored world") {
  CameraMatrices m = matrices(look_at(eye, target, up, 0.9, width, height), 0.1, 50, ClipSpace::vulkan);
  for (int column = 0; column < 4; ++column)
    m.view[column][0] *= -1;  // by a mirror of the world or the image
  dmat4 view = m.view, projection = m.projection;
  for (int i = 0; i < 4; ++i) view[i][2] *= -1, projection[2][i] *= -1;
  const HostCamera host = camera_from(view, projection, width, height, ClipSpace::vulkan);
  CHECK(apart(host, m.view, m.projection, ClipSpace::vulkan).pixels < 1e-9);
  CHECK(glm::determinant(host.camera.rotation) == doctest::Approx(-1));
}

TEST_CASE("camera matrices: cameras without matrices are refused") {
  Camera camera = look_at(eye, target, up, 0.9, width, height);
  const auto made = [&](double at_0, double at_1) { matrices(camera, at_0, at_1, ClipSpace::vulkan); };
  CHECK_THROWS_WITH_AS(made(0, 5),
                       "matrices: depths at 0 and 1 are 0 and 5, expected two numbers above 0 that differ",
                       std::invalid_argument);
  for (const auto& [at_0, at_1] :
       {std::pair{2.0, 2.0}, {infinity, infinity}, {std::nan(""), 2.0}, {-1.0, 2.0}})
    CHECK_THROWS_AS(made(at_0, at_1), std::invalid_argument);
  camera.lens.distortion.radial[0] = 0.1;
  CHECK_THROWS_WITH_AS(made(1, 2), "matrices: the camera's lens is distorted, expected a pinhole",
                       std::invalid_argument);
  camera.lens = {LensModel::fisheye, {}};
  CHECK_THROWS_WITH_AS(made(1, 2), "matrices: the camera's lens is fisheye, expected a pinhole",
                       std::invalid_argument);
}
