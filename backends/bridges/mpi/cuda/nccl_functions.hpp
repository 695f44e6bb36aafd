// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>

#include <dlfcn.h>
#include <nccl.h>

namespace swiftgs {

/// The functions of NCCL that are called. The library is loaded when ranks first ask for it: a build needs
/// its header alone, and a program that finds no library goes by the host.
struct NcclFunctions {
  decltype(&ncclGetVersion) get_version;
  decltype(&ncclGetUniqueId) get_unique_id;
  decltype(&ncclCommInitRank) comm_init_rank;
  decltype(&ncclCommDestroy) comm_destroy;
  decltype(&ncclCommAbort) comm_abort;
  decltype(&ncclCommGetAsyncError) comm_get_async_error;
  decltype(&ncclGroupStart) group_start;
  decltype(&ncclGroupEnd) group_end;
  decltype(&ncclSend) send;
  decltype(&ncclRecv) recv;
  decltype(&ncclGetErrorString) get_error_string;
  decltype(&ncclGetLastError) get_last_error;
};

/// Null where the loader finds no libnccl.so.2, or one that lacks a function. It stays loaded.
inline const NcclFunctions* nccl() {
  static const struct Loaded {
    NcclFunctions functions{};
    bool complete = false;

    Loaded() {
      void* const library = dlopen("libnccl.so.2", RTLD_NOW | RTLD_LOCAL);
      if (!library) return;
      complete = true;
      const auto find = [&](auto& function, const char* name) {
        function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
        complete = complete && function;
      };
      find(functions.get_version, "ncclGetVersion");
      find(functions.get_unique_id, "ncclGetUniqueId");
      find(functions.comm_init_rank, "ncclCommInitRank");
      find(functions.comm_destroy, "ncclCommDestroy");
      find(functions.comm_abort, "ncclCommAbort");
      find(functions.comm_get_async_error, "ncclCommGetAsyncError");
      find(functions.group_start, "ncclGroupStart");
      find(functions.group_end, "ncclGroupEnd");
      find(functions.send, "ncclSend");
      find(functions.recv, "ncclRecv");
      find(functions.get_error_string, "ncclGetErrorString");
      find(functions.get_last_error, "ncclGetLastError");
    }
  } loaded;
  return loaded.complete ? &loaded.functions : nullptr;
}

}  // namespace swiftgs
