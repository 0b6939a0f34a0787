#include "armukf/batch/noise_search.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "armukf/core/parallel.hpp"
#include "armukf/fit/dense.hpp"
#include "armukf/fit/golden_section.hpp"

namespace armukf {
namespace {

/// ln of the density (N.m.s^1/2 per rad/s), the sensor's pole, -ln(1 - pole) of the torque.
using Place = Eigen::Vector3d;

Place lowest() { return {-7.0, 0.0, 0.0}; }

/// Slower than a pole of 0.97 a torque's noise could be friction's or an offset's drift.
Place highest() { return {0.0, 0.95, 3.5}; }

Place place_of(const FilterNoise& noise) {
  return {std::log(noise.density), noise.sensor_pole, -std::log1p(-noise.torque_pole)};
}

FilterNoise noise_at(const Place& x, bool motor_alone) {
  const Place within = x.cwiseMax(lowest()).cwiseMin(highest());
  return {std::exp(within[0]), within[1], -std::expm1(-within[2]), motor_alone};
}

/// Newton's step for a loss of that slope and bend, downwards also where it bends down, and no
/// longer than kFarthest. Where it would leave the bounds it ends at them, and the others go on to
/// their least beside that.
Place step_within(const Eigen::Matrix3d& bend, const Place& slope, const Place& least,
                  const Place& most) {
  constexpr double kFarthest = 4.0;
  constexpr double kLeastBend = 1e-2;  // nats
  Place step = Place::Zero();
  std::vector<int> free{0, 1, 2};
  while (!free.empty()) {
    const Eigen::MatrixXd among = bend(free, free);
    const Eigen::VectorXd down = -(slope + bend * step)(free);
    const SymmetricSpectrum axes = symmetric_spectrum(among);
    const Eigen::VectorXd bends = axes.values.cwiseAbs().cwiseMax(kLeastBend);
    const Eigen::VectorXd move =
        axes.vectors * (axes.vectors.transpose() * down).cwiseQuotient(bends);
    Place there = step;
    there(free) = move * std::min(1.0, kFarthest / move.norm());
    const Place within = there.cwiseMax(least).cwiseMin(most);
    if (within == there) return there;
    for (int i = 0; i < 3; ++i)
      if (within[i] != there[i]) step[i] = within[i];
    std::erase_if(free, [&](int i) { return within[i] != there[i]; });
  }
  return step;
}

}  // namespace

NoiseSearch::NoiseSearch(const FilterNoise& start, Losses losses, TorqueNoise torque)
    : losses_(std::move(losses)),
      torque_(torque),
      best_(start),
      best_loss_(losses_({start}).front()) {}

void NoiseSearch::anywhere(const std::vector<FilterNoise>& noises) {
  std::vector<FilterNoise> found(noises.size());
  for_each_job(static_cast<int>(noises.size()),
               [&](int i) { found[i] = best_density(noises[i], lowest()[0], highest()[0]); });
  keep(found);
}

void NoiseSearch::near(const FilterNoise& noise) {
  constexpr double kNear = 1.0;  // of the logarithm
  constexpr int kPlaces = 7;
  const double x = std::log(noise.density);
  std::vector<FilterNoise> places(kPlaces, noise);
  for (int i = 0; i < kPlaces; ++i)
    places[i].density = std::exp(
        std::clamp(x + kNear * (2.0 * i / (kPlaces - 1) - 1.0), lowest()[0], highest()[0]));
  keep(places);
}

void NoiseSearch::polish(int most_steps) {
  constexpr double kNoLikelier = 0.3;
  for (int step = 0; step < most_steps; ++step) {
    const double before = best_loss_;
    take_step();
    if (!(best_loss_ < before - kNoLikelier)) break;
  }
}

std::vector<double> NoiseSearch::keep(const std::vector<FilterNoise>& noises) {
  // Of a torque that is white two noises may be the same.
  std::vector<FilterNoise> different;
  std::vector<std::size_t> of;
  for (const FilterNoise& noise : noises) {
    const auto at = std::ranges::find(different, noise);
    of.push_back(at - different.begin());
    if (at == different.end()) different.push_back(noise);
  }
  const std::vector<double> found = losses_(different);
  std::vector<double> losses;
  losses.reserve(of.size());
  for (const std::size_t i : of) losses.push_back(found[i]);
  const auto least = std::ranges::min_element(losses);
  if (*least < best_loss_) {
    best_loss_ = *least;
    best_ = noises[least - losses.begin()];
  }
  return losses;
}

FilterNoise NoiseSearch::best_density(FilterNoise noise, double low, double high) const {
  constexpr int kSteps = 3;  // leave a quarter of the bounds
  const auto loss = [&](double x) {
    noise.density = std::exp(x);
    return losses_({noise}).front();
  };
  noise.density = std::exp(golden_section(low, high, loss, kSteps));
  return noise;
}

void NoiseSearch::take_step() {
  constexpr int kMostHalved = 3;
  const Place apart{0.3, 0.06, 0.25};
  const Place middle = place_of(best_).cwiseMax(lowest() + apart).cwiseMin(highest() - apart);
  const auto noise_by = [&, motor_alone = best_.motor_alone](const Place& steps) {
    Place there = middle + apart.cwiseProduct(steps);
    if (torque_ == TorqueNoise::kWhite) there[2] = 0.0;
    return noise_at(there, motor_alone);
  };
  std::vector<FilterNoise> places{noise_by(Place::Zero())};
  for (int i = 0; i < 3; ++i) {
    places.push_back(noise_by(Place::Unit(i)));
    places.push_back(noise_by(-Place::Unit(i)));
    for (int j = 0; j < i; ++j) places.push_back(noise_by(Place::Unit(i) + Place::Unit(j)));
  }
  const std::vector<double> losses = keep(places);
  const double here = losses.front();
  auto next = losses.begin() + 1;
  Place up;
  Place slope;
  Eigen::Matrix3d bend;
  for (int i = 0; i < 3; ++i) {
    up[i] = *next++;
    const double down = *next++;
    slope[i] = 0.5 * (up[i] - down);
    bend(i, i) = up[i] - 2.0 * here + down;
    for (int j = 0; j < i; ++j) bend(i, j) = bend(j, i) = *next++ - up[i] - up[j] + here;
  }
  if (!bend.allFinite() || !slope.allFinite()) return;
  const Place least = (lowest() - middle).cwiseQuotient(apart);
  const Place most = (highest() - middle).cwiseQuotient(apart);
  Place step = step_within(bend, slope, least, most);
  for (int halved = 0; halved < kMostHalved; ++halved, step *= 0.5)
    if (keep({noise_by(step)}).front() < here) break;
}

}  // namespace armukf
