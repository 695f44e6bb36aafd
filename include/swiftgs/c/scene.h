/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_C_SCENE_H
#define SWIFTGS_C_SCENE_H

/// @file
/// Scenes: from files, from arrays, to files.

#include <stdint.h>

#include <swiftgs/c/camera.h>
#include <swiftgs/c/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Gaussians in the host's memory, which never change. Renderers that were given a scene share it: free it as
/// soon as you like.
typedef struct swiftgs_scene swiftgs_scene;

/// Called several times a second with the part that is done: from 0 to 1, never less than before. Return 0 to
/// go on; anything else cancels. Runs in the thread that called the function, and must not throw.
typedef int32_t (*swiftgs_progress)(void* context, double part);

/// Called with a sentence for each thing that a file does not carry or that was changed for it.
typedef void (*swiftgs_note)(void* context, const char* sentence);

/// World axes of an SPZ file; letters name where +x, +y, +z point (Right, Left, Up, Down, Forward, Back).
enum {
  SWIFTGS_SPZ_SPECIFIED = 0,  ///< what the file says; without a word RUB
  SWIFTGS_SPZ_RUB = 1,        ///< OpenGL's axes
  SWIFTGS_SPZ_RDF = 2,        ///< COLMAP's axes, those of a scene in memory
  SWIFTGS_SPZ_LUF = 3,        ///< glTF's axes
  SWIFTGS_SPZ_RAW = 4         ///< numbers as stored
};

typedef struct swiftgs_read_options {
  uint32_t size;              ///< `sizeof(swiftgs_read_options)`
  int32_t spz_axes;           ///< `SWIFTGS_SPZ_...`
  int32_t level;              ///< of detail, in a streamed SOG: 0 is the finest
  uint32_t reserved;          ///< 0
  swiftgs_progress progress;  ///< or NULL
  swiftgs_note note;          ///< or NULL
  void* context;              ///< what both are called with
} swiftgs_read_options;

/// Reads a scene of any format that docs/formats.md lists. The content decides which; `.splat` goes by the
/// name. `path` may also be the folder of a capture. Gaussians with a NaN or an infinity are counted and left
/// out. `options` may be NULL. Errors: `SWIFTGS_FORMAT_ERROR`, `SWIFTGS_CANCELLED`, `SWIFTGS_SYSTEM_ERROR`.
SWIFTGS_C_API swiftgs_status swiftgs_scene_read(const char* path, const swiftgs_read_options* options,
                                                swiftgs_scene** scene);

/// A file's bytes in memory; `name` stands for the file in messages. Neither is used after the call.
typedef struct swiftgs_file_bytes {
  uint32_t size;      ///< `sizeof(swiftgs_file_bytes)`
  uint32_t reserved;  ///< 0
  const void* data;
  uint64_t count;  ///< @units{bytes}
  const char* name;
} swiftgs_file_bytes;

/// As `swiftgs_scene_read`. A file that names other files cannot be read so.
SWIFTGS_C_API swiftgs_status swiftgs_scene_read_bytes(const swiftgs_file_bytes* bytes,
                                                      const swiftgs_read_options* options,
                                                      swiftgs_scene** scene);

/// One array of floats. The floats of one Gaussian lie side by side.
typedef struct swiftgs_array {
  const float* data;
  int64_t stride;  ///< from a Gaussian to the next, at least what one takes; 0: that @units{bytes}
} swiftgs_array;

/// Where arrays lie.
enum {
  SWIFTGS_HOST = 0,
  SWIFTGS_DEVICE = 1  ///< memory of the current CUDA device; the library must have been built with CUDA
};

/// What arrays hold in place of activated numbers, as files of training do. Flags are added.
enum {
  SWIFTGS_LOG_SCALES = 1,       ///< natural logarithms of scales
  SWIFTGS_LOGIT_OPACITIES = 2,  ///< opacities before the sigmoid
  SWIFTGS_ANY_ROTATIONS = 4,    ///< quaternions of any length, which are normalised; zeros are the identity
  SWIFTGS_PLAIN_COLOURS = 8     ///< colours in `sh0`, in place of coefficients
};

/// Gaussians in arrays. Without `raw` they are activated, and used with the bits that they have.
typedef struct swiftgs_gaussians {
  uint32_t size;             ///< `sizeof(swiftgs_gaussians)`
  int32_t sh_degree;         ///< 0 to 3
  uint64_t count;            ///< N, less than 2^32
  swiftgs_array means;       ///< @shape{N, 3} world position less `origin`
  swiftgs_array scales;      ///< @shape{N, 3} standard deviation along each local axis, 0 or more
  swiftgs_array rotations;   ///< @shape{N, 4} unit quaternions w, x, y, z, local axes to world
  swiftgs_array opacities;   ///< @shape{N} 0 to 1
  swiftgs_array sh0;         ///< @shape{N, 3} SH coefficient of band 0, RGB
  swiftgs_array sh_rest;     ///< @shape{N, (sh_degree + 1)^2 - 1, 3} bands 1 and up, RGB innermost
  int32_t memory;            ///< `SWIFTGS_HOST` or `SWIFTGS_DEVICE`
  uint32_t raw;              ///< sum of `SWIFTGS_LOG_SCALES`, ...
  int32_t antialiased;       ///< 1: trained with Mip-Splatting's opacity compensation
  int32_t feature_channels;  ///< floats a Gaussian in `features`
  void* stream;            ///< of arrays on a device: a `cudaStream_t` that has them ready; NULL: the default
  swiftgs_array features;  ///< @shape{N, feature_channels} whatever else is drawn of a Gaussian
  double origin[3];        ///< where the means' zero lies in the world; renderers do not look at it
  float blur;              ///< that it was trained with; 0: the usual 0.3; negative: none @units{pixels^2}
  int32_t order;           ///< `SWIFTGS_ORDER_...` that it was trained with
  int32_t colours;         ///< `SWIFTGS_COLOURS_...` that it was trained with
  int32_t kernel;          ///< `SWIFTGS_KERNEL_...`
} swiftgs_gaussians;

/// What was trained.
enum {
  SWIFTGS_KERNEL_ELLIPSOID = 0,  ///< 3D Gaussians
  SWIFTGS_KERNEL_DISK = 1        ///< 2D Gaussians, drawn as 3D ones that are flat: not as they were trained
};

/// Copies arrays into a scene. Arrays of a device are brought to the host; the copy waits for `stream`. To
/// draw them on that device, use `swiftgs_renderer_set_gaussians`. A Gaussian with a NaN or an infinity stays
/// in the scene, and renderers refuse it. Errors: `SWIFTGS_INVALID_ARGUMENT`, `SWIFTGS_OUT_OF_MEMORY`; on a
/// device `SWIFTGS_DEVICE_ERROR`, and `SWIFTGS_UNAVAILABLE` where this build has no device.
SWIFTGS_C_API swiftgs_status swiftgs_scene_from_arrays(const swiftgs_gaussians* gaussians,
                                                       swiftgs_scene** scene);

/// A scene that needs no file, in `count` Gaussians of SH degree 3: the same picture at any count. 200,000
/// show it well. `SWIFTGS_INVALID_ARGUMENT` from 2^32 on.
SWIFTGS_C_API swiftgs_status swiftgs_scene_builtin(uint64_t count, swiftgs_scene** scene);

SWIFTGS_C_API void swiftgs_scene_free(swiftgs_scene* scene);

typedef struct swiftgs_scene_info {
  uint32_t size;             ///< `sizeof(swiftgs_scene_info)`
  int32_t sh_degree;         ///< 0 to 3
  uint64_t count;            ///< Gaussians
  uint64_t stored;           ///< Gaussians in the file; `count` for a scene that is not from a file
  uint64_t dropped;          ///< those of them that were left out: not finite, or without a rotation
  float lower[3];            ///< least coordinates of all finite means, less `origin`; 0 if there are none
  float upper[3];            ///< greatest
  int32_t antialiased;       ///< 1: trained with Mip-Splatting's opacity compensation
  int32_t feature_channels;  ///< floats a Gaussian in `features`
  const char* format;        ///< such as "SPZ version 4", until the scene is freed; "" if not from a file
  /// Where the means' zero lies in the world, other than 0 in scenes far from the world's zero. Frames know
  /// nothing of it: add rotation origin to the translation of each camera of the world.
  double origin[3];
  float blur;       ///< that it was trained with @units{pixels^2}
  int32_t order;    ///< `SWIFTGS_ORDER_...` that it was trained with
  int32_t colours;  ///< `SWIFTGS_COLOURS_...` that it was trained with
  int32_t kernel;   ///< `SWIFTGS_KERNEL_...`
} swiftgs_scene_info;

/// Fills `info`, whose size is set. Reads all means.
SWIFTGS_C_API swiftgs_status swiftgs_scene_get_info(const swiftgs_scene* scene, swiftgs_scene_info* info);

/// Fills `gaussians`, whose size is set, with the scene's own arrays: activated, dense, on the host, valid
/// until the scene is freed. Read them only. `SWIFTGS_INVALID_ARGUMENT` for a scene with an origin if the
/// program is older than origins.
SWIFTGS_C_API swiftgs_status swiftgs_scene_get_arrays(const swiftgs_scene* scene,
                                                      swiftgs_gaussians* gaussians);

/// Fills `camera`, whose size is set, with that of the photograph that the scene was made of, in the world.
/// Where the file has none, all members but the size are zero: no renderer takes a camera of width 0.
SWIFTGS_C_API swiftgs_status swiftgs_scene_get_camera(const swiftgs_scene* scene, swiftgs_camera* camera);

/// Where most of a scene lies, in the coordinates of its means: less `origin`.
typedef struct swiftgs_scene_bounds {
  uint32_t size;           ///< `sizeof(swiftgs_scene_bounds)`
  uint32_t reserved;       ///< 0
  double low[3], high[3];  ///< box of all but the outermost 2 % to each side along each axis
  double centre[3];        ///< median along each axis
  double radius;           ///< half of the Gaussians are as near to the centre; above 0
} swiftgs_scene_bounds;

/// Fills `bounds`, whose size is set, by solid Gaussians, or by all where none is solid. A scene without
/// Gaussians has the bounds of a ball of radius 1.
SWIFTGS_C_API swiftgs_status swiftgs_scene_robust_bounds(const swiftgs_scene* scene,
                                                         swiftgs_scene_bounds* bounds);

/// Fills `camera`, whose size is set, with a view to start with, in the coordinates of means: of the middle
/// of the scene, from where most of it is seen and none stands in the way. `orbit`, or NULL, says by its `up`
/// where up is in the scene's world, or by zeros that it is to be guessed, which may be wrong; its `target`
/// and `up` are filled, for `swiftgs_camera_orbit`.
SWIFTGS_C_API swiftgs_status swiftgs_scene_default_view(const swiftgs_scene* scene, int32_t width,
                                                        int32_t height, swiftgs_camera* camera,
                                                        swiftgs_orbit* orbit);

typedef struct swiftgs_write_options {
  uint32_t size;              ///< `sizeof(swiftgs_write_options)`
  int32_t spz_version;        ///< of an SPZ file, 4 or 3; 0: 4
  int32_t spz_axes;           ///< of an SPZ file, `SWIFTGS_SPZ_...`
  uint32_t reserved;          ///< 0
  const char* ending;         ///< names the format, as `.ply` does; NULL: the file's own name does
  swiftgs_progress progress;  ///< or NULL
  swiftgs_note note;          ///< or NULL; called for each loss, and once with the largest of rounding
  void* context;              ///< what both are called with
} swiftgs_write_options;

/// Writes a scene in the format that an ending names. docs/formats.md has the endings and what each format
/// loses; none holds features. The new file takes the place of an old one when it is whole. `options` may be
/// NULL. Errors: `SWIFTGS_INVALID_ARGUMENT` for an ending or an option that is not known, or that the scene
/// does not allow, `SWIFTGS_CANCELLED`, `SWIFTGS_SYSTEM_ERROR`.
SWIFTGS_C_API swiftgs_status swiftgs_scene_write(const swiftgs_scene* scene, const char* path,
                                                 const swiftgs_write_options* options);

#ifdef __cplusplus
}
#endif

#endif
