#pragma once

namespace highwall {

// How far an observation may be from what is expected of it: |r|^2 of its whitened rows, by their
// number. 95 % of those with right noise lie within (quantiles of chi-square).
struct InlierBounds {
  double chi2_1 = 3.841;  // > 0
  double chi2_2 = 5.991;  // > 0
  double chi2_3 = 7.815;  // > 0
  double chi2_4 = 9.488;  // > 0

  // rows: 1 to 4.
  double Of(int rows) const;
  // 99.73 % of 2, 3 and 4 rows, as three sigmas are of one: where rows are worse than their noise
  // says.
  static InlierBounds ThreeSigma() { return {9.0, 11.829, 14.156, 16.251}; }
  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
