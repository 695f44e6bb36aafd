// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/c/camera.h>
#include <swiftgs/camera.hpp>

namespace swiftgs::c {

dvec3 to_vector(const double (&v)[3]);

/// Throws as `read_struct`. The camera itself is not validated.
Camera to_camera(const swiftgs_camera* given);

void write_camera(swiftgs_camera* given, const Camera& camera);

}  // namespace swiftgs::c
