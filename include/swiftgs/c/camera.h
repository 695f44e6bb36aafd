/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_C_CAMERA_H
#define SWIFTGS_C_CAMERA_H

/// @file
/// Cameras: plain structs, from files and from matrices of other renderers, and what depth buffers hold.

#include <stddef.h>
#include <stdint.h>

#include <swiftgs/c/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/// How a lens maps directions to its plane. The point (x, y, z) of camera space is shown at (u, v):
enum {
  SWIFTGS_LENS_PERSPECTIVE = 0,     ///< (x / z, y / z), for z > 0
  SWIFTGS_LENS_FISHEYE = 1,         ///< the angle to the axis times (x, y) / |(x, y)|: equidistant
  SWIFTGS_LENS_ORTHOGRAPHIC = 2,    ///< (x, y): parallel rays
  SWIFTGS_LENS_EQUIRECTANGULAR = 3  ///< azimuth atan2(x, z), elevation atan2(y, |(x, z)|) @units{radians}
};

/// Camera, OpenCV axes (x right, y down, z forward): p_camera = rotation p_world + translation. World axes
/// are the scene's own, right-handed; in scenes of captures y points down, so that up is about -y. The lens
/// shows p_camera at (u, v), distortion moves that, and the image shows it at (fx u + cx, fy v + cy). Pixel
/// (column i, row j) is sampled at (i + 0.5, j + 0.5); the principal point may lie anywhere. Numbers have no
/// default, but a lens of zeros is that of a pinhole.
///
/// Distortion is of perspective and fisheye lenses alone. With r^2 = u^2 + v^2 it moves (u, v) to
///   u R + 2 p0 u v + p1 (r^2 + 2 u^2) + s0 r^2,  v R + p0 (r^2 + 2 v^2) + 2 p1 u v + s1 r^2,
///   R = (1 + k0 r^2 + k1 r^4 + k2 r^6 + k3 r^8) / (1 + q0 r^2 + q1 r^4 + q2 r^6),
/// which is OpenCV's model of both lenses. Each number is at most 1e6 in magnitude.
typedef struct swiftgs_camera {
  uint32_t size;          ///< `sizeof(swiftgs_camera)`
  int32_t width, height;  ///< 1 to 65536; equirectangular: a row has at most 2 pi fx pixels @units{pixels}
  int32_t lens;           ///< `SWIFTGS_LENS_...`
  double rotation[9];     ///< @shape{3, 3} world to camera, row after row, orthonormal
  double translation[3];  ///< camera-space position of the world's origin
  double fx, fy;          ///< focal lengths, 1e-6 to 1e12 @units{pixels}, per unit of the lens's plane
  double cx, cy;          ///< principal point from the top left corner, at most 1e9 @units{pixels}
  double radial[4];       ///< k
  double rational[3];     ///< q
  double tangential[2];   ///< p
  double prism[2];        ///< s
} swiftgs_camera;

/// Cameras of a file, and notes on it.
typedef struct swiftgs_cameras swiftgs_cameras;

/// Reads cameras: an INRIA cameras.json, a transforms.json of nerfstudio, instant-ngp or Blender, a
/// camera_path.json of nerfstudio, the folder of a COLMAP model, or the folder of a capture that holds one of
/// these. docs/formats.md says what is read. Errors: `SWIFTGS_FORMAT_ERROR`, `SWIFTGS_SYSTEM_ERROR` for what
/// cannot be read, `SWIFTGS_INVALID_ARGUMENT` for a folder without cameras.
SWIFTGS_C_API swiftgs_status swiftgs_cameras_read(const char* path, swiftgs_cameras** cameras);
SWIFTGS_C_API void swiftgs_cameras_free(swiftgs_cameras* cameras);

SWIFTGS_C_API swiftgs_status swiftgs_cameras_count(const swiftgs_cameras* cameras, size_t* count);
/// Fills `camera`, whose size is set. `SWIFTGS_INVALID_ARGUMENT` beyond the last, and for a camera that is no
/// pinhole if the program is older than lenses.
SWIFTGS_C_API swiftgs_status swiftgs_cameras_get(const swiftgs_cameras* cameras, size_t index,
                                                 swiftgs_camera* camera);
/// The name of the image that a camera belongs to, as the file has it.
SWIFTGS_C_API swiftgs_status swiftgs_cameras_name(const swiftgs_cameras* cameras, size_t index,
                                                  const char** name);

/// How many notes reading brought up.
SWIFTGS_C_API swiftgs_status swiftgs_cameras_note_count(const swiftgs_cameras* cameras, size_t* count);
/// A sentence on what the file holds that may change a picture and was not read. `SWIFTGS_INVALID_ARGUMENT`
/// beyond the last.
SWIFTGS_C_API swiftgs_status swiftgs_cameras_note(const swiftgs_cameras* cameras, size_t index,
                                                  const char** note);

/// From where to where a camera looks, for `swiftgs_camera_look_at`.
typedef struct swiftgs_look_at {
  uint32_t size;          ///< `sizeof(swiftgs_look_at)`
  int32_t width, height;  ///< @units{pixels}
  uint32_t reserved;      ///< 0
  double eye[3];          ///< in the world
  double target[3];       ///< a point that appears in the image's centre
  double up[3];           ///< points up in the image; scenes of captures often have y pointing down
  double vertical_fov;    ///< the full angle, more than 0 and less than pi @units{radians}
} swiftgs_look_at;

/// Fills `camera`, whose size is set, with the principal point in the centre of the image.
SWIFTGS_C_API swiftgs_status swiftgs_camera_look_at(const swiftgs_look_at* from, swiftgs_camera* camera);

/// Changes `camera` to the same view at `scale` times the size; sides are rounded to whole pixels, at least
/// one. `SWIFTGS_INVALID_ARGUMENT` for what is no camera.
SWIFTGS_C_API swiftgs_status swiftgs_camera_scale(swiftgs_camera* camera, double scale);

/// How values of a depth buffer stand for depths: value d for (p d + q) / (r d + s), or for nothing where
/// r d + s is not above 0. All 0: d is the depth.
typedef struct swiftgs_stored_depth {
  double p, q, r, s;
} swiftgs_stored_depth;

/// That of a perspective projection of OpenGL (its window depth), Vulkan or Direct3D, by the depths at the
/// values 0 and 1: those of the near and the far plane, or with reversed depth of the far and the near one.
/// Either may be infinite.
SWIFTGS_C_API swiftgs_stored_depth swiftgs_stored_perspective(double at_0, double at_1);
/// That of an orthographic projection.
SWIFTGS_C_API swiftgs_stored_depth swiftgs_stored_orthographic(double at_0, double at_1);

/// Where a graphics library has the image's top and the ends of its depth.
enum {
  SWIFTGS_CLIP_OPENGL = 0,   ///< y up, depth from -1 to 1
  SWIFTGS_CLIP_VULKAN = 1,   ///< y down, depth from 0 to 1
  SWIFTGS_CLIP_DIRECT3D = 2  ///< y up, depth from 0 to 1; of Metal, WebGPU and OpenGL's glClipControl
};

/// The matrices of a program that draws a point of the world at projection view point. Points are columns,
/// and matrices lie column by column, as OpenGL takes them; row vectors row by row, as Direct3D's, are the
/// same numbers.
typedef struct swiftgs_matrices {
  uint32_t size;          ///< `sizeof(swiftgs_matrices)`
  int32_t clip_space;     ///< `SWIFTGS_CLIP_...`
  int32_t width, height;  ///< of the image @units{pixels}
  double view[16];        ///< world to camera, right-handed or left-handed, a rotation and a translation
  double projection[16];  ///< perspective: off-centre, jittered, flipped, reversed or infinite as it may be
} swiftgs_matrices;

/// Fills `camera`, whose size is set, and `stored_depth`, that of the program's depth buffer, or NULL.
/// `SWIFTGS_INVALID_ARGUMENT` with matrix and row for what is no pinhole: an orthographic or sheared
/// projection, a scaled or mirrored view, a wrong bottom row, a NaN.
SWIFTGS_C_API swiftgs_status swiftgs_camera_from_matrices(const swiftgs_matrices* from,
                                                          swiftgs_camera* camera,
                                                          swiftgs_stored_depth* stored_depth);

/// Fills `matrices`, whose size is set, with those that draw as `camera` sees: y up, looking along -z, or
/// along z if the camera's determinant is -1. The depth buffer holds 0 and 1 at the depths `at_0` and `at_1`:
/// near and far, or far and near for reversed depth; the far one may be infinite. `SWIFTGS_INVALID_ARGUMENT`
/// for a camera that is no pinhole and for other depths.
SWIFTGS_C_API swiftgs_status swiftgs_camera_to_matrices(const swiftgs_camera* camera, int32_t clip_space,
                                                        double at_0, double at_1, swiftgs_matrices* matrices);

/// A movement of a camera around a point.
typedef struct swiftgs_orbit {
  uint32_t size;      ///< `sizeof(swiftgs_orbit)`
  uint32_t reserved;  ///< 0
  double target[3];   ///< the point, which stays where it is in the image
  double up[3];       ///< the axis, of any length; zeros: -y
  double turn;        ///< about the axis, to the camera's right @units{radians}
  double rise;        ///< towards `up`, never within a degree of the axis @units{radians}
  double distance;    ///< times the distance; divides an orthographic camera's focal lengths; 0: 1
} swiftgs_orbit;

/// Moves `camera`.
SWIFTGS_C_API swiftgs_status swiftgs_camera_orbit(swiftgs_camera* camera, const swiftgs_orbit* by);

/// Fills `camera`, whose size is set, with the view that the built-in scene is composed for.
SWIFTGS_C_API swiftgs_status swiftgs_camera_builtin(int32_t width, int32_t height, swiftgs_camera* camera);

#ifdef __cplusplus
}
#endif

#endif
