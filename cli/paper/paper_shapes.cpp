// Tables 1 and 2, figures 7 to 9: triangulations, superellipsoids, characters of surfaces.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "cli/describe.h"
#include "cli/paper/lit_pictures.h"
#include "cli/paper/paper_figure.h"
#include "cli/paper/sheet.h"
#include "core/number.h"
#include "fit/build.h"
#include "fit/propose/as_published/published_superellipsoid.h"
#include "fit/propose/superellipsoid.h"
#include "fit/surface/generalized_delaunay.h"
#include "fit/surface/sized_spline.h"
#include "geometry/images/region_growing.h"

namespace partscribe::cli {
namespace {

std::string two_decimals(double x) { return print_number(snapped(x, 0.01)); }

/// Both exponents and the tapering, as cells of a table.
std::vector<std::string> cells_of(const model::Hypothesis& h) {
  return {two_decimals(h.e1), two_decimals(h.e2), two_decimals(h.taper_x) + ", " + two_decimals(h.taper_y)};
}

std::vector<std::string> joined(std::vector<std::string> cells, const std::vector<std::vector<std::string>>& more) {
  for (const auto& some : more) cells.insert(cells.end(), some.begin(), some.end());
  return cells;
}

fit::SampleLattice lattice_of(const PaperSubject& subject) {
  fit::SampleLattice lattice{subject.image.width, subject.image.height, {}, {}};
  for (int row = 0; row < lattice.rows; ++row)
    for (int column = 0; column < lattice.columns; ++column) {
      lattice.normals.push_back(subject.normal(column, row));
      lattice.places.push_back(lattice.normals.back().isZero() ? Vec3::Constant(std::nan(""))
                                                               : subject.place(column, row));
    }
  return lattice;
}

/// The superellipsoid of the pixels of an image.
fit::SuperellipsoidFit superellipsoid_of(const PaperSubject& subject, Context& context) {
  std::vector<Vec3> points, normals;
  for (int row = 0; row < subject.image.height; ++row)
    for (int column = 0; column < subject.image.width; ++column) {
      const Vec3 normal = subject.normal(column, row);
      if (normal.isZero()) continue;
      points.push_back(subject.place(column, row)), normals.push_back(normal);
    }
  return fit::recover_superellipsoid(points, context, normals);
}

/// The goodness of fits by equation (6) as published, straight and tapered, as cells of a table. From one start (6)
/// ends in one of several minima: the best of some selections of the points counts.
std::vector<std::string> published_cells(const PaperSubject& subject) {
  constexpr std::size_t selections = 6;
  const auto all = subject.points();
  const std::size_t stride = std::max(selections, all.size() / 1000);
  std::vector<std::string> cells;
  for (const bool taper : {false, true}) {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < selections; ++k) {
      std::vector<Vec3> points;
      for (std::size_t i = k * stride / selections; i < all.size(); i += stride) points.push_back(all[i]);
      if (const auto fit = fit::published_superellipsoid(points, {.taper = taper})) best = std::min(best, fit->gof);
    }
    cells.push_back(readable(best));
  }
  return cells;
}

/// Equation (5) in its two angles: latitude from pole to pole, longitude around.
TriangleMesh mesh_of_fit(const fit::SuperellipsoidFit& fit) {
  constexpr std::uint32_t rows = 60, columns = 120;
  const auto& s = fit.shape;
  const auto power = [](double x, double e) { return std::copysign(std::pow(std::abs(x), e), x); };
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= rows; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const double eta = pi * (double(i) / rows - 0.5), omega = 2 * pi * double(j) / columns;
      const double z = power(std::sin(eta), s.e1), ring = power(std::cos(eta), s.e1);
      mesh.vertices.push_back(fit.scan_from_shape *
                              Vec3(s.a1 * ring * power(std::cos(omega), s.e2) * (1 + s.taper_x * z),
                                   s.a2 * ring * power(std::sin(omega), s.e2) * (1 + s.taper_y * z), s.a3 * z));
      if (i == rows) continue;
      const std::uint32_t a = i * columns + j, b = i * columns + (j + 1) % columns;
      mesh.triangles.push_back({a, b, b + columns});
      mesh.triangles.push_back({a, b + columns, a + columns});
    }
  return mesh;
}

/// A primitive of table 1 and what the paper prints for it.
struct Primitive {
  std::string name, printed;
  model::Shape shape;
};

std::vector<Primitive> primitives() {
  using namespace model;
  HalfSpaces planes;
  const std::array<std::array<double, 4>, 7> cut = {{{1, 0, 0, 20},
                                                     {-1, 0, 0, 20},
                                                     {0, 1, 0, 15},
                                                     {0, -1, 0, 15},
                                                     {0, 0, 1, 24},
                                                     {0, 0, -1, 0},
                                                     {2.0 / 3, 1.0 / 3, 2.0 / 3, 24}}};
  for (const auto& [x, y, z, offset] : cut) planes.planes.push_back({x, y, z, offset, {}});
  return {{"sphere", "e1 = e2 = 1", Sphere{18}},
          {"ellipsoid", "e1 = e2 = 1", Ellipsoid{24, 16, 11}},
          {"parallelepiped", "e1 << 1, e2 << 1", Box{40, 28, 18}},
          {"cylinder", "e1 << 1, e2 = 1 (as equation 5 has it)", Cylinder{11, 44}},
          {"cone", "cylinder and tapering", Cone{16, 6, 38}},
          {"torus", "-", Torus{22, 7}},
          {"wedge", "parallelepiped and tapering", Wedge{44, 26, 24, 12}},
          {"fillet", "-", Fillet{14, 12, 40}},
          {"half-spaces", "-", planes}};
}

}  // namespace

PaperFigure triangulations_figure(const PaperSubjects& subjects, Context& context) {
  PaperFigure figure;
  figure.title = "Figure 7: triangulations";
  figure.text =
      "Points are inserted from the centre of gravity outwards, coarse before fine, where the surface is "
      "farther than the tolerance along its normal, and taken out again where the triangles around them say "
      "as much without them. The counts of the paper (724 and 1260) belong to images that are lost.";
  figure.table = {{"image", "tolerance, mm", "triangles", "points in the image", "largest distance, mm"}};
  for (const auto& [subject, tolerance] : {std::pair{&subjects.mask, 0.5}, std::pair{&subjects.hand, 0.4}}) {
    const auto result = fit::generalized_delaunay(lattice_of(*subject), {.tolerance = tolerance}, context);
    figure.table.push_back({subject->name, print_number(tolerance), std::to_string(result.mesh.triangles.size()),
                            std::to_string(subject->points().size()), two_decimals(result.max_distance)});
    figure.pictures.push_back({"figure-7-" + subject->file + ".png",
                               write_png(lit_mesh(result.mesh, {0.15, -0.1, 1}, {0, 1, 0}, 512, true)),
                               "the " + subject->name + " as triangles, small ones where it bends"});
  }
  return figure;
}

Result<PaperFigure> primitives_table(Context& context) {
  PaperFigure figure;
  figure.title = "Table 1: primitives and their superellipsoids";
  figure.text =
      "Each primitive was scanned from six sides with noise of 0.02 mm. Rows of the paper for cylinder and "
      "box have e1 and e2 exchanged against its equation (5), which counts here.";
  figure.table = {{"primitive", "printed", "e1", "e2", "tapering", "indicated", "procedure found at 0.1 mm"}};
  for (const auto& primitive : primitives()) {
    model::Model truth;
    truth.objects.push_back({"body", primitive.shape, {}, {}, {}});
    scan::SimulateOptions seen;
    seen.resolution = 96, seen.sigma = 0.02;
    scan::SimulatedScan simulated = scan::simulate(scan::surface_of(truth), seen, context);
    const auto built = fit::build_model(simulated.merged, {.tolerance = 0.1}, context);
    if (!built) return built.error();
    const model::Model& found = **built;
    if (!found.hypothesis) continue;
    figure.table.push_back(joined({primitive.name, primitive.printed},
                                  {cells_of(*found.hypothesis), {found.hypothesis->suggests, procedure_text(found)}}));
  }
  return figure;
}

PaperFigure superellipsoids_figure(const PaperSubjects& subjects, Context& context) {
  PaperFigure figure;
  figure.title = "Table 2 and figure 8: superellipsoids of the three images";
  figure.text =
      "The goodness of fit is the paper's, on data scaled to unit size (it is no length otherwise), and the "
      "mean radial distance in mm. The paper has 0.10, 1.08 and 0.06 for the pin, 0.15, 0.87 and 0.15 for "
      "the face, 0.10, 0.10 and 0.22 for the hand. The pin's good fit indicates a turned part, the "
      "bad ones of face and hand nothing: bounding surfaces describe them. The last columns are goodness by equation "
      "(6) as published, without tapering and with it, the best of six selections of the points.";
  figure.table = {
      {"image", "e1", "e2", "tapering", "goodness of fit", "mm", "indicated", "(6), straight", "(6), tapered"}};
  for (const PaperSubject* subject : {&subjects.pin, &subjects.mask, &subjects.hand}) {
    const auto fit = superellipsoid_of(*subject, context);
    const auto& h = fit.hypothesis;
    figure.table.push_back(
        joined({subject->name},
               {cells_of(h), {two_decimals(h.gof), two_decimals(h.gof_mm), h.suggests}, published_cells(*subject)}));
    figure.pictures.push_back({"figure-8-" + subject->file + ".png",
                               write_png(lit_mesh(mesh_of_fit(fit), {0.5, -0.4, 1}, {0, 1, 0}, 320, false)),
                               "the superellipsoid of the " + subject->name});
  }
  return figure;
}

PaperFigure characterization_figure(const PaperSubjects& subjects) {
  PaperFigure figure;
  figure.title = "Figure 9: characters of surfaces";
  figure.text =
      "Colours say the signs of mean and Gaussian curvature where they stand out from noise by three standard "
      "deviations: blue flat, red peak, green pit, orange ridge, violet valley, brown and pink saddles; dark "
      "is unknown. Patches of first and second order are grown from them; three control points for each "
      "patch along the line with most patches size the control mesh.";
  figure.table = {{"image", "patches", "most along a row", "most along a column", "control mesh"}};
  Sheet sheet(3 * 256, 256);
  int k = 0;
  for (const PaperSubject* subject : {&subjects.pin, &subjects.mask, &subjects.hand}) {
    const auto& characters = subject->characters;
    const Patches& patches = subject->patches;
    const int width = subject->image.width, height = subject->image.height;
    const PatchCounts counts = most_patches(patches.label, width, height);
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column) {
        const std::size_t i = subject->index(column, row);
        Color color{18, 20, 26};
        if (subject->filtered.kept[i])
          color = characters[i].kind == SurfaceClass::unknown ? Color{90, 96, 108}
                  : characters[i].kind == SurfaceClass::flat
                      ? series_color(0)
                      : series_color(
                            std::array<std::size_t, 9>{0, 0, 3, 2, 1, 4, 5, 6, 7}[std::size_t(characters[i].kind)]);
        sheet.pixel(256 * k + column, row, color);
      }
    const fit::NetSize net = fit::net_size(counts);
    figure.table.push_back({subject->name, std::to_string(patches.patches.size()), std::to_string(counts.along_row),
                            std::to_string(counts.along_column),
                            std::to_string(net.columns) + " x " + std::to_string(net.rows)});
    ++k;
  }
  figure.pictures = {{"figure-9.png", sheet.png(), "three maps in colours"}};
  return figure;
}

}  // namespace partscribe::cli
