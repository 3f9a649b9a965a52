// Figures 10 to 12: a profile as a spline, a discontinuity, a trimmed surface.
#include <algorithm>
#include <array>
#include <cmath>

#include "cli/describe.h"
#include "cli/paper/lit_pictures.h"
#include "cli/paper/paper_figure.h"
#include "cli/paper/sheet.h"
#include "fit/surface/border_curves.h"
#include "fit/surface/flatten.h"
#include "fit/surface/published_spline.h"
#include "geometry/images/enclosed_by_edges.h"
#include "geometry/images/region_growing.h"
#include "geometry/points/kd_tree.h"
#include "geometry/surfaces/trimmed_surface.h"
#include "scan/simulate/reliefs.h"

namespace partscribe::cli {
namespace {

/// The longest run of kept places of a row or column of an image; x along it, z the height.
std::vector<Vec3> longest_run(const PaperSubject& subject, int at, bool column) {
  std::vector<Vec3> best, run;
  const int count = column ? subject.image.height : subject.image.width;
  for (int k = 0; k <= count; ++k) {
    const int c = column ? at : k, r = column ? k : at;
    const bool kept = k < count && subject.kept(c, r);
    if (kept) {
      const Vec3 p = subject.place(c, r);
      run.push_back({column ? -p.y() : p.x(), 0, subject.height(c, r)});
    } else {
      if (run.size() > best.size()) best = run;
      run.clear();
    }
  }
  return best;
}

/// Panels of one fit: the profile with its spline, and the error along it.
void draw_profile(Sheet& sheet, double bottom, const std::string& title, const std::vector<Vec3>& places,
                  const fit::PublishedCurve& fit, double tolerance, double most_error) {
  std::vector<double> x, z, spline_x, spline_z;
  for (const Vec3& p : places) x.push_back(p.x()), z.push_back(p.z());
  for (int i = 0; i <= 1200; ++i) {
    const Vec3 p = fit.curve.at(i / 1200.0);
    spline_x.push_back(p.x()), spline_z.push_back(p.z());
  }
  const auto [low, high] = std::minmax_element(z.begin(), z.end());
  Chart shape{50, bottom + 150, 690, 170, x.front(), x.back(), *low, *high};
  shape.frame(sheet, title);
  shape.curve(sheet, x, z, 1, {150, 156, 168});
  shape.curve(sheet, spline_x, spline_z, 1.8, series_color(0));
  std::vector<Vec3> knots;
  for (const double t : fit.curve.t.breaks()) {
    const Vec3 p = fit.curve.at(t);
    knots.push_back(shape.place(p.x(), p.z()));
  }
  sheet.dots(knots, std::vector<Color>(knots.size(), series_color(1)), 3);
  Chart error{50, bottom + 30, 690, 80, x.front(), x.back(), 0, most_error};
  error.frame(sheet, "error at equal parameters, mm");
  error.curve(sheet, x, fit.errors, 1.2, series_color(3));
  if (tolerance < most_error) error.curve(sheet, {x.front(), x.back()}, {tolerance, tolerance}, 1, {150, 156, 168});
}

/// How trims and the true outline of the hand agree.
struct OutlineAgreement {
  double trims = 0;    ///< share of the trims within two pixels of the outline
  double outline = 0;  ///< share of the outline within two pixels of the trims
  double half = 0;     ///< pixels, within which half of the trims lie
};

/// Distances in pixels from each of `from` to the nearest of `to`, ascending.
std::vector<double> nearest_distances(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  const KdTree tree(to);
  std::vector<double> result;
  for (const Vec3& p : from) result.push_back(std::sqrt(tree.nearest_one(p).sq_distance));
  std::sort(result.begin(), result.end());
  return result;
}

OutlineAgreement compared_with_truth(const std::vector<SurfaceTrim>& trims, const RangeImage& image) {
  constexpr double step = 0.2;  // pixels
  const auto there = [&](double row, double column) {
    return std::isfinite(scan::hand_height(-85 + column * image.pitch_x, 184 - row * image.pitch_y));
  };
  std::vector<Vec3> outline, along;
  for (int i = 0; i * step < image.height - 1; ++i)
    for (int k = 0; k * step < image.width - 1; ++k) {
      const double row = i * step, column = k * step;
      const bool here = there(row, column);
      if (here != there(row, column + step)) outline.emplace_back(column + 0.5 * step, row, 0);
      if (here != there(row + step, column)) outline.emplace_back(column, row + 0.5 * step, 0);
    }
  for (const auto& trim : trims)
    for (int i = 0; i < 300; ++i) {
      const Vec2 p = trim.curve.at((i + 0.5) / 300).cwiseProduct(Vec2(image.width - 1, image.height - 1));
      along.emplace_back(p.x(), p.y(), 0);
    }
  if (along.empty() || outline.empty()) return {};
  const auto within = [](const std::vector<double>& off) {
    return double(std::upper_bound(off.begin(), off.end(), 2.0) - off.begin()) / double(off.size());
  };
  const auto off_outline = nearest_distances(along, outline), off_trims = nearest_distances(outline, along);
  return {within(off_outline), within(off_trims), off_outline[off_outline.size() / 2]};
}

}  // namespace

PaperFigure profile_figure(const PaperSubjects& subjects) {
  const PaperSubject& mask = subjects.mask;
  const int middle = mask.image.width / 2;
  // Patches along this one line size its control polygon, as the line with most of them would a mesh.
  std::vector<int> line;
  for (int row = 0; row < mask.image.height; ++row) line.push_back(mask.patches.label[mask.index(middle, row)]);
  const int count = std::max(2, most_patches(line, int(line.size()), 1).along_row);
  const auto places = longest_run(mask, middle, true);
  const auto at = fit::parameters_of(places, fit::Parameters::chord_length);
  const auto first = fit::published_curve(places, at, fit::equal_spans(3 * count));
  constexpr double tolerance = 1.0;  // mm
  const auto refined = fit::refined_curve(places, at, fit::equal_spans(3 * count), tolerance);
  Sheet sheet(760, 720);
  const double most = 1.1 * first.worst;
  draw_profile(sheet, 360,
               "from the number of patches: " + std::to_string(first.curve.points.size()) + " control points", places,
               first, tolerance, most);
  draw_profile(sheet, 0, "refined to 1.0 mm: " + std::to_string(refined.curve.points.size()) + " control points",
               places, refined, tolerance, most);
  PaperFigure figure;
  figure.title = "Figure 10: a profile of the face";
  figure.text = "Down the middle of the face lie " + std::to_string(count) + " patches, which gives " +
                std::to_string(3 * count) + " control points and errors of up to " + readable(first.worst) +
                " mm, measured at equal parameters (chord lengths). With knots at the largest errors, " +
                std::to_string(refined.curve.points.size()) + " control points leave " + readable(refined.worst) +
                " mm. Dots are knots.";
  figure.table = {{"spline", "control points", "largest error, mm"},
                  {"from the number of patches", std::to_string(first.curve.points.size()), readable(first.worst)},
                  {"refined", std::to_string(refined.curve.points.size()), readable(refined.worst)}};
  figure.pictures = {{"figure-10.png", sheet.png(), "two splines over a face's profile, each with its errors below"}};
  return figure;
}

PaperFigure discontinuity_figure(const PaperSubjects& subjects) {
  // The true profile of the pin: from the axis out, along shank and head.
  std::vector<Vec3> places;
  const auto values = model::values_of(subjects.pin_model);
  const double shank = values.at("shank_radius"), length = values.at("shank_length"), head = values.at("head_radius"),
               whole = length + values.at("head_height");
  for (int i = 0; i <= 200; ++i) {
    const double x = whole * i / 200;
    places.push_back({x, 0, x < values.at("chamfer") ? shank - values.at("chamfer") + x : x < length ? shank : head});
  }
  const auto at = fit::parameters_of(places, fit::Parameters::uniform);
  constexpr int controls = 12;
  const auto smooth = fit::published_curve(places, at, fit::equal_spans(controls));
  const auto split = fit::published_curve(places, at, fit::with_gap(fit::equal_spans(controls), length / whole - 1e-9));
  Sheet sheet(760, 720);
  const double most = 1.1 * smooth.worst;
  draw_profile(sheet, 360, "a cubic with simple knots", places, smooth, most, most);
  draw_profile(sheet, 0, "with four knots at the shoulder", places, split, most, most);
  PaperFigure figure;
  figure.title = "Figure 11: a discontinuity";
  figure.text = "Before, the spline swings where the head begins, by up to " + readable(smooth.worst) +
                " mm. Four knots at one place part a cubic there, and " + readable(split.worst) +
                " mm are left, of the "
                "chamfer at the other end.";
  figure.table = {{"spline", "control points", "largest error, mm"},
                  {"simple knots", std::to_string(smooth.curve.points.size()), readable(smooth.worst)},
                  {"four knots at the shoulder", std::to_string(split.curve.points.size()), readable(split.worst)}};
  figure.pictures = {{"figure-11.png", sheet.png(), "a swinging curve above, one with a clean step below"}};
  return figure;
}

PaperFigure trimmed_figure(Context& context) {
  // The hand on a table, which returns as well: so the border of the hand is a step of depth.
  constexpr double sigma = 0.1;
  PaperSubject hand;
  hand.image = image_of_relief(scan::hand_height, {-85, -6}, {85, 184}, sigma, 0.001, true, 8);
  hand.filtered = rlts_filter(hand.image, {.sigma = sigma}, context);
  const int width = hand.image.width, height = hand.image.height;
  const auto edges = range_edges(hand.image, hand.filtered, {});
  std::vector<double> depth;
  fit::PlaceGrid grid{width, height, {}};
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      // Pixels that the filter set aside take the mean height of their neighbours.
      Vec3 place = hand.place(column, row);
      double sum = 0;
      int count = 0;
      for (int r = std::max(0, row - 2); r <= std::min(height - 1, row + 2); ++r)
        for (int c = std::max(0, column - 2); c <= std::min(width - 1, column + 2); ++c)
          if (hand.kept(c, r)) sum += hand.place(c, r).z(), ++count;
      if (!hand.kept(column, row) && count > 0) place.z() = sum / count;
      grid.places.push_back(place);
      depth.push_back(hand.kept(column, row) || count > 0 ? -place.z() : std::nan(""));
    }
  const std::vector<std::uint8_t> outside = outside_of_edges(edges, depth, width, height, {});
  PaperFigure figure;
  figure.title = "Figure 12: a complete surface and its trimmed part";
  figure.table = {
      {"parameters", "control points", "largest error inside, mm", "rms inside, mm", "rms at the border, mm"}};
  const auto knots = fit::equal_spans(64);
  fit::PublishedSurface uniform;
  for (const auto& [kind, name] :
       {std::pair{fit::Parameters::chord_length, "chord length"}, std::pair{fit::Parameters::uniform, "uniform"},
        std::pair{fit::Parameters::centripetal, "centripetal"}}) {
    const auto surface = fit::published_surface(grid, knots, knots, kind);
    double inside = 0, border = 0, worst = 0;
    std::size_t inner = 0, outer = 0;
    for (int row = 3; row + 3 < height; ++row)
      for (int column = 3; column + 3 < width; ++column) {
        const std::size_t i = std::size_t(row) * std::size_t(width) + std::size_t(column);
        if (outside[i] || !hand.filtered.kept[i]) continue;
        bool near_border = false;
        for (int dr = -3; dr <= 3; ++dr)
          for (int dc = -3; dc <= 3; ++dc)
            near_border = near_border || outside[std::size_t((row + dr) * width + column + dc)];
        const double e = surface.errors[i];
        if (near_border)
          border += e * e, ++outer;
        else
          inside += e * e, ++inner, worst = std::max(worst, e);
      }
    figure.table.push_back({name, std::to_string(surface.surface.points.size()), readable(worst),
                            readable(std::sqrt(inside / double(std::max<std::size_t>(1, inner)))),
                            readable(std::sqrt(border / double(std::max<std::size_t>(1, outer))))});
    if (kind == fit::Parameters::uniform) uniform = surface;
  }
  // Triangles inside of the edges have the border that becomes the trimming curves.
  TriangleMesh enclosed, complete;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      enclosed.vertices.push_back({double(column), double(row), 0});
      complete.vertices.push_back(uniform.surface.at(uniform.u[std::size_t(column)], uniform.v[std::size_t(row)]));
    }
  for (int row = 0; row + 1 < height; ++row)
    for (int column = 0; column + 1 < width; ++column) {
      const std::uint32_t a = std::uint32_t(row * width + column), b = a + 1, c = a + std::uint32_t(width), d = c + 1;
      for (const auto& t : {std::array{a, b, c}, std::array{b, d, c}}) {
        complete.triangles.push_back(t);
        if (!outside[t[0]] && !outside[t[1]] && !outside[t[2]]) enclosed.triangles.push_back(t);
      }
    }
  std::vector<std::vector<SurfaceTrim>> loops(1);
  std::size_t trim_controls = 0;
  {
    auto outlines = fit::border_loops(enclosed);
    std::sort(outlines.begin(), outlines.end(), [](const auto& x, const auto& y) { return x.size() > y.size(); });
    std::vector<Vec2> outline;
    if (!outlines.empty())
      for (const std::uint32_t v : outlines.front()) outline.push_back(enclosed.vertices[v].head<2>());
    for (auto& curve : fit::border_curves(outline, 1)) {  // pixels
      for (Vec2& p : curve.points) p = p.cwiseQuotient(Vec2(width - 1, height - 1));
      trim_controls += curve.points.size();
      loops[0].push_back({std::move(curve), static_cast<int>(loops[0].size()) + 1});  // every edge is a rim
    }
  }
  const TriangleMesh trimmed = triangulated(std::array{TrimmedSurface{uniform.surface, loops}}, 0.3).mesh;
  const OutlineAgreement agreement = compared_with_truth(loops[0], hand.image);
  std::size_t steps = 0;
  for (const RangeEdge e : edges) steps += e == RangeEdge::step;
  Sheet sheet(3 * 360, 360);
  Raster map(width, height, sheet_white);
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (edges[i] != RangeEdge::none) map.pixels[i] = edges[i] == RangeEdge::step ? sheet_ink : Color{190, 150, 60};
  sheet.paste(map, 52, 52);
  sheet.paste(lit_mesh(complete, {0.25, -0.5, 1}, {0, 1, 0}, 360, false), 360, 0);
  sheet.paste(lit_mesh(trimmed, {0.25, -0.5, 1}, {0, 1, 0}, 360, false), 720, 0);
  figure.text =
      "Edges by Deriche's operator (" + std::to_string(steps) +
      " pixels at steps; roofs are lighter), the B-spline surface over the whole image, and the part of it that "
      "the edges enclose, within " +
      std::to_string(loops[0].size()) + " trimming curves of " + std::to_string(trim_controls) +
      " control points. Of these " + readable(100 * agreement.trims) +
      " % lie within two pixels of the true outline, half within " + readable(agreement.half) + ", and of that " +
      readable(100 * agreement.outline) +
      " % within two pixels of them: fingers stay apart but for the ends of two slots a few pixels wide, in which "
      "the filter sets points aside. The paper prefers equal steps for the inside and "
      "chord lengths for the border; on this relief the table says how much of either is true.";
  figure.pictures = {
      {"figure-12.png", sheet.png(), "edges of a hand, a surface with a table around it, the hand alone"}};
  return figure;
}

}  // namespace partscribe::cli
