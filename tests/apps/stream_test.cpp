#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "apps/program.hpp"
#include "armukf/online/seals.hpp"

namespace armukf {
namespace {

using nlohmann::json;

/// The program in pipes, with what they carry gone wrong.
class Stream : public Program {
 protected:
  void SetUp() override {
    ASSERT_EQ(run("simulate -o a.csv --samples 3000 --sensor-noise 0.1").status, 0);
    record_ = lines_of(text("a.csv"));
  }

  /// The record with these lines instead of those at their places (header: 0).
  std::string with(const std::vector<std::pair<std::size_t, std::string>>& changes) const {
    std::vector<std::string> lines = record_;
    for (const auto& [place, line] : changes) lines[place] = line;
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
  }

  json summary(const std::string& file = "s.json") const { return json::parse(text(file)); }

  std::vector<std::string> record_;  // without comments
};

TEST_F(Stream, FaultyRowOfAPipeIsSkippedCountedAndNamed) {
  put("bad.csv", with({{100, "0.0495,x,1"}, {200, "garbage"}, {300, record_[299]}}));
  EXPECT_EQ(shell("cat bad.csv | $A --json s.json > out 2> err"), 0) << text("err");
  EXPECT_EQ(lines_of(text("out")).size(), 1 + 3000 - 3U);
  EXPECT_EQ(summary()["samples"], 2997);
  EXPECT_EQ(summary()["input"]["faulty"], 2);
  EXPECT_EQ(summary()["input"]["repeated"], 1);
  for (const char* part :
       {"<stdin>:101: u: 'x' is not a number\n", "<stdin>:201: row has 1 cell, the header has 3\n",
        "<stdin>:301: time repeats\n", "2 faulty, 0 late, 1 repeated"})
    EXPECT_NE(text("err").find(part), std::string::npos) << part << text("err");
}

TEST_F(Stream, FaultyRowOfAFileStopsItWithAllThatWasFoundBefore) {
  put("bad.csv", with({{1000, "garbage"}}));
  EXPECT_EQ(shell("$A bad.csv --json s.json --save m.toml > out 2> err"), 2);
  EXPECT_EQ(lines_of(text("out")).size(), 1 + 999U);
  EXPECT_EQ(summary()["samples"], 999);
  EXPECT_TRUE(exists("m.toml"));
  EXPECT_EQ(lines_of(text("err")).back(), "bad.csv:1001: row has 1 cell, the header has 3");
  EXPECT_EQ(run("bad.csv --quiet").error, "bad.csv:1001: row has 1 cell, the header has 3\n");
}

TEST_F(Stream, UserChoosesWhatAFaultyRowIs) {
  put("bad.csv", with({{1000, "0.4995,0.1,x"}, {1500, "garbage"}}));
  EXPECT_EQ(shell("cat bad.csv | $A --on-error stop --quiet > out 2> err"), 2);
  EXPECT_EQ(text("err"), "<stdin>:1001: y: 'x' is not a number\n");
  EXPECT_EQ(shell("$A bad.csv --on-error skip --json s.json > out 2> err"), 0);
  EXPECT_EQ(summary()["samples"], 2998);
  EXPECT_EQ(shell("$A bad.csv --on-error missing --json s.json > out 2> err"), 0);
  EXPECT_EQ(summary()["samples"], 2999);
  EXPECT_EQ(summary()["missing"], 1);
  EXPECT_NE(text("out").find("0.4995,nan"), std::string::npos);
}

TEST_F(Stream, ManyFaultyRowsAreNamedAtABoundedRateAndAllCounted) {
  std::string bad = with({});
  for (int k = 0; k < 20000; ++k) bad += "garbage\n";
  put("bad.csv", bad);
  EXPECT_EQ(shell("cat bad.csv | $A --json s.json > out 2> err"), 0);
  EXPECT_EQ(summary()["input"]["faulty"], 20000);
  EXPECT_LT(lines_of(text("err")).size(), 60U);
  EXPECT_NE(text("err").find(" more\n"), std::string::npos);
}

TEST_F(Stream, RowsOutOfOrderAreAsGoodAsInOrderWithinTheWindow) {
  std::vector<std::pair<std::size_t, std::string>> swaps;
  for (std::size_t k = 10; k + 5 < record_.size(); k += 10)
    swaps.insert(swaps.end(), {{k, record_[k + 4]}, {k + 4, record_[k]}});
  put("bad.csv", with(swaps));
  EXPECT_EQ(shell("$A a.csv --quiet > whole; cat bad.csv | $A --reorder-s 0.01 --quiet > out"), 0);
  EXPECT_EQ(text("out"), text("whole"));
  EXPECT_EQ(shell("$A bad.csv --reorder-s 0.01 --quiet > out"), 0);
  EXPECT_EQ(text("out"), text("whole"));
  EXPECT_EQ(shell("$A bad.csv --quiet > out 2> err"), 2);
}

TEST_F(Stream, ClockThatBeginsAnewIsAGapAndTheEstimateGoesOn) {
  std::string twice = with({});
  for (std::size_t k = 1; k < record_.size(); ++k) twice += record_[k] + "\n";
  put("twice.csv", twice);
  EXPECT_EQ(shell("cat twice.csv | $A --json s.json > out 2> err"), 0) << text("err");
  EXPECT_EQ(summary()["samples"], 6000);
  EXPECT_EQ(summary()["gaps"], 1);
  EXPECT_EQ(summary()["input"]["new_clocks"], 1);
  EXPECT_EQ(summary()["input"]["astray"], 0);
}

/// What writes it may have failed before the stream asks, or after.
TEST_F(Stream, LastCheckpointThatFailsIsAlwaysStatusOne) {
  constexpr int kTimes = 12;
  for (int time = 0; time < kTimes; ++time)
    EXPECT_EQ(shell("$A a.csv --quiet --checkpoint /dev/full > out 2> err"), 1) << time;
  EXPECT_EQ(text("err"), "armukf: /dev/full: cannot write: No space left on device\n");
}

TEST_F(Stream, AllResultsComeOutAlsoIfTheOutputFails) {
  EXPECT_EQ(shell("$A a.csv --json s.json --save m.toml > /dev/full 2> err"), 1);
  EXPECT_GT(summary()["samples"], 50);
  EXPECT_TRUE(exists("m.toml"));
  EXPECT_EQ(shell("$A a.csv --json closed.json --save closed.toml 2> err | head -n 1 > out"), 0);
  EXPECT_GT(summary("closed.json")["samples"], 50);
  EXPECT_TRUE(exists("closed.toml"));
  EXPECT_EQ(shell("$A a.csv --json no_error.json 2>&- > out"), 0);
  EXPECT_EQ(summary("no_error.json")["samples"], 3000);
}

TEST_F(Stream, AllResultsComeOutOnASignal) {
  for (const char* signal : {"TERM", "INT"}) {
    EXPECT_EQ(shell("rm -f in out; mkfifo in; (cat a.csv; exec sleep 600) > in & feeder=$!\n"
                    "$A --json s.json --save m.toml < in > out 2> err & program=$!\n"
                    "until [ -e out ] && [ $(wc -l < out) -eq 3001 ]; do sleep 0.1; done\n"
                    "kill -" +
                    std::string(signal) +
                    " $program; wait $program; status=$?\n"
                    "kill $feeder; exit $status"),
              0);
    EXPECT_EQ(summary()["samples"], 3000);
    EXPECT_EQ(lines_of(text("out")).size(), 3001U);
    EXPECT_TRUE(exists("m.toml"));
    std::filesystem::remove(folder_ / "s.json");
    std::filesystem::remove(folder_ / "m.toml");
  }
}

/// Someone reads nothing of what comes out; `then` is done to the program a second later. Its
/// status, or what it is still doing three seconds after.
std::string while_stalled(const std::string& then) {
  return "mkfifo pipe; sleep 30 < pipe & reader=$!\n"
         "($A a.csv --json s.json --save m.toml > pipe 2> err & echo $! > pid; wait $!; echo $? > "
         "status) &\n"
         "sleep 1.5; " +
         then +
         "\nfor i in $(seq 50); do [ -s status ] && break; sleep 0.1; done\n"
         "[ -s status ] || { echo still there > status; kill -9 $(cat pid); }\n"
         "kill $reader; wait 2> /dev/null; rm pipe";
}

TEST_F(Stream, StalledReaderDoesNotKeepItFromEndingOnASignal) {
  shell(while_stalled("kill -TERM $(cat pid)"));
  EXPECT_EQ(text("status"), "1\n");  // rows are lost
  EXPECT_NE(lines_of(text("err")).back().find("<stdout>: cannot write"), std::string::npos);
  EXPECT_GT(summary()["samples"], 50);
  EXPECT_TRUE(exists("m.toml"));
}

TEST_F(Stream, SecondSignalEndsItAtOnce) {
  shell(while_stalled(
      "kill -TERM $(cat pid); kill -INT $(cat pid); sleep 0.2; kill -TERM $(cat pid)"));
  EXPECT_TRUE(text("status") == "143\n" || text("status") == "130\n") << text("status");
  EXPECT_FALSE(exists("s.json"));
}

TEST_F(Stream, ResumedEstimateGoesOnBitByBitWhateverIsGivenAgain) {
  ASSERT_EQ(shell("$A a.csv --quiet > whole; head -n 1502 a.csv | $A --checkpoint c --quiet > one"),
            0);
  const std::vector<std::string> whole = lines_of(text("whole"));
  const std::size_t before = lines_of(text("one")).size();
  for (const char* again :
       {"$A a.csv", "cat a.csv | $A", "(grep -m 1 t,u,y a.csv; tail -n 1700 a.csv) | $A"}) {
    ASSERT_EQ(shell(std::string(again) + " --resume c --checkpoint d --quiet > two 2> err"), 0)
        << text("err");
    std::vector<std::string> pieces = lines_of(text("one"));
    const std::vector<std::string> two = lines_of(text("two"));
    pieces.insert(pieces.end(), two.begin() + 1, two.end());
    EXPECT_EQ(pieces.size(), whole.size());
    EXPECT_EQ(pieces, whole) << again;
  }
  EXPECT_LT(before, whole.size());
  // All has been estimated: nothing is left to do, and the summary is still there.
  ASSERT_EQ(shell("$A a.csv --resume d --json s.json > three 2> err"), 0) << text("err");
  EXPECT_EQ(summary()["samples"], 3000);
  EXPECT_EQ(text("three"), "");
}

TEST_F(Stream, CheckpointIsRefusedWithAReason) {
  ASSERT_EQ(shell("$A a.csv --checkpoint c --quiet > out"), 0);
  expect_refused("a.csv --resume nowhere", "nowhere: cannot open the checkpoint");
  expect_refused("a.csv --resume a.csv", "a.csv: is no checkpoint of armukf");
  expect_refused("a.csv --resume c --filter ekf",
                 "c: is of another model or filter: 'filter ukf' there, 'filter ekf' here");
  const std::string whole = text("c");
  put("c", whole.substr(0, whole.size() - 5));
  expect_refused("a.csv --resume c",
                 fmt::format("c: is cut short: {} bytes of {}", whole.size() - 5, whole.size()));
  std::string wrong = whole;
  wrong[whole.size() / 2] ^= 1;
  put("c", wrong);
  expect_refused("a.csv --resume c", "c: is damaged: its checksum is wrong");
  std::string newer = whole;
  newer[8] = static_cast<char>(kTrackSeal.version + 1);
  put("c", newer);
  expect_refused("a.csv --resume c",
                 fmt::format("c: is of version {}; this program knows version {}",
                             kTrackSeal.version + 1, kTrackSeal.version));
  expect_refused("a.csv --checkpoint -", "--checkpoint: needs a FILE to replace");
  expect_refused("a.csv --passes 2 --checkpoint c",
                 "--checkpoint, --resume: neither with --passes nor with --score");
}

TEST_F(Stream, CheckpointThatCannotBeWrittenLeavesTheLastGoodOne) {
  ASSERT_EQ(shell("head -n 1000 a.csv | $A --checkpoint c --quiet > one"), 0);
  const std::string good = text("c");
  // No file may grow beyond one block: the disk is full.
  EXPECT_EQ(shell("cat a.csv | (trap '' XFSZ; ulimit -f 4; exec $A --resume c --checkpoint c "
                  "--every-s 0.001 2> >(cat > err)) | cat > two"),
            0);
  EXPECT_EQ(text("c"), good);
  EXPECT_NE(text("err").find("c: cannot write: File too large"), std::string::npos) << text("err");
  EXPECT_EQ(lines_of(text("one")).size() + lines_of(text("two")).size(), 3000 + 2U);
}

TEST_F(Stream, FollowedFileGoesOnAcrossRotation) {
  EXPECT_EQ(shell("head -n 1000 a.csv > live.csv\n"
                  "$A live.csv --follow --json s.json > out 2> err & pid=$!\n"
                  "sleep 0.5; sed -n 1001,1500p a.csv >> live.csv; sleep 0.3; mv live.csv old.csv\n"
                  "sed -n 1501,1600p a.csv >> old.csv\n"
                  "(grep -m 1 t,u,y a.csv; tail -n +1601 a.csv) > new; mv new live.csv\n"
                  "for i in $(seq 100); do [ $(wc -l < out) -ge 3001 ] && break; sleep 0.1; done\n"
                  "kill -TERM $pid; wait $pid"),
            0)
      << text("err");
  EXPECT_EQ(summary()["samples"], 3000);
  EXPECT_EQ(shell("$A a.csv --quiet > whole; cmp whole out"), 0);
}

}  // namespace
}  // namespace armukf
