#include "armukf/io/rewritten_file.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "io/folder.hpp"

namespace armukf {
namespace {

namespace fs = std::filesystem;

class RewrittenFileTest : public Folder {
 protected:
  const std::string path_ = path("belief");
};

TEST_F(RewrittenFileTest, HoldsWhatWasPutLast) {
  RewrittenFile file(path_);
  for (int i = 0; i < 50; ++i) file.put(std::string(1000, static_cast<char>('a' + i % 26)));
  file.finish();
  EXPECT_FALSE(file.busy());
  EXPECT_EQ(content(path_), std::string(1000, 'a' + 49 % 26));
  EXPECT_EQ(file.take_failure(), "");
  EXPECT_EQ(files(), 1);
}

TEST_F(RewrittenFileTest, WritesWhatStillWaitsBeforeItGoes) {
  { RewrittenFile(path_).put("last"); }
  EXPECT_EQ(content(path_), "last");
}

TEST_F(RewrittenFileTest, FailureIsToldAndTheNextOneMayDoBetter) {
  RewrittenFile file(path("not_yet/belief"));
  file.put("one");
  file.finish();
  EXPECT_NE(file.take_failure().find("cannot open for writing"), std::string::npos);
  EXPECT_EQ(file.take_failure(), "");
  fs::create_directory(path("not_yet"));
  file.put("two");
  file.finish();
  EXPECT_EQ(file.take_failure(), "");
}

TEST_F(RewrittenFileTest, RemovesWhatAKilledWriterLeftAndNothingElse) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  const std::string stale = path_ + "." + std::to_string(child) + ".0.tmp";
  const std::string living = path_ + "." + std::to_string(::getpid()) + ".0.tmp";
  for (const std::string& name : {stale, living, path_ + ".tmp", path_ + ".1.2.tmp.txt"})
    std::ofstream(name) << "half";
  const RewrittenFile file(path_);
  EXPECT_FALSE(fs::exists(stale));
  EXPECT_EQ(files(), 3);
}

}  // namespace
}  // namespace armukf
