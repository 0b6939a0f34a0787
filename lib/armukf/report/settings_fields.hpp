#pragma once

#include <array>
#include <concepts>
#include <string_view>
#include <type_traits>

#include "armukf/online/settings.hpp"

/// The one list of settings that reading and writing a model file share. Structures are taken apart
/// by binding all their fields, so that a field added to one of them without a line here does not
/// compile.
namespace armukf {

/// What numbers a setting may take.
enum class Range { kAny, kNotNegative, kPositive };

/// One setting in a model file: [section] key, and what the comment beside it says.
struct SettingsField {
  std::string_view section;
  std::string_view key;
  std::string_view comment;
  Range range = Range::kNotNegative;
};

inline constexpr std::array<std::string_view, 7> kSettingsSections{
    "filter", "propagation", "noise", "prior", "gate", "race", "adaptation"};

template <class S, class Plain>
concept MaybeConst = std::same_as<std::remove_const_t<S>, Plain>;

/// Calls visit(key, number, range) for each number of a setting that is a table.
template <MaybeConst<Annealing> S, class Visit>
void for_each_part(S& sd, Visit visit) {
  auto& [start, floor, time_s] = sd;
  visit("start", start, Range::kNotNegative);
  visit("floor", floor, Range::kNotNegative);
  visit("time_s", time_s, Range::kPositive);
}

template <MaybeConst<ModelError> S, class Visit>
void for_each_part(S& error, Visit visit) {
  auto& [start, least, gain, time_s] = error;
  visit("start", start, Range::kNotNegative);
  visit("least", least, Range::kNotNegative);
  visit("gain", gain, Range::kNotNegative);
  visit("time_s", time_s, Range::kPositive);
}

template <MaybeConst<NoiseLearning> S, class Visit>
void for_each_part(S& learning, Visit visit) {
  auto& [most_torque, beyond, fade, fade_from_s, fade_until_s] = learning;
  visit("most_torque", most_torque, Range::kNotNegative);
  visit("beyond", beyond, Range::kPositive);
  visit("fade", fade, Range::kNotNegative);
  visit("fade_from_s", fade_from_s, Range::kPositive);
  visit("fade_until_s", fade_until_s, Range::kNotNegative);
}

template <class S>
concept SettingsTable =
    MaybeConst<S, Annealing> || MaybeConst<S, ModelError> || MaybeConst<S, NoiseLearning>;

/// Calls visit(field, value) for every setting, in the file's order. Values are numbers, names (of
/// a filter, a Stepper), tables or the race's starts.
template <MaybeConst<EstimatorSettings> S, class Visit>
void for_each_setting(S& settings, Visit visit) {
  using enum Range;
  auto& [filter, spread, propagation, noise, prior, gate, race, adaptation, belief, limits] =
      settings;
  (void)belief;  // tables of their own, read and written beside the settings
  (void)limits;

  auto& [alpha, beta, kappa] = spread;
  visit({"filter", "kind", "ukf, ekf, srukf, ckf, iekf, adaptive or adaptive_ekf ..."}, filter);
  visit({"filter", "alpha", "distance of the sigma points, in root-n deviations", kPositive},
        alpha);
  visit({"filter", "beta", "2 is best for a normal distribution"}, beta);
  visit({"filter", "kappa", "added to the number n of states and unknowns", kAny}, kappa);

  auto& [stepper, steps, max_step_s, begin_s] = propagation;
  (void)begin_s;  // nobody sets it in a file
  visit({"propagation", "stepper", "euler, rk4, cash_karp54 or dopri5"}, stepper);
  visit({"propagation", "steps", "per sample interval, at least"}, steps);
  visit({"propagation", "max_step_s", "s; a longer interval is cut into more", kPositive},
        max_step_s);

  auto& [sensor, model_error, torque, parameter_walk, learning] = noise;
  visit({"noise", "sensor", "rad/s, sd of the speed sensor's white noise", kPositive}, sensor);
  visit({"noise", "model_error", "rad/s; gain: variance per mean square of the innovations"},
        model_error);
  for (int i = 0; i < kMassCount; ++i)
    visit({"noise", kMasses[i].noise_name,
           "N.m.s^1/2, density of the torque noise; unless told it goes with J"},
          torque[i]);
  visit({"noise", "parameter_walk", "1/s^1/2, density of the unknowns' random walk, relative"},
        parameter_walk);
  visit(
      {"noise", "learning", "most_torque: N.m.s^1/2, beyond which nothing is learnt; fade: power"},
      learning);

  auto& [twist, speed] = prior;
  visit({"prior", "twist", "rad, sd of both twists at the first sample", kPositive}, twist);
  visit({"prior", "speed", "rad/s, sd of gear box and arm against the motor", kPositive}, speed);

  auto& [nis, patience, longest_gap_s] = gate;
  visit({"gate", "nis", "normalised innovation squared that rejects a sample", kPositive}, nis);
  visit({"gate", "patience", "samples rejected in a row until the states start anew"}, patience);
  visit({"gate", "longest_gap_s", "s; after a longer one the states start anew", kPositive},
        longest_gap_s);

  auto& [duration_s, starts] = race;
  visit({"race", "duration_s", "s, after which the likeliest goes on alone"}, duration_s);
  visit({"race", "starts", "factors on the start values, a table per filter", kPositive}, starts);

  auto& [watched_s, settle_s, least, most] = adaptation;
  visit({"adaptation", "time_s", "s, over which an adaptive filter watches innovations", kPositive},
        watched_s);
  visit({"adaptation", "settle_s", "s, in which it lets model_error decay", kPositive}, settle_s);
  visit({"adaptation", "least", "of the factors on sensor and torque noise", kPositive}, least);
  visit({"adaptation", "most", "of these factors", kPositive}, most);
}

}  // namespace armukf
