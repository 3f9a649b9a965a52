/// Nearest points of a range image, looked for among the pixels around the place where a query lies in the image.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/points/kd_tree.h"

namespace partscribe::geometry {

/// The camera of an image that looks along z from the origin: column = fx x / z + cx (orthographic: without z), row
/// alike.
struct PixelCamera {
  bool pinhole = false;
  double fx = 1, fy = 1, cx = 0, cy = 0;
  int width = 0, height = 0;
};

/// Which point each pixel holds. A point that lies so many pixels away from a query's own is farther from it than the
/// rays there are, so that what a window holds is often known to be the nearest; where it is not, nothing is said and a
/// tree has to be asked.
class PixelGrid {
 public:
  static constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

  /// `pixels`: row times width plus column of each point, ascending. Points may lie beside their pixel, for a filter
  /// may have moved them; the farther the farthest does, the less is known.
  PixelGrid(const PixelCamera& camera, const std::vector<std::uint32_t>& pixels, const std::vector<Vec3>& points);

  /// What is known of the nearest: `first` may be nobody, which says that no point is nearer than `others`.
  struct Found {
    std::uint32_t first = nobody, second = nobody;  ///< the latter of the window: others may be as near
    double sq_first = std::numeric_limits<double>::max();
    double others = 0;  ///< mm; all points but the first are at least as far
  };
  /// The nearest point, the same as that of a tree; false if it may lie outside of the largest window and within
  /// `limit` (mm).
  bool nearest(const Vec3& query, double limit, Found& found) const;

  /// The `count` nearest points, nearest first, the same as those of a tree; false if they may lie outside of the
  /// largest window.
  bool nearest(const Vec3& query, std::size_t count, std::vector<Neighbour>& result) const;

  /// All points in the order of a curve that fills the image: neighbours lie together.
  std::vector<std::uint32_t> order() const;

 private:
  /// Where a query lies in the image.
  struct Place {
    int column = 0, row = 0;
    double pixel = 0;   // mm that one pixel is at least
    double beside = 0;  // pixels from the query to what a window of no width may leave out
    /// No point outside of a window of so many pixels to all sides is nearer, mm.
    double bound(int half) const { return pixel * (half + beside); }
  };
  bool locate(const Vec3& query, Place& place) const;
  template <class Use>
  void window(const Place& place, int half, const Use& use) const;

  PixelCamera camera_;
  double pitch_ = 0;  // least mm of a pixel at a distance of 1 (orthographic: anywhere)
  double off_ = 0;    // pixels that points lie beside theirs, at most
  std::vector<std::uint32_t> index_;
  const std::vector<Vec3>* points_;
};

}  // namespace partscribe::geometry
