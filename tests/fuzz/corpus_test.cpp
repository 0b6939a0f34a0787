#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "fuzz/targets.hpp"

namespace armukf {
namespace {

namespace fs = std::filesystem;

/// Each file of a target's corpus through it, and each with its bytes cut and turned over; how
/// many.
int passed(const std::string& name, void (*target)(std::string_view)) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(ARMUKF_CORPUS) / name)) {
    SCOPED_TRACE(entry.path().string());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    target(bytes);
    for (std::size_t part = 1; part < 8; ++part) {
      std::string wrong = bytes.substr(0, part * bytes.size() / 8);
      target(wrong);
      if (!wrong.empty()) wrong[wrong.size() / 2] ^= static_cast<char>(1 << part % 7);
      target(wrong);
    }
    ++count;
  }
  return count;
}

TEST(Fuzz, CorpusOfEachTargetDoesNoHarm) {
  EXPECT_GT(passed("csv", fuzz::csv), 0);
  EXPECT_GT(passed("model", fuzz::model), 0);
  EXPECT_GT(passed("checkpoint", fuzz::checkpoint), 0);
  EXPECT_GT(passed("estimate", fuzz::estimate), 0);
}

}  // namespace
}  // namespace armukf
