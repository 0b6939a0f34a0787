#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "armukf/core/error.hpp"
#include "armukf/io/atomic_file.hpp"
#include "armukf/report/source_text.hpp"
#include "commands.hpp"
#include "model_options.hpp"
#include "option_values.hpp"

namespace armukf::apps {
namespace {

struct ExportOptions {
  std::string language;
  std::string folder;
  std::string name = "arm";
  ModelOptions model;
};

void write_sources(const ExportOptions& o) {
  const ModelFile chosen = chosen_model(o.model);
  const Language language = of_option("--to", [&] { return find_language(o.language); });
  const auto files = of_option("--name", [&] {
    return source_files(chosen.model, o.name, language, chosen.settings.propagation);
  });
  std::error_code error;
  std::filesystem::create_directories(o.folder, error);
  if (error) throw InputError(fmt::format("{}: {}", o.folder, error.message()));
  for (const SourceFile& source : files) {
    AtomicFile file((std::filesystem::path(o.folder) / source.name).string());
    file.write(source.text);
    file.commit();
  }
}

}  // namespace

void add_export(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "export", "The model's equations and parameters as source in C or for MATLAB");
  command.footer(
      "For a controller, C99: NAME.h and NAME.c hold the derivative of the states, what the "
      "sensor\n"
      "shows, and a Runge-Kutta step. For MATLAB and Octave: NAME.m, as idnlgrey calls it, and\n"
      "NAME_parameters.m, which makes the idnlgrey model; what is known is fixed there.");
  const auto o = std::make_shared<ExportOptions>();
  command.add_option("--to", o->language, "one of c, matlab")->required();
  command.add_option("-o,--output", o->folder, "folder to write to; made if there is none")
      ->required()
      ->type_name("FOLDER");
  command.add_option("--name", o->name, "what the model is called there")->capture_default_str();
  add_model_options(command, o->model);
  command.callback([o] { write_sources(*o); });
}

}  // namespace armukf::apps
