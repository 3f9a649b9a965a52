// SINTEF's SISL: the bilinear interpolant of a grid, from which knots are taken out within a tolerance (s1966).
#include "peers.h"

#ifdef PARTSCRIBE_HAS_SISL
#include <sisl.h>
#endif

namespace bench {

#ifdef PARTSCRIBE_HAS_SISL

namespace {

/// `share`: of the tolerance, for the bilinear surface; `order`: 3 takes knots out along x first, 4 along y.
std::optional<NurbsSurface> reduced(const Question& question, double allowed, double share, int order) {
  const int columns = question.columns, rows = question.rows;
  std::vector<double> heights, x, y, edges(4, allowed);
  for (int j = 0; j < rows; ++j)  // x runs fastest
    for (int i = 0; i < columns; ++i) heights.push_back(question.points[std::size_t(i * rows + j)].z());
  for (int i = 0; i < columns; ++i) x.push_back(question.points[std::size_t(i * rows)].x());
  for (int j = 0; j < rows; ++j) y.push_back(question.points[std::size_t(j)].y());
  int free[4] = {0, 0, 0, 0}, status = 0;
  double off = 0;
  SISLSurf* surface = nullptr;
  s1966(heights.data(), columns, rows, 1, 3, x.data(), y.data(), &allowed, free, 1, 1, edges.data(), share, order, 20,
        4, 4, &surface, &off, &status);
  if (status < 0 || !surface) return std::nullopt;
  const std::vector<double> u(surface->et1, surface->et1 + surface->in1 + surface->ik1);
  const std::vector<double> v(surface->et2, surface->et2 + surface->in2 + surface->ik2);
  std::vector<double> coefficients;
  for (int i = 0; i < surface->in1; ++i)
    for (int j = 0; j < surface->in2; ++j) coefficients.push_back(surface->ecoef[j * surface->in1 + i]);
  freeSurf(surface);
  return graph_of(u, v, 3, coefficients);
}

}  // namespace

std::vector<Contestant> sisl(double seconds) {
  std::vector<Contestant> result;
  for (const double share : {0.0, 0.2, 0.4})
    for (const int order : {3, 4})
      result.push_back({"SISL s1966", std::to_string(share).substr(0, 3) + (order == 3 ? " u v" : " v u"), true, false,
                        9, [=](const Question& question, double allowed) {
                          return asked_apart([&] { return reduced(question, allowed, share, order); }, seconds);
                        }});
  return result;
}

#else

std::vector<Contestant> sisl(double) { return {}; }

#endif

}  // namespace bench
