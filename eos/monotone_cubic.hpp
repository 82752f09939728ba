// SPDX-License-Identifier: Apache-2.0
// Piecewise cubic through points that is monotone wherever the points are: slopes after Fritsch & Butland, SIAM J. Sci. Stat.
// Comput. 5 (1984) 300, eqs 4-5 (weighted harmonic mean, zero at an extremum).
#pragma once

#include <algorithm>
#include <vector>

namespace eos {

/// Slopes at x (strictly rising, two at least); at the ends those of the end intervals' chords.
inline std::vector<double> monotone_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> s(n, 0.0);
  const auto chord = [&](std::size_t i) { return (y[i + 1] - y[i]) / (x[i + 1] - x[i]); };
  s[0] = chord(0), s[n - 1] = chord(n - 2);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double a = chord(i - 1), b = chord(i);
    if (!(a * b > 0)) continue;
    const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
    const double alpha = (1 + after / (before + after)) / 3;
    s[i] = a * b / (alpha * b + (1 - alpha) * a);
  }
  return s;
}

/// The cubic and its slope; beyond the ends the end tangents.
class MonotoneCubic {
 public:
  MonotoneCubic(std::vector<double> x, std::vector<double> y) : x_(std::move(x)), y_(std::move(y)), s_(monotone_slopes(x_, y_)) {}

  double operator()(double x) const {
    if (x <= x_.front()) return y_.front() + s_.front() * (x - x_.front());
    if (x >= x_.back()) return y_.back() + s_.back() * (x - x_.back());
    const auto i = static_cast<std::size_t>(std::upper_bound(x_.begin(), x_.end(), x) - x_.begin()) - 1;
    const double h = x_[i + 1] - x_[i], t = (x - x_[i]) / h, r = 1 - t;
    return y_[i] + (y_[i + 1] - y_[i]) * t * t * (3 - 2 * t) + h * t * r * (r * s_[i] - t * s_[i + 1]);
  }

 private:
  std::vector<double> x_, y_, s_;
};

}  // namespace eos
