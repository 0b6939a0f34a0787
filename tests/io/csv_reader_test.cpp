#include "armukf/io/csv_reader.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

void put(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const auto count = ::write(descriptor, text.data(), text.size());
    ASSERT_GT(count, 0);
    text.remove_prefix(static_cast<std::size_t>(count));
  }
}

/// A regular file of this content, named run.csv in messages.
ByteSource file(std::string_view content) {
  Descriptor memory(::memfd_create("run.csv", MFD_CLOEXEC));
  put(memory.number(), content);
  ::lseek(memory.number(), 0, SEEK_SET);
  return ByteSource(std::move(memory), "run.csv");
}

struct Pipe {
  Descriptor read_end;
  Descriptor write_end;
};

Pipe make_pipe() {
  std::array<int, 2> ends{-1, -1};
  EXPECT_EQ(::pipe(ends.data()), 0);
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

/// The samples before the end or the first fault, and the message of that fault.
struct Outcome {
  std::vector<Sample> samples;
  std::string fault;
};

Outcome read_all(ByteSource source, const Columns& columns = {}) {
  Outcome outcome;
  CsvReader reader(std::move(source), columns);
  try {
    while (const auto sample = reader.next()) outcome.samples.push_back(*sample);
  } catch (const InputError& error) {
    outcome.fault = error.what();
  }
  return outcome;
}

std::string fault(std::string_view content) { return read_all(file(content)).fault; }

std::string open_fault(const std::string& path) {
  try {
    const ByteSource source(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Expects the rows (0, 1, 2) and (0.5, -3, 4e-1), in whatever dress.
void expect_two_rows(std::string_view content, const Columns& columns = {}) {
  const Outcome outcome = read_all(file(content), columns);
  EXPECT_EQ(outcome.fault, "") << content;
  ASSERT_EQ(outcome.samples.size(), 2u) << content;
  EXPECT_EQ(outcome.samples[0].t, 0.0);
  EXPECT_EQ(outcome.samples[0].u, 1.0);
  EXPECT_EQ(outcome.samples[0].y, 2.0);
  EXPECT_EQ(outcome.samples[1].t, 0.5);
  EXPECT_EQ(outcome.samples[1].u, -3.0);
  EXPECT_EQ(outcome.samples[1].y, 0.4);
}

TEST(CsvReader, EverySeparatorReadsAlike) {
  expect_two_rows("t,u,y\n0,1,2\n0.5,-3,4e-1\n");
  expect_two_rows("t;u;y\n0;1;2\n0.5;-3;4e-1\n");
  expect_two_rows("t\tu\ty\n0\t1\t2\n0.5\t-3\t4e-1\n");
}

TEST(CsvReader, LineEndsAndByteOrderMarkChangeNothing) {
  expect_two_rows("t,u,y\r\n0,1,2\r\n0.5,-3,4e-1\r\n");
  expect_two_rows("\xEF\xBB\xBFt,u,y\n0,1,2\n0.5,-3,4e-1\n");
  expect_two_rows("\xEF\xBB\xBF# first a comment\nt,u,y\n0,1,2\n0.5,-3,4e-1\n");
  expect_two_rows("t,u,y\n0,1,2\n0.5,-3,4e-1");
  expect_two_rows("t,u,y\r\n0,1,2\r\n0.5,-3,4e-1\r\n\r\n\n  \n");
}

TEST(CsvReader, CommentsSpacesQuotesAndPlusSignsChangeNothing) {
  expect_two_rows("# made by hand\n\nt,u,y\n#0,0,0\n0,1,2\n  # half\n0.5,-3,4e-1\n# end");
  expect_two_rows(" t , u,y \n 0 ,1, 2\n\t0.5,-3 ,4e-1  \n");
  expect_two_rows("\"t\",\"u\",\"y\"\n0,\"1\",2\n0.5,-3,4e-1\n");
  expect_two_rows("t,u,y\n+0,+1.0,+2\n+5e-1,-3,+.4\n");
}

TEST(CsvReader, ColumnsAreFoundByNameInAnyOrder) {
  expect_two_rows("note,y,q,t,u\nx,2,,0,1\n\"a;b,\"\"c\",4e-1,7,0.5,-3\n");
  expect_two_rows("\"a, b, c\";y;t;u\nx;2;0;1\nx;4e-1;0.5;-3\n");
  expect_two_rows("time,u,speed,y\n0,1,2,9\n0.5,-3,4e-1,9\n", parse_columns("t=time,y=speed"));
}

TEST(CsvReader, ClosingSeparatorsChangeNothing) {
  expect_two_rows("t,u,y\n0,1,2,\n0.5,-3,4e-1,\n");
  expect_two_rows("t,u,y,\n0,1,2,\n0.5,-3,4e-1,\n");
  expect_two_rows("t,u,y,\n0,1,2\n0.5,-3,4e-1\n");
}

TEST(CsvReader, EmptyAndNanMeasurementsAreMissing) {
  const auto outcome =
      read_all(file("t,u,y\n0,1,\n1,1,nan\n2,1,NaN\n3,1,-NAN\n4,1,  \n5,1,\"\"\n6,1,"));
  EXPECT_EQ(outcome.fault, "");
  ASSERT_EQ(outcome.samples.size(), 7u);
  for (const Sample& sample : outcome.samples) EXPECT_TRUE(std::isnan(sample.y)) << sample.t;
}

TEST(CsvReader, RowsBeforeTheFaultAreDelivered) {
  const auto outcome = read_all(file("t,u,y\n0,1,2\n1,1,2\n2,abc,2\n3,1,2\n"));
  EXPECT_EQ(outcome.samples.size(), 2u);
  EXPECT_EQ(outcome.fault, "run.csv:4: u: 'abc' is not a number");
}

TEST(CsvReader, NumberKeepsAllItsDigits) {
  const auto outcome = read_all(file("t,u,y\n0.1,-1.7976931348623157e308,5e-324\n"));
  ASSERT_EQ(outcome.samples.size(), 1u);
  EXPECT_EQ(outcome.samples[0].t, 0.1);
  EXPECT_EQ(outcome.samples[0].u, -1.7976931348623157e308);
  EXPECT_EQ(outcome.samples[0].y, 5e-324);
}

TEST(CsvReader, FileOfNothingIsRefused) {
  EXPECT_EQ(fault(""), "run.csv: file is empty");
  EXPECT_EQ(fault("# only\n\n# comments\n"), "run.csv: no header line");
  EXPECT_EQ(fault("\xEF\xBB\xBF"), "run.csv: no header line");
  EXPECT_EQ(fault("t,u,y\n"), "run.csv: has a header but no samples");
  EXPECT_EQ(fault("t,u,y\n# none\n"), "run.csv: has a header but no samples");
}

TEST(CsvReader, MissingColumnIsNamedBesideThoseFound) {
  EXPECT_EQ(fault("t,torque,y\n0,1,2\n"),
            "run.csv:1: u: no such column; the header has t, torque, y");
  EXPECT_EQ(fault("# no header\n0.1,1.5,2\n"),
            "run.csv:2: t: no such column; the header has 0.1, 1.5, 2");
  std::string wide = "a1";
  for (int i = 2; i <= 30; ++i) wide += ",a" + std::to_string(i);
  EXPECT_EQ(fault(wide + "\n1\n"),
            "run.csv:1: t: no such column; the header has a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, "
            "a11, a12, a13, a14, a15, a16, a17, a18, a19, a20, ...");
}

TEST(CsvReader, ColumnGivenTwiceIsRefusedOnlyIfNeeded) {
  EXPECT_EQ(fault("t,u,y,u\n0,1,2,3\n"), "run.csv:1: u: the header has this column twice");
  EXPECT_EQ(fault("t,u,y,x,x\n0,1,2,3,4\n"), "");
}

TEST(CsvReader, TextInPlaceOfANumberIsQuoted) {
  EXPECT_EQ(fault("t,u,y\n0,1,2 3\n"), "run.csv:2: y: '2 3' is not a number");
  EXPECT_EQ(fault("t,u,y\n0x10,1,2\n"), "run.csv:2: t: '0x10' is not a number");
  EXPECT_EQ(fault("t,u,y\n0,+-1,2\n"), "run.csv:2: u: '+-1' is not a number");
  EXPECT_EQ(fault("t,u,y\n0,1,a\x1B[31m\x7F\n"), "run.csv:2: y: 'a?[31m?' is not a number");
}

TEST(CsvReader, LongTextIsCutAtAWholeCharacter) {
  EXPECT_EQ(fault("t,u,y\n0," + std::string(60, 'a') + ",2\n"),
            "run.csv:2: u: '" + std::string(40, 'a') + "...' is not a number");
  EXPECT_EQ(fault("t,u,y\n0," + std::string(39, 'a') + "\xC3\xA9z,2\n"),
            "run.csv:2: u: '" + std::string(39, 'a') + "...' is not a number");
}

TEST(CsvReader, DecimalCommaIsRefused) {
  EXPECT_EQ(fault("t;u;y\n0;1,5;2\n"),
            "run.csv:2: u: '1,5' is not a number; the decimal sign is a point");
  EXPECT_EQ(fault("t,u,y\n0,1,5,2,0\n"), "run.csv:2: row has 5 cells, the header has 3");
}

TEST(CsvReader, InfiniteValueIsRefused) {
  EXPECT_EQ(fault("t,u,y\ninf,1,2\n"), "run.csv:2: t: 'inf' is not finite");
  EXPECT_EQ(fault("t,u,y\n0,-Infinity,2\n"), "run.csv:2: u: '-Infinity' is not finite");
  EXPECT_EQ(fault("t,u,y\n0,1,1e999\n"), "run.csv:2: y: '1e999' is not finite");
}

TEST(CsvReader, OnlyTheMeasurementMayBeMissing) {
  EXPECT_EQ(fault("t,u,y\nnan,1,2\n"), "run.csv:2: t: 'nan' is missing, which only y may be");
  EXPECT_EQ(fault("t,u,y\n0,,2\n"), "run.csv:2: u: '' is missing, which only y may be");
  EXPECT_EQ(fault("t,u,y\n,,\n"), "run.csv:2: t: '' is missing, which only y may be");
}

TEST(CsvReader, TimeMustAdvance) {
  EXPECT_EQ(fault("t,u,y\n0.5,1,2\n0.5,1,2\n"), "run.csv:3: t: time repeats: 0.5 s after 0.5 s");
  EXPECT_EQ(fault("t,u,y\n0.5,1,2\n# a break\n-1e-3,1,2\n"),
            "run.csv:4: t: time goes back: -0.001 s after 0.5 s");
}

TEST(CsvReader, FaultIsNamedByTheUsersColumn) {
  const auto outcome = read_all(file("zeit,u,y\n1,1,2\n0,1,2\n"), parse_columns("t=zeit"));
  EXPECT_EQ(outcome.fault, "run.csv:3: zeit: time goes back: 0 s after 1 s");
}

TEST(CsvReader, RowOfAnotherWidthIsRefused) {
  EXPECT_EQ(fault("t,u,y\n0,1\n1,1,2\n"), "run.csv:2: row has 2 cells, the header has 3");
  EXPECT_EQ(fault("t,u,y\n0\n1,1,2\n"), "run.csv:2: row has 1 cell, the header has 3");
  EXPECT_EQ(fault("t,u,y\n0,1,2,3\n"), "run.csv:2: row has 4 cells, the header has 3");
  EXPECT_EQ(fault("t,u,y,note\n0,1,2\n"), "run.csv:2: row has 3 cells, the header has 4");
}

TEST(CsvReader, LastRowCutInTheMiddleIsRefused) {
  const auto outcome = read_all(file("t,u,y\n0,1,2\n1,1"));
  EXPECT_EQ(outcome.samples.size(), 1u);
  EXPECT_EQ(outcome.fault, "run.csv:3: row is cut in the middle");
}

TEST(CsvReader, BinaryIsRefused) {
  using namespace std::string_view_literals;
  const std::string message = "line holds a NUL byte: binary or UTF-16, not CSV text";
  EXPECT_EQ(fault("t,u,y\n0,1,2\n1,1,2\0\n"sv), "run.csv:3: " + message);
  EXPECT_EQ(fault("\xFF\xFEt\0,\0u\0,\0y\0\n\0"sv), "run.csv:1: " + message);
}

TEST(CsvReader, LineLongerThanAMebibyteIsRefused) {
  const std::string long_note(std::size_t{1} << 20, 'x');
  const std::string allowed = long_note.substr(8);  // "0,1,2," and the note: under the limit
  EXPECT_EQ(fault("t,u,y,note\n0,1,2," + allowed + "\n1,1,2,\n"), "");
  EXPECT_EQ(fault("t,u,y,note\n0,1,2," + long_note + "\n"), "run.csv:2: line is longer than 1 MiB");
  EXPECT_EQ(fault(long_note + long_note + long_note), "run.csv:1: line is longer than 1 MiB");
}

TEST(CsvReader, LinesAcrossReadsStayWhole) {
  std::string content = "t,u,y\n";
  constexpr int kRows = 50'000;  // 800 kB: a dozen reads
  for (int i = 0; i < kRows; ++i) content += std::to_string(i) + ",0.125,-0.25\n";
  const auto outcome = read_all(file(content));
  ASSERT_EQ(outcome.samples.size(), std::size_t{kRows}) << outcome.fault;
  for (int i = 0; i < kRows; ++i) {
    ASSERT_EQ(outcome.samples[static_cast<std::size_t>(i)].t, i);
    ASSERT_EQ(outcome.samples[static_cast<std::size_t>(i)].y, -0.25);
  }
}

TEST(CsvReader, ConsumedGrowsToTheSizeOfTheFile) {
  const std::string_view content = "t,u,y\n0,1,2\n1,1,2\n";
  CsvReader reader(file(content));
  EXPECT_FALSE(reader.live());
  EXPECT_EQ(reader.size(), std::optional<std::uint64_t>(content.size()));
  reader.next();
  EXPECT_EQ(reader.consumed(), 12u);  // the header and one row, six bytes each
  while (reader.next()) {
  }
  EXPECT_EQ(reader.consumed(), content.size());
}

TEST(CsvReader, PathThatCannotBeReadIsRefused) {
  const std::string missing = testing::TempDir() + "no_such_run.csv";
  EXPECT_EQ(open_fault(missing), missing + ": cannot open: No such file or directory");
  EXPECT_EQ(open_fault("/"), "/: cannot open: Is a directory");
}

TEST(CsvReader, RecordHoldsAllSamplesAndItsName) {
  const std::string path =
      testing::TempDir() + "armukf_record_" + std::to_string(::getpid()) + ".csv";
  {
    const Descriptor output(::creat(path.c_str(), 0600));
    put(output.number(), "t,u,y\n0,1,2\n1,1,\n");
  }
  const Record record = read_record(path);
  std::filesystem::remove(path);
  EXPECT_EQ(record.name, path);
  EXPECT_EQ(record.samples.size(), 2u);
}

TEST(LiveCsvReader, SampleIsReadyAsSoonAsItsLineIs) {
  auto [read_end, write_end] = make_pipe();
  CsvReader reader(ByteSource(std::move(read_end), "<stdin>"));
  EXPECT_TRUE(reader.live());
  EXPECT_EQ(reader.size(), std::nullopt);
  put(write_end.number(), "t,u,y\n0,1,2\n");
  EXPECT_EQ(reader.next()->t, 0.0);  // and does not wait for more
  put(write_end.number(), "1,1,2\n2,1");
  EXPECT_EQ(reader.next()->t, 1.0);
  put(write_end.number(), ",2\n");
  EXPECT_EQ(reader.next()->t, 2.0);
  write_end = Descriptor();
  EXPECT_FALSE(reader.next());
  EXPECT_FALSE(reader.next());  // an end stays an end
}

TEST(LiveCsvReader, WouldWaitUnlessASampleIsBuffered) {
  auto [read_end, write_end] = make_pipe();
  CsvReader reader(ByteSource(std::move(read_end), "<stdin>"));
  EXPECT_TRUE(reader.would_wait());
  put(write_end.number(), "t,u,y\n0,1,2\n1,1,2\n# not a sample\n\n2,1");
  EXPECT_EQ(reader.next()->t, 0.0);
  EXPECT_FALSE(reader.would_wait());
  EXPECT_EQ(reader.next()->t, 1.0);
  EXPECT_TRUE(reader.would_wait());
  put(write_end.number(), ",abc\n");
  try {
    reader.next();
    FAIL() << "a fault goes unnoticed";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "<stdin>:6: y: 'abc' is not a number");  // passed-over lines count
  }
}

TEST(LiveCsvReader, FileNeverWouldWait) {
  CsvReader reader(file("t,u,y\n0,1,2\n"));
  while (reader.next()) EXPECT_FALSE(reader.would_wait());
}

TEST(LiveCsvReader, BytesMayComeOneByOne) {
  auto [read_end, write_end] = make_pipe();
  std::jthread sender([end = std::move(write_end)] {
    for (const char c : std::string_view("\xEF\xBB\xBFt,u,y\r\n0,1,2\r\n1,1,2\r\n")) {
      put(end.number(), std::string_view(&c, 1));
      std::this_thread::yield();
    }
  });
  const auto outcome = read_all(ByteSource(std::move(read_end), "<stdin>"));
  EXPECT_EQ(outcome.fault, "");
  EXPECT_EQ(outcome.samples.size(), 2u);
}

volatile std::sig_atomic_t stop_requested = 0;

TEST(LiveCsvReader, StopFlagEndsTheWaitAndDropsTheIncompleteRow) {
  auto [read_end, write_end] = make_pipe();
  stop_requested = 0;
  std::signal(SIGALRM, [](int) { stop_requested = 1; });
  const itimerval soon{.it_interval = {}, .it_value = {.tv_sec = 0, .tv_usec = 20'000}};
  CsvReader reader(ByteSource(std::move(read_end), "<stdin>", &stop_requested));
  put(write_end.number(), "t,u,y\n0,1,2\n1,1");
  EXPECT_TRUE(reader.next());
  ASSERT_EQ(::setitimer(ITIMER_REAL, &soon, nullptr), 0);
  EXPECT_FALSE(reader.next());  // the pipe is still open
  std::signal(SIGALRM, SIG_DFL);
}

TEST(LiveCsvReader, StopFlagBeforeTheFirstReadIsNoFault) {
  auto [read_end, write_end] = make_pipe();
  stop_requested = 1;
  CsvReader reader(ByteSource(std::move(read_end), "<stdin>", &stop_requested));
  EXPECT_FALSE(reader.next());
}

std::string columns_fault(std::string_view text) {
  try {
    parse_columns(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Columns, AnySubsetMayBeRenamed) {
  const Columns one = parse_columns("u=torque [N.m]");
  EXPECT_EQ(one.t, "t");
  EXPECT_EQ(one.u, "torque [N.m]");
  EXPECT_EQ(one.y, "y");
  const Columns all = parse_columns("y=a=b,t=u,u=t");
  EXPECT_EQ(all.t, "u");
  EXPECT_EQ(all.u, "t");
  EXPECT_EQ(all.y, "a=b");
}

TEST(Columns, BadTextIsRefused) {
  for (const std::string text : {"", "t", "t=", "x=a", "t=a,", ",t=a", "t=a,,u=b", "time=a"}) {
    EXPECT_EQ(columns_fault(text), "--columns: '" + text + "': expected t=NAME,u=NAME,y=NAME");
  }
  EXPECT_EQ(columns_fault("t=a,t=b"), "--columns: 't=a,t=b': t is given twice");
  EXPECT_EQ(columns_fault("u=y"), "--columns: 'u=y': t, u and y must be three different columns");
}

}  // namespace
}  // namespace armukf
