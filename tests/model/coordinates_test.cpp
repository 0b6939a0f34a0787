#include "armukf/model/coordinates.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace armukf {
namespace {

/// The choices of unknowns that have coordinates of their own.
std::vector<Model> choices() {
  std::vector<Model> models(5, published_estimate());
  models[1].parameter("a_m").known = true;
  models[2].parameter("a_g").known = true;
  for (Parameter& p : models[3].parameters) p.known = false;
  models[4].add_effect("torque_bias");
  models[4].parameter("k_a").upper = 40.0;
  models[4].parameter("k_g1").lower = 5.0;
  return models;
}

TEST(FreeCoordinates, GoThereAndBack) {
  for (const Model& model : choices()) {
    const FreeCoordinates coordinates(model);
    const std::vector<double> p = model.values();
    const std::vector<double> z = coordinates.from_physical(p);
    std::vector<double> back(p.size());
    coordinates.to_physical(z.data(), back.data());
    for (std::size_t i = 0; i < p.size(); ++i)
      EXPECT_NEAR(back[i], p[i], 1e-13 * (1.0 + std::abs(p[i]))) << model.parameters[i].name;
  }
}

TEST(FreeCoordinates, LeadNowhereUnphysical) {
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> anywhere(-15.0, 15.0);
  for (const Model& model : choices()) {
    const FreeCoordinates coordinates(model);
    std::vector<double> z(coordinates.size());
    std::vector<double> p(model.parameters.size());
    for (int trial = 0; trial < 200; ++trial) {
      for (double& value : z) value = anywhere(generator);
      coordinates.to_physical(z.data(), p.data());
      for (std::size_t i = 0; i < p.size(); ++i) {
        EXPECT_GE(p[i], model.parameters[i].lower) << model.parameters[i].name;
        EXPECT_LE(p[i], model.parameters[i].upper) << model.parameters[i].name;
      }
      EXPECT_LT(p[kAm] + p[kAg], 1.0);
    }
  }
}

TEST(FreeCoordinates, LetAStartOnItsBoundLeave) {
  const Model model = published_arm();  // k_g3 = 0
  const FreeCoordinates coordinates(model);
  const std::vector<double> z = coordinates.from_physical(model.values());
  std::vector<double> p(model.parameters.size());
  coordinates.to_physical(z.data(), p.data());
  EXPECT_NEAR(p[kKg3], model.parameter("k_g3").scale, 1e-12);
}

/// A logarithm of what may be nothing would make of a deviation a part of a value, however small.
TEST(FreeCoordinates, KnowASizeAsWellWhereItIsNearlyNothing) {
  Model model = published_estimate();
  model.add_effect("backlash");
  const int backlash = model.index_of("backlash");
  const double scale = model.parameters[backlash].scale;
  const FreeCoordinates coordinates(model);
  const int last = coordinates.size() - 1;
  for (const double size : {0.8, 1e-2, 1e-5}) {
    model.parameters[backlash].value = size * scale;
    std::vector<double> sd(coordinates.size());
    const auto covariance = [](int i, int j) { return i == j ? 0.04 : 0.0; };
    coordinates.deviations(model.values().data(), covariance, sd.data());
    EXPECT_NEAR(sd[last], 0.2 * scale, 1e-15) << size;
  }
}

TEST(FreeCoordinates, KeepInsideWhatIsBeyondABound) {
  Model model = published_estimate();
  model.add_effect("backlash");
  const Parameter& backlash = model.parameter("backlash");
  const int at = model.index_of("backlash");
  const FreeCoordinates coordinates(model);
  std::vector<double> z = coordinates.from_physical(model.values());
  std::vector<double> p(model.parameters.size());
  for (const double beyond : {-3.0, 1e3}) {
    z.back() = beyond;
    coordinates.to_physical(z.data(), p.data());
    EXPECT_EQ(p[at], beyond < 0.0 ? backlash.lower : backlash.upper);
    coordinates.keep_inside(z.data());
    coordinates.to_physical(z.data(), p.data());
    EXPECT_NEAR(p[at], beyond < 0.0 ? backlash.lower : backlash.upper, 1e-5 * backlash.scale);
    // It is a value that was found, and stays.
    EXPECT_NEAR(coordinates.from_physical(p).back(), z.back(), 1e-9);
  }
}

TEST(FreeCoordinates, DeviationsAreThoseOfTheJacobian) {
  using Number = Dual<16>;
  std::mt19937_64 generator(9);
  std::normal_distribution<double> normal;
  for (const Model& model : choices()) {
    const FreeCoordinates coordinates(model);
    const int n = coordinates.size();
    const std::vector<double> p = model.values();
    const std::vector<double> z = coordinates.from_physical(p);
    std::vector<std::array<double, 16>> root(n);  // covariance = root root'
    for (auto& row : root)
      for (double& value : row) value = 0.1 * normal(generator);
    const auto covariance = [&](int i, int j) {
      double sum = 0.0;
      for (int k = 0; k < 16; ++k) sum += root[i][k] * root[j][k];
      return sum;
    };
    std::vector<Number> variables;
    for (int k = 0; k < n; ++k) variables.push_back(Number::variable(z[k], k));
    std::vector<Number> values(p.size());
    coordinates.to_physical(variables.data(), values.data());
    std::vector<double> sd(n);
    coordinates.deviations(p.data(), covariance, sd.data());
    for (int k = 0; k < n; ++k) {
      const Number& value = values[coordinates.unknowns()[k]];
      double variance = 0.0;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          variance += value.gradient[i] * value.gradient[j] * covariance(i, j);
      EXPECT_NEAR(sd[k], std::sqrt(variance), 1e-10 * (1.0 + sd[k]))
          << model.parameters[coordinates.unknowns()[k]].name;
    }
  }
}

}  // namespace
}  // namespace armukf
