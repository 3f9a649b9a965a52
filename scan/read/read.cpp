/// Finds out what each input is, reads it, and joins all pieces in one frame and one unit.
#include "scan/read/read.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "geometry/io/read_geometry.h"
#include "geometry/mesh/mesh_facets.h"
#include "geometry/points/place.h"
#include "scan/read/range_file.h"
#include "scan/read/sources.h"

namespace partscribe::scan {
namespace {

std::string lower_case(std::string text) {
  for (auto& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// Three significant digits are enough for a warning; of a number so small that it has none left, none.
std::string rough(double value) {
  const double step = value == 0 ? 0 : power_of_ten_below(std::abs(value)) / 100;
  return print_number(step > 1e-300 ? snapped(value, step) : 0);
}

bool near_multiple(double value, double step, double tolerance) {
  return std::abs(value - step * std::round(value / step)) < tolerance;
}

/// Only meshes carry the sizes that a designer chose; only what is unlikely by chance counts as evidence.
bool looks_like_inches(const Vec3& size) {
  bool metric = true, sixteenths = true, metric_in_mm = true;
  for (int k = 0; k < 3; ++k) {
    if (!(size[k] > 0.1 && size[k] < 40)) return false;
    sixteenths = sixteenths && near_multiple(size[k], 1.0 / 16, 1e-5);
    metric = metric && near_multiple(size[k], 0.1, 1e-5);
    metric_in_mm = metric_in_mm && near_multiple(size[k] * 25.4, 0.5, 1e-3);
  }
  return !metric && (sixteenths || metric_in_mm);
}

void warn_of_unit(const Scan& scan, bool known, std::vector<std::string>& warnings) {
  const Vec3 size = scan.cloud.bounds().size();
  const double largest = size.maxCoeff();
  const auto millimetres = rough(largest) + " mm";
  constexpr double few = 5;  // mm; fewer parts are that small than are drawn in inches
  if (!known && largest < 1.0)
    warnings.push_back("the whole part would be only " + millimetres +
                       " large; if its numbers are metres, say --units m");
  else if (largest > 10'000)
    warnings.push_back("the whole scan is " + rough(largest / 1000) +
                       " m large; if that is wrong, say --units mm, cm, m or inch");
  else if (!known && !scan.mesh.empty() && looks_like_inches(size))
    warnings.push_back("the sizes " + rough(size.x()) + " x " + rough(size.y()) + " x " + rough(size.z()) +
                       " are round in inches and not in mm; inches? --units inch");
  else if (!known && largest < few)
    warnings.push_back("the whole part would be only " + millimetres + " large; inches? --units inch");
}

/// Appends a column that only some pieces have; the others get `missing`.
template <class T>
void append(std::vector<T>& to, const std::vector<T>& from, std::size_t before, std::size_t count, const T& missing) {
  if (to.empty() && from.empty()) return;
  to.resize(before, missing);
  if (from.empty())
    to.resize(before + count, missing);
  else
    to.insert(to.end(), from.begin(), from.end());
}

void append_mesh(TriangleMesh& to, const TriangleMesh& from) {
  const auto first = static_cast<std::uint32_t>(to.vertices.size());
  to.vertices.insert(to.vertices.end(), from.vertices.begin(), from.vertices.end());
  for (const auto& t : from.triangles) to.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

void scale(Piece& piece, double factor) {
  if (factor == 1) return;
  for (auto& p : piece.cloud.points) p *= factor;
  for (auto& p : piece.mesh.vertices) p *= factor;
  for (auto& s : piece.cloud.sigma) s = static_cast<float>(s * factor);
  piece.view.world_from_view.translation *= factor;
  RangeImage& image = piece.image;
  for (double* length : {&image.z0, &image.q, &image.x0, &image.y0, &image.pitch_x, &image.pitch_y}) *length *= factor;
  image.world_from_view.translation *= factor;
}

Result<Scan> joined(Pieces&& source, const ReadOptions& options, std::vector<RangeImage>* images) {
  Scan scan;
  scan.files = std::move(source.files);
  scan.sha256 = std::move(source.sha256);
  scan.warnings = std::move(source.warnings);
  bool known = true, several_units = false, all_meshes = true, any_mesh = false, all_sigma = true;
  for (const auto& piece : source.pieces) {
    all_meshes = all_meshes && !piece.mesh.empty(), any_mesh = any_mesh || !piece.mesh.empty();
    all_sigma = all_sigma && !piece.cloud.sigma.empty();
  }
  if (any_mesh && !all_meshes) scan.warnings.push_back("meshes and points are mixed; the meshes count as points");
  auto& cloud = scan.cloud;
  for (std::size_t i = 0; i < source.pieces.size(); ++i) {
    auto& piece = source.pieces[i];
    double factor = 1;
    if (options.unit) {
      factor = options.unit->millimetres;
    } else if (!piece.unit.empty()) {
      const auto unit = parse_unit(piece.unit);
      if (!unit)
        return bad_input(piece.view.file + ": expected the unit um, mm, cm, m, inch or foot, found '" + piece.unit +
                         "'");
      factor = unit->millimetres;
    } else {
      known = false;
    }
    if (i == 0) scan.unit_scale = factor;
    several_units = several_units || factor != scan.unit_scale;
    scale(piece, factor);
    if (all_meshes) append_mesh(scan.mesh, piece.mesh);
    const auto before = cloud.size(), count = piece.cloud.size();
    const auto first_view = static_cast<std::int32_t>(scan.views.size());
    append(cloud.normals, piece.cloud.normals, before, count, Vec3(0, 0, 0));
    append(cloud.rays, piece.cloud.rays, before, count, Vec3(0, 0, 0));
    if (all_sigma) append(cloud.sigma, piece.cloud.sigma, before, count, 0.0f);
    append(cloud.pixel, piece.cloud.pixel, before, count, std::int32_t(-1));
    append(cloud.rejected, piece.cloud.rejected, before, count, std::uint8_t(0));
    // A cloud that was merged before brings its own numbers of views.
    std::int32_t last = 0;
    for (auto& v : piece.cloud.view) last = std::max(last, v);
    constexpr std::int32_t most_views = 100'000;
    if (last >= most_views)
      return bad_input(piece.view.file + ": expected view numbers below " + std::to_string(most_views) + ", found " +
                       std::to_string(last));
    if (piece.cloud.view.empty()) piece.cloud.view.assign(count, 0);
    for (const auto v : piece.cloud.view) cloud.view.push_back(v < 0 ? -1 : first_view + v);
    scan.views.insert(scan.views.end(), static_cast<std::size_t>(last) + 1, piece.view);
    if (source.pieces.size() == 1 && factor == 1 && piece.pose_covariance.matrix.rows() >= 6 * (last + 1))
      scan.pose_covariance = std::move(piece.pose_covariance);
    if (images) {
      images->resize(scan.views.size());
      if (last == 0) images->back() = std::move(piece.image);
    }
    cloud.points.insert(cloud.points.end(), piece.cloud.points.begin(), piece.cloud.points.end());
    piece = {};
  }
  if (cloud.empty()) return bad_input(scan.files.front() + ": expected points, found not one return in all images");
  if (!std::all_of(cloud.points.begin(), cloud.points.end(), is_place))
    return bad_input(scan.files.front() + ": expected coordinates below " + print_number(farthest_place) +
                     " mm, found larger ones, or a unit or pose that makes them so");
  if (several_units) scan.warnings.push_back("the files state different units; each was converted by its own");
  if (!options.unit) warn_of_unit(scan, known, scan.warnings);
  return scan;
}

/// Turns facets that face the other way than their neighbours; one line says how many, and how many have no area.
void mend_facets(const RawGeometry& raw, TriangleMesh& mesh, const std::string& name,
                 std::vector<std::string>& warnings) {
  const std::size_t flat = raw.collapsed + (raw.mesh.triangles.size() - mesh.triangles.size()) + flat_facets(mesh);
  const std::size_t turned = topology(mesh).inconsistent_edges > 0 ? orient_facets(mesh) : 0;
  if (turned + flat > 0) {
    std::string line = name + ": of " + std::to_string(raw.mesh.triangles.size() + raw.collapsed) + " facets ";
    if (turned)
      line += std::to_string(turned) + (turned == 1 ? " faces" : " face") + " the wrong way and " +
              (turned == 1 ? "was" : "were") + " turned";
    if (flat) line += (turned ? ", " : "") + std::to_string(flat) + (flat == 1 ? " has" : " have") + " no area";
    warnings.push_back(line);
  }
  if (turn_outward(mesh)) warnings.push_back(name + ": its triangles face inward; they were turned");
}

std::optional<Error> add_input(const Path& input, const ReadOptions& options, Context& context, Pieces& pieces) {
  std::error_code failure;
  if (std::filesystem::is_directory(input, failure)) {
    if (std::filesystem::is_regular_file(input / "scan.json", failure))
      return add_scan_json(input / "scan.json", options, context, pieces);
    std::vector<Path> confs;
    for (const auto& entry : std::filesystem::directory_iterator(input, failure))
      if (entry.path().extension() == ".conf") confs.push_back(entry.path());
    if (confs.size() == 1) return add_conf(confs.front(), context, pieces);
    return bad_input(input.string() + ": expected scan.json in this folder, found none; name the files instead");
  }
  const auto suffix = lower_case(input.extension().string());
  if (suffix == ".json") return add_scan_json(input, options, context, pieces);
  if (suffix == ".conf") return add_conf(input, context, pieces);
  if (is_range_file(suffix)) return add_image_with_sidecar(input, options, pieces);
  if (auto error = add_geometry(input, {}, false, "", context, pieces)) return error;
  add_pose_covariance(input, pieces);
  return {};
}

}  // namespace

std::optional<Unit> parse_unit(const std::string& name) {
  static const std::pair<const char*, Unit> names[] = {{"mm", {"mm", 1}},
                                                       {"millimeter", {"mm", 1}},
                                                       {"millimetre", {"mm", 1}},
                                                       {"cm", {"cm", 10}},
                                                       {"centimeter", {"cm", 10}},
                                                       {"centimetre", {"cm", 10}},
                                                       {"m", {"m", 1000}},
                                                       {"meter", {"m", 1000}},
                                                       {"metre", {"m", 1000}},
                                                       {"in", {"inch", 25.4}},
                                                       {"inch", {"inch", 25.4}},
                                                       {"inche", {"inch", 25.4}},
                                                       {"ft", {"foot", 304.8}},
                                                       {"foot", {"foot", 304.8}},
                                                       {"feet", {"foot", 304.8}},
                                                       {"um", {"um", 0.001}},
                                                       {"micron", {"um", 0.001}},
                                                       {"micrometer", {"um", 0.001}},
                                                       {"micrometre", {"um", 0.001}},
                                                       {"\"", {"inch", 25.4}}};
  auto wanted = lower_case(name);
  if (wanted.size() > 3 && wanted.back() == 's') wanted.pop_back();
  for (const auto& [text, unit] : names)
    if (wanted == text) return unit;
  return {};
}

Result<std::string> read_source(const Path& path, Pieces& pieces) {
  auto bytes = read_file(path);
  if (!bytes.ok()) return bytes;
  pieces.files.push_back(path.filename().string());
  pieces.sha256.push_back(sha256(*bytes));
  return bytes;
}

std::optional<Error> add_geometry(const Path& path, const Pose& pose, bool sensor_at_origin, const std::string& unit,
                                  Context& context, Pieces& pieces) {
  const auto name = path.filename().string();
  context.report("reading " + name, 0);
  const auto bytes = read_source(path, pieces);
  if (!bytes.ok()) return bytes.error();
  auto raw = parse_geometry(*bytes, name);
  if (!raw.ok()) return raw.error();
  if (context.cancelled) return Error{"cancelled while reading " + name, ErrorKind::stopped};
  pieces.warnings.insert(pieces.warnings.end(), raw->warnings.begin(), raw->warnings.end());
  Piece piece;
  piece.view.file = name;
  piece.view.world_from_view = pose;
  piece.view.has_sensor = sensor_at_origin;
  piece.view.width = raw->width, piece.view.height = raw->height;
  piece.unit = !unit.empty() ? unit : raw->unit;
  if (!raw->mesh.empty()) {
    auto mesh = welded(raw->mesh, 0);
    if (mesh.vertices.size() * 2 < raw->cloud.size() && raw->format == "PLY" &&
        mesh.triangles.size() * 6 < raw->cloud.size())
      pieces.warnings.push_back(name + ": most of its points belong to no face and are left out");
    if (mesh.triangles.empty()) return bad_input(name + ": expected triangles, found only collapsed ones");
    mend_facets(*raw, mesh, name, pieces.warnings);
    piece.mesh = transformed(mesh, pose);
    piece.cloud.points = piece.mesh.vertices;
    piece.cloud.normals = vertex_normals(piece.mesh);
    const auto samples = sample_coarse_mesh(piece.mesh);
    piece.cloud.points.insert(piece.cloud.points.end(), samples.points.begin(), samples.points.end());
    piece.cloud.normals.insert(piece.cloud.normals.end(), samples.normals.begin(), samples.normals.end());
  } else {
    piece.cloud = std::move(raw->cloud);
    if (sensor_at_origin && piece.cloud.rays.empty())
      for (const auto& p : piece.cloud.points)
        piece.cloud.rays.push_back(p.norm() > 0 ? Vec3(p.normalized()) : Vec3(0, 0, 1));
    for (auto& p : piece.cloud.points) p = pose * p;
    for (auto& n : piece.cloud.normals) n = pose.rotation * n;
    for (auto& r : piece.cloud.rays) r = pose.rotation * r;
  }
  pieces.pieces.push_back(std::move(piece));
  return {};
}

PointCloud cloud_of(const RangeImage& image) {
  PointCloud cloud;
  const bool pinhole = image.projection == Projection::pinhole;
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      const auto p = view_point(image, row, column);
      if (!p) continue;
      const Vec3 ray = pinhole && p->norm() > 0 ? Vec3(p->normalized()) : Vec3(0, 0, 1);
      cloud.points.push_back(image.world_from_view * *p);
      cloud.rays.push_back(image.world_from_view.rotation * ray);
      cloud.pixel.push_back(row * image.width + column);
    }
  return cloud;
}

void add_range_image(const RangeImage& image, const std::string& file, const std::string& unit, Pieces& pieces) {
  Piece piece;
  piece.view = {file, image.world_from_view, image.projection == Projection::pinhole, image.width, image.height};
  piece.unit = unit;
  piece.cloud = cloud_of(image);
  piece.image = image;
  if (piece.cloud.empty()) pieces.warnings.push_back(file + ": not one of its pixels has a return");
  pieces.pieces.push_back(std::move(piece));
}

Result<Scan> read_scan(const std::vector<Path>& inputs, const ReadOptions& options, Context& context,
                       std::vector<RangeImage>* images) {
  if (inputs.empty()) return usage_error("expected a file or folder to read, found none");
  Pieces pieces;
  for (const auto& input : inputs) {
    if (auto error = add_input(input, options, context, pieces)) return *error;
    if (context.cancelled) return Error{"cancelled while reading", ErrorKind::stopped};
  }
  if (images) images->clear();
  return joined(std::move(pieces), options, images);
}

}  // namespace partscribe::scan
