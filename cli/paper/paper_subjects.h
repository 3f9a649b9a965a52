/// The three range images of the 1993 paper, or what stands in for them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/context.h"
#include "fit/surface/published_spline.h"
#include "geometry/images/range_image.h"
#include "geometry/images/region_growing.h"
#include "geometry/images/rlts_filter.h"
#include "geometry/points/point_cloud.h"
#include "model/model.h"
#include "scan/simulate/simulate.h"

namespace partscribe::cli {

/// One range image of 256 x 256 pixels, 16 bits, as measured and as filtered.
struct PaperSubject {
  std::string name;  ///< "Cylindrical Pin"
  std::string file;  ///< for names of files: "pin"
  std::string note;  ///< what it is, or stands in for
  RangeImage image;
  FilteredImage filtered;
  std::vector<CharacterizedPoint> characters;  ///< of the pixels
  Patches patches;                             ///< of first and second order, grown from them
  double deepest = 0;                          ///< mm, the largest filtered depth

  std::size_t index(int column, int row) const {
    return std::size_t(row) * std::size_t(image.width) + std::size_t(column);
  }
  bool kept(int column, int row) const { return filtered.kept[index(column, row)] != 0; }
  /// Heights towards the sensor (mm) over the pixels, from the lowest return; NaN without one.
  double height(int column, int row) const;
  /// Filtered places in the sensor's frame turned so that z points to the sensor; pixels that were kept only.
  std::vector<Vec3> points() const;
  Vec3 place(int column, int row) const;   ///< of a pixel with a depth, in that frame
  Vec3 normal(int column, int row) const;  ///< unit, towards the sensor; zero where unknown
};

/// The filtered pixels as the scan of one view, the sensor looking along -z.
Scan scan_of(const PaperSubject& subject);

struct PaperSubjects {
  model::Model pin_model;  ///< the pin's truth
  Scan pin_scan;           ///< of six views; the first is `pin`
  PaperSubject pin, mask, hand;
};

/// The pin is seen from its side. Noise of 4 codes and bit errors with probability 0.001 for the pin, as published; the
/// reliefs have 0.1 mm of noise and as many bit errors.
Result<PaperSubjects> paper_subjects(Context& context);

/// A relief as seen from above, `low` to `high` in x and y, its background at 0 or without return.
RangeImage image_of_relief(const std::function<double(double, double)>& height, const Vec2& low, const Vec2& high,
                           double sigma, double bit_error, bool background, std::uint64_t seed);

}  // namespace partscribe::cli
