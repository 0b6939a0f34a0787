#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "armukf/core/record.hpp"
#include "armukf/core/sequence.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/settings.hpp"
#include "armukf/online/tally.hpp"
#include "armukf/online/watch.hpp"

namespace armukf {

/// What the rows of a stream came to, besides estimates.
struct StreamCounts {
  std::uint64_t faulty = 0;  // rows that could not be read
  FateCounts fates;

  template <class Archive>
  void archive(Archive& archive) {
    archive(faulty, fates);
  }
};

/// The estimate of one arm whose samples come as they come: early, late, twice, by a clock that was
/// set, or again from where a checkpoint was made.
///
///     track.put(sample);
///     while (const auto estimate = track.next()) ...
///
/// After the first samples nothing is allocated.
class Track {
 public:
  Track(const Model& model, const EstimatorSettings& settings, Arrival arrival = {});

  /// What becomes of the sample; one that is passed over since a checkpoint covers it is kTaken.
  Fate put(const Sample& sample) { return sequence_.put(sample); }

  /// What is believed after the next sample that waits for no other; its spans stay valid until the
  /// next call.
  std::optional<Estimate> next();

  /// None will be put any more: nothing waits.
  void end() { sequence_.end(); }

  /// Rows that could not be read.
  void count_faulty_rows(int count);

  /// The samples' clock was set while nobody listened: none of them is old, whatever its time.
  void expect_new_clock();

  /// Looks for changes of the machine from here on (see Watch).
  void watch(const Model& model, const EstimatorSettings& settings,
             const WatchSettings& watch = {});
  /// What the last estimate has shown to have changed; until the next one.
  std::span<const Event> events() const { return events_; }
  /// The watch, if there is one.
  const Watch* watch() const { return watch_ ? &*watch_ : nullptr; }

  const Session& session() const { return session_; }
  const Tally& tally() const { return tally_; }
  StreamCounts counts() const;

  /// Session and counts as bytes: a checkpoint. It covers the samples up to the last estimate;
  /// those that still wait for others do not count.
  ///
  /// Format: a seal (core/sealed.hpp: magic `armukf_t`, version, checksum, length); the session's
  /// bytes (Session::save); the tally; the counts; time of the first and of the last sample; the
  /// watch's bytes (Watch::save), none where nobody watches.
  std::string save() const;

  /// Goes on from there, and gives no estimates of samples that it covers: those whose time is not
  /// later than that of the last one; if the stream begins with the same time as the saved one, and
  /// that one's clock was set meanwhile, all before as well. InputError as of Session::load, the
  /// track then being as it was. Whoever watches what nobody watched before begins to
  /// watch there; where somebody did, nobody may go on without: InputError.
  void load(std::string_view bytes);

 private:
  bool is_covered(const Sequence::Timed& timed);

  /// What a checkpoint holds besides the session.
  struct Progress {
    Tally tally;
    StreamCounts counts;
    double first_t = 0.0;  // s, by the samples' clock
    double last_t = 0.0;

    template <class Archive>
    void archive(Archive& archive) {
      archive(tally, counts, first_t, last_t);
    }
  };

  Session session_;
  std::optional<Watch> watch_;
  std::span<const Event> events_;
  Arrival arrival_;
  Sequence sequence_;
  Tally tally_;
  StreamCounts before_;       // all that counts but is not of sequence_
  FateCounts ignored_;        // of sequence_, of samples that the checkpoint covers
  double first_t_ = 0.0;      // s
  double last_t_ = 0.0;       // s
  bool covered_ = false;      // a checkpoint still may cover what comes
  bool seen_ = false;         // a sample, since the checkpoint was loaded
  std::uint64_t clocks_ = 0;  // that are to be set again until its last one
};

}  // namespace armukf
