#pragma once

#include <memory>
#include <span>
#include <vector>

#include "armukf/core/archive.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/coordinates.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/moment.hpp"
#include "armukf/online/race.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// A filter in a session's race, of whatever kind and size: Runner and Engine say what each of this
/// does. Unknowns are counted as the model's free coordinates are.
class Contender {
 public:
  Contender() = default;
  Contender(const Contender&) = delete;
  Contender& operator=(const Contender&) = delete;
  virtual ~Contender() = default;

  /// One that has seen nothing, of the same model and settings.
  virtual std::unique_ptr<Contender> anew() const = 0;

  /// One that has gone over the samples of the beginning, from that start, with the noise that this
  /// one has learnt, or that part of the torque's. Its likelihood counts from their end on.
  virtual std::unique_ptr<Contender> second_look(const Start& start,
                                                 std::span<const Sample> samples,
                                                 double part_of_torque) const = 0;

  virtual void begin(const Start& start) = 0;
  virtual void go_on_from(const ParameterBelief& earlier, const std::vector<int>& held) = 0;

  /// Changes its mind about the parameters, a value each, and goes on; nothing is allocated.
  virtual void believe(const std::vector<double>& values, const ParameterBelief& belief) = 0;
  virtual void begin_noise_anew() = 0;

  /// What it makes of the sample, without values and deviations; nothing is allocated.
  virtual Estimate step(const Sample& sample) = 0;

  virtual double log_likelihood() const = 0;
  virtual const Moment& moment() const = 0;
  virtual int still() const = 0;

  /// Values and deviations of as many states as those have room for.
  virtual void states(std::span<double> values, std::span<double> deviations) const = 0;

  /// Covariance of two of the belief's rows: states, then noises, then unknowns from the
  /// first_unknown() on, each a free coordinate.
  virtual double covariance_of_rows(int i, int j) const = 0;
  virtual int first_unknown() const = 0;

  /// The value of each parameter of the model.
  virtual const double* parameters() const = 0;

  /// Of the unknowns' physical values, to be believed; and the deviations as the belief has them.
  virtual void deviations(double* sd) const = 0;
  virtual double covariance(int i, int j) const = 0;
  virtual void model_deviations(double* sd) const = 0;
  virtual double free_variance(int k) const = 0;

  virtual LearntNoise noise() const = 0;

  virtual void archive(OutArchive& archive) = 0;
  virtual void archive(InArchive& archive) = 0;
};

/// Whether the noises, which have colours, are to be learnt.
bool learns_noise(const EstimatorSettings& settings);

/// The filter that the settings name, in the size that the model needs. All that it is made of must
/// outlive it.
std::unique_ptr<Contender> make_contender(const Model& model, const FreeCoordinates& coordinates,
                                          const EstimatorSettings& settings);

}  // namespace armukf
