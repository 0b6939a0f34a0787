#include "arms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "armukf/core/archive.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/sealed.hpp"
#include "armukf/io/atomic_file.hpp"
#include "armukf/io/csv_writer.hpp"
#include "armukf/online/track.hpp"
#include "armukf/report/estimate_report.hpp"
#include "armukf/report/event_report.hpp"
#include "checkpoints.hpp"
#include "complaints.hpp"
#include "first_failure.hpp"
#include "option_values.hpp"
#include "rows.hpp"
#include "signals.hpp"

namespace armukf::apps {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kBatch = 8192;  // rows; some milliseconds of work for one core
constexpr std::size_t kFew = 256;     // rows that are not worth a thread
constexpr Seal kSeal{"armukf_a", 1};
constexpr std::string_view kModelEnding = ".toml";

/// The models that arms begin with.
class Models {
 public:
  explicit Models(const ArmsJob& job) : other_(read(job, job.model.file)) {
    if (job.arms.models.empty()) return;
    std::error_code failure;
    for (const auto& entry : fs::directory_iterator(job.arms.models, failure))
      if (entry.path().extension() == kModelEnding)
        own_.emplace(entry.path().stem().string(), read(job, entry.path().string()));
    if (failure) throw InputError(job.arms.models, 0, "", failure.message());
  }

  const ModelFile& of(const std::string& arm) const {
    const auto found = own_.find(arm);
    return found == own_.end() ? other_ : found->second;
  }

  /// Names of states and unknowns of all models, each once.
  std::vector<std::string> columns() const {
    std::vector<std::string> all = augmented_names(other_.model);
    for (const auto& [name, own] : own_)
      for (const std::string& column : augmented_names(own.model))
        if (std::ranges::find(all, column) == all.end()) all.push_back(column);
    return all;
  }

 private:
  static ModelFile read(const ArmsJob& job, const std::string& file) {
    ModelOptions options = job.model;
    options.file = file;
    ModelFile model = chosen_model(options);
    choose_filter(model.settings, job.filter);
    forget(model, job.forget);
    return model;
  }

  ModelFile other_;
  std::map<std::string, ModelFile> own_;
};

/// One of the arms.
class Arm {
 public:
  Arm(std::string name, const ModelFile& start, Arrival arrival,
      const std::vector<std::string>& columns, bool watched)
      : name_(std::move(name)), start_(&start), track_(start.model, start.settings, arrival) {
    if (watched) track_.watch(start.model, start.settings);
    const std::vector<std::string> own = augmented_names(start.model);
    for (const std::string& column : columns) {
      const auto found = std::ranges::find(own, column);
      places_.push_back(found == own.end() ? kNowhere : found - own.begin());
    }
  }

  const std::string& name() const { return name_; }
  Track& track() { return track_; }
  const Track& track() const { return track_; }
  const ModelFile& start() const { return *start_; }

  /// Of the batch that is read, while that before is worked on.
  std::vector<Sample>& inbox() { return inboxes_[filled_]; }
  bool has_rows() const { return !inboxes_[filled_].empty(); }
  /// What is read now is the next batch.
  void turn() { filled_ ^= 1; }

  /// Works on the batch before that which is read, on whatever thread.
  void work() {
    for (const Sample& sample : inboxes_[filled_ ^ 1]) {
      track_.put(sample);
      write_due();
    }
    inboxes_[filled_ ^ 1].clear();
    rows_.append_to(text_);
  }

  void end() {
    track_.end();
    write_due();
    rows_.append_to(text_);
  }

  /// What has come of the work so far is to be written, while the work may go on. Nothing of the
  /// time before must be left of it.
  void conclude() {
    rows_done_.swap(text_);
    events_done_.swap(events_);
  }

  /// That, for whoever writes it to empty.
  std::string& rows() { return rows_done_; }
  std::string& events() { return events_done_; }

  Clock::time_point seen;
  std::list<Arm*>::iterator place;  // among those seen lately

 private:
  static constexpr std::ptrdiff_t kNowhere = -1;

  void write_due() {
    while (const auto e = track_.next()) {
      rows_.cell(name_);
      write_outcome(rows_, *e);
      write(e->values);
      write(e->deviations);
      if (track_.watch() != nullptr) rows_.cell(event_cell(track_.events()));
      rows_.end_row();
      for (const Event& event : track_.events()) events_ += event_line(event, name_);
    }
  }

  void write(std::span<const double> values) {
    for (const std::ptrdiff_t at : places_) {
      if (at == kNowhere) {
        rows_.cell(std::string_view());
      } else {
        rows_.cell(values[static_cast<std::size_t>(at)]);
      }
    }
  }

  std::string name_;
  const ModelFile* start_;
  Track track_;
  std::vector<std::ptrdiff_t> places_;  // of the columns among the arm's own
  std::array<std::vector<Sample>, 2> inboxes_;
  std::size_t filled_ = 0;
  CsvRows rows_;
  std::string text_;  // of those
  std::string events_;
  std::string rows_done_;
  std::string events_done_;
};

struct NameHash {
  using is_transparent = void;  // NOLINT(readability-identifier-naming): the standard's name
  std::size_t operator()(std::string_view name) const {
    return std::hash<std::string_view>()(name);
  }
};

/// The stream of all arms at work: while one batch is worked on by all threads, the rows of the one
/// before are written and the next is read.
class Arms {
 public:
  explicit Arms(const ArmsJob& job)
      : job_(job),
        models_(job),
        columns_(models_.columns()),
        complaints_(job.report.quiet),
        rows_(job.input, job.columns, job.stream, complaints_),
        checkpoints_(job.stream.checkpoint, job.stream.every_s, complaints_),
        events_(job.watch.events, !job.stream.resume.empty()) {
    if (job.report.json != "-" && job.watch.events != "-") output_.emplace("-", stop_flag());
    std::error_code error;
    if (!job.save.empty()) fs::create_directories(job.save, error);
    if (error) throw InputError(job.save, 0, "", "cannot make the folder: " + error.message());
    if (!job.stream.resume.empty())
      resume_from(job.stream.resume, [this](const std::string& bytes) { load(bytes); });
  }

  /// All there is, with all results, also where something fails.
  void result() {
    FirstFailure failure;
    failure.of([&] { take_rows(); });
    failure.of([&] { finish(); });
    const std::chrono::duration<double> taken = Clock::now() - begin_;
    if (samples() == 0) return failure.rethrow();
    for (const auto& named : arms_) failure.of([&] { save(*named.second); });
    failure.of([&] { write_json(job_.report, json(taken.count())); });
    if (!job_.report.quiet) say(text(taken.count()));
    failure.rethrow();
  }

 private:
  void take_rows() {
    while (const auto sample = rows_.next()) {
      events_.begin();
      Arm& arm = seen(rows_.reader().key());
      if (!arm.has_rows()) reading_.push_back(&arm);
      arm.inbox().push_back(*sample);
      ++read_;
      const bool idle = rows_.reader().would_wait();
      if (idle || read_ >= kBatch) hand_over(idle);
      if (checkpoints_.due(idle)) put_checkpoint();
      if (is_stopped() || (output_ && output_->closed())) return;
    }
  }

  /// The arm of that name, made where it is new; the one not seen for longest makes room.
  Arm& seen(std::string_view name) {
    auto found = arms_.find(name);
    if (found == arms_.end()) {
      if (arms_.size() >= static_cast<std::size_t>(job_.arms.most)) make_room(name);
      found = arms_.emplace(std::string(name), made(std::string(name))).first;
      Arm& arm = *found->second;
      arm.place = order_.insert(order_.end(), &arm);
      if (job_.stream.new_clock) arm.track().expect_new_clock();
    }
    Arm& arm = *found->second;
    order_.splice(order_.end(), order_, arm.place);
    arm.seen = now_;
    return arm;
  }

  /// Ends the arm not seen for longest. One that comes back had to go while it was still there.
  void make_room(std::string_view for_whom) {
    constexpr std::size_t kMost = 10'000;  // names, whatever comes
    if (ended_for_others_.contains(for_whom) && !std::exchange(is_crowded_, true))
      complaints_.say(
          fmt::format("more arms at a time than --max-arms {}: what is learnt of one is lost where "
                      "another comes",
                      job_.arms.most));
    Arm& oldest = *order_.front();
    if (ended_for_others_.size() < kMost) ended_for_others_.insert(oldest.name());
    retire(oldest);
  }

  std::unique_ptr<Arm> made(const std::string& name) const {
    return std::make_unique<Arm>(name, models_.of(name), rows_.arrival(), columns_,
                                 job_.watch.watch);
  }

  /// Has the batch that was read worked on, and writes what came of the one before. at_once:
  /// nothing is to be read meanwhile, and all is written.
  void hand_over(bool at_once) {
    wait();
    working_.swap(reading_);
    for (Arm* arm : working_) arm->turn();
    const auto work = [this](int threads) {
      for_each_job(threads, static_cast<int>(working_.size()),
                   [this](int i) { working_[static_cast<std::size_t>(i)]->work(); });
    };
    if (at_once || read_ < kFew) {
      write_rows();
      work(read_ < kFew ? 1 : job_.arms.threads);
      conclude();
    } else {
      worker_ = std::jthread(work, job_.arms.threads);
    }
    write_rows();
    read_ = 0;
    now_ = Clock::now();
    retire_old();
  }

  /// Waits for the batch that is worked on.
  void wait() {
    if (!worker_.joinable()) return;
    worker_.join();
    conclude();
  }

  void conclude() {
    for (Arm* arm : working_) arm->conclude();
    done_.swap(working_);
  }

  void write_rows() {
    for (Arm* arm : done_) write(*arm);
    done_.clear();
    if (output_) output_->flush();
  }

  void write(Arm& arm) {
    if (output_ && !arm.rows().empty()) {
      if (!std::exchange(headed_, true)) write_head();
      output_->append_rows(arm.rows());
    }
    arm.rows().clear();
    events_.put(arm.events());
    arm.events().clear();
  }

  void write_head() {
    std::vector<std::string> names = row_names(columns_, job_.watch.watch);
    names.insert(names.begin(), job_.arms.key);
    output_->row(names);
  }

  void retire_old() {
    const std::chrono::duration<double> longest(job_.arms.forget_after_s);
    while (!order_.empty() && now_ - order_.front()->seen > longest) retire(*order_.front());
  }

  /// Ends an arm of which nothing was heard for long.
  void retire(Arm& arm) {
    wait();
    write_rows();
    if (arm.has_rows()) {
      arm.turn();
      arm.work();
      std::erase(reading_, &arm);
    }
    arm.end();
    arm.conclude();
    write(arm);
    save(arm);
    if (!job_.report.quiet && !is_crowded_)
      complaints_.say(fmt::format("retired {}", line_of(arm)));
    retired_samples_ += arm.track().tally().samples();
    ++retired_;
    order_.erase(arm.place);
    arms_.erase(arms_.find(arm.name()));
  }

  void finish() {
    hand_over(true);
    if (!is_stopped() || !checkpoints_.wanted()) {
      for (const auto& [name, arm] : arms_) {
        arm->end();
        arm->conclude();
        write(*arm);
      }
    }
    if (output_) output_->flush();
    if (output_ && output_->closed()) return;
    if (checkpoints_.wanted()) put_checkpoint();
    checkpoints_.finish();
  }

  /// Format: a seal (magic `armukf_a`), the number of arms, and of each its name and its track.
  void put_checkpoint() {
    hand_over(true);
    if (output_ && output_->closed()) return;
    OutArchive archive;
    std::uint64_t count = arms_.size();
    archive(count);
    for (const Arm* arm : order_) {
      std::string name = arm->name();
      std::string track = arm->track().save();
      archive(name, track);
    }
    checkpoints_.put(sealed(kSeal, archive.bytes()));
  }

  void load(const std::string& bytes) {
    InArchive archive(unsealed(kSeal, bytes));
    std::uint64_t count = 0;
    archive(count);
    for (std::uint64_t i = 0; i < count; ++i) {
      std::string name;
      std::string track;
      archive(name, track);
      of_option(name, [&] { seen(name).track().load(track); });
      if (job_.stream.new_clock) seen(name).track().expect_new_clock();
    }
  }

  void save(const Arm& arm) {
    if (job_.save.empty() || arm.track().tally().samples() == 0) return;
    const fs::path file = fs::path(job_.save) / (arm.name() + std::string(kModelEnding));
    // What has not even decided between its starts takes the place of nothing.
    if (!arm.track().session().decided() && fs::exists(file)) return;
    const RecursiveEstimate estimate = result_of(arm);
    write_model_file(file.string(), to_go_on_from(estimate, arm.start().settings));
    if (const std::string note = unsaved_text(estimate); !note.empty())
      complaints_.say(fmt::format("{}: {}", arm.name(), note));
  }

  static RecursiveEstimate result_of(const Arm& arm, double seconds = 0.0) {
    return armukf::result_of(arm.track().session(), arm.start().settings.filter,
                             arm.track().tally(), seconds);
  }

  std::size_t samples() const {
    std::size_t sum = retired_samples_;
    for (const auto& [name, arm] : arms_) sum += arm->track().tally().samples();
    return sum;
  }

  nlohmann::ordered_json json(double seconds) {
    nlohmann::ordered_json json{{"samples", samples()},
                                {"faulty", rows_.take_faulty()},
                                {"retired", retired_},
                                {"seconds", seconds},
                                {"samples_per_second", static_cast<double>(samples()) / seconds},
                                {"arms", nlohmann::ordered_json::object()}};
    for (const Arm* arm : sorted()) {
      const RecursiveEstimate estimate = result_of(*arm, seconds);
      nlohmann::ordered_json one =
          estimate_json({estimate,
                         {},
                         arm->track().counts(),
                         summary_of(arm->track().watch(), arm->start().model, estimate)});
      for (const char* of_all : {"simulation", "seconds", "samples_per_second"}) one.erase(of_all);
      json["arms"][arm->name()] = std::move(one);
    }
    return json;
  }

  std::vector<const Arm*> sorted() const {
    std::vector<const Arm*> all;
    for (const auto& [name, arm] : arms_) all.push_back(arm.get());
    std::ranges::sort(all, {}, [](const Arm* arm) { return arm->name(); });
    return all;
  }

  static std::string line_of(const Arm& arm) {
    const Tally& tally = arm.track().tally();
    return fmt::format("{}: {}, one step ahead {}", arm.name(), counts_text(tally),
                       fit_text(tally.innovations().fit_percent()));
  }

  std::string text(double seconds) const {
    std::string text;
    for (const Arm* arm : sorted()) text += line_of(*arm) + "\n";
    return text + fmt::format("{} arms, {} retired; {} samples, {:.3f} s, {:.0f} samples/s\n",
                              arms_.size(), retired_, samples(), seconds,
                              static_cast<double>(samples()) / seconds);
  }

  const ArmsJob& job_;
  Models models_;
  std::vector<std::string> columns_;
  Complaints complaints_;
  Rows rows_;
  Checkpoints checkpoints_;
  EventLog events_;
  std::optional<CsvWriter> output_;
  Clock::time_point begin_ = Clock::now();
  Clock::time_point now_ = begin_;
  std::unordered_map<std::string, std::unique_ptr<Arm>, NameHash, std::equal_to<>> arms_;
  std::list<Arm*> order_;      // the one not seen for longest first
  std::vector<Arm*> reading_;  // that have rows in the batch that is read,
  std::vector<Arm*> working_;  // in that which is worked on,
  std::vector<Arm*> done_;     // and in that whose rows are to be written
  std::size_t read_ = 0;       // rows of the batch
  std::size_t retired_ = 0;
  std::size_t retired_samples_ = 0;
  bool headed_ = false;
  std::unordered_set<std::string, NameHash, std::equal_to<>> ended_for_others_;
  bool is_crowded_ = false;  // more arms at a time than there may be
  std::jthread worker_;      // last: it uses all of the above
};

}  // namespace

void add_arms_options(CLI::App& command, ArmsOptions& options) {
  CLI::Option* key =
      command
          .add_option("--key", options.key,
                      "many arms in one stream: the column that names the arm; the files of --save "
                      "and --models are in a folder, NAME.toml")
          ->type_name("COLUMN");
  command.add_option("--models", options.models, "with --key: model files of some arms")
      ->type_name("FOLDER")
      ->needs(key);
  command
      .add_option("--max-arms", options.most,
                  "with --key: beyond so many the arm not seen for longest is ended, 1000 by "
                  "default")
      ->check(whole_number(1, 1'000'000))
      ->needs(key);
  command
      .add_option("--forget-after-s", options.forget_after_s,
                  "with --key: an arm not seen for so long is ended, 3600 by default")
      ->check(number_above(0.0))
      ->needs(key);
  add_threads_option(command, options.threads);
}

void estimate_arms(const ArmsJob& job) { Arms(job).result(); }

}  // namespace armukf::apps
