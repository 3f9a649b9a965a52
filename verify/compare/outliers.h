/// Points off the model that stand so close together that outliers cannot explain them.
#pragma once

#include <cstdint>
#include <vector>

#include "verify/compare/source.h"

namespace partscribe::verify {

/// What a scan's outliers are judged by. All points off the model, kept or set aside by a filter, in coordinate order.
struct OutlierScene {
  std::vector<Vec3> off;                                 ///< the points
  std::vector<Vec3> feet;                                ///< the nearest places on the model
  std::vector<Vec3> foot_normals;                        ///< unit, of the facets there
  const ScanSource* source = nullptr;                    ///< all kept points
  const std::vector<std::uint8_t>* is_off = nullptr;     ///< per kept point: 1 if it is among `off`
  const std::vector<std::uint32_t>* triangle = nullptr;  ///< per kept point: its nearest facet
  const std::vector<Vec3>* normals = nullptr;            ///< per facet
  double most_outliers = 0.02;  ///< share of the points that is believed to be outliers, at most
};

/// A group that chance does not explain.
struct OutlierCluster {
  std::vector<std::uint32_t> members;  ///< indices into OutlierScene::off, ascending
  std::size_t most = 0;                ///< points in the window that gave it away
  double expected = 0;                 ///< outliers that the scan's own density puts into that window
  double extent = 0;                   ///< mm, largest width
};

/// Two tests on windows about every point off the model, each with half of `false_alarm` for the whole scan:
/// - space: how many other points off the model lie within 2.5 and 5 spacings of it, against a Poisson count. Its
///   density is that of the ring around the window, but at least the scan's own share of outliers and at most that of
///   the densest curtain of mixed pixels;
/// - surface: how many of the points over the patch around its foot are off the model, against a binomial with the
///   share in the ring around that patch. A feature hides the surface below it; outliers leave it in view.
std::vector<OutlierCluster> clusters_beyond_chance(const OutlierScene& scene, double false_alarm, int threads);

/// Outliers of one view that scatter between an edge and what lies behind it are at most so dense, as a share of the
/// density of scanned surface: three in ten of the pixels along the edge, spread over two pixels or more.
inline constexpr double densest_curtain = 0.15;

}  // namespace partscribe::verify
