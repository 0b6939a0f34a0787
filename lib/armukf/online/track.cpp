#include "armukf/online/track.hpp"

#include <algorithm>

#include "armukf/core/archive.hpp"
#include "armukf/core/error.hpp"
#include "armukf/online/seals.hpp"

namespace armukf {
namespace {

/// What was counted before, and what a sequence has counted since; new clocks are counted where
/// samples are given out, so that a checkpoint tells those it covers.
FateCounts sum(const FateCounts& before, const FateCounts& now, const FateCounts& ignored) {
  return {.late = before.late + now.late - ignored.late,
          .repeated = before.repeated + now.repeated - ignored.repeated,
          .astray = before.astray + now.astray - ignored.astray,
          .new_clocks = before.new_clocks};
}

}  // namespace

Track::Track(const Model& model, const EstimatorSettings& settings, Arrival arrival)
    : session_(model, settings), arrival_(arrival), sequence_(arrival) {}

std::optional<Estimate> Track::next() {
  for (;;) {
    const auto timed = sequence_.next();
    if (!timed) return std::nullopt;
    if (covered_ && is_covered(*timed)) continue;
    if (timed->new_clock) {
      session_.expect_new_clock();
      ++before_.fates.new_clocks;
    }
    if (tally_.samples() == 0) first_t_ = timed->sample.t;
    last_t_ = timed->sample.t;
    const Estimate estimate = session_.step(timed->sample);
    tally_.add(estimate);
    if (watch_) events_ = watch_->see(session_, timed->sample, estimate);
    if (std::ranges::any_of(events_, &Event::is_named)) tally_.begin_anew();
    return estimate;
  }
}

void Track::watch(const Model& model, const EstimatorSettings& settings,
                  const WatchSettings& watch) {
  watch_.emplace(model, settings, watch);
}

/// Whether the checkpoint holds the sample; if not, it holds none after it.
bool Track::is_covered(const Sequence::Timed& timed) {
  if (!seen_ && timed.sample.t != first_t_) clocks_ = 0;  // this is not where that stream began
  seen_ = true;
  const bool later_clock = timed.new_clock && clocks_ == 0;
  if (timed.new_clock && !later_clock) --clocks_;
  if (!later_clock && (clocks_ > 0 || timed.sample.t <= last_t_)) return true;
  covered_ = false;
  ignored_ = sequence_.counts();
  return false;
}

void Track::count_faulty_rows(int count) {
  if (!covered_) before_.faulty += count;
}

void Track::expect_new_clock() {
  covered_ = false;
  session_.expect_new_clock();
}

StreamCounts Track::counts() const {
  if (covered_) return before_;
  return {before_.faulty, sum(before_.fates, sequence_.counts(), ignored_)};
}

std::string Track::save() const {
  OutArchive archive;
  std::string session = session_.save();
  Progress progress{tally_, counts(), first_t_, last_t_};
  std::string watch = watch_ ? watch_->save() : "";
  archive(session, progress, watch);
  return sealed(kTrackSeal, archive.bytes());
}

void Track::load(std::string_view bytes) {
  InArchive archive(unsealed(kTrackSeal, bytes));
  std::string session;
  Progress progress;
  std::string watch;
  archive(session, progress, watch);
  if (watch_) {
    Watch loaded = watch_->anew();
    if (!watch.empty()) loaded.load(watch);
    session_.load(session);
    watch_ = std::move(loaded);
  } else if (!watch.empty()) {
    throw InputError("holds what a watch has seen: whoever goes on has to watch as well (--watch)");
  } else {
    session_.load(session);
  }
  events_ = {};
  tally_ = progress.tally;
  before_ = progress.counts;
  first_t_ = progress.first_t;
  last_t_ = progress.last_t;
  sequence_ = Sequence(arrival_);
  ignored_ = {};
  covered_ = tally_.samples() > 0;
  seen_ = false;
  clocks_ = before_.fates.new_clocks;
}

}  // namespace armukf
