#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glog/logging.h>
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "armukf/core/build.hpp"
#include "armukf/core/error.hpp"
#include "commands.hpp"
#include "start_options.hpp"

namespace armukf::apps {
namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kWrongInput = 2;

constexpr const char* kDefault = "estimate";

void add_commands(CLI::App& program) {
  program.require_subcommand(1);
  add_estimate(program);
  add_smooth(program);
  add_simulate(program);
  add_fit(program);
  add_evaluate(program);
  add_compare(program);
  add_diagnose(program);
  add_export(program);
  const std::string version =
      fmt::format("armukf {} (built for {})", library_version(), build_processor());
  program.set_version_flag("--version", version);
  for (CLI::App* command : program.get_subcommands({}))
    command->set_version_flag("--version", version);
}

/// Whether a word at the front is for the program itself, not for the default command.
bool chooses_command(const CLI::App& program, const std::string& word) {
  constexpr std::array<std::string_view, 3> kOwnOptions{"-h", "--help", "--version"};
  return std::ranges::find(kOwnOptions, word) != kOwnOptions.end() ||
         std::ranges::any_of(program.get_subcommands({}),
                             [&](const CLI::App* command) { return command->get_name() == word; });
}

/// InputError where a word at the front that is no command can neither be a record's name nor an
/// option, and so was to be a command.
void check_record(const CLI::App& program, const std::string& word) {
  std::error_code unknown;  // what cannot be looked up is no record either
  if (word.empty() || word.find_first_of("-./") != std::string::npos) return;
  if (std::filesystem::exists(word, unknown)) return;
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands({})) names.push_back(command->get_name());
  throw InputError(fmt::format("{}: neither a file nor a command; commands are: {}", word,
                               fmt::join(names, ", ")));
}

/// What the user typed, last word first as CLI11 takes it; the default command where none is named.
std::vector<std::string> reversed_words(const CLI::App& program, std::vector<std::string> words) {
  if (words.empty() || !chooses_command(program, words[0])) {
    if (!words.empty()) check_record(program, words[0]);
    words.insert(words.begin(), kDefault);
  }
  std::ranges::reverse(words);
  return words;
}

/// One line on standard error, whatever the message holds.
int complain(std::string message, int status) {
  std::ranges::replace(message, '\n', ' ');
  fmt::print(stderr, "{}\n", message);
  return status;
}

/// Fits take and give back matrices of megabytes at every step: what is given back stays at hand,
/// or the system would have to clear it page by page each time.
void keep_freed_memory() {
  constexpr int kMostKept = 1 << 29;  // bytes, at the end of what is in use
  constexpr int kApart = 1 << 28;     // bytes, of what is never kept
  mallopt(M_TRIM_THRESHOLD, kMostKept);
  mallopt(M_MMAP_THRESHOLD, kApart);
}

int run(const std::vector<std::string>& words) {
  CLI::App program("Recursive estimate of the states and parameters of a flexible robot arm.",
                   "armukf");
  try {
    add_commands(program);
    program.parse(reversed_words(program, words));
    return kDone;
  } catch (const CLI::Success& wish) {  // --help, --version
    program.exit(wish);
    if (std::cout.flush()) return kDone;
    return complain("<stdout>: cannot write", kFailed);
  } catch (const CLI::ParseError& error) {
    return complain(error.what(), kWrongInput);
  } catch (const InputError& error) {
    return complain(error.what(), kWrongInput);
  } catch (const std::exception& error) {
    return complain(fmt::format("armukf: {}", error.what()), kFailed);
  }
}

}  // namespace
}  // namespace armukf::apps

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a reader that leaves shows as a failed write
  // A step that Ceres cannot solve for is shortened; its warnings would stand among our own.
  FLAGS_minloglevel = google::GLOG_FATAL;
  armukf::apps::keep_freed_memory();
  return armukf::apps::run(armukf::apps::with_joined_starts({argv + 1, argv + argc}));
}
