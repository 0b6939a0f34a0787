#include "armukf/io/csv_writer.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "armukf/core/error.hpp"
#include "armukf/io/csv_reader.hpp"

namespace armukf {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// What is in a file in memory, or on its way through a pipe.
std::string content(int descriptor) {
  std::string text;
  std::array<char, 4096> piece{};
  ::lseek(descriptor, 0, SEEK_SET);
  for (;;) {
    const auto count = ::read(descriptor, piece.data(), piece.size());
    if (count <= 0) return text;
    text.append(piece.data(), static_cast<std::size_t>(count));
  }
}

Descriptor memory() { return Descriptor(::memfd_create("rows", MFD_CLOEXEC)); }

TEST(CsvWriter, RowIsItsCellsBetweenCommas) {
  const Descriptor file = memory();
  CsvWriter writer(file.number(), "rows");
  writer.row(std::vector<std::string>{"t", "y", "status"});
  writer.cell(0.5);
  writer.cell(kNan);
  writer.cell("missing");
  writer.end_row();
  writer.row(std::array{1e-300, -2.0, std::copysign(kNan, -1.0)});
  writer.flush();
  EXPECT_EQ(content(file.number()), "t,y,status\n0.5,nan,missing\n1e-300,-2,nan\n");
}

TEST(CsvWriter, TextThatWouldBreakARowIsQuoted) {
  const Descriptor file = memory();
  CsvWriter writer(file.number(), "rows");
  writer.row(std::vector<std::string>{"a,b", "say \"so\"", "plain"});
  writer.flush();
  EXPECT_EQ(content(file.number()), "\"a,b\",\"say \"\"so\"\"\",plain\n");
}

TEST(CsvWriter, EveryDoubleReadsBackTheSame) {
  std::mt19937_64 random(7);
  std::vector<double> values{-std::numeric_limits<double>::min(),
                             std::numeric_limits<double>::denorm_min(),
                             -std::numeric_limits<double>::max(), 0.1, 1.0 / 3.0};
  while (values.size() < 10'000) {
    const double value = std::bit_cast<double>(random());
    if (std::isfinite(value)) values.push_back(value);
  }
  Descriptor file = memory();
  {
    CsvWriter writer(file.number(), "rows");
    writer.row(std::vector<std::string>{"t", "u", "y"});
    double t = 0.0;  // s
    for (const double value : values) writer.row(std::array{t += 1.0, value, -value});
  }
  ::lseek(file.number(), 0, SEEK_SET);
  CsvReader reader(ByteSource(std::move(file), "rows"));
  for (const double value : values) {
    const auto sample = reader.next();
    ASSERT_TRUE(sample);
    ASSERT_EQ(sample->u, value);
    ASSERT_EQ(sample->y, -value);
  }
}

TEST(CsvWriter, RowsWaitForAFlush) {
  const Descriptor file = memory();
  CsvWriter writer(file.number(), "rows");
  writer.row(std::array{1.0});
  EXPECT_EQ(content(file.number()), "");
  writer.flush();
  EXPECT_EQ(content(file.number()), "1\n");
}

/// What is written at once arrives at once.
struct Packets {
  Packets() { EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends.data()), 0); }
  ~Packets() {
    for (const int end : ends) ::close(end);
  }
  std::string next() const {
    std::string packet(std::size_t{1} << 20, ' ');
    packet.resize(static_cast<std::size_t>(::read(ends[1], packet.data(), packet.size())));
    return packet;
  }
  std::array<int, 2> ends{-1, -1};
};

TEST(CsvWriter, FullBatchesAreWrittenInWholeRows) {
  const Packets packets;
  CsvWriter writer(packets.ends[0], "rows");
  std::jthread rows([&] {
    for (int i = 0; i < 20'000; ++i) writer.row(std::array{0.125, 0.25});  // 220 kB
  });
  for (int i = 0; i < 3; ++i) {
    const std::string written = packets.next();
    EXPECT_GT(written.size(), std::size_t{16} * 1024);
    EXPECT_EQ(written.size() % std::string_view("0.125,0.25\n").size(), 0u);
  }
  ::shutdown(packets.ends[1], SHUT_RD);  // nobody takes the rest
}

TEST(CsvWriter, RowsKeepTheirOrderHoweverTheyCame) {
  const Descriptor file = memory();
  CsvWriter writer(file.number(), "rows");
  std::string expected;
  for (int i = 0; i < 30'000; ++i) {
    const std::string number = std::to_string(i);
    if (i % 3 == 0) {
      writer.append_rows(number + "\n");
    } else if (i % 3 == 1) {
      writer.row(std::vector<std::string>{number});
    } else {
      writer.cell(i);
      writer.end_row();
    }
    if (i % 7'001 == 0) writer.flush();
    expected += number + "\n";
  }
  writer.flush();
  EXPECT_EQ(content(file.number()), expected);
}

TEST(CsvWriter, NothingIsWrittenAfterWhatCouldNotBe) {
  const Descriptor file(::open("/dev/full", O_WRONLY));
  const Descriptor good = memory();
  CsvWriter writer(file.number(), "rows");
  EXPECT_THROW(
      {
        for (int i = 0; i < 60'000; ++i) writer.row(std::array{0.125, 0.25});
        writer.flush();
      },
      std::system_error);
  ASSERT_EQ(::dup2(good.number(), file.number()), file.number());  // there is room again
  EXPECT_TRUE(writer.closed());
  writer.row(std::array{1.0});
  writer.flush();
  EXPECT_EQ(content(good.number()), "");
}

TEST(CsvWriter, StopEndsTheWaitForAStalledReaderWhateverThreadWaits) {
  std::array<int, 2> ends{-1, -1};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const Descriptor read_end(ends[0]);
  const std::string path = "/dev/fd/" + std::to_string(ends[1]);
  volatile std::sig_atomic_t stop = 0;
  CsvWriter writer(path, &stop);
  ::close(ends[1]);
  std::jthread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    stop = 1;
  });
  EXPECT_THROW(
      {
        for (int i = 0; i < 60'000; ++i) writer.row(std::array{0.125, 0.25});
        writer.flush();
      },
      std::system_error);
}

TEST(CsvWriter, EndOfLifeFlushes) {
  const Descriptor file = memory();
  { CsvWriter(file.number(), "rows").row(std::array{1.0, 2.0}); }
  EXPECT_EQ(content(file.number()), "1,2\n");
}

TEST(CsvWriter, PathIsReplacedFromItsStart) {
  const std::string path =
      testing::TempDir() + "armukf_writer_" + std::to_string(::getpid()) + ".csv";
  { CsvWriter(path).row(std::array{123456.0}); }
  { CsvWriter(path).row(std::array{7.0}); }
  const Descriptor file(::open(path.c_str(), O_RDONLY));
  EXPECT_EQ(content(file.number()), "7\n");
  std::filesystem::remove(path);
}

TEST(CsvWriter, ClosedPipeEndsWritingWithoutAFault) {
  std::signal(SIGPIPE, SIG_IGN);
  std::array<int, 2> ends{-1, -1};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const Descriptor write_end(ends[1]);
  CsvWriter writer(write_end.number(), "<stdout>");
  writer.row(std::array{1.0});
  writer.flush();
  EXPECT_FALSE(writer.closed());
  ::close(ends[0]);
  writer.row(std::array{2.0});
  writer.flush();
  EXPECT_TRUE(writer.closed());
  for (int i = 0; i < 50'000; ++i) writer.row(std::array{0.125, 0.25});
  writer.flush();
  EXPECT_TRUE(writer.closed());
}

TEST(CsvWriter, FullDiskIsAFaultThatNamesTheFile) {
  CsvWriter writer("/dev/full");
  writer.row(std::array{1.0});
  try {
    writer.flush();
    FAIL() << "a full disk goes unnoticed";
  } catch (const std::system_error& error) {
    EXPECT_STREQ(error.what(), "/dev/full: cannot write: No space left on device");
  }
}

TEST(CsvWriter, PathThatCannotBeWrittenIsTheUsersFault) {
  try {
    CsvWriter writer("/no/such/folder/out.csv");
    FAIL() << "a missing folder goes unnoticed";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "/no/such/folder/out.csv: cannot open for writing: No such file or directory");
  }
}

}  // namespace
}  // namespace armukf
