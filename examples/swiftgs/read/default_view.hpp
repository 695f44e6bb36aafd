// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/camera.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs::cli {

/// A camera of 1280x720 for a scene that comes without: it looks at the middle of the bulk of the Gaussians
/// from where most of them are seen and none stands in the way. Up is whichever of -y, y, z and -z puts what
/// is far or bright at the top of the image, tilted to the ground where one is found.
Camera default_view(const Scene& scene);

/// The middle of the bulk of the Gaussians; the world's origin where there is none.
dvec3 middle_of(const Scene& scene);

}  // namespace swiftgs::cli
