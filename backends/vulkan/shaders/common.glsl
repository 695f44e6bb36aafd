// SPDX-License-Identifier: Apache-2.0

// What all kernels have: memory by its address, and sums over a workgroup. `SUBGROUP` lanes make a subgroup; a thread's
// place in its workgroup is `thread()`, which need not be gl_LocalInvocationIndex.

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_spirv_intrinsics : require
#extension GL_KHR_memory_scope_semantics : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_shuffle : require

// RoundingModeRTE: round floats of 32 bits to nearest.
spirv_execution_mode(capabilities = [4467], 4462, 32);

layout(constant_id = 0) const uint SUBGROUP = 32;
layout(constant_id = 1) const uint THREADS = 128;
layout(constant_id = 2) const uint ARITHMETIC = 0u;  // what probe.comp found out
const bool FUSES = (ARITHMETIC & 1u) != 0u;         // whether `fma` rounds once
const bool NATIVE_EXP2 = (ARITHMETIC & 2u) != 0u;   // whether `exp2` is as exact as pixels need it
layout(local_size_x_id = 1) in;

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Uints { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Floats { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Fours { uvec4 at[]; };

bool is_null(uvec2 address) { return address == uvec2(0u); }

// The address of element `i` of a row of elements `stride` bytes apart.
uvec2 element(uvec2 address, uint i, uint stride) {
  uint high, low, carry;
  umulExtended(i, stride, high, low);
  low = uaddCarry(address.x, low, carry);
  return uvec2(low, address.y + high + carry);
}

// Pair `i` of words. Drivers take indices as signed, so pairs are found by address.
Uints pair_at(Uints pairs, uint i) { return Uints(element(uvec2(pairs), i, 8u)); }

// A number of elements, at most `most`, that the device may know: as `Count`.
struct Count {
  uvec2 exact;
  uint most;
};
uint number_of(Count count) { return is_null(count.exact) ? count.most : min(Uints(count.exact).at[0], count.most); }

// Adds low + 2^16 high to a number of 64 bits.
void add_halves(Uints to, uint low, uint high) {
  uint carry;
  const uint sum = uaddCarry(high << 16, low, carry), before = atomicAdd(to.at[0], sum);
  if (before + sum < before) ++carry;
  if ((high >> 16) + carry != 0u) atomicAdd(to.at[1], (high >> 16) + carry);
}

// Operations of subgroups also stand in loops and branches that a subgroup takes as one and its workgroup does not. That
// the lanes converge behind them is what drivers do; VK_KHR_shader_subgroup_uniform_control_flow would promise it.

// A grid may have more workgroups than were asked for.
uint workgroup() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uint thread() { return gl_SubgroupID * SUBGROUP + gl_SubgroupInvocationID; }
uint invocation() { return workgroup() * THREADS + thread(); }

// Lets the lanes of a subgroup see what they wrote to shared memory. `subgroupBarrier` would also wait for other memory.
void share_in_subgroup() {
  controlBarrier(gl_ScopeSubgroup, gl_ScopeSubgroup, gl_StorageSemanticsShared, gl_SemanticsAcquireRelease);
}

shared uint subgroup_sums[THREADS / 4 + 1];

// The sum of `x` over the threads before this one; `total` is that over all threads. All threads call it.
uint sum_before(uint x, out uint total) {
  const uint inclusive = subgroupInclusiveAdd(x);
  if (THREADS == SUBGROUP) {
    total = subgroupShuffle(inclusive, SUBGROUP - 1u);
    return inclusive - x;
  }
  if (gl_SubgroupInvocationID == SUBGROUP - 1u) subgroup_sums[gl_SubgroupID] = inclusive;
  barrier();
  uint before = 0u;
  total = 0u;
  for (uint s = 0u; s < THREADS / SUBGROUP; ++s) {
    const uint sum = subgroup_sums[s];
    if (s < gl_SubgroupID) before += sum;
    total += sum;
  }
  barrier();
  return before + inclusive - x;
}
