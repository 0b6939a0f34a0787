// Someone else's program: it includes the one public header, links the installed library, streams
// the record that it is given through a Session, and prints the estimate.

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "armukf/armukf.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return EXIT_FAILURE;
  const armukf::Record record = armukf::read_record(argv[1]);
  armukf::Session session(armukf::published_arm(), {});
  for (const armukf::Sample& sample : record.samples) session.step(sample);
  const armukf::Model model = session.model();
  const std::vector<double> sd = session.parameter_deviations();
  std::cout << "library " << armukf::library_version() << " built for " << armukf::build_processor()
            << '\n';
  bool sound = !record.samples.empty();
  for (const int i : model.unknowns()) {
    const armukf::Parameter& p = model.parameters[i];
    std::cout << p.name << ' ' << p.value << " +- " << sd[i] << ' ' << p.unit << '\n';
    sound = sound && std::isfinite(p.value) && sd[i] > 0.0;
  }
  // The truth of data/short_record.csv, one second of the published estimate's arm.
  const double share = model.parameter("a_m").value;
  return sound && std::abs(share - 0.266479) < 3.0 * sd[model.index_of("a_m")] ? EXIT_SUCCESS
                                                                               : EXIT_FAILURE;
}
