#include "rows.hpp"

#include <fmt/format.h>

#include <utility>

#include "signals.hpp"

namespace armukf::apps {
namespace {

OnError on_error(const StreamOptions& options, bool live) {
  if (options.on_error.empty()) return live ? OnError::kSkip : OnError::kStop;
  if (options.on_error == "stop") return OnError::kStop;
  return options.on_error == "skip" ? OnError::kSkip : OnError::kMissing;
}

std::string_view text_of(Fate fate) {
  switch (fate) {
    case Fate::kLate:
      return "time goes back";
    case Fate::kRepeated:
      return "time repeats";
    default:
      return "time is far from those before";
  }
}

/// Who wants to stop at faults, and to have nothing put in order, is told of times that do not
/// rise; not if many arms share the stream.
bool wants_order(const StreamOptions& options, const Columns& columns, bool live) {
  return on_error(options, live) == OnError::kStop && options.reorder_s == 0.0 &&
         columns.key.empty();
}

}  // namespace

Rows::Rows(const std::string& input, const Columns& columns, const StreamOptions& options,
           Complaints& complaints)
    : Rows(ByteSource(input, stop_flag(), options.follow ? FileEnd::kFollowed : FileEnd::kEnds),
           columns, options, complaints) {}

Rows::Rows(ByteSource source, const Columns& columns, const StreamOptions& options,
           Complaints& complaints)
    : on_error_(on_error(options, source.live())),
      arrival_{options.reorder_s, wants_order(options, columns, source.live())},
      reader_(std::move(source), columns, arrival_.in_order ? TimeOrder::kRising : TimeOrder::kAny),
      complaints_(complaints) {}

std::optional<Sample> Rows::next() {
  for (;;) {
    try {
      return reader_.next();
    } catch (const LineError& error) {
      if (on_error_ == OnError::kStop) throw;
      ++faulty_;
      complaints_.say(error.what());
    }
    if (on_error_ != OnError::kMissing) continue;
    if (const auto sample = reader_.salvaged()) return sample;
  }
}

int Rows::take_faulty() { return std::exchange(faulty_, 0); }

void Rows::tell(Fate fate) {
  if (fate == Fate::kTaken) return;
  complaints_.say(fmt::format("{}:{}: {}", reader_.name(), reader_.line_number(), text_of(fate)));
}

}  // namespace armukf::apps
