// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/version.hpp>

#include "commands.hpp"
#include "suggestion.hpp"

namespace swiftgs::cli {
namespace {

constexpr const char* about = "Renders scenes of 3D Gaussians, and measures how exactly and how quickly.";

constexpr const char* start_here = R"(Start here:
  swiftgs render builtin                             an image without any file
  swiftgs info garden.spz                            what a file holds
  swiftgs render garden.spz                          a view that is found for the scene
  swiftgs render garden.spz --cameras cameras.json   the views it was trained with
  swiftgs list                                       what can render
  swiftgs check builtin --renderers 'cpu/early/*'    errors and times, side by side
'swiftgs COMMAND --help' explains each command. An error is one line, with exit code 1.)";

/// `text` without line breaks: an error is one line.
std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

int fail(const std::string& what) {
  std::fprintf(stderr, "swiftgs: %s\n", one_line(what).c_str());
  return 1;
}

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

/// What is wrong with arguments that no option takes, in the order in which they were typed.
std::string unexpected(const CLI::App& app, const std::vector<std::string>& arguments) {
  const CLI::App& command = app.get_subcommands().empty() ? app : *app.get_subcommands().front();
  std::vector<std::string> options;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  const std::vector<std::string> left = app.remaining(true);
  std::string message;
  for (const std::string& argument : arguments) {
    if (std::find(left.begin(), left.end(), argument) == left.end()) continue;
    message += message.empty() ? command.get_name() + ": " : "; ";
    message += "'" + argument + "' is not expected";
    if (argument.starts_with("--")) message += suggestion(argument.substr(0, argument.find('=')), options);
  }
  return message;
}

int run(int argc, char** argv) {
  CLI::App app(about, "swiftgs");
  app.footer(start_here);
  app.set_version_flag("--version", "swiftgs " + std::string(version));
  app.require_subcommand(0, 1);  // that none is there is said below: CLI11 would not name an unknown one

  add_info(app);
  add_list(app);
  add_render(app);
  add_compare(app);
  add_check(app);
  add_calibrate(app);
  add_prune(app);
  add_bench(app);
  add_report(app);
  add_stress(app);

  const std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc),
      names = names_of_commands(app);
  const std::string first = arguments.empty() || arguments[0].starts_with("-") ? "" : arguments[0];
  if (first != "" && std::find(names.begin(), names.end(), first) == names.end())
    return fail("command '" + first + "' is not known" + suggestion(first, names) + " (see swiftgs --help)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked_for_help) {
    return app.exit(asked_for_help);
  } catch (const CLI::ExtrasError&) {
    return fail(unexpected(app, arguments) + " (see swiftgs --help)");
  } catch (const CLI::ParseError& error) {
    return fail(std::string(error.what()) + " (see swiftgs --help)");
  }

  if (app.get_subcommands().empty()) {
    std::string all;
    for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
    return fail("expected a command: " + all + " (see swiftgs --help)");
  }
  // A full disk may show only here.
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) return fail("standard output: cannot be written");
  return 0;
}

}  // namespace
}  // namespace swiftgs::cli

int main(int argc, char** argv) {
#if defined(SIGXFSZ)
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows beyond a limit is an error like others
#endif
  try {
    return swiftgs::cli::run(argc, argv);
  } catch (const std::bad_alloc&) {
    return swiftgs::cli::fail("out of memory");
  } catch (const std::filesystem::filesystem_error& error) {
    return swiftgs::cli::fail(error.path1().string() + ": " + error.code().message());
  } catch (const std::exception& error) {
    return swiftgs::cli::fail(error.what());
  }
}
