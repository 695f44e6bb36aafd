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

#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/version.hpp>

#include "commands.hpp"
#include "draw/team.hpp"
#include "interruptible.hpp"
#include "options.hpp"

namespace swiftgs::cli {
namespace {

constexpr const char* about = "Renders scenes of 3D Gaussians, and measures how exactly and how quickly.";

constexpr const char* start_here = R"(Start here:
  swiftgs render builtin                             an image without any file
  swiftgs info garden.spz                            what a file holds
  swiftgs render garden.spz                          a view that is found for the scene
  swiftgs render garden/                             all views of a capture: scene and cameras in a folder
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
  if (!Team::here().leads()) return 1;  // all processes find the same wrong with their arguments
  std::fprintf(stderr, "swiftgs: %s\n", one_line(what).c_str());
  return 1;
}

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

/// The command that was asked for, or the tool where none was.
const CLI::App& command_in(const CLI::App& app) {
  return app.get_subcommands().empty() ? app : *app.get_subcommands().front();
}

/// The message for arguments that no option takes, in the order of the command line. If some look like
/// options, it names these alone.
std::string unexpected(const CLI::App& app, const std::vector<std::string>& arguments) {
  const CLI::App& command = command_in(app);
  std::vector<std::string> options;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  const std::vector<std::string> left = app.remaining(true);
  const auto is_option = [](const std::string& argument) {
    return argument.size() > 1 && argument.starts_with("-");
  };
  // The value of an unknown option is taken for a positional argument, and may displace a right one.
  const bool only_options = std::any_of(left.begin(), left.end(), is_option);
  std::string message = &command == &app ? "" : command.get_name() + ": ";
  const char* separator = "";
  for (const std::string& argument : arguments) {
    if (std::find(left.begin(), left.end(), argument) == left.end()) continue;
    if (only_options && !is_option(argument)) continue;
    message += separator + ("'" + argument + "' is not expected");
    if (is_option(argument)) message += suggestion(argument.substr(0, argument.find('=')), options);
    separator = "; ";
  }
  return message;
}

/// Refuses empty values of every option and positional argument of every command.
void refuse_empty_values(CLI::App& app) {
  const auto given = [](const std::string& value) {
    return std::string(value.empty() ? "expected a value, found nothing" : "");
  };
  for (CLI::App* command : app.get_subcommands({}))
    for (CLI::Option* option : command->get_options())
      if (option->get_items_expected_max() > 0) option->check(given);  // flags take no value
}

/// What an option of a type of CLI11's takes.
std::string expected_by(const CLI::Option* option) {
  if (!option || option->get_type_name().empty()) return "no value";  // a flag
  return option->get_type_name().starts_with("FLOAT") ? "a number" : "a whole number";
}

/// The parser's errors in our words. Their texts are `NAME is required`, `NAME: 1 required TYPE missing`,
/// `NAME: At Most 1 required but received N`, and `Could not convert: NAME = VALUE`.
std::string in_our_words(const CLI::App& command, const CLI::ParseError& error) {
  const std::string text = one_line(error.what()), name = text.substr(0, text.find(": "));
  if (dynamic_cast<const CLI::RequiredError*>(&error))
    return command.get_name() + ": expected " + text.substr(0, text.find(" is required"));
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error)) {
    const bool too_many = text.find("At Most") != std::string::npos;
    return name + (too_many ? ": expected one value, found " + text.substr(text.rfind(' ') + 1)
                            : ": expected a value, found nothing");
  }
  const std::size_t value = text.find(" = ");
  if (dynamic_cast<const CLI::ConversionError*>(&error) && name != text && value != std::string::npos) {
    const std::size_t begin = name.size() + 2;
    const std::string option = text.substr(begin, value - begin);
    return option + " '" + text.substr(value + 3) + "': expected " +
           expected_by(command.get_option_no_throw(option));
  }
  return text;
}

/// `help` and `help COMMAND` are what many type first.
std::vector<std::string> with_help_as_option(std::vector<std::string> arguments) {
  if (arguments.empty() || arguments[0] != "help") return arguments;
  arguments.erase(arguments.begin());
  arguments.emplace_back("--help");
  return arguments;
}

int run_command(int argc, char** argv) {
  CLI::App app(about, "swiftgs");
  app.footer(std::string(start_here) + "\nScenes are read from " + readable_scenes() + ".");
  app.set_version_flag("--version", "swiftgs " + std::string(version));
  app.require_subcommand(0, 1);  // that none is there is said below: CLI11 would not name an unknown one

  add_info(app);
  add_list(app);
  add_render(app);
  add_compare(app);
  add_check(app);
  add_conform(app);
  add_convert(app);
  add_pages(app);
  add_prune(app);
  add_bench(app);
  add_report(app);
  add_stress(app);
  add_view(app);
  refuse_empty_values(app);

  const std::vector<std::string> names = names_of_commands(app),
                                 arguments = with_help_as_option({argv + std::min(argc, 1), argv + argc});
  const std::string first = arguments.empty() || arguments[0].starts_with("-") ? "" : arguments[0];
  if (first != "" && std::find(names.begin(), names.end(), first) == names.end())
    return fail("command '" + first + "' is not known" + suggestion(first, names) + " (see swiftgs --help)");
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::Success& asked_for_help) {
    return app.exit(asked_for_help);
  } catch (const CLI::ParseError& error) {
    const CLI::App& command = command_in(app);
    const std::string help = &command == &app ? "" : command.get_name() + " ";
    // What was mistyped may be what is missing.
    const std::string what =
        app.remaining(true).empty() ? in_our_words(command, error) : unexpected(app, arguments);
    return fail(what + " (see swiftgs " + help + "--help)");
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

int run(int argc, char** argv) {
#if defined(SIGXFSZ)
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows beyond a limit is an error like others
#endif
  try {
    return Team::run(argc, argv, [&] { return run_command(argc, argv); });
  } catch (const std::bad_alloc&) {
    return fail("out of memory");
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(error.path1().string() + ": " + error.code().message());
  } catch (const Interrupted& error) {
    const int code = fail(error.what());
    std::fflush(stdout);
    std::signal(SIGINT, SIG_DFL);
    std::raise(SIGINT);
    return code;
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}

}  // namespace swiftgs::cli
