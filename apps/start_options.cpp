#include "start_options.hpp"

#include <fmt/format.h>

#include <string_view>

#include "armukf/batch/frequency_start.hpp"
#include "armukf/batch/slow_motion.hpp"
#include "armukf/core/error.hpp"
#include "option_values.hpp"

namespace armukf::apps {
namespace {

/// Of the square of the speed: speeds that rise and fall over seconds have a thousandth, noise
/// included, the fast ones by which springs are told a twentieth and more.
constexpr double kMostFast = 0.01;

constexpr std::string_view kSlow = "slow=";
constexpr std::string_view kFrequency = "frequency";

void choose_start(std::string_view word, StartOptions& options) {
  if (word == kFrequency) {
    options.frequency = true;
  } else if (word.starts_with(kSlow) && word.size() > kSlow.size()) {
    options.slow_file = word.substr(kSlow.size());
  } else if (word == "slow" || word == kSlow) {
    throw InputError("--start: slow needs a record of slow motion: --start slow FILE");
  } else {
    throw InputError(fmt::format("--start: '{}' is neither 'slow FILE' nor 'frequency'", word));
  }
}

std::string changes(const Model& before, const Model& after) {
  std::string text;
  for (std::size_t i = 0; i < after.parameters.size(); ++i) {
    const Parameter& p = after.parameters[i];
    if (p.value != before.parameters[i].value)
      text += fmt::format("  {:<20} {:>12.6g} {}\n", p.name, p.value, p.unit);
  }
  return text;
}

void keep_given(const std::vector<std::string>& assignments, const Model& before, Model& after) {
  for (const std::string& assignment : assignments) {
    const std::string name = assignment.substr(0, assignment.find('='));
    after.parameter(name).value = before.parameter(name).value;
  }
}

}  // namespace

void add_start_options(CLI::App& command, StartOptions& options) {
  command
      .add_option_function<std::vector<std::string>>(
          "--start",
          [&options](const std::vector<std::string>& words) {
            for (const std::string& word : words) choose_start(word, options);
          },
          "find start values: 'slow SLOW.csv', friction and inertia J from a record of slow\n"
          "motion; 'frequency', masses and springs from FILE's frequency response; repeatable")
      ->allow_extra_args(false)
      ->type_name("slow FILE|frequency");
}

std::vector<std::string> with_joined_starts(const std::vector<std::string>& words) {
  std::vector<std::string> joined;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool slow = words[i] == "slow" && i > 0 && words[i - 1] == "--start";
    if ((slow || words[i] == "--start=slow") && i + 1 < words.size()) {
      joined.push_back(fmt::format("{}={}", words[i], words[i + 1]));
      ++i;
    } else {
      joined.push_back(words[i]);
    }
  }
  return joined;
}

std::string find_start(const StartOptions& options, const ModelOptions& model_options,
                       const Record& record, const Columns& columns, ModelFile& start) {
  const Model before = start.model;
  std::string text;
  if (!options.slow_file.empty()) {
    const Record slow = read_record(options.slow_file, columns);
    start.model = from_slow_motion(start.model, slow, start.settings.propagation);
    keep_given(model_options.values, before, start.model);
    text += fmt::format("start values from slow motion, {}\n{}", slow.name,
                        changes(before, start.model));
    if (const double fast = share_of_fast_motion(slow); fast > kMostFast)
      text += fmt::format(
          "note: {:.2g} % of the motion of {} is faster than a quarter of a second: friction and "
          "J\n"
          "      from it are a guess\n",
          100.0 * fast, slow.name);
  }
  if (options.frequency) {
    const Model slow = start.model;
    start.model = from_frequency_response(start.model, record, start.settings.propagation);
    keep_given(model_options.values, before, start.model);
    text += fmt::format("start values from the frequency response of {}\n{}", record.name,
                        changes(slow, start.model));
  }
  of_option("--start", [&] { start.model.check(); });
  return text;
}

}  // namespace armukf::apps
