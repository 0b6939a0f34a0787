#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "armukf/io/csv_reader.hpp"
#include "armukf/report/model_file.hpp"
#include "model_options.hpp"
#include "report_options.hpp"
#include "stream_options.hpp"
#include "watch_options.hpp"

namespace armukf::apps {

/// Estimates of many arms whose rows come in one stream.
struct ArmsOptions {
  std::string key;     // column that names the arm; empty: there is one arm
  std::string models;  // folder of model files, NAME.toml; empty: all arms are alike
  int most = 1000;     // arms at a time
  double forget_after_s = 3600.0;
  int threads = 0;
};

void add_arms_options(CLI::App& command, ArmsOptions& options);

/// What an estimate of many arms shares with that of one.
struct ArmsJob {
  std::string input;
  std::string filter;
  double forget = 1.0;
  std::string save;  // folder; empty: none
  ArmsOptions arms;
  ModelOptions model;
  ReportOptions report;
  Columns columns;
  StreamOptions stream;
  WatchOptions watch;
};

/// Rows of all arms to standard output, the arm's name first; a column that an arm lacks is empty.
void estimate_arms(const ArmsJob& job);

}  // namespace armukf::apps
