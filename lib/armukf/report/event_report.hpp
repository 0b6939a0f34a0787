#pragma once

#include <span>
#include <string>
#include <string_view>

#include "armukf/online/watch.hpp"

namespace armukf {

/// A unit behind a number, with the blank before it; nothing where there is none ("-").
std::string unit_text(std::string_view unit);

/// An event as a line of JSON, with the line's end; `arm` tells whose it is where there are many.
std::string event_line(const Event& event, std::string_view arm = {});

/// What the events of a sample are of, for its row: names, with a semicolon between them; empty
/// where there are none.
std::string event_cell(std::span<const Event> events);

/// An event for a person.
std::string event_text(const Event& event);

}  // namespace armukf
