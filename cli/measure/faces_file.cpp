#include "cli/measure/faces_file.h"

#include <nlohmann/json.hpp>

#include "core/csv_text.h"
#include "core/json_text.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

using Json = nlohmann::ordered_json;

/// Millimetres, degrees and shares to a millionth: below what any scan tells and above what the order of sums leaves.
double rounded(double v) { return snapped(v, 1e-6); }
double rounded_direction(double v) { return snapped(v, 1e-9); }
double rounded_degrees(double radians) { return rounded(degrees(radians)); }

Json place_json(const Vec3& v) { return {rounded(v.x()), rounded(v.y()), rounded(v.z())}; }
Json direction_json(const Vec3& v) {
  return {rounded_direction(v.x()), rounded_direction(v.y()), rounded_direction(v.z())};
}

bool has_length(FaceKind kind) { return kind == FaceKind::cylinder || kind == FaceKind::cone; }

Json ids_json(const std::vector<std::uint32_t>& faces) {
  Json ids = Json::array();
  for (const auto f : faces) ids.push_back(face_number(f));
  return ids;
}

Json sigma_json(const Face& face) {
  Json sigma;
  sigma["offset"] = rounded(face.fit.sigma_point);
  if (is_round(face.kind)) sigma["radius"] = rounded(face.fit.sigma_radius);
  if (face.kind == FaceKind::torus) sigma["minor_radius"] = rounded(face.fit.sigma_tube);
  if (face.kind == FaceKind::cone) sigma["half_angle_deg"] = rounded_degrees(face.fit.sigma_half_angle);
  if (has_direction(face.kind)) sigma["axis_deg"] = rounded_degrees(face.fit.sigma_axis);
  return sigma;
}

Json face_json(const MeasuredPart& part, std::size_t f) {
  const Face& face = part.faces.faces[f];
  const Primitive& p = face.surface();
  Json json;
  json["id"] = face_number(f);
  json["name"] = face_name(part.faces, f);
  json["kind"] = name_of(face.kind);
  json["area"] = rounded(face.area);
  json["points"] = face.points;
  json["coverage"] = rounded(face.coverage);
  json["complete"] = face.complete;
  json["middle"] = place_json(face.middle);
  if (is_round(face.kind)) json["convex"] = !face.hollow, json["arc_deg"] = rounded_degrees(face.arc);
  if (face.kind != FaceKind::free_form) {
    json["rms"] = rounded(face.fit.rms);
    json["point"] = place_json(p.point);
    if (has_direction(face.kind)) json["axis"] = direction_json(p.axis);
    if (face.kind == FaceKind::plane)
      json["size"] = {rounded(part.plane_sizes[f].x()), rounded(part.plane_sizes[f].y())};
    if (is_round(face.kind)) json["radius"] = rounded(p.radius);
    if (face.kind == FaceKind::torus) json["minor_radius"] = rounded(p.tube);
    if (face.kind == FaceKind::cone) json["half_angle_deg"] = rounded_degrees(p.half_angle);
    if (has_length(face.kind)) json["low"] = rounded(face.low), json["high"] = rounded(face.high);
    json["sigma"] = sigma_json(face);
  }
  json["neighbours"] = Json::array();
  for (const auto& n : face.neighbours)
    json["neighbours"].push_back({{"id", face_number(n.face)},
                                  {"edge", name_of(n.edge)},
                                  {"angle_deg", rounded_degrees(n.angle)},
                                  {"length", rounded(n.length)}});
  return json;
}

Json relation_json(const FaceRelation& relation) {
  const bool angle = is_angle(relation.kind);
  const auto shown = [&](double v) { return angle ? rounded_degrees(v) : rounded(v); };
  return {{"kind", name_of(relation.kind)}, {"faces", ids_json({relation.first, relation.second})},
          {"unit", angle ? "deg" : "mm"},   {"value", shown(relation.value)},
          {"sigma", shown(relation.sigma)}, {"z", snapped(relation.z, 1e-3)},
          {"accepted", relation.accepted}};
}

/// Value and sigma of a feature's dimension in the unit it is told in; a count has none.
struct ToldDimension {
  const char* unit;
  double value, sigma;
};

template <class Dimension>
ToldDimension told(const Dimension& d) {
  using Quantity = typename Dimension::Quantity;
  if (d.quantity == Quantity::angle) return {"deg", rounded_degrees(d.value), rounded_degrees(d.sigma)};
  return {d.quantity == Quantity::length ? "mm" : "", rounded(d.value), rounded(d.sigma)};
}

Json feature_json(const Faces& faces, const SimpleFeature& feature) {
  Json json;
  json["name"] = feature.name;
  json["kind"] = feature.kind;
  json["faces"] = ids_json(feature.faces);
  json["place"] = place_json(place_of(faces, feature));
  json["dimensions"] = Json::array();
  for (const auto& d : feature.dimensions) {
    const auto t = told(d);
    json["dimensions"].push_back({{"name", d.name}, {"unit", t.unit}, {"value", t.value}, {"sigma", t.sigma}});
  }
  return json;
}

/// Specks of a scan by the thousand are one entry.
Json places_json(const std::vector<UnclassifiedPlace>& places) {
  constexpr std::size_t most = 100;
  Json json = Json::array();
  double rest = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& place = places[i];
    rest += i < most ? 0 : place.area;
    if (i < most)
      json.push_back({{"area", rounded(place.area)}, {"place", place_json(place.place)}, {"reason", place.reason}});
  }
  if (places.size() > most)
    json.push_back({{"area", rounded(rest)},
                    {"place", place_json(places[most].place)},
                    {"reason", std::to_string(places.size() - most) + " smaller places; the largest of them is here"}});
  return json;
}

Json json_of(const MeasuredPart& part) {
  Json json;
  json["units"] = "mm";
  json["tolerance"] = part.tolerance;
  json["noise"] = rounded(part.faces.noise);
  json["frame"] = "scan";
  json["source"] = part.faces.of_mesh ? "mesh" : "points";
  json["area"] = rounded(total_area(part));
  json["faces"] = Json::array();
  for (std::size_t f = 0; f < part.faces.faces.size(); ++f) json["faces"].push_back(face_json(part, f));
  json["relations"] = Json::array();
  for (const auto& relation : part.relations) json["relations"].push_back(relation_json(relation));
  json["features"] = Json::array();
  for (const auto& feature : part.features) json["features"].push_back(feature_json(part.faces, feature));
  json["unclassified"] = places_json(part.unclassified);
  return json;
}

std::string csv_row(const std::vector<std::string>& cells) {
  std::string text;
  for (std::size_t i = 0; i < cells.size(); ++i) text += (i ? "," : "") + quoted_csv(cells[i]);
  return text + "\n";
}

std::string number(double v) { return print_number(rounded(v)); }

/// Ids with spaces between them, which no sheet takes for one number.
std::string spaced(const std::vector<std::uint32_t>& faces) {
  std::string text;
  for (const auto f : faces) text += (text.empty() ? "" : " ") + std::to_string(face_number(f));
  return text;
}

}  // namespace

std::string faces_json(const MeasuredPart& part) { return json_text(json_of(part)); }

std::string faces_json(const MeasuredPart& part, const std::vector<Path>& files,
                       const std::vector<std::string>& warnings) {
  Json json = json_of(part);
  json["files"] = Json::array();
  for (const auto& file : files) json["files"].push_back(file.string());
  json["warnings"] = warnings;
  return json_text(json);
}

std::string faces_csv(const MeasuredPart& part) {
  std::string text = csv_row({"id",
                              "name",
                              "kind",
                              "side",
                              "area",
                              "points",
                              "coverage",
                              "arc_deg",
                              "complete",
                              "rms",
                              "x",
                              "y",
                              "z",
                              "axis_x",
                              "axis_y",
                              "axis_z",
                              "radius",
                              "minor_radius",
                              "half_angle_deg",
                              "length",
                              "width",
                              "sigma_offset",
                              "sigma_radius",
                              "sigma_minor_radius",
                              "sigma_half_angle_deg",
                              "sigma_axis_deg",
                              "neighbours"});
  for (std::size_t f = 0; f < part.faces.faces.size(); ++f) {
    const Face& face = part.faces.faces[f];
    const Primitive& p = face.surface();
    const FaceKind kind = face.kind;
    const auto only = [](bool holds, double v) { return holds ? number(v) : std::string(); };
    const bool fitted = kind != FaceKind::free_form, round = is_round(kind), axis = has_direction(kind);
    const bool plane = kind == FaceKind::plane, torus = kind == FaceKind::torus, cone = kind == FaceKind::cone;
    const Vec3 place = place_of(face);
    std::vector<std::uint32_t> neighbours;
    for (const auto& n : face.neighbours) neighbours.push_back(n.face);
    text += csv_row({std::to_string(face_number(f)),
                     face_name(part.faces, f),
                     name_of(kind),
                     round ? face.hollow ? "inside" : "outside" : "",
                     number(face.area),
                     std::to_string(face.points),
                     number(face.coverage),
                     only(round, degrees(face.arc)),
                     face.complete ? "yes" : "no",
                     only(fitted, face.fit.rms),
                     number(place.x()),
                     number(place.y()),
                     number(place.z()),
                     only(axis, p.axis.x()),
                     only(axis, p.axis.y()),
                     only(axis, p.axis.z()),
                     only(round, p.radius),
                     only(torus, p.tube),
                     only(cone, degrees(p.half_angle)),
                     plane ? number(part.plane_sizes[f].x()) : only(has_length(kind), face.high - face.low),
                     only(plane, part.plane_sizes[f].y()),
                     only(fitted, face.fit.sigma_point),
                     only(round, face.fit.sigma_radius),
                     only(torus, face.fit.sigma_tube),
                     only(cone, degrees(face.fit.sigma_half_angle)),
                     only(axis, degrees(face.fit.sigma_axis)),
                     spaced(neighbours)});
  }
  return text;
}

std::string features_csv(const MeasuredPart& part) {
  std::string text = csv_row({"feature", "kind", "dimension", "unit", "value", "sigma", "x", "y", "z", "faces"});
  for (const auto& feature : part.features) {
    const Vec3 p = place_of(part.faces, feature);
    const std::string x = number(p.x()), y = number(p.y()), z = number(p.z()), faces = spaced(feature.faces);
    for (const auto& d : feature.dimensions) {
      const auto t = told(d);
      text += csv_row(
          {feature.name, feature.kind, d.name, t.unit, print_number(t.value), print_number(t.sigma), x, y, z, faces});
    }
    if (feature.dimensions.empty()) text += csv_row({feature.name, feature.kind, "", "", "", "", x, y, z, faces});
  }
  return text;
}

}  // namespace partscribe::cli
