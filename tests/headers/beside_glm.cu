// SPDX-License-Identifier: Apache-2.0

// A program whose kernels use GLM beside the library. CMakeLists.txt beside this compiles it with GLM before
// the library or behind it, and with and without the program's own GLM_FORCE_CUDA.
#if defined(CUDA_BEFORE)
#include <cuda.h>
#endif
#if defined(GLM_BEFORE)
#include <glm/vec3.hpp>
#endif
#include <swiftgs/frame/math.hpp>

using OfTheLibrary = swiftgs::vec3;  // between inclusions, whose order is what is tested

#include <cuda.h>
#include <glm/ext/matrix_transform.hpp>

static_assert(CUDA_VERSION == CUDART_VERSION, "the version is the program's own again");

__global__ void turn(glm::vec3* own, OfTheLibrary* other) {
  const glm::mat4 turned = glm::rotate(glm::mat4(1.0f), 1.0f, own[threadIdx.x]);
  own[threadIdx.x] = glm::vec3(turned * glm::vec4(other[threadIdx.x], 1.0f));
  other[threadIdx.x] = OfTheLibrary(swiftgs::dot(own[threadIdx.x], own[0]));
}
