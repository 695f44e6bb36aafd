# SPDX-License-Identifier: Apache-2.0

# Toolchain for arm64 by Debian's cross compiler; `cmake/release_check.sh arm64` installs it and libraries for arm64.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
