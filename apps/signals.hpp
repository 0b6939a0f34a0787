#pragma once

#include "armukf/io/byte_source.hpp"

namespace armukf::apps {

/// From now on SIGINT and SIGTERM set stop_flag(), and interrupt what waits, again every second;
/// the second of them ends the program at once.
void stop_on_signals();

StopFlag stop_flag();

/// Whether such a signal came.
bool is_stopped();

}  // namespace armukf::apps
