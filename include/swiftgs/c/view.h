/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_C_VIEW_H
#define SWIFTGS_C_VIEW_H

/// @file
/// Views: from where, by which rules, and into which memory a frame is drawn. Images in files.

#include <stdint.h>

#include <swiftgs/c/camera.h>
#include <swiftgs/c/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The numbers that define "the same image". `swiftgs_conventions_named` fills them in. A zero is a zero
/// here, not a default; members that a smaller `size` leaves out are those of gsplat. Presets leave some
/// members to the scene, `SWIFTGS_OF_SCENE`: they are as it was trained.
typedef struct swiftgs_conventions {
  uint32_t size;           ///< `sizeof(swiftgs_conventions)`
  float near_plane;        ///< a Gaussian nearer than this is culled
  int32_t cull_at_near;    ///< 1: so is one exactly on the near plane
  float far_plane;         ///< a Gaussian further than this is culled
  int32_t clamp;           ///< `SWIFTGS_CLAMP_...`
  float blur;              ///< added to both variances of a splat; or of the scene @units{pixels^2}
  int32_t antialiased;     ///< 1: scale opacity as Mip-Splatting does; or of the scene
  float min_compensation;  ///< least ratio of determinants in that
  float alpha_min;         ///< a pixel skips a Gaussian with less alpha
  float alpha_max;         ///< alpha is cut here
  float stop;              ///< a pixel ends before the Gaussian that would bring its transmittance below
  int32_t stop_at_equal;   ///< 1: or exactly to `stop`
  int32_t footprint;       ///< `SWIFTGS_FOOTPRINT_...`, of the reference; renderers use their bounds
  int32_t depth;           ///< `SWIFTGS_DEPTH_...`
  float first_alpha;       ///< a pixel's first depth is of the Gaussian that takes its alpha above
  int32_t depth_at;        ///< `SWIFTGS_DEPTH_AT_...`
  int32_t order;           ///< `SWIFTGS_ORDER_...`, or of the scene; by depth in views with an occluder
  int32_t colours;         ///< `SWIFTGS_COLOURS_...`, or of the scene: in which colours are blended
} swiftgs_conventions;

/// Limits of x/z and y/z where the projection is linearised, in tangents.
enum {
  SWIFTGS_CLAMP_AROUND_IMAGE = 0,  ///< 0.3 tan(fov/2) beyond each image border
  SWIFTGS_CLAMP_AROUND_CENTRE = 1  ///< 1.3 tan(fov/2) to each side of the axis
};
enum {
  SWIFTGS_FOOTPRINT_ALPHA = 0,               ///< every pixel where alpha is at least `alpha_min`
  SWIFTGS_FOOTPRINT_THREE_SIGMA_SQUARE = 1,  ///< only those in tiles that the square of 3 sigma touches
  SWIFTGS_FOOTPRINT_THREE_SIGMA_ELLIPSE = 2  ///< only those at most 3 sigma from the mean
};
/// In place of a number of `swiftgs_conventions`: as the scene was trained.
enum { SWIFTGS_OF_SCENE = -1 };
/// What orders the splats of a frame.
enum {
  SWIFTGS_ORDER_DEPTH = 0,    ///< as `depth` measures it
  SWIFTGS_ORDER_DISTANCE = 1  ///< from the camera's centre
};
/// The values in which splats are blended. Images have the same kind of values whichever it is.
enum {
  SWIFTGS_COLOURS_SRGB = 0,   ///< encoded for a display, as photographs are
  SWIFTGS_COLOURS_LINEAR = 1  ///< linear light; each pixel is encoded when it is finished
};
/// What is compared with the planes and with occluders, and is drawn as depth. In units of the scene.
enum {
  SWIFTGS_DEPTH_OF_LENS = 0,  ///< z of perspective and orthographic lenses, distance of the others
  SWIFTGS_DEPTH_Z = 1,        ///< along the camera's axis
  SWIFTGS_DEPTH_DISTANCE = 2  ///< from the camera's centre
};

/// A splat's depth at a pixel, for planes of depth and occluders. Order and culling take the mean's.
enum {
  SWIFTGS_DEPTH_AT_CENTRE = 0,  ///< its mean's, at every pixel
  SWIFTGS_DEPTH_AT_RAY = 1      ///< where the Gaussian is densest along the pixel's ray
};

/// Fills `conventions`, whose size is set, with the preset `gsplat`, `inria` or `khronos`.
/// `SWIFTGS_INVALID_ARGUMENT` for any other name.
SWIFTGS_C_API swiftgs_status swiftgs_conventions_named(const char* name, swiftgs_conventions* conventions);

/// Format of colours in memory, interleaved. The last channel of RGBA is alpha, and colours are premultiplied
/// by it. Colours are in the scene's own values, usually sRGB-encoded (those of scenes in linear light are
/// encoded), unless `conversion` of the view says otherwise.
enum {
  SWIFTGS_RGB_FLOAT = 0,   ///< 12 bytes
  SWIFTGS_RGBA_FLOAT = 1,  ///< 16 bytes
  SWIFTGS_RGBA_HALF = 2,   ///< 8 bytes, IEEE half
  SWIFTGS_RGBA_8 = 3,      ///< 4 bytes; cut to [0, 1] and rounded to the nearest of 255 steps
  SWIFTGS_BGRA_8 = 4       ///< the same with blue first, as most swap chains have it
};

/// What makes an image's colours of the scene's values: the sRGB curve or its inverse, of straight colours.
/// Alpha is never converted. `over` lays splats on an image of the view's own kind of values; a view without
/// alpha, or before a background that is not black, is converted as a whole picture.
enum {
  SWIFTGS_CONVERT_NOTHING = 0,
  SWIFTGS_CONVERT_SRGB_TO_LINEAR = 1,  ///< the scene's values are sRGB-encoded, the view's linear light
  SWIFTGS_CONVERT_LINEAR_TO_SRGB = 2   ///< the other way round
};

/// One plane of a frame in the caller's memory. NULL means absent, and absent planes are not computed.
typedef struct swiftgs_plane {
  void* data;     ///< first pixel of the image's top row, wherever that lies in memory
  int64_t pitch;  ///< from a row to the one below it in the image, negative where rows go up @units{bytes}
} swiftgs_plane;

/// In place of a Gaussian's index: there is none.
#define SWIFTGS_NOTHING UINT32_C(0xffffffff)

/// One image of a frame, or a rectangle of one.
///
/// A Gaussian's weight in a pixel is alpha times the transmittance in front of it. Depths are as the
/// conventions measure them, of means unless `depth_at` says otherwise.
typedef struct swiftgs_view {
  uint32_t size;                           ///< `sizeof(swiftgs_view)`; the same in all views of an array
  int32_t format;                          ///< of `colour`: `SWIFTGS_RGB_FLOAT`, ...
  int32_t width, height;                   ///< of the frame; 0: those of the camera @units{pixels}
  const swiftgs_camera* camera;            ///< of the whole image
  const swiftgs_conventions* conventions;  ///< NULL: those of gsplat
  swiftgs_plane colour;                    ///< of `format`
  swiftgs_plane alpha;                     ///< float: 1 - transmittance
  swiftgs_plane depth;                     ///< float: mean by weight; 0 where alpha is 0
  /// float, only read: a depth buffer of the same measure, stored as `stored_depth` says. A splat there or
  /// behind is not drawn; infinity hides nothing.
  swiftgs_plane occluder;
  int32_t over;         ///< 1: what `colour` holds shows behind the splats, in place of the background
  int32_t left, top;    ///< pixel of the image that is the frame's first; multiples of 16
  float background[3];  ///< RGB in the scene's own values; has no part in alpha
  swiftgs_stored_depth stored_depth;  ///< of `occluder`
  swiftgs_plane squared_depth;        ///< float: mean by weight of depth^2; 0 where alpha is 0
  /// float: depth of the Gaussian that takes alpha above `first_alpha` of the conventions; 0 where none does.
  swiftgs_plane first_depth;
  swiftgs_plane median_depth;  ///< float: of the Gaussian that takes alpha above 1/2; 0 where none does
  /// 3 floats: sum of weight times normal, a unit vector in camera space along the Gaussian's shortest axis,
  /// against the ray through its mean.
  swiftgs_plane normal;
  /// uint32: Gaussian of the largest weight, of equal ones the nearest; or `SWIFTGS_NOTHING`. Of several
  /// placed scenes the number is that over the frame, as `swiftgs_renderer_place` says.
  swiftgs_plane id;
  swiftgs_plane median_id;   ///< uint32: index of the Gaussian of `median_depth`; or `SWIFTGS_NOTHING`
  swiftgs_plane features;    ///< `feature_channels` floats: sum of weight times feature
  int32_t feature_channels;  ///< their number: the scene's first ones
  int32_t conversion;        ///< of `colour`: `SWIFTGS_CONVERT_...`
  uint32_t first_shown;      ///< number of the first placed scene that shows
  uint32_t shown_count;      ///< how many placed scenes show; 0: all from there on
} swiftgs_view;

/// Pixels of an image on the host, for `swiftgs_image_write`. Planes are those of `swiftgs_view`, only read.
/// PNG holds colour, and alpha with straight colours: the last channel of RGBA, or of RGB the plane `alpha`.
/// It is opaque if it was drawn before a `background` that is not black, or as RGB `over` an image. EXR holds
/// all.
typedef struct swiftgs_image {
  uint32_t size;             ///< `sizeof(swiftgs_image)`
  int32_t width, height;     ///< @units{pixels}
  int32_t feature_channels;  ///< of `features`
  swiftgs_plane colour;      ///< of `format`
  swiftgs_plane alpha, depth, squared_depth, first_depth, median_depth, normal, id, median_id, features;
  int32_t format;       ///< of `colour`, as of `swiftgs_view`; 0: RGB in float
  int32_t over;         ///< as of `swiftgs_view`
  float background[3];  ///< as of `swiftgs_view`
  uint32_t reserved;    ///< 0
} swiftgs_image;

/// Writes an image as its name's ending says: `.png` with 8 bits a channel, `.pfm`, or `.exr`. Values are
/// written as they are, without gamma. docs/command_line.md names the channels of an EXR. Errors:
/// `SWIFTGS_INVALID_ARGUMENT`, `SWIFTGS_SYSTEM_ERROR`, and `SWIFTGS_UNAVAILABLE` for EXR in a build without
/// OpenEXR.
SWIFTGS_C_API swiftgs_status swiftgs_image_write(const char* path, const swiftgs_image* image);

/// Takes `count` bytes, which are valid until it returns.
typedef void (*swiftgs_take_bytes)(void* context, const void* bytes, uint64_t count);

/// Calls `take` once, with the bytes of the PNG that `swiftgs_image_write` writes. Errors:
/// `SWIFTGS_INVALID_ARGUMENT`.
SWIFTGS_C_API swiftgs_status swiftgs_png_encode(const swiftgs_image* image, swiftgs_take_bytes take,
                                                void* context);

/// A picture of a file, such as a photograph that frames are compared with.
typedef struct swiftgs_picture swiftgs_picture;

typedef struct swiftgs_pixels {
  uint32_t size;          ///< `sizeof(swiftgs_pixels)`
  int32_t width, height;  ///< @units{pixels}
  int32_t channels;       ///< 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha
  const float* data;      ///< @shape{height, width, channels} from 0 to 1 if the file has integers
} swiftgs_pixels;

/// Reads a PNG, a JPEG, a PFM or, where built with OpenEXR, an EXR. The content decides which. Values are
/// those of the file, without gamma. Errors: `SWIFTGS_FORMAT_ERROR`, `SWIFTGS_SYSTEM_ERROR`.
SWIFTGS_C_API swiftgs_status swiftgs_picture_read(const char* path, swiftgs_picture** picture);
/// Fills `pixels`, whose size is set, with the picture's own memory, valid until it is freed.
SWIFTGS_C_API swiftgs_status swiftgs_picture_get(const swiftgs_picture* picture, swiftgs_pixels* pixels);
SWIFTGS_C_API void swiftgs_picture_free(swiftgs_picture* picture);

#ifdef __cplusplus
}
#endif

#endif
