/// The same question to all: a B-spline surface near these points, with few control points.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "measure.h"

namespace bench {

struct Question {
  std::vector<Vec3> points;   ///< of a grid: y runs fastest
  int columns = 0, rows = 0;  ///< of a grid, evenly over the field; 0: scattered points
  double sigma = 0;           ///< mm, of their noise, along z; told to all
  double tolerance = 0;       ///< mm
};

struct Answer {
  NurbsSurface surface;
  double seconds = 0;    ///< of processor time, the fit alone
  double megabytes = 0;  ///< memory at most beside the question
};

/// `allowed`: mm, what the contestant's own parameter is made of: larger is looser.
using Ask = std::function<std::optional<Answer>(const Question&, double allowed)>;

struct Contestant {
  std::string name, setting;  ///< of those with the same name in turn the best is shown
  bool needs_grid = false, needs_scatter = false;
  double loosest = 3;  ///< where the search begins, over the tolerance
  Ask ask;
  bool driven = true;  ///< else asked once, with the loosest
};

/// Asks in a process of its own, which is ended after so many seconds of processor time; nothing then, or if it
/// crashes.
std::optional<Answer> asked_apart(const std::function<std::optional<NurbsSurface>()>& fit, double seconds);

/// Numbers that make up a surface: degree, number of knots, knots of u and of v, control points, v fastest.
std::vector<double> numbers_of(const NurbsSurface& surface);
std::optional<NurbsSurface> surface_of(const std::vector<double>& numbers, std::size_t& next);

/// The graph of a function with these knots and coefficients, v fastest: x and y are the parameters.
NurbsSurface graph_of(const std::vector<double>& u, const std::vector<double>& v, int degree,
                      const std::vector<double>& coefficients);

/// The domain and the options are those that the program takes.
Contestant ours(bool driven, double seconds);
std::vector<Contestant> fitpack(double seconds);  ///< regrid and surfit by a script for SciPy; none: not installed
std::vector<Contestant> sisl(double seconds);
std::vector<Contestant> occt(double seconds);

}  // namespace bench
