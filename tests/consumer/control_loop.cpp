// A joint's control loop with the estimate in it. The record that it is given stands for the robot.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <vector>

#include "armukf/armukf.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return EXIT_FAILURE;
  const armukf::Record robot = armukf::read_record(argv[1]);

  // Before the loop: the model and its settings, here the built-in ones, else
  // read_model_file(path).
  armukf::ModelFile arm;
  arm.model.parameter("J").value = 0.0329;  // kg.m^2, from the data sheet
  arm.settings.noise.sensor = 0.05;         // rad/s
  armukf::Session session(arm.model, arm.settings);
  armukf::Watch watch(arm.model, arm.settings);
  const std::vector<int> unknowns = arm.model.unknowns();
  const auto gear = std::ranges::find(unknowns, arm.model.index_of("k_g1")) - unknowns.begin();
  const auto k_g1 = static_cast<std::size_t>(arm.model.states.size() + gear);  // where it stands

  // The loop: after the first step nothing is allocated, apart from events.
  double arm_speed = 0.0;
  double stiffness = 0.0;
  for (const armukf::Sample& measured : robot.samples) {
    const armukf::Estimate belief =
        session.step({.t = measured.t, .u = measured.u, .y = measured.y});
    arm_speed = belief.values[armukf::kSpeedArm];  // rad/s, which no sensor shows
    stiffness = belief.values[k_g1];
    for (const armukf::Event& event : watch.see(session, measured, belief))
      std::cout << event.what << " from " << event.from << " to " << event.to << '\n';
  }

  // After it: what is believed, and the bytes from which session.load() goes on.
  const double sd = session.parameter_deviations()[arm.model.index_of("k_g1")];
  std::cout << "speed of the arm " << arm_speed << " rad/s, k_g1 " << stiffness << " +- " << sd
            << " N.m/rad, " << session.save().size() << " bytes to go on from\n";
  return std::abs(stiffness - 20.0774) < 4.0 * sd ? EXIT_SUCCESS : EXIT_FAILURE;
}
