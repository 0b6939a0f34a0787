#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace armukf {

/// What a run of the program left behind.
struct Outcome {
  int status;
  std::string output;
  std::string error;
};

/// Runs the program in an empty folder of its own.
class Program : public testing::Test {
 protected:
  Program()
      : folder_(std::filesystem::temp_directory_path() / fmt::format("armukf_{}", ::getpid())) {
    std::filesystem::create_directory(folder_);
  }
  ~Program() override { std::filesystem::remove_all(folder_); }

  /// `arguments` as typed into a shell; `before` the program stands what runs it.
  Outcome run(const std::string& arguments, const std::string& output = "out",
              const std::string& before = "") const {
    const int status =
        std::system(fmt::format("cd '{}' && {} '{}' {} > {} 2> err < /dev/null", folder_.string(),
                                before, ARMUKF_PROGRAM, arguments, output)
                        .c_str());
    return {WEXITSTATUS(status), output == "out" ? text("out") : "", text("err")};
  }

  /// A command of bash in the test's folder, the program being $A; its exit status.
  int shell(const std::string& command) const {
    put("command", command);
    return WEXITSTATUS(std::system(
        fmt::format("cd '{}' && A='{}' bash ./command", folder_.string(), ARMUKF_PROGRAM).c_str()));
  }

  /// Lines that are no comments.
  static std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);)
      if (!line.starts_with('#')) lines.push_back(line);
    return lines;
  }

  std::string text(const std::string& file) const {
    std::ostringstream content;
    content << std::ifstream(folder_ / file).rdbuf();
    return content.str();
  }

  void put(const std::string& file, const std::string& content) const {
    std::ofstream(folder_ / file) << content;
  }

  bool exists(const std::string& file) const { return std::filesystem::exists(folder_ / file); }

  void expect_refused(const std::string& arguments, const std::string& message) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_EQ(outcome.error, message + "\n") << arguments;
    EXPECT_EQ(outcome.output, "") << arguments;
  }

  /// Whoever reads the output has no room for it. alone: nothing else is said, either.
  void expect_full_disk(const std::string& arguments, bool alone = false) const {
    const Outcome full = run(arguments, "/dev/full");
    EXPECT_EQ(full.status, 1) << arguments;
    // What else is said on standard error comes before.
    const auto last = full.error.rfind('\n', full.error.size() - 2) + 1;
    EXPECT_NE(full.error.find("<stdout>: cannot write", last), std::string::npos)
        << arguments << ": " << full.error;
    if (alone) {
      EXPECT_EQ(last, 0U) << arguments << ": " << full.error;
    }
  }

  std::filesystem::path folder_;
};

}  // namespace armukf
