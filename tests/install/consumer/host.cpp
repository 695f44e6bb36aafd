// SPDX-License-Identifier: Apache-2.0

// host PLUGIN [LIBRARY...]: a program that links none of the libraries, loads each LIBRARY and then PLUGIN,
// and lets that render. Exceptions that it knows by their header alone reach it with their types.
#include <iostream>
#include <stdexcept>

#include <dlfcn.h>

#include <swiftgs/error.hpp>

namespace {

void* load(const char* path) {
  void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (!library) throw std::runtime_error(dlerror());
  return library;
}

template <class Error>
bool throws(void (*plugin_throws)(int), int what) {
  try {
    plugin_throws(what);
  } catch (const Error& error) {
    std::cout << error.what() << "\n";
    return true;
  } catch (const std::exception& error) {
    std::cout << "of another type: " << error.what() << "\n";
  }
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 2; i < argc; ++i) load(argv[i]);
  void* plugin = load(argv[1]);
  const auto renders = reinterpret_cast<bool (*)()>(dlsym(plugin, "plugin_renders"));
  const auto raise = reinterpret_cast<void (*)(int)>(dlsym(plugin, "plugin_throws"));
  const bool good = renders() && throws<swiftgs::FormatError>(raise, 0) &&
                    throws<swiftgs::CapacityError>(raise, 1) && throws<std::invalid_argument>(raise, 2);
  std::cout << (good ? "good\n" : "bad\n");
  return good ? 0 : 1;
}
