// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Cameras of programs that draw with OpenGL, Vulkan or Direct3D: from their matrices, and to them.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdio>
#include <string>
#include <type_traits>

#include <swiftgs/camera.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/math.hpp>

namespace swiftgs {

/// Where a graphics library has the image's top and the ends of its depth.
enum class ClipSpace {
  opengl,  ///< y up, depth from -1 to 1
  vulkan,  ///< y down, depth from 0 to 1
  /// y up, depth from 0 to 1. So have Metal and WebGPU, Vulkan where the height of the viewport is negative,
  /// and OpenGL after glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE): set `HostCamera::bottom_row_first` for
  /// that.
  direct3d,
};

/// A program's own camera.
struct HostCamera {
  Camera camera;
  StoredDepth stored_depth;       ///< of its depth buffer, for `FrameView::stored_depth`
  bool bottom_row_first = false;  ///< in its memory, as images of OpenGL lie there

  /// A frame in the program's memory: `colour` of `format`, and its depth buffer as stored, or null. Rows lie
  /// densely.
  FrameView frame(void* colour, const float* depth, PixelFormat format = PixelFormat::rgba_8) const {
    const auto plane = [&]<class T>(T* first, std::size_t bytes) {
      const Plane<T> down{first, std::ptrdiff_t(bytes) * camera.width};
      return bottom_row_first ? Plane<T>{down.from(0, camera.height - 1).data, -down.pitch} : down;
    };
    return {.width = camera.width,
            .height = camera.height,
            .colour = plane(colour, bytes_per_pixel(format)),
            .format = format,
            .occluder = plane(depth, sizeof(float)),
            .stored_depth = stored_depth};
  }
};

/// A program's matrices, for vectors that are columns: clip = projection * view * world.
struct CameraMatrices {
  dmat4 view{1.0}, projection{1.0};
};

namespace detail {

struct Matrix4 {
  double at[4][4];  ///< [row][column]
};

template <class>
inline constexpr bool is_no_matrix = false;

/// Of GLM, m[column][row]; of Eigen, Qt and the like, m(row, column); or of 16 numbers column by column.
template <class M>
Matrix4 matrix_of(const M& m, const char* name) {
  Matrix4 out;
  const auto fill = [&](const auto& entry) {
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column) out.at[row][column] = double(entry(row, column));
  };
  if constexpr (requires {
                  { m(0, 0) } -> std::convertible_to<double>;
                }) {
    fill([&](int row, int column) { return m(row, column); });
  } else if constexpr (requires {
                         { m[0][0] } -> std::convertible_to<double>;
                       }) {
    if constexpr (requires { M::length(); }) static_assert(M::length() == 4, "expected four columns");
    fill([&](int row, int column) { return m[column][row]; });
  } else if constexpr (requires {
                         { m[0] } -> std::convertible_to<double>;
                       }) {
    if constexpr (requires { m.size(); })
      if (m.size() != 16) refuse("camera_from: ", name, " has ", m.size(), " numbers, expected 16");
    fill([&](int row, int column) { return m[4 * column + row]; });
  } else {
    static_assert(is_no_matrix<M>, "expected m[column][row], m(row, column), or 16 numbers column by column");
  }
  return out;
}

inline std::string text_of(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", number + 0.0);  // 0, not -0
  return text;
}

inline std::string row_of(const Matrix4& m, int row, int columns = 4) {
  std::string text = "row " + std::to_string(row) + " is (";
  for (int column = 0; column < columns; ++column) text += (column ? ", " : "") + text_of(m.at[row][column]);
  return text + ")";
}

[[noreturn]] inline void refuse_matrix(const char* name, const std::string& found,
                                       const std::string& expected) {
  refuse("camera_from: ", name, ": ", found, ", expected ", expected);
}

inline constexpr const char* if_transposed =
    "; numbers are read column by column, so transpose a matrix stored by rows; one for row vectors, such as "
    "XMFLOAT4X4 or osg::Matrix, is passed as a pointer to its numbers";

/// What rounding may leave where a matrix has 0 or 1, for products of matrices in float.
inline constexpr double matrix_rounding = 1e-6;

inline void require_finite(const char* name, const Matrix4& m) {
  for (int row = 0; row < 4; ++row)
    for (const double number : m.at[row])
      if (!detail::is_finite(number)) refuse_matrix(name, row_of(m, row), "finite numbers");
}

inline void validate_view(const Matrix4& view) {
  const char* const name = "view";
  require_finite(name, view);
  const double(&bottom)[4] = view.at[3];
  if (std::max({std::abs(bottom[0]), std::abs(bottom[1]), std::abs(bottom[2]), std::abs(bottom[3] - 1)}) >
      matrix_rounding)
    refuse_matrix(name, row_of(view, 3), std::string("(0, 0, 0, 1)") + if_transposed);
  const auto axis = [&](int row) { return dvec3(view.at[row][0], view.at[row][1], view.at[row][2]); };
  for (int row = 0; row < 3; ++row) {
    const double squared = dot(axis(row), axis(row));
    if (!(std::abs(squared - 1) < max_rotation_error))
      refuse_matrix(name, row_of(view, row, 3) + " of length " + text_of(std::sqrt(squared)),
                    "length 1: the view is scaled; scale a placed scene instead");
  }
  for (int row = 0; row < 3; ++row) {
    const int next = (row + 1) % 3;
    const double product = dot(axis(row), axis(next));
    if (!(std::abs(product) < max_rotation_error))
      refuse_matrix(
          name, row_of(view, row, 3) + " and " + row_of(view, next, 3) + " of product " + text_of(product),
          "rows at right angles: the view is sheared");
  }
  const double determinant = dot(cross(axis(0), axis(1)), axis(2));
  if (determinant < 0)
    refuse_matrix(name, "the determinant of its rotation is " + text_of(determinant),
                  "1: the view is mirrored; for the image of a mirrored world negate row 2 of the view and "
                  "column 2 of the projection");
}

inline void validate_projection(const Matrix4& projection) {
  const char* const name = "projection";
  require_finite(name, projection);
  const double(&m)[4][4] = projection.at;
  const auto is_zero = [&](int row, int column, double beside) {
    return std::abs(m[row][column]) <= matrix_rounding * std::abs(beside);
  };
  if (m[3][0] == 0 && m[3][1] == 0 && m[3][2] == 0 && m[3][3] != 0)
    refuse_matrix(name, row_of(projection, 3),
                  "(0, 0, -1, 0) or (0, 0, 1, 0): the projection is orthographic, which does not tell where "
                  "it looks; use look_at and LensModel::orthographic");
  if (!is_zero(3, 0, 1) || !is_zero(3, 1, 1) || !is_zero(3, 3, 1) ||
      !(std::abs(std::abs(m[3][2]) - 1) <= matrix_rounding))
    refuse_matrix(name, row_of(projection, 3), std::string("(0, 0, -1, 0) or (0, 0, 1, 0)") + if_transposed);
  for (int row = 0; row < 2; ++row) {
    if (!is_zero(row, 1 - row, m[row][row]))
      refuse_matrix(name, row_of(projection, row),
                    "0 in column " + std::to_string(1 - row) + ": the projection is sheared or turned");
    if (!is_zero(row, 3, m[row][row]))
      refuse_matrix(name, row_of(projection, row),
                    "0 in column 3: the projection moves the camera; move the view instead");
  }
  const double depth = std::abs(m[2][2]) + std::abs(m[2][3]);
  if (!is_zero(2, 0, depth) || !is_zero(2, 1, depth) || m[2][3] == 0)
    refuse_matrix(name, row_of(projection, 2),
                  "(0, 0, a, b) with b not 0: depth does not go with the distance along the axis, as of an "
                  "oblique near plane");
}

inline HostCamera camera_of(const Matrix4& view, const Matrix4& projection, int width, int height,
                            ClipSpace clip) {
  validate_view(view), validate_projection(projection);
  const double(&m)[4][4] = projection.at;
  // The camera's axes are those of the view, each turned so that x goes right, y down and z forward.
  const double down = clip == ClipSpace::vulkan ? 1 : -1;
  const double forward = std::copysign(1, m[3][2]);
  const double turned[3] = {std::copysign(1, m[0][0]), std::copysign(1, down * m[1][1]), forward};
  HostCamera host;
  Camera& camera = host.camera;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      camera.rotation[column][row] = turned[row] * view.at[row][column];
    camera.translation[row] = turned[row] * view.at[row][3];
  }
  camera.width = width, camera.height = height;
  camera.fx = 0.5 * width * std::abs(m[0][0]), camera.cx = 0.5 * width * (1 + forward * m[0][2]);
  camera.fy = 0.5 * height * std::abs(m[1][1]), camera.cy = 0.5 * height * (1 + down * forward * m[1][2]);
  validate(camera);

  // The depth buffer has a + b / z.
  double a = forward * m[2][2], b = m[2][3];
  if (clip == ClipSpace::opengl) a = 0.5 * (a + 1), b = 0.5 * b;
  host.stored_depth = {0, 1, 1 / b, -a / b};
  host.bottom_row_first = clip == ClipSpace::opengl;
  return host;
}

}  // namespace detail

/// The camera of a program that draws a point of the world at `projection` * `view` * point, and what its
/// depth buffer holds.
///
/// Matrices are for vectors that are columns, in float or double: GLM's, Eigen's, what else has m(row,
/// column) or m[column][row], or 16 numbers column by column, as OpenGL takes them. Matrices for row vectors
/// that lie row by row are the same numbers: pass a pointer to them, `&m.m[0][0]` of DirectXMath's XMFLOAT4X4
/// or `m.ptr()` of osg::Matrix. The view may be right-handed or left-handed, looking along
/// -z or z, with y up or down: the projection tells. Off-centre projections, jitter, axes flipped by a
/// negative number in the projection, and near and far planes in any order or infinite are as they are.
///
/// The camera is in the world of the view. Where that world is left-handed its rotation is a mirror, and the
/// scene shows as the program's own meshes of the same numbers would.
///
/// Throws `InvalidArgument` that names matrix and row if it is no pinhole: an orthographic or sheared
/// projection, one that moves the camera or has an oblique near plane, a scaled, sheared or mirrored view, a
/// wrong bottom row, a NaN; and as `validate` of a camera.
template <class View, class Projection>
HostCamera camera_from(const View& view, const Projection& projection, int width, int height,
                       ClipSpace clip) {
  return detail::camera_of(detail::matrix_of(view, "view"), detail::matrix_of(projection, "projection"),
                           width, height, clip);
}

/// Matrices with which a program draws as `camera` sees, for its own meshes. The view is right-handed, with
/// y up and looking along -z; that of a camera of determinant -1 looks along z. The depth buffer holds 0 and
/// 1 at the depths `at_0` and `at_1`: near and far, or far and near for reversed depth; the far one may be
/// infinite. GLM converts them to float by `glm::mat4(m.view)`; `&m.view[0][0]` are 16 numbers column by
/// column.
///
/// Throws `InvalidArgument` if the camera is no pinhole or depths are not above 0 and different.
inline CameraMatrices matrices(const Camera& camera, double at_0, double at_1, ClipSpace clip) {
  validate(camera);
  if (!camera.lens.is_pinhole())
    detail::refuse("matrices: the camera's lens is ",
                   camera.lens.is_distorted() ? "distorted" : name_of(camera.lens.model),
                   ", expected a pinhole");
  const double near = std::min(at_0, at_1), far = std::max(at_0, at_1);
  if (!(near > 0 && near < far))
    detail::refuse("matrices: depths at 0 and 1 are ", detail::text_of(at_0), " and ", detail::text_of(at_1),
                   ", expected two numbers above 0 that differ");
  const dvec3 x(camera.rotation[0][0], camera.rotation[1][0], camera.rotation[2][0]);
  const dvec3 y(camera.rotation[0][1], camera.rotation[1][1], camera.rotation[2][1]);
  const dvec3 z(camera.rotation[0][2], camera.rotation[1][2], camera.rotation[2][2]);
  const double forward = detail::dot(detail::cross(x, y), z) > 0 ? -1 : 1;
  const double turned[3] = {1, -1, forward};
  CameraMatrices out;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      out.view[column][row] = turned[row] * camera.rotation[column][row];
    out.view[3][row] = turned[row] * camera.translation[row];
  }
  const double down = clip == ClipSpace::vulkan ? 1 : -1;
  dmat4& m = out.projection;
  m = dmat4(0.0);
  m[0][0] = 2 * camera.fx / camera.width, m[2][0] = forward * (2 * camera.cx / camera.width - 1);
  m[1][1] = -down * 2 * camera.fy / camera.height;
  m[2][1] = down * forward * (2 * camera.cy / camera.height - 1);
  m[2][3] = forward;
  // a + b / z is 0 and 1 at these depths. The ratio keeps digits of 1 / at_1 - 1 / at_0, and an infinity out.
  const double ratio = near / far, rest = 1 - ratio;
  double a = 1 / rest, b = -near / rest;
  if (at_0 > at_1) a = -ratio / rest, b = near / rest;
  if (clip == ClipSpace::opengl) a = 2 * a - 1, b = 2 * b;
  m[2][2] = forward * a, m[3][2] = b;
  return out;
}

}  // namespace swiftgs
