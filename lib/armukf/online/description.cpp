#include "armukf/online/description.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

template <class... T>
void line(std::string& text, std::string_view title, const T&... values) {
  text += title;
  ((text += fmt::format(" {}", values)), ...);
  text += '\n';
}

void add(std::string& text, const Parameter& p) {
  line(text, p.name, p.value, p.known ? "known" : "unknown", p.lower, p.upper, p.scale, p.spread);
}

// What is taken apart by binding all fields does not compile where one was added and not said here.

void add(std::string& text, const Noise& noise) {
  const auto& [sensor, model_error, torque, walk, learning] = noise;
  line(text, "[noise] sensor:", sensor);
  for (int i = 0; i < kMassCount; ++i)
    if (torque[i]) line(text, kMasses[i].noise_name, *torque[i]);
  const auto& [start, least, gain, time_s] = model_error;
  line(text, "[noise] model_error:", start, least, gain, time_s);
  const auto& [walk_start, floor, walk_time_s] = walk;
  line(text, "[noise] parameter_walk:", walk_start, floor, walk_time_s);
  const auto& [most_torque, beyond, fade, fade_from_s, fade_until_s] = learning;
  if (most_torque) line(text, "[noise] most_torque:", *most_torque);
  line(text, "[noise] learning:", beyond, fade, fade_from_s, fade_until_s);
}

void add(std::string& text, const Race& race) {
  const auto& [duration_s, starts] = race;
  line(text, "[race] duration_s:", duration_s);
  for (const StartFactors& factors : starts) line(text, "[race] start:", factors);
}

void add(std::string& text, const ParameterBelief& belief) {
  const auto& [names, covariance, noise] = belief;
  for (std::size_t i = 0; i < names.size(); ++i) {
    line(text, "[belief]", names[i]);
    for (std::size_t j = 0; j <= i; ++j)
      line(text, "[belief]", covariance(static_cast<int>(i), static_cast<int>(j)));
  }
  const auto& [sought, known, torque_sd, torque_pole, sensor_sd, sensor_pole, sample_s, not_noise] =
      noise;
  line(text, "[belief] noise:", sought, known, torque_sd, torque_pole, sensor_sd, sensor_pole,
       sample_s, not_noise);
}

void add(std::string& text, const EstimatorSettings& settings) {
  const auto& [filter, spread, propagation, noise, prior, gate, race, adaptation, belief, limits] =
      settings;
  (void)limits;  // only what is said of trends depends on them
  line(text, "filter", filter);
  const auto& [alpha, beta, kappa] = spread;
  line(text, "[filter] alpha, beta, kappa:", alpha, beta, kappa);
  const auto& [stepper, steps, max_step_s, begin_s] = propagation;
  (void)begin_s;  // a stream is no part of another record
  line(text, "[propagation]", name_of(stepper), steps, max_step_s);
  add(text, noise);
  const auto& [twist, speed] = prior;
  line(text, "[prior]", twist, speed);
  const auto& [nis, patience, longest_gap_s] = gate;
  line(text, "[gate]", nis, patience, longest_gap_s);
  add(text, race);
  const auto& [time_s, settle_s, least, most] = adaptation;
  line(text, "[adaptation]", time_s, settle_s, least, most);
  if (belief) add(text, *belief);
}

/// The line of a text that begins there.
std::string_view line_at(std::string_view text, std::size_t begin) {
  text.remove_prefix(std::min(begin, text.size()));
  return text.substr(0, text.find('\n'));
}

}  // namespace

std::string description(const Model& model, const EstimatorSettings& settings) {
  std::string text;
  for (const EffectSlot& slot : model.effects) line(text, "effect", slot.name());
  for (const Parameter& parameter : model.parameters) add(text, parameter);
  for (const Coordinate& state : model.states) line(text, "state", state.name, state.spread);
  add(text, settings);
  return text;
}

void check_same(const std::string& there, const std::string& here) {
  if (there == here) return;
  const auto apart = std::ranges::mismatch(there, here);
  const auto at = static_cast<std::size_t>(apart.in1 - there.begin());
  const std::size_t newline = at == 0 ? std::string::npos : there.rfind('\n', at - 1);
  const std::size_t begin = newline == std::string::npos ? 0 : newline + 1;
  throw InputError(fmt::format("is of another model or filter: '{}' there, '{}' here",
                               line_at(there, begin), line_at(here, begin)));
}

}  // namespace armukf
