#include "armukf/io/rewritten_file.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace armukf {
namespace {

namespace fs = std::filesystem;

class RewrittenFileTest : public testing::Test {
 protected:
  RewrittenFileTest() { fs::create_directory(folder_); }
  ~RewrittenFileTest() override { fs::remove_all(folder_); }

  std::string path() const { return (folder_ / "belief").string(); }
  std::string content() const {
    std::ifstream file(path());
    return {std::istreambuf_iterator<char>(file), {}};
  }
  auto files() const { return std::distance(fs::directory_iterator(folder_), {}); }

  fs::path folder_ =
      fs::path(testing::TempDir()) / ("armukf_rewritten_" + std::to_string(::getpid()));
};

TEST_F(RewrittenFileTest, HoldsWhatWasPutLast) {
  RewrittenFile file(path());
  for (int i = 0; i < 50; ++i) file.put(std::string(1000, static_cast<char>('a' + i % 26)));
  file.finish();
  EXPECT_FALSE(file.busy());
  EXPECT_EQ(content(), std::string(1000, 'a' + 49 % 26));
  EXPECT_EQ(file.take_failure(), "");
  EXPECT_EQ(files(), 1);
}

TEST_F(RewrittenFileTest, WritesWhatStillWaitsBeforeItGoes) {
  { RewrittenFile(path()).put("last"); }
  EXPECT_EQ(content(), "last");
}

TEST_F(RewrittenFileTest, FailureIsToldAndTheNextOneMayDoBetter) {
  RewrittenFile file((folder_ / "not_yet" / "belief").string());
  file.put("one");
  file.finish();
  EXPECT_NE(file.take_failure().find("cannot open for writing"), std::string::npos);
  EXPECT_EQ(file.take_failure(), "");
  fs::create_directory(folder_ / "not_yet");
  file.put("two");
  file.finish();
  EXPECT_EQ(file.take_failure(), "");
}

TEST_F(RewrittenFileTest, RemovesWhatAKilledWriterLeftAndNothingElse) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  const std::string stale = path() + "." + std::to_string(child) + ".0.tmp";
  const std::string living = path() + "." + std::to_string(::getpid()) + ".0.tmp";
  for (const std::string& name : {stale, living, path() + ".tmp", path() + ".1.2.tmp.txt"})
    std::ofstream(name) << "half";
  const RewrittenFile file(path());
  EXPECT_FALSE(fs::exists(stale));
  EXPECT_EQ(files(), 3);
}

}  // namespace
}  // namespace armukf
