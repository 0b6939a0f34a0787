#include "armukf/online/contender.hpp"

#include <algorithm>
#include <utility>

#include "armukf/online/filters.hpp"
#include "armukf/online/runner.hpp"

namespace armukf {
namespace {

template <class Filter>
class ContenderBy final : public Contender {
 public:
  explicit ContenderBy(Runner<Filter> runner) : runner_(std::move(runner)) {}

  std::unique_ptr<Contender> anew() const override { return fresh(); }

  std::unique_ptr<Contender> second_look(const Start& start, std::span<const Sample> samples,
                                         double part_of_torque) const override {
    auto again = fresh();
    again->engine().look_again(engine(), start.values, part_of_torque);
    again->engine().begin_at(start.places);
    for (const Sample& sample : samples) again->runner_.step(sample);
    again->runner_.forget_likelihood();
    return again;
  }

  void begin(const Start& start) override {
    engine().believe_parameters(start.values);
    engine().begin_at(start.places);
  }
  void go_on_from(const ParameterBelief& earlier, const std::vector<int>& held) override {
    engine().go_on_from(earlier, held);
  }
  void believe(const std::vector<double>& values, const ParameterBelief& belief) override {
    engine().believe_parameters(values);
    engine().believe(belief);
  }
  void begin_noise_anew() override { engine().begin_noise_anew(); }

  Estimate step(const Sample& sample) override { return runner_.step(sample).estimate(sample); }

  double log_likelihood() const override { return runner_.log_likelihood(); }
  const Moment& moment() const override { return runner_.moment(); }
  int still() const override { return runner_.still(); }

  void states(std::span<double> values, std::span<double> deviations) const override {
    const Filter& filter = engine().filter();
    for (int i = 0; i < static_cast<int>(values.size()); ++i) {
      values[i] = filter.mean()[i];
      deviations[i] = filter.deviation(i);
    }
  }
  double covariance_of_rows(int i, int j) const override {
    return engine().filter().covariance(i, j);
  }
  int first_unknown() const override { return engine().filter().shape().states(); }

  const double* parameters() const override { return engine().parameters(); }
  void deviations(double* sd) const override { engine().deviations(sd); }
  double covariance(int i, int j) const override { return engine().covariance(i, j); }
  void model_deviations(double* sd) const override { engine().model_deviations(sd); }
  double free_variance(int k) const override { return engine().free_variance(k); }

  LearntNoise noise() const override { return engine().learnt_noise(); }

  void archive(OutArchive& archive) override { archive(runner_); }
  void archive(InArchive& archive) override { archive(runner_); }

 private:
  Engine<Filter>& engine() { return runner_.engine(); }
  const Engine<Filter>& engine() const { return runner_.engine(); }

  std::unique_ptr<ContenderBy> fresh() const {
    return std::make_unique<ContenderBy>(runner_.anew());
  }

  Runner<Filter> runner_;
};

}  // namespace

bool learns_noise(const EstimatorSettings& settings) {
  return !is_adaptive(settings.filter) && settings.noise.model_error.gain > 0.0 &&
         settings.noise.learning.most_torque != 0.0;
}

std::unique_ptr<Contender> make_contender(const Model& model, const FreeCoordinates& coordinates,
                                          const EstimatorSettings& settings) {
  return with_shape(model, coordinates, learns_noise(settings), [&](auto shape) {
    return with_filter("an estimate", Filters<decltype(shape)>(), kind_of(settings.filter), shape,
                       settings.spread,
                       [&]<class Filter>(Filter filter) -> std::unique_ptr<Contender> {
                         return std::make_unique<ContenderBy<Filter>>(
                             Runner(Engine(model, coordinates, settings, filter), settings.gate));
                       });
  });
}

}  // namespace armukf
