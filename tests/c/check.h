/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_TESTS_C_CHECK_H
#define SWIFTGS_TESTS_C_CHECK_H

/* What the cases of the C interface have in common. A case returns normally, or calls `skip`. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <swiftgs.h>

/* Counts a failure and says where, unless `holds`. */
void check_that(bool holds, const char* expected, const char* file, int line);
/* As above, unless `status` is `expected`, with the library's text where it failed. */
void check_status(swiftgs_status status, swiftgs_status expected, const char* call, const char* file,
                  int line);
/* As above, and unless the text of the error holds `part`. */
void check_error(swiftgs_status status, swiftgs_status expected, const char* part, const char* file,
                 int line);

#define CHECK(condition) check_that((condition), #condition, __FILE__, __LINE__)
#define CHECK_OK(call) check_status((call), SWIFTGS_OK, #call, __FILE__, __LINE__)
#define CHECK_ERROR(call, status, part) check_error((call), (status), (part), __FILE__, __LINE__)
/* An argument is invalid. */
#define CHECK_INVALID(call, part) CHECK_ERROR(call, SWIFTGS_INVALID_ARGUMENT, part)
/* Neither of two pointers may be NULL. */
#define CHECK_NULLS(function, a, name_of_a, b, name_of_b) \
  CHECK_INVALID(function(NULL, b), name_of_a " is NULL"); \
  CHECK_INVALID(function(a, NULL), name_of_b " is NULL")

/* Ends the program as skipped. */
_Noreturn void skip(const char* reason);

/* Ends the program where going on would crash. */
_Noreturn void give_up(const char* reason);

enum { small_width = 64, small_height = 48, small_count = 2000 };
extern const char* const small_renderer;

/* The built-in scene in `small_count` Gaussians. */
swiftgs_scene* make_scene(void);
swiftgs_gaussians arrays_of(const swiftgs_scene* scene);
/* The built-in camera with an image of the given size. */
swiftgs_camera make_camera(int32_t width, int32_t height);
/* A renderer with that scene. */
swiftgs_renderer* make_renderer(const char* name);
/* A view of the whole image into RGB floats that lie densely. */
swiftgs_view make_view(const swiftgs_camera* camera, float* colour);
swiftgs_frame make_frame(const swiftgs_view* views, uint64_t count);
/* Memory of zeros, which lasts as long as the program. */
void* make_memory(size_t bytes);
float* make_floats(size_t count);
void write_text(const char* path, const char* text);

/* A frame of one view with the small size. Its parts point to each other. */
struct drawing {
  swiftgs_renderer* renderer;
  swiftgs_camera camera;
  float* colour;
  swiftgs_view view;
  swiftgs_frame frame;
};
void set_up(struct drawing* drawing, const char* renderer);
/* Draws the frame: whether its image has the bits of `expected`. */
bool draws(struct drawing* drawing, const float* expected);
/* The image of a plain view of `camera`, in memory of its own. */
float* draw_plain(swiftgs_renderer* renderer, const swiftgs_camera* camera);
/* Whether `count` floats have the same bits. */
bool same_floats(const float* a, const float* b, size_t count);

#define CASE(name, sentence) void test_##name(void);
#include "cases.h"
#undef CASE

#endif
