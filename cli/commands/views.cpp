#include "cli/commands/views.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/describe.h"
#include "cli/inputs.h"
#include "core/json_text.h"
#include "core/number.h"
#include "scan/register/fiducials.h"

namespace partscribe::cli {
namespace {

using Json = nlohmann::ordered_json;

const char* word_of(ViewStatus status) {
  return status == ViewStatus::reference ? "reference" : status == ViewStatus::registered ? "registered" : "refused";
}

Json numbers(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json rows_of(const Pose& pose) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r)
    rows.push_back({pose.rotation(r, 0), pose.rotation(r, 1), pose.rotation(r, 2), pose.translation[r]});
  rows.push_back({0, 0, 0, 1});
  return rows;
}

template <int size>
Json rows_of(const Eigen::Matrix<double, size, size>& m) {
  Json rows = Json::array();
  for (int r = 0; r < size; ++r) {
    Json row = Json::array();
    for (int c = 0; c < size; ++c) row.push_back(m(r, c));
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The lower triangle, seven digits of each number.
Json triangle_of(const Eigen::MatrixXd& m) {
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < m.rows(); ++r) {
    Json row = Json::array();
    for (Eigen::Index c = 0; c <= r; ++c) {
      const double size = std::abs(m(r, c));
      row.push_back(size > 0 ? snapped(m(r, c), 1e-6 * power_of_ten_below(size)) : 0.0);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string in_degrees(double angle) { return print_number(snapped(angle * 180 / pi, 1e-3)) + " degrees"; }

std::string listed_degrees(const std::vector<double>& angles) {
  std::string text;
  for (const double a : angles) text += (text.empty() ? "" : ", ") + print_number(snapped(a * 180 / pi, 1e-2));
  return text + " degrees";
}

void say(const Registration& registration, const Scan& scan, Session& session) {
  for (const auto& warning : registration.warnings) session.warn(warning);
  // A verdict within T needs poses four times as sure.
  if (session.options.tolerance)
    for (std::size_t v = 0; v < registration.views.size(); ++v) {
      const double sigma = std::sqrt(registration.views[v].covariance.bottomRightCorner<3, 3>().diagonal().maxCoeff());
      if (registration.views[v].status == ViewStatus::registered && sigma > 0.25 * *session.options.tolerance)
        session.warn("view " + std::to_string(v) + " (" + scan.views[v].file + ") is placed to " + readable(sigma) +
                     " mm only; within " + readable(*session.options.tolerance) + " mm that may not be enough");
    }
  if (const auto& table = registration.turntable)
    session.print("Turntable: axis (" + readable(table->axis.x()) + ", " + readable(table->axis.y()) + ", " +
                  readable(table->axis.z()) + ") through (" + readable(table->point.x()) + ", " +
                  readable(table->point.y()) + ", " + readable(table->point.z()) + "), " +
                  (table->steps.empty() ? "step " + in_degrees(table->step) : "steps " + listed_degrees(table->steps)) +
                  (table->step_observed ? "" : ", as for a full turn: the part is round") + "\n");
}

Result<Registration> registration_of(const Scan& scan, const std::vector<RangeImage>& images,
                                     const PoseArguments& poses, Session& session) {
  if (scan.views.size() < 2)
    return usage_error("--poses " + poses.poses + ": expected several views to bring together, found one");
  RegisterOptions options;
  options.arrangement = poses.poses == "none"        ? Arrangement::unknown
                        : poses.poses == "turntable" ? Arrangement::turntable
                                                     : Arrangement::guessed;
  options.correct_depth = poses.correct_depth;
  options.method = poses.method == "paper"             ? PairMethod::paper
                   : poses.method == "paper-triangles" ? PairMethod::paper_triangles
                                                       : PairMethod::symmetric;
  return register_views(views_to_register(scan, images, session.context), options, session.context);
}

/// Where reference points put the views.
Result<Registration> by_fiducials(const Path& file, const Scan& scan) {
  const auto text = read_file(file);
  if (!text) return text.error();
  const auto fiducials = parse_fiducials(*text, scan.views, scan.unit_scale);
  if (!fiducials) return bad_input(file.string() + ": " + fiducials.error().message);
  auto registration = register_by_fiducials(views_of(scan), *fiducials);
  if (!registration) return bad_input(file.string() + ": " + registration.error().message);
  return registration;
}

/// The scan as if it had been read with these guesses; views without one lose their points.
void begin_at(const Registration& start, Scan& scan, std::vector<RangeImage>& images) {
  place_views(start, scan);
  scan.pose_covariance = {};
  for (std::size_t v = 0; v < images.size(); ++v) images[v].world_from_view = scan.views[v].world_from_view;
}

/// Some view must have been brought to the first.
Result<Registration> together(Result<Registration> registration, const Scan& scan, Session& session) {
  if (!registration) return registration;
  const auto placed = [](const RegisteredView& v) { return v.status == ViewStatus::registered; };
  if (std::none_of(registration->views.begin(), registration->views.end(), placed)) {
    for (const auto& warning : registration->warnings) session.warn(warning);
    std::string why;
    for (const auto& v : registration->views)
      if (v.status == ViewStatus::refused && why.empty()) why = v.reason;
    return bad_input(scan.files.front() + ": expected views that can be brought together, found none: " + why);
  }
  return registration;
}

}  // namespace

void declare(PoseArguments& poses, Arguments& arguments) {
  arguments.choice(
      poses.poses, "--poses", {"given", "guess", "none", "turntable"},
      "where the views stood: as the files say; roughly so; unknown; turned about one axis in their order");
  arguments.flag(poses.correct_depth, "--correct-depth",
                 "turntable: make depths fit widths where a round part shows that they do not");
  arguments.choice(
      poses.method, "--registration", {"symmetric", "paper", "paper-triangles"},
      "how views are brought together: all at once; or one after the other as published in 1993, by planar "
      "patches or, of free form, by triangles");
  arguments.path(poses.fiducials, "--fiducials", "FILE",
                 "reference points that several views show, rows of view file, name, x, y, z: they give the poses, or "
                 "with --poses guess where registration begins");
}

Result<PlacedViews> read_views(const std::vector<Path>& inputs, const PoseArguments& poses, Points points,
                               Session& session, RltsForm form) {
  if (poses.correct_depth && poses.poses != "turntable")
    return usage_error(
        "--correct-depth: expected --poses turntable, whose round part shows what is wrong with depths, found "
        "--poses " +
        poses.poses);
  if (!poses.fiducials.empty() && poses.poses != "given" && poses.poses != "guess")
    return usage_error("--fiducials: expected no --poses, or --poses guess to go on from there, found --poses " +
                       poses.poses);
  ReadOptions options;
  options.initial_guess = poses.poses == "guess" && poses.fiducials.empty();
  std::vector<RangeImage> images;
  auto read = read_scans(inputs, session, options, &images);
  if (!read) return read.error();
  PlacedViews placed;
  placed.scan = std::move(*read);
  // Registration filters for itself: it wants the places as measured as well.
  if (poses.poses != "given" || !poses.fiducials.empty())
    if (auto ok = session.stage("register"); !ok) return ok.error();
  if (!poses.fiducials.empty()) {
    auto start = together(by_fiducials(poses.fiducials, placed.scan), placed.scan, session);
    if (!start) return start.error();
    say(*start, placed.scan, session);
    if (poses.poses == "given")
      placed.registration = std::move(*start);
    else
      begin_at(*start, placed.scan, images);
  }
  if (poses.poses != "given") {
    auto registration = together(registration_of(placed.scan, images, poses, session), placed.scan, session);
    if (!registration) return registration.error();
    say(*registration, placed.scan, session);
    placed.registration = std::move(*registration);
  }
  const bool any_image = std::any_of(images.begin(), images.end(), [](const RangeImage& i) { return i.width > 0; });
  if (points != Points::measured && any_image) {
    if (auto ok = session.stage("filter"); !ok) return ok.error();
    placed.filter = points == Points::filtered ? filter_views(placed.scan, images, session.context)
                                               : flag_outliers(placed.scan, images, form, session.context);
  }
  if (placed.registration) place_views(*placed.registration, placed.scan);
  return placed;
}

std::string poses_json(const PlacedViews& placed, const std::string& cloud_sha256) {
  Json json;
  json["views"] = Json::array();
  for (std::size_t v = 0; v < placed.scan.views.size(); ++v) {
    const View& view = placed.scan.views[v];
    Json row;
    row["file"] = view.file;
    row["world_from_view"] = rows_of(view.world_from_view);
    if (placed.registration) {
      const RegisteredView& r = placed.registration->views[v];
      row["covariance"] = rows_of(r.covariance);
      row["overlap"] = r.overlap, row["residual_median"] = r.residual_median, row["seen_through"] = r.seen_through;
      row["status"] = word_of(r.status);
      if (!r.reason.empty()) row["reason"] = r.reason;
    } else {
      row["status"] = "given";
    }
    json["views"].push_back(row);
  }
  if (const auto& r = placed.registration) {
    json["center"] = numbers(r->center);
    json["cloud_sha256"] = cloud_sha256;
    json["covariance_between_views"] = triangle_of(r->covariance);
    json["worst_gap"] = r->worst_gap;
    json["free_motions"] = Json::array();
    for (const auto& free : r->free_motions) json["free_motions"].push_back(free.words);
    json["alike"] = Json::array();
    for (const auto& places : r->alike) json["alike"].push_back(places.words);
    if (r->turntable) {
      json["turntable"] = {{"axis", numbers(r->turntable->axis)},
                           {"point", numbers(r->turntable->point)},
                           {"step_deg", r->turntable->step * 180 / pi},
                           {"step_observed", r->turntable->step_observed}};
      for (const double step : r->turntable->steps) json["turntable"]["steps_deg"].push_back(step * 180 / pi);
    }
    if (r->depth)
      json["depth_correction"] = {{"linear", rows_of(r->depth->linear)},
                                  {"center", numbers(r->depth->center)},
                                  {"stretch", r->depth->stretch},
                                  {"stretch_sigma", r->depth->stretch_sigma},
                                  {"shear", r->depth->shear},
                                  {"shear_sigma", r->depth->shear_sigma}};
  }
  return json_text(json);
}

}  // namespace partscribe::cli
