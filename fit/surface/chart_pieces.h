/// Charts with strips of their neighbours, each fitted as one B-spline surface.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/context.h"
#include "fit/candidate.h"
#include "fit/surface/charts.h"
#include "fit/surface/spline_fit.h"
#include "geometry/mesh/triangle_mesh.h"
#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

/// A chart with the strip around it, laid out and fitted.
struct ChartPiece {
  TriangleMesh mesh;
  std::map<std::uint32_t, std::uint32_t> local;  ///< number of a vertex of the whole mesh in this one
  std::vector<std::uint32_t> triangles;          ///< of the whole mesh
  std::vector<Vec2> places;                      ///< of the vertices, mm
  SplineData data;                               ///< points, at their feet on the surface
  NurbsSurface surface;
};

class ChartPieces {
 public:
  /// The mesh says where there is surface, the points of the scan where exactly it lies; where there are none the mesh
  /// is smoothed. `input` and `context` must outlive it.
  ChartPieces(const TriangleMesh& mesh, const FitInput& input, Context& context);

  const TriangleMesh& mesh() const { return mesh_; }

  /// Nothing for a chart that cannot be laid out in a plane, or takes too many control points. What was fitted before
  /// is not fitted again.
  std::shared_ptr<const ChartPiece> fitted(const Charts& charts, int chart);

 private:
  void add_facets();
  void add_unseen();
  void even_out();
  std::vector<Vec3> means_around() const;
  void smooth(const std::vector<char>& fixed);
  Vec3 middle(std::size_t triangle) const;
  std::vector<std::uint32_t> with_strip(const std::vector<std::uint32_t>& chart, double share) const;
  ChartPiece laid_out(std::vector<std::uint32_t> triangles) const;

  TriangleMesh mesh_;
  const FitInput& input_;
  Context& context_;
  std::vector<std::array<std::uint32_t, 3>> neighbours_;
  std::vector<Vec3> normals_;
  std::vector<std::vector<std::pair<Vec3, Vec3>>> on_;  // points of the scan by triangle, and the place on it
  std::map<std::vector<std::uint32_t>, std::shared_ptr<const ChartPiece>> fitted_;  // by the triangles of the chart
};

}  // namespace partscribe::fit
