#include "truth.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <stdexcept>
#include <string_view>

namespace blind {
namespace {

constexpr std::array<std::string_view, 3> kMotions{"square and multisine", "random phase", "moves"};
constexpr std::array<std::string_view, 3> kSites{"motor", "gear", "arm"};

struct Json {
  std::ofstream& file;

  void number(double value) const {
    if (std::isfinite(value))
      file << value;
    else
      file << "null";
  }

  void object(const std::vector<NamedNumber>& numbers) const {
    std::string_view comma;
    file << '{';
    for (const auto& [name, value] : numbers) {
      file << comma << '"' << name << "\": ";
      number(value);
      comma = ", ";
    }
    file << '}';
  }
};

std::vector<NamedNumber> numbers_of(const ArmValues& p) {
  return {{"Fv", p.Fv},   {"Fc", p.Fc},   {"Fcs", p.Fcs}, {"alpha", p.alpha}, {"beta", p.beta},
          {"J", p.J},     {"a_m", p.a_m}, {"a_g", p.a_g}, {"k_g1", p.k_g1},   {"k_g3", p.k_g3},
          {"d_g", p.d_g}, {"k_a", p.k_a}, {"d_a", p.d_a}};
}

std::string_view name_of(Motion motion) { return kMotions[static_cast<std::size_t>(motion)]; }

}  // namespace

void write_truth(const std::string& path, const World& world, const Effects& effects,
                 const std::vector<Record>& records) {
  std::ofstream file(path);
  file << std::setprecision(12);
  const Json json{file};
  file << "{\"arm\": ";
  json.object(numbers_of(world.arm));
  file << ",\n \"noise\": ";
  json.object({{"sensor_sd", world.sensor.sd},
               {"sensor_pole", world.sensor.pole},
               {"torque_sd", world.torque.sd},
               {"torque_pole", world.torque.pole}});
  file << ",\n \"controller\": ";
  json.object({{"proportional", world.controller.proportional},
               {"integral_time", world.controller.integral_time},
               {"filter_time", world.controller.filter_time}});
  file << ",\n \"motion\": \"" << name_of(world.motion) << "\", \"test_motion\": \""
       << name_of(world.test_motion) << "\",\n \"effects\": ";
  json.object(numbers_of(effects));
  file << ",\n \"oscillators\": [";
  std::string_view comma;
  for (const Oscillator& o : effects.oscillators) {
    file << comma << "{\"site\": \"" << kSites[static_cast<std::size_t>(o.site)] << "\", \"at\": ";
    json.object({{"share", o.share}, {"frequency", o.frequency_hz}, {"damping", o.damping}});
    file << '}';
    comma = ", ";
  }
  file << "],\n \"starts\": [";
  comma = "";
  for (const Record& record : records) {
    file << comma;
    json.object(
        {{"motor_angle", record.start.x[State::kQm]}, {"arm_angle", record.start.x[State::kQa]}});
    comma = ", ";
  }
  file << "]}\n";
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace blind
