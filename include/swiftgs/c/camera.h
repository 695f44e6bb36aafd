/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_C_CAMERA_H
#define SWIFTGS_C_CAMERA_H

/// @file
/// Cameras: plain structs, and lists of them from files.

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

/// Camera, OpenCV axes (x right, y down, z forward): p_camera = rotation p_world + translation. The lens
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

/// Fills `camera`, whose size is set, with the view that the built-in scene is composed for.
SWIFTGS_C_API swiftgs_status swiftgs_camera_builtin(int32_t width, int32_t height, swiftgs_camera* camera);

#ifdef __cplusplus
}
#endif

#endif
