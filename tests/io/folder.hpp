#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace armukf {

/// A folder of its own for each test, removed afterwards.
class Folder : public testing::Test {
 protected:
  Folder() { std::filesystem::create_directory(folder_); }
  ~Folder() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  auto files() const { return std::distance(std::filesystem::directory_iterator(folder_), {}); }

  static std::string content(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static void put(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

 private:
  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      fmt::format("armukf_{}_{}", ::getpid(),
                  testing::UnitTest::GetInstance()->current_test_info()->name());
};

}  // namespace armukf
