#include "armukf/io/atomic_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "armukf/core/error.hpp"
#include "armukf/io/csv_writer.hpp"
#include "io/folder.hpp"

namespace armukf {
namespace {

namespace fs = std::filesystem;

using AtomicFileTest = Folder;

TEST_F(AtomicFileTest, TargetIsUntouchedBeforeCommit) {
  put(path("a.json"), "old");
  AtomicFile file(path("a.json"));
  file.write("new");
  EXPECT_EQ(content(path("a.json")), "old");
  file.commit();
  EXPECT_EQ(content(path("a.json")), "new");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, NothingRemainsWithoutCommit) {
  put(path("old.json"), "old");
  {
    AtomicFile replaced(path("old.json"));
    AtomicFile fresh(path("new.json"));
    replaced.write("half");
    fresh.write("half");
  }
  EXPECT_EQ(content(path("old.json")), "old");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, TwoFilesOfOneTargetDoNotMix) {
  AtomicFile first(path("a.json"));
  AtomicFile second(path("a.json"));
  first.write("first");
  second.write("second");
  first.commit();
  EXPECT_EQ(content(path("a.json")), "first");
  second.commit();
  EXPECT_EQ(content(path("a.json")), "second");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, PermissionsAreKept) {
  put(path("a.json"), "old");
  ::chmod(path("a.json").c_str(), 0640);
  AtomicFile file(path("a.json"));
  file.commit();
  EXPECT_EQ(fs::status(path("a.json")).permissions(), fs::perms{0640});
}

TEST_F(AtomicFileTest, NewFileHasTheUsersDefaultPermissions) {
  put(path("ordinary"), "");
  AtomicFile file(path("a.json"));
  file.commit();
  EXPECT_EQ(fs::status(path("a.json")).permissions(), fs::status(path("ordinary")).permissions());
}

TEST_F(AtomicFileTest, SymbolicLinkStaysALink) {
  put(path("real.json"), "old");
  fs::create_symlink("real.json", path("link.json"));
  AtomicFile file(path("link.json"));
  file.write("new");
  file.commit();
  EXPECT_TRUE(fs::is_symlink(path("link.json")));
  EXPECT_EQ(content(path("real.json")), "new");
}

TEST_F(AtomicFileTest, CarriesTheRowsOfACsvWriter) {
  AtomicFile file(path("a.csv"));
  CsvWriter writer(file.descriptor(), file.name());
  writer.row(std::array{1.0, 2.0});
  writer.flush();
  file.commit();
  EXPECT_EQ(content(path("a.csv")), "1,2\n");
}

TEST_F(AtomicFileTest, DeviceIsWrittenDirectly) {
  {
    AtomicFile file("/dev/null");
    file.write("gone");
    file.commit();
  }
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  AtomicFile full("/dev/full");
  EXPECT_THROW(full.write("too much"), std::system_error);
}

TEST_F(AtomicFileTest, StandardOutputIsWrittenDirectly) {
  for (const std::string target : {"-", "/dev/stdout"}) {
    testing::internal::CaptureStdout();
    AtomicFile file(target);
    file.write("text");
    file.commit();
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "text");
  }
}

TEST_F(AtomicFileTest, TargetThatCannotBeWrittenIsTheUsersFault) {
  try {
    AtomicFile file(path("missing") + "/a.json");
    FAIL() << "a missing folder goes unnoticed";
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(),
              path("missing") + "/a.json: cannot open for writing: No such file or directory");
  }
  EXPECT_THROW(AtomicFile(path("")), InputError);  // a folder
}

}  // namespace
}  // namespace armukf
