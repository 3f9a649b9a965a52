/// One view made ready for registration: smoothed places and normals, what its sensor saw through, its borders.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/images/pixel_grid.h"
#include "geometry/points/kd_tree.h"
#include "scan/register/register.h"

namespace partscribe::scan {

/// Depths on the sensor's own grid, or on one laid across the view: tells what the sensor looked through.
struct SightRaster {
  bool pinhole = false;
  Vec3 origin = Vec3::Zero();             ///< of the raster's frame in the view
  Mat3 axes = Mat3::Identity();           ///< view_from_raster; column 2 is the direction of sight
  double fx = 1, fy = 1, cx = 0, cy = 0;  ///< column = fx x / z + cx (orthographic: without z)
  int width = 0, height = 0;
  std::vector<float> depth;  ///< mm along the direction of sight, negative where nothing returned

  /// Column, row and depth of a point of the view.
  Vec3 project(const Vec3& p) const;
  /// Unit, from the sensor to the point.
  Vec3 ray(const Vec3& p) const { return pinhole ? Vec3((p - origin).normalized()) : Vec3(axes.col(2)); }
};

/// What a sensor says of a place.
enum class Sight {
  outside,   ///< not in its image, or too close to a border to say
  measured,  ///< at the depth that it measured there
  hidden,    ///< behind what it measured
  in_front,  ///< before what it measured: the sensor looked through it
  empty,     ///< nothing returned around it: looked through, or the surface does not return
};
Sight sight(const SightRaster& raster, const Vec3& p, double margin);

/// A border of the surface as this view saw it, half a pixel outside the last return.
struct ContourPoint {
  Vec3 point, normal, outward;  ///< of the place, of its surface, in the image plane
  double pixel = 0;             ///< its size, mm
};

/// Answers of which many are never asked for, each found when it is asked for first; any thread may ask.
template <class T>
class FoundOnce {
 public:
  explicit FoundOnce(std::size_t count = 0) : values_(count), states_(new std::atomic<std::uint8_t>[count]()) {}
  /// `find`: the same whoever calls it.
  template <class Find>
  T at(std::size_t k, const Find& find) {
    if (states_[k].load(std::memory_order_acquire) == known) return values_[k];
    const T value = find();
    if (std::uint8_t before = unknown; states_[k].compare_exchange_strong(before, taken))
      values_[k] = value, states_[k].store(known, std::memory_order_release);
    return value;
  }

 private:
  static constexpr std::uint8_t unknown = 0, taken = 1, known = 2;
  std::vector<T> values_;
  std::unique_ptr<std::atomic<std::uint8_t>[]> states_;
};

struct ViewSurface {
  std::vector<Vec3> points;            ///< in the view's frame, moved along the normal onto their neighbours' surface
  std::vector<Vec3> measured;          ///< where each of `points` was measured
  std::vector<Vec3> normals;           ///< unit, towards the sensor
  std::vector<std::uint8_t> smooth;    ///< 1: inside a smooth piece, so that place and normal are good
  std::vector<float> variance;         ///< of each place along its normal, relative to that of most
  std::vector<double> cosine;          ///< of the angle under which the sensor sees each
  std::vector<std::uint32_t> samples;  ///< smooth points, evenly spread over directions and places
  std::vector<ContourPoint> contour;
  SightRaster raster;
  Vec3 center = Vec3::Zero();
  double radius = 0;              ///< rms distance from the center
  double spacing = 0, sigma = 0;  ///< of neighbours; noise along the normal of a single point, mm
  std::size_t rejected = 0;
  bool organised = false;               ///< the raster is the sensor's own
  std::vector<std::uint32_t> pixels;    ///< of `points`: row times width plus column; only if organised
  std::unique_ptr<KdTree> tree;         ///< over `points`
  std::unique_ptr<PixelGrid> grid;      ///< of `points`; only if organised
  std::unique_ptr<KdTree> sample_tree;  ///< over the places of `samples`; only with borders
  std::vector<Vec3> sample_points;

  mutable FoundOnce<Mat3> bendings;  ///< see bending

  bool usable() const { return samples.size() >= 50; }
  /// The change of the normal with the place, 1/mm, at `sample` of `samples`; for any thread.
  Mat3 bending(std::size_t sample) const;
  /// Of `points`; there must be some.
  Neighbour nearest(const Vec3& p) const;
  /// At an infinite distance where none is within `limit` (mm).
  Neighbour nearest_within(const Vec3& p, double limit) const;
  void nearest(const Vec3& p, std::size_t count, std::vector<Neighbour>& result) const;
};

/// Points whose neighbours contradict them are left out. `contours`: borders are found as well. The same for any number
/// of threads.
std::vector<ViewSurface> view_surfaces(const std::vector<RegisterView>& views, int samples, Context& context,
                                       bool contours = true);

/// `count` of the given points: seven tenths from equally filled bins of directions, the rest from everywhere.
std::vector<std::uint32_t> spread_sample(const std::vector<Vec3>& points, const std::vector<Vec3>& normals,
                                         const std::vector<std::uint32_t>& from, std::size_t count);

}  // namespace partscribe::scan
