#include "changes.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace blind {
namespace {

constexpr std::array<std::pair<std::string_view, double ArmValues::*>, 13> kArmValues{{
    {"Fv", &ArmValues::Fv},
    {"Fc", &ArmValues::Fc},
    {"Fcs", &ArmValues::Fcs},
    {"alpha", &ArmValues::alpha},
    {"beta", &ArmValues::beta},
    {"J", &ArmValues::J},
    {"a_m", &ArmValues::a_m},
    {"a_g", &ArmValues::a_g},
    {"k_g1", &ArmValues::k_g1},
    {"k_g3", &ArmValues::k_g3},
    {"d_g", &ArmValues::d_g},
    {"k_a", &ArmValues::k_a},
    {"d_a", &ArmValues::d_a},
}};

constexpr std::array<std::pair<std::string_view, double Wiring::*>, 5> kWiring{{
    {"torque_gain", &Wiring::torque_gain},
    {"torque_bias", &Wiring::torque_bias},
    {"input_delay", &Wiring::input_delay},
    {"sensor_gain", &Wiring::sensor_gain},
    {"sensor_bias", &Wiring::sensor_bias},
}};

void carry(ArmValues& arm, double payload) {
  const double total = arm.J * (1.0 + payload * (1.0 - arm.a_m - arm.a_g));
  arm.a_m *= arm.J / total;
  arm.a_g *= arm.J / total;
  arm.J = total;
}

void apply(const std::string& what, double size, Machine& machine) {
  if (what == "payload") carry(machine.arm, size);
  for (const auto& [name, value] : kArmValues)
    if (name == what || (what == "friction_level" && name.front() == 'F'))
      machine.arm.*value *= 1.0 + size;
  for (const auto& [name, value] : kWiring)
    if (name == what) machine.wiring.*value += size;
}

}  // namespace

bool can_change(const std::string& what) {
  const auto named = [&](const auto& entry) { return entry.first == what; };
  return what == "payload" || what == "friction_level" || std::ranges::any_of(kArmValues, named) ||
         std::ranges::any_of(kWiring, named);
}

Machine changed(const ArmValues& arm, const std::vector<Change>& changes, double t) {
  Machine machine{arm, {}};
  for (const Change& c : changes) {
    if (t < c.from) continue;
    const double part = c.duration > 0.0 ? std::min(1.0, (t - c.from) / c.duration) : 1.0;
    apply(c.what, part * c.size, machine);
  }
  return machine;
}

}  // namespace blind
