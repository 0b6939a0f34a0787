#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "armukf/core/error.hpp"
#include "armukf/io/csv_reader.hpp"
#include "io/folder.hpp"

namespace armukf {
namespace {

namespace fs = std::filesystem;

const std::string kLongLine(3'000'000, 'x');  // bytes; no record has such a line

volatile std::sig_atomic_t stop_requested = 0;

/// A file that grows while it is read.
class FollowedFile : public Folder {
 protected:
  FollowedFile() { stop_requested = 0; }

  void append(const std::string& text) const {
    std::ofstream(path_, std::ios::app | std::ios::binary) << text;
  }
  CsvReader reader(TimeOrder order = TimeOrder::kRising) const {
    return CsvReader(ByteSource(path_, &stop_requested, FileEnd::kFollowed), {}, order);
  }

  const std::string path_ = path("live.csv");
};

TEST_F(FollowedFile, IsLiveAndGivesWhatIsAppended) {
  append("t,u,y\n0,1,2\n");
  CsvReader rows = reader();
  EXPECT_TRUE(rows.live());
  EXPECT_EQ(rows.next()->t, 0.0);
  EXPECT_TRUE(rows.would_wait());
  append("1,1,2\n2,");
  EXPECT_EQ(rows.next()->t, 1.0);
  append("1,3\n");
  EXPECT_EQ(rows.next()->y, 3.0);
}

TEST_F(FollowedFile, StopEndsTheWait) {
  append("t,u,y\n0,1,2\n");
  CsvReader rows = reader();
  rows.next();
  stop_requested = 1;
  EXPECT_FALSE(rows.next());
}

TEST_F(FollowedFile, RotationLosesNoRowWithOrWithoutANewHeader) {
  for (const std::string header : {"t,u,y\n", "", "y,t,u\n", "# begun anew\nt,u,y\n"}) {
    fs::remove(path_);
    append("t,u,y\n0,1,2\n");
    CsvReader rows = reader();
    EXPECT_EQ(rows.next()->t, 0.0);
    fs::rename(path_, path_ + ".1");
    std::ofstream(path_ + ".1", std::ios::app) << "1,1,2\n2,1,2";  // the last without a newline
    append(header + (header.starts_with("y") ? "2,3,1\n" : "3,1,2\n"));
    for (const double t : {1.0, 2.0, 3.0}) {
      const auto sample = rows.next();
      ASSERT_TRUE(sample);
      EXPECT_EQ(sample->t, t) << header;
      EXPECT_EQ(sample->y, 2.0) << header;
    }
  }
}

TEST_F(FollowedFile, FileThatIsCutAndWrittenAnewIsReadFromItsStart) {
  append("t,u,y\n0,1,2\n1,1,2\n");
  CsvReader rows = reader();
  rows.next();
  rows.next();
  fs::resize_file(path_, 0);
  append("t,u,y\n2,1,2\n");
  EXPECT_EQ(rows.next()->t, 2.0);
}

TEST_F(FollowedFile, LinesCountFromEachFilesStart) {
  append("t,u,y\n0,1,2\n1,1,2\n");
  CsvReader rows = reader();
  rows.next();
  rows.next();
  fs::rename(path_, path_ + ".1");
  append("t,u,y\nx,1,2\n");
  try {
    rows.next();
    FAIL() << "a fault goes unnoticed";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), path_ + ":2: t: 'x' is not a number");
  }
}

/// Rows that are told from the others.
CsvReader tolerant(const std::string& path) {
  return CsvReader(ByteSource(path), {}, TimeOrder::kAny);
}

/// What is left of a record if faulty rows are passed over.
struct Salvage {
  std::vector<double> times;
  std::vector<std::string> faults;
};

Salvage skipping(CsvReader reader) {
  Salvage all;
  for (;;) {
    try {
      const auto sample = reader.next();
      if (!sample) return all;
      all.times.push_back(sample->t);
    } catch (const LineError& error) {
      all.faults.emplace_back(error.what());
    }
  }
}

TEST_F(FollowedFile, RowsAfterAFaultyOneCanBeReadWhateverTheFault) {
  append("t,u,y\n0,1,2\nabc,1,2\n1,1,2\n2,1\n" + std::string(1, '\0') + "\n3,1,2\n" + kLongLine +
         "\n4,1,2\n5,1,inf\n5,1,2,3\n6,,2\n7,1,2\n7,1,2\n6,1,2\n");
  const Salvage salvage = skipping(tolerant(path_));
  EXPECT_EQ(salvage.times, (std::vector{0.0, 1.0, 3.0, 4.0, 7.0, 7.0, 6.0}));
  ASSERT_EQ(salvage.faults.size(), 7U);
  EXPECT_EQ(salvage.faults[3], path_ + ":8: line is longer than 1 MiB");
  EXPECT_EQ(salvage.faults[4], path_ + ":10: y: 'inf' is not finite");
}

TEST_F(FollowedFile, WithoutAHeaderNothingCanBeRead) {
  append(kLongLine + "\nt,u,y\n0,1,2\n");
  CsvReader reader = tolerant(path_);
  try {
    reader.next();
    FAIL() << "a fault goes unnoticed";
  } catch (const LineError&) {
    FAIL() << "taken for a row";
  } catch (const InputError&) {
  }
}

TEST_F(FollowedFile, TimeOfAFaultyRowIsSalvagedWhereItCanBeTrusted) {
  const auto salvaged = [&](const std::string& row) -> std::optional<Sample> {
    fs::remove(path_);
    append("u,t,y\n1,0,2\n" + row);
    CsvReader reader = tolerant(path_);
    reader.next();
    EXPECT_THROW(reader.next(), LineError) << row;
    return reader.salvaged();
  };
  EXPECT_EQ(salvaged("1,0.5,abc\n")->t, 0.5);
  EXPECT_EQ(salvaged("1,0.5,abc\n")->u, 1.0);
  EXPECT_TRUE(std::isnan(salvaged("1,0.5,abc\n")->y));
  EXPECT_TRUE(std::isnan(salvaged("x,0.5,3\n")->u));
  EXPECT_EQ(salvaged("1,0.5,3,4,5\n")->t, 0.5);
  EXPECT_FALSE(salvaged("1,0.5"));  // of 0.5125, perhaps
  EXPECT_FALSE(salvaged("1,x,3\n"));
  EXPECT_FALSE(salvaged("1,inf,3\n"));
  EXPECT_FALSE(salvaged(kLongLine + "\n"));
}

TEST_F(FollowedFile, KeyIsTheCellOfItsColumnAndNoPath) {
  append(
      "arm,t,u,y\na,0,1,2\n\"left "
      "3\",0,1,2\n../x,0,1,2\nb/c,0,1,2\n,0,1,2\n.b,0,1,2\nd\\e,0,1,2\n" +
      std::string(101, 'n') + ",0,1,2\n\x01,0,1,2\n");
  CsvReader reader(ByteSource(path_), {.key = "arm"}, TimeOrder::kAny);
  reader.next();
  EXPECT_EQ(reader.key(), "a");
  reader.next();
  EXPECT_EQ(reader.key(), "left 3");
  for (int i = 0; i < 7; ++i) {
    EXPECT_THROW(reader.next(), LineError) << i;
    EXPECT_FALSE(reader.salvaged().has_value() && reader.key().empty()) << i;
  }
  EXPECT_FALSE(reader.next());
  EXPECT_THROW(CsvReader(ByteSource(path_), {.key = "robot"}).next(), InputError);
}

}  // namespace
}  // namespace armukf
