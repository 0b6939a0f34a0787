#include "armukf/batch/slow_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "armukf/batch/identify.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/dual.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/segments.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/fit/dense.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

// s; springs and masses of such an axis swing at a few Hz and above.
constexpr double kWindowS = 0.25;
constexpr int kWindowsPerLength = 10;       // overlapping, so that none of the motion is lost
constexpr double kLeastSpeed = 0.1;         // rad/s; below, the record is noise
constexpr double kLeastSpeedChange = 0.05;  // of the greatest speed, rms over the windows

constexpr double kLeastInertia = 1e-6;  // kg.m^2

/// The unknowns, in this order.
constexpr std::array<int, 6> kSought{kFv, kFc, kFcs, kAlpha, kBeta, kTotalInertia};
constexpr int kUnknowns = kSought.size();
using Number = Dual<8>;  // a lane per unknown, rounded up to a vector register

/// A window of a record: its first and last sample, both measured and all between them.
struct Window {
  const Sample* first;
  const Sample* last;

  double length() const { return last->t - first->t; }
  double speed_change() const { return last->y - first->y; }
};

void add_windows(const std::vector<Sample>& samples, std::vector<Window>& windows) {
  const double spacing = kWindowS / kWindowsPerLength;
  double next_start = samples.front().t;
  std::size_t last = 0;
  for (std::size_t first = 0; first < samples.size(); ++first) {
    if (samples[first].t < next_start) continue;
    while (last < samples.size() && samples[last].t < samples[first].t + kWindowS) ++last;
    if (last == samples.size()) return;
    const bool measured = std::none_of(&samples[first], &samples[last] + 1,
                                       [](const Sample& s) { return std::isnan(s.y); });
    if (measured) windows.push_back({&samples[first], &samples[last]});
    next_start = samples[first].t + spacing;
  }
}

/// Torque balance of each window as residuals, in the unknowns z.
class TorqueBalance {
 public:
  TorqueBalance(const Model& model, std::vector<Window> windows) : windows_(std::move(windows)) {
    parameters_ = model.values();
  }

  int size() const { return static_cast<int>(windows_.size()); }

  /// Fills r and, unless it is null, the Jacobian row by row.
  void operator()(const double* z, double* r, double* gradient) const {
    std::vector<Number> p(parameters_.begin(), parameters_.end());
    for (int i = 0; i < kUnknowns; ++i) p[kSought[i]] = Number::variable(z[i], i);
    const Coefficients<Number> coefficients(p.data());
    for (int k = 0; k < size(); ++k) {
      const Number balance = missing_torque(coefficients, p[kTotalInertia], windows_[k]);
      r[k] = balance.value;
      for (int i = 0; gradient != nullptr && i < kUnknowns; ++i)
        gradient[k * kUnknowns + i] = balance.gradient[i];
    }
  }

 private:
  /// N.m, by which the torque given exceeds the torque accounted for.
  static Number missing_torque(const Coefficients<Number>& c, const Number& inertia,
                               const Window& window) {
    Number impulse(0.0);  // N.m.s
    for (const Sample* s = window.first; s != window.last; ++s) {
      const double dt = s[1].t - s->t;
      impulse += dt * (s->u - friction(c, Number(0.5 * (s->y + s[1].y))));
    }
    return (impulse - inertia * window.speed_change()) / window.length();
  }

  std::vector<double> parameters_;
  std::vector<Window> windows_;
};

/// Fv, Fc, Fcs and J enter linearly: their best values for given alpha and beta, none below 0.
std::vector<double> solved(const TorqueBalance& balance, double alpha, double beta) {
  constexpr std::array<int, 4> kLinear{0, 1, 2, 5};
  std::vector<double> z{0.0, 0.0, 0.0, alpha, beta, 1.0};
  Eigen::VectorXd r(balance.size());
  JacobianMatrix jacobian(balance.size(), kUnknowns);
  balance(z.data(), r.data(), jacobian.data());
  r -= jacobian.col(5);  // at J = 1 to J = 0
  Eigen::MatrixXd regressors(balance.size(), kLinear.size());
  for (int i = 0; i < 4; ++i) regressors.col(i) = jacobian.col(kLinear[i]);
  const Eigen::VectorXd best = least_squares_solution(regressors, -r);
  for (int i = 0; i < 4; ++i) z[kLinear[i]] = std::max(i == 3 ? kLeastInertia : 0.0, best[i]);
  return z;
}

struct Guess {
  std::vector<double> z;
  double misfit;
};

/// A grid over the two parameters that do not enter linearly, transitions from a tenth of a rad/s
/// to a few of them: for each alpha the best beta.
std::vector<Guess> guesses(const TorqueBalance& balance) {
  std::vector<Guess> best;
  Eigen::VectorXd r(balance.size());
  for (double alpha = 0.5; alpha < 10.0; alpha *= 2.0) {
    Guess guess{{}, kInfinite};
    for (double beta = 0.25; beta < 20.0; beta *= 2.0) {
      std::vector<double> z = solved(balance, alpha, beta);
      balance(z.data(), r.data(), nullptr);
      if (r.squaredNorm() < guess.misfit) guess = {std::move(z), r.squaredNorm()};
    }
    if (!guess.z.empty()) best.push_back(guess);
  }
  return best;
}

void check_motion(const std::string& name, const std::vector<Window>& windows) {
  if (static_cast<int>(windows.size()) <= 2 * kUnknowns)
    throw InputError(name, 0, "y", "too short to tell friction and inertia from");
  double greatest = 0.0;
  double changes = 0.0;
  for (const Window& w : windows) {
    greatest = std::max(greatest, std::abs(w.first->y));
    changes += w.speed_change() * w.speed_change();
  }
  if (greatest < kLeastSpeed)
    throw InputError(name, 0, "y", "does not move: friction and inertia cannot be told");
  if (std::sqrt(changes / static_cast<double>(windows.size())) < kLeastSpeedChange * greatest)
    throw InputError(name, 0, "y", "keeps its speed: the inertia J cannot be told");
}

/// The model with the sought parameters as a fit of the whole arm finds them from this guess.
Identification sharpened(Model model, const Guess& guess, const std::vector<Record>& pieces,
                         const Propagation& propagation) {
  for (int i = 0; i < kUnknowns; ++i) {
    model.parameters[kSought[i]].value = guess.z[i];
    model.parameters[kSought[i]].known = false;
  }
  // The windows hardly see the friction peak near standstill; a search that begins without one
  // would not find alpha.
  Parameter& peak = model.parameters[kFcs];
  peak.value = std::max(peak.value, model.parameters[kFc].value);
  IdentifySettings settings;
  settings.propagation = propagation;
  settings.initial = all_free(model);
  settings.jackknife = false;  // only where it ends counts
  return identify(model, pieces, settings);
}

}  // namespace

Model from_slow_motion(Model model, const Record& record, const Propagation& propagation) {
  const std::vector<Record> pieces = split_at_gaps({record});
  std::vector<Window> windows;
  for (const Record& piece : pieces) add_windows(piece.samples, windows);
  check_motion(record.name, windows);
  const TorqueBalance balance(model, std::move(windows));
  std::optional<Identification> best;
  for (const Guess& guess : guesses(balance)) {
    Identification found = sharpened(model, guess, pieces, propagation);
    if (found.mse < (best ? best->mse : kInfinite)) best = std::move(found);
  }
  if (!best)
    throw InputError(record.name, 0, "y", "cannot be simulated with the model's other values");
  for (const int i : kSought) model.parameters[i].value = best->model.parameters[i].value;
  return model;
}

double share_of_fast_motion(const Record& record) {
  std::vector<Window> windows;
  const std::vector<Record> pieces = split_at_gaps({record});
  for (const Record& piece : pieces) add_windows(piece.samples, windows);
  double all = 0.0;
  double fast = 0.0;
  for (const Window& w : windows) {
    // What a straight line leaves of the speed in the window.
    double n = 0.0, t = 0.0, y = 0.0, tt = 0.0, ty = 0.0, yy = 0.0;
    for (const Sample* s = w.first; s != w.last; ++s) {
      const double at = s->t - w.first->t;
      n += 1.0;
      t += at;
      y += s->y;
      tt += at * at;
      ty += at * s->y;
      yy += s->y * s->y;
    }
    all += yy;
    fast += yy - y * y / n - std::pow(ty - t * y / n, 2) / (tt - t * t / n);
  }
  return all > 0.0 ? fast / all : 0.0;
}

}  // namespace armukf
