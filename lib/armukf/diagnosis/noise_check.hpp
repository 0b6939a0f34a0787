#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armukf/batch/output_error.hpp"
#include "armukf/batch/searches.hpp"
#include "armukf/diagnosis/acceptance_settings.hpp"
#include "armukf/diagnosis/ahead_score.hpp"
#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/trace_records.hpp"

namespace armukf {

/// Another effect in the stead of one that was found: the model with it, as it is likeliest.
struct Stead {
  const Refit* rival;
  Model model;
  StatesOfPieces x0;  // of the estimation pieces
  double
      gain;  // of the log-likelihood one sample ahead, less one for each value more that is fitted
  /// How sure that gain is by how it scatters: the mean of its sixteenths over its deviation. Holds
  /// whatever the noise is. Source: Q. H. Vuong, Econometrica 57, 1989.
  double steadiness;
};

/// What is known of the noise in the records of a model, or of nearly the same one.
struct KnownNoise {
  std::optional<FilterNoise> likeliest = {};  // where it can be all that the model leaves
  std::optional<Model> model = {};            // with the values that are likeliest with it
  bool hopeless = false;                      // it explains far too little of that
  bool looked_from_far_off = false;           // for the arm, with the effects that it has
};

/// A model with the values that make records likeliest.
struct LikeliestFit {
  Model model;
  StatesOfPieces x0;           // of the estimation pieces
  Eigen::MatrixXd covariance;  // of its unknowns
  std::vector<Gains> gains;    // with the likeliest noise, of the estimation pieces
};

/// How far off a minimum is looked for.
enum class Effort { kUsual, kUtmost };

/// Whether noise alone explains what an effect seems to.
///
/// A controller brings the sensor's noise into the torque, and what the torque's own noise does to
/// the speed. A prediction over several samples knows that torque, and whatever bends the model a
/// little learns from it what the noise will be: on other records of the same loop as well, so that
/// no record kept apart tells. One sample ahead and with the noise's own colour nothing is to be
/// had of it. Source: L. Ljung, "System Identification", 2nd ed. 1999, section 13.4, the direct
/// method.
class NoiseCheck {
 public:
  /// now: the model as it stands; given: values that its own may be looked for from as well, where
  /// from these noise cannot be all and it has no effect yet, since a fit may have led the arm into
  /// a poor minimum. All must outlive this.
  NoiseCheck(const Explained& now, const TraceRecords& records, const KnownNoise& known = {},
             const Model* given = nullptr);

  /// Whether the innovations of the model as it stands, with the likeliest noise, can be noise
  /// alone.
  bool noise_can_be_all(const AcceptanceSettings& settings);

  /// Why the effect does not count: with the likeliest noise the model as it stands leaves next to
  /// nothing, and the effect makes the records not likelier than chance does. Empty where it
  /// counts, and where noise cannot be all: there it hides what is missing. Of the same fit asked
  /// again it says the same.
  std::string refusal(const Refit& refit, const Looks& looks, const AcceptanceSettings& settings);

  /// Effects too small for the scatter of predictions to tell, which make the records likelier than
  /// chance does; the likeliest alone is not refused. None where noise cannot be all: there the
  /// likelihood is not what its name says. Asked again, it goes by what it has found for the same
  /// trials before: they may be fewer, not others.
  std::vector<Refit> likelier(const std::vector<Trial>& trials, const Looks& looks,
                              const AcceptanceSettings& settings);

  /// Whether any of those trials, or two of them that hide each other, may count as found: by one
  /// linearised step with the likeliest noise. Always where noise cannot be all. Asked again, as
  /// likelier().
  bool may_find_any(const std::vector<Trial>& trials, const Looks& looks,
                    const AcceptanceSettings& settings);

  /// Each rival on top of the rest, which is the model as it stands without one effect; the
  /// likeliest first. The likelihood is the sharpest judge of names where nothing but noise is
  /// left; where noise cannot be all there are none.
  std::vector<Stead> instead(const Model& rest, const std::vector<Refit>& rivals,
                             const AcceptanceSettings& settings);

  /// Whether the records are as likely, but for chance, without what the rest has less than the
  /// model as it stands. Not so where noise cannot be all.
  bool is_as_likely(const Model& rest, const AcceptanceSettings& settings);

  /// Whether chance alone makes the estimation records and those that validate as much likelier by
  /// a model of the same effects each, with a noise of its own, as they are. Not so where noise
  /// cannot be all, or nothing validates.
  bool is_one_for_all(const AcceptanceSettings& settings);

  /// The model as it stands with the values that make all records likeliest, those that validate as
  /// well; its deviations by the information that they hold. Where noise is all that is left no
  /// estimate has smaller ones. Nothing where it cannot be all, or where one model is not enough
  /// for all records; before that is said of records that noise can be all of, or with the utmost
  /// effort of any, they are looked for from far off. Source: L. Ljung, "System Identification",
  /// 2nd ed. 1999, sections 7.4, 9.3.
  std::optional<LikeliestFit> likeliest_fit(const AcceptanceSettings& settings,
                                            Effort effort = Effort::kUsual);

  /// What speaks against noise being all that is left, in words: of what the likeliest model leaves
  /// in the estimation records, and in those that validate.
  std::vector<std::string> unlike_noise(const AcceptanceSettings& settings);

  /// By what has been asked.
  KnownNoise known(const AcceptanceSettings& settings) const;

 private:
  /// A trial with what one linearised step would gain.
  struct Promise {
    Trial trial;
    Suggestion suggestion;
    double p_value;
  };

  /// The same of two effects that hide each other.
  struct PromiseOfTwo {
    std::string effect;
    std::string other;
    double p_value;
  };

  /// Of all trials that were asked about.
  struct Promises {
    std::vector<Promise> of_each;
    std::vector<PromiseOfTwo> of_pairs;
  };

  /// An effect with what it gains of the log-likelihood, for so many values more that are fitted.
  struct Likelier {
    Trial trial;
    FoundMinimum found;
    double more;
    double gain;
    std::optional<Refit> refit = {};  // once it is judged
  };

  /// As refusal(), where noise can be all, by fits of the effect with its noise.
  std::string explained_by_noise(const Refit& refit, const Looks& looks,
                                 const AcceptanceSettings& settings);

  /// Of those trials, all that are likelier than chance makes them, most first.
  std::vector<Likelier> likelier_than_chance(const std::vector<Trial>& trials, const Looks& looks,
                                             const AcceptanceSettings& settings);

  /// That of a gain, given all that was looked at.
  static double chance_of(const Likelier& one, const Looks& looks);

  /// As it is judged; its gain is then over what the model without it reaches from its arm on.
  Refit refit_of(const Likelier& one, const Looks& looks, const AcceptanceSettings& settings) const;

  /// Whether the rough fit says that no better one is worth while.
  bool hopeless(const AcceptanceSettings& settings) const;

  /// near: noise that theirs is looked for near to; else anywhere. ends: after each of its
  /// searches, whether that is enough.
  FoundMinimum likeliest(const Model& model, const StatesOfPieces& x0,
                         const std::optional<FilterNoise>& near,
                         const std::function<bool(const FoundMinimum&)>& ends = {}) const;

  /// The least -ln of the likelihood of those pieces alone, from the base on.
  double loss_alone(const std::vector<Record>& pieces) const;

  /// Whether it has no effect yet that was not given.
  bool none_found() const;

  /// The model as it stands with the values that were given, if any were.
  Model from_given() const;

  /// The model as it stands, the likeliest from those starts and of what was found before.
  void look_for_base(const std::vector<Model>& starts, const std::optional<FilterNoise>& near,
                     const AcceptanceSettings& settings);

  /// Whether what a trial brings may be a resonance of the arm itself, which a search has lost by
  /// locking two masses together: as long as nothing is found, the arm is then looked for from far
  /// off, and is likelier.
  bool is_lost_resonance(const Trial& trial);

  /// The same by predictions from high gains to low ones, and by what simulates best; once.
  void look_from_far_off();

  /// With what is told of it.
  void take_for_base(FoundMinimum found);
  void take_if_likelier(FoundMinimum found);

  /// The model as it stands, from that arm on.
  FoundMinimum base_from(const Model& arm) const;

  /// Whether the base is likelier from where a fit with an effect has led the arm, or from what was
  /// given: what the effect gained by leaving a poor minimum is not the effect's.
  bool leaves_poor_minimum(const Model& with);

  /// From that model on, the noise near to the base's. ends: as of likeliest().
  FoundMinimum likeliest_near_base(const Model& start,
                                   const std::function<bool(const FoundMinimum&)>& ends = {}) const;

  /// Of the trials that were asked about first: others are fewer of them.
  const Promises& promises_of(const std::vector<Trial>& trials, const Looks& looks);

  /// Of each effect the most promising trial, of what happens several moments, if a fit of it may
  /// be beyond chance; the most promising first, and no more than are worth the time.
  std::vector<Promise> promising(const std::vector<Trial>& trials, const Looks& looks);

  /// One per promise: of those far behind the likeliest after one search that one, of the others
  /// the end of all, also from where the likeliest of all has led the arm: no name loses for having
  /// ended in another minimum.
  std::vector<FoundMinimum> likeliest_of(const std::vector<Promise>& promises) const;

  /// One per rival, on top of the rest: from the arm of the rest or from the base's, whichever one
  /// search gets on better with; and from that of the likeliest of all, which the base is then
  /// looked for from as well: no name loses for having ended in another minimum.
  std::vector<FoundMinimum> likeliest_in_its_stead(const Model& rest,
                                                   const std::vector<Refit>& rivals);

  /// How many values more the likeliest fit of one model finds than that of another.
  double more_values(const Model& with, const Model& without) const;

  /// -ln of the likelihood of the model as it stands, also from where a fit with an effect has led
  /// the arm: what that gained by leaving a poor minimum is not the effect's.
  double loss_without(const Model& with) const;

  OutputError::Evaluation errors_at(const FoundMinimum& found, bool derivatives) const;

  /// ln of the likelihood of each sixteenth of the records, but for what is the same for all.
  std::vector<double> likelihoods_of_parts(const FoundMinimum& found) const;

  /// Largest, of what that minimum leaves.
  double correlation_at(const FoundMinimum& found) const;

  /// That chance alone leads the trial's effect there as far from none.
  double chance_at(const FoundMinimum& found, const Trial& trial) const;

  const Explained& now_;
  const TraceRecords& records_;
  std::vector<Record> pieces_;
  KnownNoise known_;  // of nearly the same model
  const Model* given_;
  bool looked_from_given_ = false;  // for the base
  std::optional<FoundMinimum> base_;
  std::optional<double> correlation_;                               // of what the base leaves
  std::optional<bool> one_for_all_;                                 // once it has been asked
  std::map<std::pair<std::string, double>, std::string> refusals_;  // by effect and cost of its fit
  std::optional<Promises> promises_;
  std::optional<std::vector<Likelier>> likelier_;  // likewise
};

}  // namespace armukf
