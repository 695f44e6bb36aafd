/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_H
#define SWIFTGS_H

/// @file
/// The C interface of SwiftGS, for C11, C++ and every language that can call C. Link libswiftgs_c.
///
/// **Errors.** Every function that can fail returns a `swiftgs_status`, 0 where it succeeded. Then
/// `swiftgs_last_error` says what, where and what was expected. No exception leaves the library, and nothing
/// is printed. A function that fails changes nothing that it would have returned.
///
/// **Structs** begin with their own size, as the caller compiled them: set `size` to `sizeof` before each
/// call. In what a caller passes in, a zero means the library's default, so that `{.size = sizeof(view)}` is
/// a valid beginning. Later versions add members at the end alone. A struct of an older program has its
/// missing members at their defaults. A struct of a newer program is taken if what this library does not know
/// is zero, and refused otherwise. In structs that the library fills, what it does not know becomes zero.
/// `swiftgs_plane`, `swiftgs_array` and `swiftgs_report` have no size and never change.
///
/// **Ownership.** Functions that make a handle write it to their last argument; the function `_free` of its
/// kind takes it back, and NULL as well. Strings that the library returns belong to the handle that was
/// asked, and live as long. Arrays and strings that a caller passes in are read before the function returns.
///
/// **Threads.** Scenes and lists of cameras never change, and any number of threads may read them. Calls to
/// one renderer run one after another; renderers of several threads draw at once. Free a handle when no call
/// uses it.
///
/// **Paths and strings** are bytes that end in zero, as the file system has them.

#include <swiftgs/c/camera.h>
#include <swiftgs/c/device.h>
#include <swiftgs/c/pages.h>
#include <swiftgs/c/renderer.h>
#include <swiftgs/c/scene.h>
#include <swiftgs/c/status.h>
#include <swiftgs/c/view.h>

#endif
