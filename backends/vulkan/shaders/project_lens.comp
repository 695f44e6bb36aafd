// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#define THROUGH_LENS
#include "project_gaussians.glsl"
