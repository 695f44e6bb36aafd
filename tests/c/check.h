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

/* Ends the program as skipped. */
_Noreturn void skip(const char* reason);

/* Ends the program where going on would crash. */
_Noreturn void give_up(const char* reason);

enum { small_width = 64, small_height = 48, small_count = 2000 };
extern const char* const small_renderer;

/* The built-in scene in `small_count` Gaussians. */
swiftgs_scene* make_scene(void);
/* The built-in camera with an image of the given size. */
swiftgs_camera make_camera(int32_t width, int32_t height);
/* A renderer with that scene. */
swiftgs_renderer* make_renderer(const char* name);
/* A view of the whole image into RGB floats that lie densely. */
swiftgs_view make_view(const swiftgs_camera* camera, float* colour);
swiftgs_frame make_frame(const swiftgs_view* views, uint64_t count);
/* Memory of zeros. */
void* make_memory(size_t bytes);
void write_text(const char* path, const char* text);

/* The cases. */
void test_versions(void);
void test_structs(void);
void test_threads(void);
void test_turns(void);
void test_scenes(void);
void test_scene_camera(void);
void test_progress(void);
void test_arrays(void);
void test_scene_errors(void);
void test_cameras(void);
void test_camera_notes(void);
void test_camera_errors(void);
void test_images(void);
void test_table(void);
void test_formats(void);
void test_pitches(void);
void test_views(void);
void test_over(void);
void test_occluder(void);
void test_conventions(void);
void test_each_convention(void);
void test_recorded(void);
void test_measures(void);
void test_sharing(void);
void test_gaussians(void);
void test_memory(void);
void test_calibrations(void);
void test_frame_errors(void);
void test_renderer_errors(void);
void test_no_device(void);
void test_device(void);

#endif
