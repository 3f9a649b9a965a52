/// What the registration of 1993 leaves open: kinds of primitives, thresholds, ends.
#pragma once

#include <cstddef>

#include "core/layers.h"

namespace partscribe::scan {

/// What the model consists of and where the points come from (section 2.1.2, last paragraph).
enum class PaperPrimitives {
  planar_patches,  ///< large planar patches; points are their centres of gravity
  triangles,       ///< for free form: triangulated surface; points are centres of gravity of coarse triangles
};

struct PaperOptions {
  PaperPrimitives primitives = PaperPrimitives::planar_patches;
  double patch_angle = 0.12;       ///< rad; normals of one patch differ by no more
  double patch_radius = 0.35;      ///< of the view's rms radius; a larger planar area is several patches
  double normal_angle = 0.785398;  ///< rad; alpha of the consistency of normals; large, so that it converges
  double mismatch_deviations = 3;  ///< from which on a residual is a mismatch
  bool visibility = true;          ///< points that no registered view can see by the first estimate are left out
  int looks = 3;  ///< how often that is asked: by the first estimate, then by what came of it; 1: as printed
  double error_threshold = 1e-6;    ///< in square pixels; iterations stop when e(q) is below
  int iterations = 2000;            ///< at most; each takes microseconds, and weakly fixed motions converge slowly
  std::size_t most_triangles = 99;  ///< of the coarse surface: the paper has fewer than a hundred points
};

/// For free form. A bent surface lies near itself wherever a view slides along it, so that mismatches have to be told
/// from less: by three deviations the views of a sculpture came out 2 to 5 degrees off, by two 1 to 2.
inline PaperOptions free_form_options() {
  PaperOptions options;
  options.primitives = PaperPrimitives::triangles, options.mismatch_deviations = 2;
  return options;
}

}  // namespace partscribe::scan
