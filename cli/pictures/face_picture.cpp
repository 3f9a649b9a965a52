#include "cli/pictures/face_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cli/measure/measured_part.h"
#include "cli/pictures/annotate.h"
#include "cli/pictures/color_scale.h"
#include "cli/pictures/raster_text.h"
#include "core/number.h"
#include "core/parallel.h"
#include "geometry/mesh/mesh_facets.h"

namespace partscribe::cli {
namespace {

constexpr int fine = 3;  // pixels are drawn three times finer, then averaged
constexpr int panel_width = 640, panel_height = 470, bar_height = 40;
constexpr double text_height = 9;  // px
constexpr double light = 0.5;      // share of it that shapes the colours: numbers stay readable
constexpr std::uint32_t nothing = no_face - 1;
constexpr Color left_over{92, 92, 98};

struct Side {
  const char* title;
  Vec3 to_eye;  // in the frame the part stands in
};

/// Each of the six sides of a box is seen twice.
const std::vector<Side>& sides() {
  static const std::vector<Side> all = {{"from the front, right and above", {0.75, -1, 0.7}},
                                        {"from the back, left and above", {-0.75, 1, 0.7}},
                                        {"from the front, left and below", {-0.75, -1, -0.7}},
                                        {"from the back, right and below", {0.75, 1, -0.7}}};
  return all;
}

/// Hue 0..1, the other two as shares.
Color from_hue(double hue, double saturation, double value) {
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + 6 * hue, 6.0);
    return static_cast<std::uint8_t>(255 * (value - value * saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0)) +
                                     0.5);
  };
  return {channel(5), channel(3), channel(1)};
}

/// What a person would set upright: the largest direction of faces, then the largest one square to it. Columns are the
/// part's x, y, z in the scan's frame; z is the one of the three that points most upward in the scan.
Mat3 standing(const Faces& faces) {
  struct Direction {
    Vec3 axis;
    double area;
  };
  std::vector<Direction> directions;
  constexpr double same = 0.999;
  for (const auto& face : faces.faces) {
    if (face.kind != FaceKind::plane && face.kind != FaceKind::cylinder) continue;
    const Vec3 axis = face.surface().axis;
    const auto known = std::find_if(directions.begin(), directions.end(),
                                    [&](const Direction& d) { return std::abs(d.axis.dot(axis)) > same; });
    if (known != directions.end())
      known->area += face.area;
    else
      directions.push_back({axis, face.area});
  }
  std::stable_sort(directions.begin(), directions.end(),
                   [](const Direction& a, const Direction& b) { return a.area > b.area; });
  if (directions.empty()) return Mat3::Identity();
  const Vec3 first = directions.front().axis;
  Vec3 second = Vec3::Zero();
  for (const auto& d : directions)
    if (second.isZero() && std::abs(d.axis.dot(first)) < 0.02) second = d.axis - d.axis.dot(first) * first;
  for (const Vec3& scan_axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY())})
    if (second.isZero() && std::abs(scan_axis.dot(first)) < 0.8) second = scan_axis - scan_axis.dot(first) * first;
  second.normalize();
  std::vector<Vec3> three = {first, second, first.cross(second)};
  const auto take = [&](const Vec3& like) {
    const auto best = std::max_element(three.begin(), three.end(), [&](const Vec3& a, const Vec3& b) {
      return std::abs(a.dot(like)) < std::abs(b.dot(like)) - 1e-6;
    });
    const Vec3 taken = best->dot(like) < 0 ? Vec3(-*best) : *best;
    three.erase(best);
    return taken;
  };
  Mat3 frame;
  frame.col(2) = take(Vec3::UnitZ());
  frame.col(0) = take(Vec3::UnitX());
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

/// A picture and which face each of its pixels shows.
struct Painted {
  Raster raster;
  Camera camera;
  std::vector<std::uint32_t> face_at;
};

Color color_of(const Faces& faces, std::uint32_t face) { return face == no_face ? left_over : face_color(faces, face); }

void paint_mesh(const Scan& scan, const Faces& faces, const std::vector<Vec3>& normals, Painted& painted) {
  draw_triangles(painted.raster, painted.camera, scan.mesh.vertices, scan.mesh.triangles,
                 [&](std::uint32_t t, const Vec3&, int column, int row) {
                   const std::uint32_t face = faces.face_of[t];
                   painted.face_at[static_cast<std::size_t>(row) * painted.raster.width + column] = face;
                   return shaded(color_of(faces, face), painted.camera, normals[t], light);
                 });
}

/// The points that are drawn, and their faces.
struct DrawnPoints {
  std::vector<Vec3> points;
  std::vector<Vec3> normals;  // outward; zero where that is not known
  std::vector<std::uint32_t> faces;
  std::vector<Vec3> framed;  // those of faces: strays far away would make the part small
  double area = 0;           // mm^2 that one stands for
};

/// Of its face, whose sense is known; of the point itself where its ray told the sense.
Vec3 normal_of(const PointCloud& cloud, const Faces& faces, std::size_t i) {
  const std::uint32_t f = faces.face_of[i];
  if (f == no_face || faces.faces[f].kind == FaceKind::free_form)
    return cloud.normals.empty() || cloud.rays.empty() ? Vec3(0, 0, 0) : cloud.normals[i];
  return outward_normal(faces.faces[f], cloud.points[i]);
}

DrawnPoints drawn_points(const Scan& scan, const Faces& faces) {
  const PointCloud& cloud = scan.cloud;
  DrawnPoints drawn;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.rejected.empty() && cloud.rejected[i]) continue;
    drawn.points.push_back(cloud.points[i]);
    drawn.normals.push_back(normal_of(cloud, faces, i));
    drawn.faces.push_back(faces.face_of[i]);
    if (faces.face_of[i] != no_face) drawn.framed.push_back(cloud.points[i]);
  }
  if (drawn.framed.empty()) drawn.framed = drawn.points;
  drawn.area = area_per_point(scan, faces);
  return drawn;
}

/// What is seen: no inner sides, which would shine through between the points before them, unless there is little else.
std::vector<std::uint32_t> facing(const DrawnPoints& drawn, const Camera& camera) {
  const Vec3 to_eye = camera.view_from_world.row(2);
  std::vector<std::uint32_t> seen, all;
  for (std::uint32_t i = 0; i < drawn.points.size(); ++i) {
    all.push_back(i);
    if (drawn.normals[i].isZero() || drawn.normals[i].dot(to_eye) > 0) seen.push_back(i);
  }
  constexpr std::size_t enough = 4;  // a quarter of the points: a part that was scanned from all sides shows half
  return seen.size() * enough > all.size() ? seen : all;
}

/// Drawn twice, the second time with numbers in place of colours.
void paint_points(const DrawnPoints& drawn, const Faces& faces, Painted& painted) {
  std::vector<Vec3> points;
  std::vector<Color> colors, numbers;
  for (const auto i : facing(drawn, painted.camera)) {
    points.push_back(drawn.points[i]);
    const Color color = color_of(faces, drawn.faces[i]);
    colors.push_back(drawn.normals[i].isZero() ? color : shaded(color, painted.camera, drawn.normals[i], light));
    const std::uint32_t n = drawn.faces[i] == no_face ? 1 : drawn.faces[i] + 2;
    numbers.push_back(
        {static_cast<std::uint8_t>(n >> 16), static_cast<std::uint8_t>(n >> 8), static_cast<std::uint8_t>(n)});
  }
  const double radius = std::clamp(0.9 * std::sqrt(drawn.area) * painted.camera.pixels_per_mm, 1.0, 7.0 * fine);
  draw_points(painted.raster, painted.camera, points, colors, radius);
  Raster told(painted.raster.width, painted.raster.height, {0, 0, 0});
  draw_points(told, painted.camera, points, numbers, radius);
  for (std::size_t k = 0; k < told.pixels.size(); ++k) {
    const auto& c = told.pixels[k];
    const std::uint32_t n = std::uint32_t(c.red) << 16 | std::uint32_t(c.green) << 8 | c.blue;
    painted.face_at[k] = n == 0 ? nothing : n == 1 ? no_face : n - 2;
  }
}

/// A dark line where two faces meet in the picture.
void draw_borders(Painted& painted) {
  const int width = painted.raster.width, height = painted.raster.height;
  for (int row = 0; row + 1 < height; ++row)
    for (int column = 0; column + 1 < width; ++column) {
      const std::size_t k = static_cast<std::size_t>(row) * width + column;
      for (const std::size_t other : {k + 1, k + width})
        if (painted.face_at[k] != painted.face_at[other])
          for (const std::size_t at : {k, other})
            if (painted.face_at[at] != nothing) painted.raster.pixels[at] = ink;
    }
}

/// Where in a picture a number may stand: in the middle of the widest place of its face.
struct Spot {
  double room = 0;  ///< px to the nearest border of the face
  Vec2 at = Vec2::Zero();
};

/// Which face each pixel of the reduced picture shows in its middle.
std::vector<std::uint32_t> reduced_faces(const Painted& painted) {
  const int width = painted.raster.width / fine, height = painted.raster.height / fine;
  std::vector<std::uint32_t> face_at;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column)
      face_at.push_back(painted.face_at[static_cast<std::size_t>(row * fine + fine / 2) * painted.raster.width +
                                        column * fine + fine / 2]);
  return face_at;
}

/// By face, in pixels of the reduced picture. Distances by two sweeps of the 3-4 chamfer mask [Borgefors 1986].
std::vector<Spot> spots_of(const Painted& painted, std::size_t faces) {
  const int width = painted.raster.width / fine, height = painted.raster.height / fine;
  const auto face_at = reduced_faces(painted);
  std::vector<int> room(face_at.size(), width + height);
  const auto relax = [&](int column, int row, int dx, int dy, int weight) {
    const int x = column + dx, y = row + dy;
    const std::size_t k = static_cast<std::size_t>(row) * width + column;
    const bool inside = x >= 0 && y >= 0 && x < width && y < height;
    const std::size_t other = inside ? static_cast<std::size_t>(y) * width + x : k;
    room[k] = std::min(room[k], inside && face_at[other] == face_at[k] ? room[other] + weight : weight);
  };
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      relax(column, row, -1, 0, 3), relax(column, row, 0, -1, 3);
      relax(column, row, -1, -1, 4), relax(column, row, 1, -1, 4);
    }
  for (int row = height - 1; row >= 0; --row)
    for (int column = width - 1; column >= 0; --column) {
      relax(column, row, 1, 0, 3), relax(column, row, 0, 1, 3);
      relax(column, row, 1, 1, 4), relax(column, row, -1, 1, 4);
    }
  std::vector<Spot> spots(faces);
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const std::size_t k = static_cast<std::size_t>(row) * width + column;
      if (face_at[k] >= faces) continue;
      const double here = room[k] / 3.0;
      if (here > spots[face_at[k]].room) spots[face_at[k]] = {here, Vec2(column + 0.5, row + 0.5)};
    }
  return spots;
}

struct LabelBox {
  double left, top, right, bottom;
  bool meets(const LabelBox& o) const { return left < o.right && o.left < right && top < o.bottom && o.top < bottom; }
};

LabelBox box_around(const Vec2& middle, const std::string& text) {
  const double half = text_width(text, text_height) / 2 + 3, up = text_height / 2 + 3;
  return {middle.x() - half, middle.y() - up, middle.x() + half, middle.y() + up};
}

/// Beside its face, with a line to it: the first free place, outward ones before others. False if there is none.
bool draw_beside(Raster& panel, const Spot& spot, const std::string& text, std::vector<LabelBox>& taken) {
  Vec2 outward = spot.at - Vec2(0.5 * panel.width, 0.5 * panel.height);
  if (!(outward.norm() > 0)) outward = Vec2(1, 0);
  const double first = std::atan2(outward.y(), outward.x());
  for (const double reach : {16.0, 26.0, 38.0, 54.0, 72.0})
    for (const int step : {0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6}) {
      const double angle = first + step * pi / 6;
      const Vec2 middle = spot.at + reach * Vec2(std::cos(angle), std::sin(angle));
      const LabelBox box = box_around(middle, text);
      const bool inside = box.left > 2 && box.top > 24 && box.right < panel.width - 2 && box.bottom < panel.height - 2;
      if (!inside || std::any_of(taken.begin(), taken.end(), [&](const LabelBox& o) { return o.meets(box); })) continue;
      draw_stroke(panel, spot.at, middle, 1.2, ink);
      fill_box(panel, static_cast<int>(spot.at.x()) - 1, static_cast<int>(spot.at.y()) - 1, 3, 3, ink);
      fill_box(panel, static_cast<int>(box.left) + 1, static_cast<int>(box.top) + 1,
               static_cast<int>(box.right - box.left) - 2, static_cast<int>(box.bottom - box.top) - 2, paper);
      draw_text(panel, middle.x(), middle.y() + text_height / 2, text_height, text, ink, TextAlign::middle);
      taken.push_back(box);
      return true;
    }
  return false;
}

/// Numbers inside the faces that have room for them, beside those that are seen nowhere better.
void draw_numbers(Raster& panel, const std::vector<Spot>& spots, const std::vector<std::size_t>& best_side,
                  std::size_t side) {
  constexpr std::size_t most_beside = 80;
  std::vector<LabelBox> taken;
  std::vector<std::size_t> beside;
  for (std::size_t f = 0; f < spots.size(); ++f) {
    const Spot& spot = spots[f];
    const std::string text = std::to_string(face_number(f));
    const double needed = Vec2(text_width(text, text_height), text_height).norm() / 2 + 1;
    if (spot.room >= needed) {
      draw_text(panel, spot.at.x(), spot.at.y() + text_height / 2, text_height, text, ink, TextAlign::middle);
      taken.push_back(box_around(spot.at, text));
    } else if (best_side[f] == side && spot.room > 0) {
      beside.push_back(f);
    }
  }
  std::size_t drawn = 0;
  for (const auto f : beside)
    if (drawn < most_beside) drawn += draw_beside(panel, spots[f], std::to_string(face_number(f)), taken);
}

void copy_panel(const Raster& panel, int left, int top, Raster& picture) {
  for (int row = 0; row < panel.height; ++row)
    std::copy_n(panel.pixels.begin() + static_cast<std::ptrdiff_t>(row) * panel.width, panel.width,
                picture.pixels.begin() + static_cast<std::ptrdiff_t>(top + row) * picture.width + left);
}

}  // namespace

Color face_color(const Faces& faces, std::size_t face) {
  if (faces.faces[face].kind == FaceKind::free_form) return {178, 176, 170};
  // Steps of the golden section: neighbours in number, and any few faces, get hues far apart.
  const double hue = std::fmod(0.58 + 0.61803398875 * static_cast<double>(face), 1.0);
  return from_hue(hue, face % 3 == 1 ? 0.26 : 0.42, face % 2 == 1 ? 0.92 : 1);
}

Raster draw_faces(const Scan& scan, const Faces& faces, Context& context) {
  const Mat3 frame = standing(faces);
  const auto normals = faces.of_mesh ? triangle_normals(scan.mesh) : std::vector<Vec3>();
  const DrawnPoints drawn = faces.of_mesh ? DrawnPoints() : drawn_points(scan, faces);
  std::vector<Raster> panels(sides().size(), Raster(panel_width, panel_height, paper));
  std::vector<Camera> cameras(sides().size());
  std::vector<std::vector<Spot>> spots(sides().size());
  const auto paint = [&](std::size_t s) {
    Painted painted{Raster(panel_width * fine, panel_height * fine, paper), {}, {}};
    painted.face_at.assign(painted.raster.pixels.size(), nothing);
    painted.camera = camera_for(faces.of_mesh ? scan.mesh.vertices : drawn.framed, frame * sides()[s].to_eye,
                                frame.col(2), painted.raster.width, painted.raster.height - bar_height * fine);
    if (faces.of_mesh) {
      paint_mesh(scan, faces, normals, painted);
      draw_borders(painted);
    } else {
      paint_points(drawn, faces, painted);
    }
    spots[s] = spots_of(painted, faces.faces.size());
    panels[s] = reduced(painted.raster, fine);
    cameras[s] = painted.camera;
    cameras[s].pixels_per_mm /= fine;
  };
  parallel_for(
      sides().size(), context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) paint(s);
      },
      1);
  std::vector<std::size_t> best_side(faces.faces.size(), 0);
  for (std::size_t f = 0; f < faces.faces.size(); ++f)
    for (std::size_t s = 1; s < sides().size(); ++s)
      if (spots[s][f].room > spots[best_side[f]][f].room) best_side[f] = s;
  constexpr int columns = 2;
  Raster picture(columns * panel_width, static_cast<int>(sides().size()) / columns * panel_height, paper);
  for (std::size_t s = 0; s < sides().size(); ++s) {
    draw_numbers(panels[s], spots[s], best_side, s);
    annotate(panels[s], cameras[s], sides()[s].title);
    const int place = static_cast<int>(s);
    copy_panel(panels[s], place % columns * panel_width, place / columns * panel_height, picture);
  }
  return picture;
}

}  // namespace partscribe::cli
