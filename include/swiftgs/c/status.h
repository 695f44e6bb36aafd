/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_C_STATUS_H
#define SWIFTGS_C_STATUS_H

/// @file
/// Versions and errors of the C interface.

#include <stdint.h>

#if defined(__GNUC__)
#define SWIFTGS_C_API __attribute__((visibility("default")))
#else
#define SWIFTGS_C_API
#endif

/// Version of the binary interface that this header describes, apart from the library's own version. A change
/// that breaks programs raises the first number, which is part of the library's file name; an addition raises
/// the second.
#define SWIFTGS_ABI_MAJOR 2
#define SWIFTGS_ABI_MINOR 2

#ifdef __cplusplus
extern "C" {
#endif

/// What a function returns. A plain integer, because the size of an enumeration is the compiler's choice.
typedef int32_t swiftgs_status;

enum {
  SWIFTGS_OK = 0,
  SWIFTGS_INVALID_ARGUMENT = 1,  ///< an argument that the function does not take
  SWIFTGS_FORMAT_ERROR = 2,      ///< a file is invalid; the text has its name and the byte
  SWIFTGS_CANCELLED = 3,         ///< a `swiftgs_progress` asked to stop
  SWIFTGS_SYSTEM_ERROR = 4,      ///< the system refused, such as a file that is not there
  SWIFTGS_DEVICE_ERROR = 5,    ///< a call to a device failed; the text has the call and the device's own text
  SWIFTGS_CAPACITY_ERROR = 6,  ///< a frame exceeds a limit or the device's memory; the renderer stays usable
  SWIFTGS_LOGIC_ERROR = 7,     ///< a call out of turn, such as a frame before a scene
  SWIFTGS_OUT_OF_MEMORY = 8,   ///< of the host, or of the caller's own functions; the renderer stays usable
  SWIFTGS_UNAVAILABLE = 9,     ///< this machine or this build cannot do it
  SWIFTGS_INTERNAL_ERROR = 10  ///< a defect of the library, or an exception of a callback
};

/// The name of `status`, as `SWIFTGS_FORMAT_ERROR`. "unknown status" for any other number.
SWIFTGS_C_API const char* swiftgs_status_name(swiftgs_status status);

/// One line on the last call of this thread that failed: what, where and what was expected. Valid until
/// another call of this thread fails; never NULL, and empty where none has failed.
SWIFTGS_C_API const char* swiftgs_last_error(void);

/// Version of the library: `major.minor.patch`.
SWIFTGS_C_API const char* swiftgs_version(void);

/// Version of the binary interface that the library has: 65536 times its first number plus the second. A
/// program needs the first number of its header, and at least the second.
SWIFTGS_C_API uint32_t swiftgs_abi_version(void);

#ifdef __cplusplus
}
#endif

#endif
