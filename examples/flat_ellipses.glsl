// SPDX-License-Identifier: Apache-2.0

// `FlatEllipses` for the backend Vulkan. `rest.y` is the opacity, in units of alpha_max.
Terms own_terms(Shape s, vec2 first, float alpha_max) { return terms_of(s, first, alpha_max); }
float own_alpha(Terms t, vec2 at, float least) { return exponent_of(t, at) > 0.72134752 ? 0.0 : min(t.rest.y, 1.0); }
