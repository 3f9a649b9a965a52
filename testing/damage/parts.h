/// The parts that are damaged: the golden models, and machined ones that are combined from several objects.
#pragma once

#include <string>
#include <vector>

#include "geometry/points/point_cloud.h"
#include "model/model.h"

namespace partscribe::testing {

using namespace model;

/// The model of tests/golden/<part> at a tolerance of 0.2 mm, or 0.4 mm where curved surfaces take a second or more to
/// mesh at a tenth of less; damages and noise grow with it.
Model golden_part(const std::string& part);

/// A plate with five holes, a block with a boss and a blind hole, a flange with a bolt circle, a shaft with a keyway, a
/// tray with standoffs; tolerance 0.2 mm.
std::vector<Model> machined_parts();

/// Golden parts by name, and machined ones.
Model part_named(const std::string& name);

struct ScanConditions {
  double sigma = 0.2;       ///< of the tolerance
  double outliers = 0.005;  ///< share of pixels
  int resolution = 88;      ///< pixels; twelve views
};

/// Twelve views with rays, and even points (a touch probe) where no view reaches: no surface is left unseen.
Scan scan_of(const Model& model, const ScanConditions& conditions = {});

}  // namespace partscribe::testing
