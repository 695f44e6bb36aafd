// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

/// The commands of the tool. Each function adds one to `app`: its options, its help, and what it runs.
/// Commands report failure by throwing.
namespace swiftgs::cli {

void add_bench(CLI::App& app);
void add_check(CLI::App& app);
void add_compare(CLI::App& app);
void add_conform(CLI::App& app);
void add_convert(CLI::App& app);
void add_info(CLI::App& app);
void add_list(CLI::App& app);
void add_pages(CLI::App& app);
void add_prune(CLI::App& app);
void add_render(CLI::App& app);
void add_report(CLI::App& app);
void add_stress(CLI::App& app);
void add_view(CLI::App& app);

/// Runs the command that the arguments name, in all processes of a launcher, and returns the exit code: 1
/// with one line on standard error where something is wrong.
int run(int argc, char** argv);

}  // namespace swiftgs::cli
