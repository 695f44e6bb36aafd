// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#define ALONG_RAY
#include "gather_attributes.glsl"
