#include "cli/measure/face_words.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "cli/describe.h"
#include "core/disjoint_sets.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

constexpr std::size_t most_refused = 8;  // relations that are not
constexpr std::size_t most_pairs = 8;    // of directions that are square to each other
constexpr std::size_t most_listed = 5;   // places without a face
constexpr double fine_degrees = 0.001;   // nobody reads more

/// The smallest step of the tables, mm: a thousandth of the tolerance.
double fine_step(const MeasuredPart& part) { return power_of_ten_below(std::max(part.tolerance, 1e-6)) / 1000; }

/// With its standard deviation, unless that is too small to be read.
std::string measured(double value, double sigma, double finest) {
  const double step = sigma > 0 && std::isfinite(sigma) ? std::max(power_of_ten_below(sigma) / 10, finest) : finest;
  const double shown = std::isfinite(sigma) ? snapped(sigma, step) : 0;
  return print_number(snapped(value, step)) + (shown > 0 ? " ± " + print_number(shown) : "");
}

/// Corners of a mesh lie on its surfaces: more digits than a hundredth of the tolerance would be those of the file.
std::string length(double mm, double sigma, const MeasuredPart& part) {
  return measured(mm, sigma, (part.faces.of_mesh ? 10 : 1) * fine_step(part));
}

/// What has no sigma of its own: where a face of a cloud ends is known to the distance between its points only.
std::string extent(double mm, const MeasuredPart& part) {
  return measured(mm, 0, (part.faces.of_mesh ? 10 : 100) * fine_step(part));
}

std::string angle(double radians, double sigma) {
  return measured(degrees(radians), degrees(sigma), fine_degrees) + " deg";
}

std::string triple(const Vec3& v, double step) {
  return "(" + print_number(snapped(v.x(), step)) + ", " + print_number(snapped(v.y(), step)) + ", " +
         print_number(snapped(v.z(), step)) + ")";
}

std::string place_text(const Vec3& place, const MeasuredPart& part) { return triple(place, 100 * fine_step(part)); }

std::string percent(double share) {
  const double value = 100 * share;
  return (value > 0 && value < 0.01 ? "below 0.01" : print_number(snapped(value, value < 10 ? 0.01 : 0.1))) + " %";
}

/// Drawings give a radius to what goes around half a turn or less, as ends of slots do, and a diameter to the rest.
bool goes_around(const Face& face) { return face.arc > 1.1 * pi; }

std::string across(const Face& face, double radius, double sigma, const MeasuredPart& part) {
  const bool turned = goes_around(face);
  const double factor = turned ? 2 : 1;
  return (turned ? "diameter " : "radius ") + length(factor * radius, factor * sigma, part);
}

std::string size_of(const MeasuredPart& part, std::size_t f) {
  const Face& face = part.faces.faces[f];
  const Primitive& p = face.surface();
  const std::string side = face.hollow ? "inside " : "outside ";
  const auto mm = [&](double v) { return extent(v, part); };
  switch (face.kind) {
    case FaceKind::plane: {
      const Vec2 size = part.plane_sizes[f];
      return size.x() > 0 ? mm(size.x()) + " x " + mm(size.y()) : "";
    }
    case FaceKind::cylinder:
      return side + across(face, p.radius, face.fit.sigma_radius, part) + ", length " + mm(face.high - face.low);
    case FaceKind::cone: {
      const double low = p.radius + face.low * std::tan(p.half_angle),
                   high = p.radius + face.high * std::tan(p.half_angle);
      const double factor = goes_around(face) ? 2 : 1;
      return side + (factor > 1 ? "diameters " : "radii ") + mm(factor * std::max(0.0, low)) + " to " +
             mm(factor * std::max(0.0, high)) + ", half angle " + angle(p.half_angle, face.fit.sigma_half_angle);
    }
    case FaceKind::sphere:
      return side + across(face, p.radius, face.fit.sigma_radius, part);
    case FaceKind::torus:
      return side + "ring radius " + length(p.radius, face.fit.sigma_radius, part) + ", tube radius " +
             length(p.tube, face.fit.sigma_tube, part);
    case FaceKind::free_form:
      return "";
  }
  return "";
}

std::string covered_text(const Face& face) {
  std::string text = is_round(face.kind) ? print_number(snapped(degrees(face.arc), 1)) + " deg" : "";
  // A round face that lacks nothing but the rest of the turn has no hole worth a word.
  const double whole = is_round(face.kind) ? std::min(1.0, face.arc / (2 * pi)) : 1;
  if (face.kind != FaceKind::sphere && face.coverage < 0.95 * whole)
    text += (text.empty() ? "" : ", ") + percent(face.coverage);
  if (face.kind == FaceKind::sphere) text = percent(face.coverage);
  if (!face.complete) text += text.empty() ? "runs out" : ", runs out";
  return text;
}

/// "<0.0001" for what is too small to be read.
std::string small(double value, double finest) {
  return value > 0 && value < finest ? "<" + print_number(snapped(finest, power_of_ten_below(1.5 * finest)))
                                     : readable(value);
}

std::string text_of(const SimpleFeature& feature, const MeasuredPart& part) {
  std::string text;
  for (const auto& d : feature.dimensions) {
    using Quantity = std::decay_t<decltype(d)>::Quantity;
    text += (text.empty() ? "" : ", ") + d.name + " " +
            (d.quantity == Quantity::angle    ? angle(d.value, d.sigma)
             : d.quantity == Quantity::length ? length(d.value, d.sigma, part)
                                              : print_number(snapped(d.value, 1)));
  }
  return text;
}

std::string numbers_of(const std::vector<std::uint32_t>& faces) {
  constexpr std::size_t most = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, faces.size()); ++i)
    text += (i ? ", " : "") + std::to_string(face_number(faces[i]));
  return text + (faces.size() > most ? ", and " + std::to_string(faces.size() - most) + " more" : "");
}

/// Faces that hold one relation to each other, directly or through others, and how far they are from it.
struct RelatedGroup {
  std::vector<std::uint32_t> faces;
  double largest = 0;  ///< of the accepted values: rad or mm
};

std::vector<RelatedGroup> groups_of(const MeasuredPart& part, RelationKind kind) {
  DisjointSets sets(part.faces.faces.size());
  const auto holds = [&](const FaceRelation& r) { return r.kind == kind && r.accepted; };
  for (const auto& r : part.relations)
    if (holds(r)) sets.unite(r.first, r.second);
  std::map<std::uint32_t, RelatedGroup> by_root;
  for (std::uint32_t f = 0; f < part.faces.faces.size(); ++f)
    if (sets.size(f) > 1) by_root[sets.root(f)].faces.push_back(f);
  for (const auto& r : part.relations)
    if (holds(r)) {
      double& largest = by_root.at(sets.root(r.first)).largest;
      largest = std::max(largest, std::abs(r.value));
    }
  std::vector<RelatedGroup> groups;
  for (auto& [root, group] : by_root) groups.push_back(std::move(group));
  return groups;
}

std::string within(RelationKind kind, double largest, const MeasuredPart& part) {
  const double finest = is_angle(kind) ? fine_degrees : fine_step(part);
  const double value = is_angle(kind) ? degrees(largest) : largest;
  return "within " + (value < finest ? print_number(finest) : readable(value)) + (is_angle(kind) ? " deg" : " mm");
}

/// A, B, ..., Z, AA, AB, ...
std::string letters(std::size_t n) {
  std::string text(1, static_cast<char>('A' + n % 26));
  return n < 26 ? text : letters(n / 26 - 1) + text;
}

/// Directions by letters, single faces by their names; what is square to what, once for each pair of directions.
void add_square_pairs(const MeasuredPart& part, const std::vector<RelatedGroup>& directions, TableRows& rows) {
  std::vector<std::size_t> direction_of(part.faces.faces.size(), directions.size());
  for (std::size_t d = 0; d < directions.size(); ++d)
    for (const auto f : directions[d].faces) direction_of[f] = d;
  using Name = std::pair<std::size_t, std::uint32_t>;  // a direction, or none and a face
  const auto name_for = [&](std::uint32_t f) {
    return direction_of[f] < directions.size() ? Name(direction_of[f], 0) : Name(directions.size(), f);
  };
  std::map<std::pair<Name, Name>, double> pairs;
  for (const auto& r : part.relations) {
    if (r.kind != RelationKind::orthogonal || !r.accepted) continue;
    const auto ends = std::minmax({name_for(r.first), name_for(r.second)});
    double& largest = pairs[{ends.first, ends.second}];
    largest = std::max(largest, std::abs(r.value));
  }
  const auto word = [&](const Name& n) {
    return n.first < directions.size() ? letters(n.first) : face_name(part.faces, n.second);
  };
  std::string text;
  double largest = 0;
  std::size_t told = 0;
  for (const auto& [ends, value] : pairs) {
    largest = std::max(largest, value);
    if (++told <= most_pairs) text += (text.empty() ? "" : ", ") + word(ends.first) + " to " + word(ends.second);
  }
  if (told > most_pairs) text += " and " + std::to_string(told - most_pairs) + " more";
  if (!text.empty()) rows.push_back({"square", text, within(RelationKind::orthogonal, largest, part)});
}

/// Those between the largest faces.
void add_refused(const MeasuredPart& part, TableRows& rows) {
  std::vector<FaceRelation> refused;
  for (const auto& r : part.relations)
    if (!r.accepted) refused.push_back(r);
  const auto smaller_face = [](const FaceRelation& r) { return std::max(r.first, r.second); };
  std::stable_sort(refused.begin(), refused.end(),
                   [&](const FaceRelation& a, const FaceRelation& b) { return smaller_face(a) < smaller_face(b); });
  for (std::size_t i = 0; i < std::min(most_refused, refused.size()); ++i) {
    const FaceRelation& r = refused[i];
    std::string kind = name_of(r.kind);
    std::replace(kind.begin(), kind.end(), '_', ' ');
    rows.push_back({"not " + kind, face_list(part.faces, {r.first, r.second}),
                    "off by " + (is_angle(r.kind) ? angle(std::abs(r.value), r.sigma)
                                                  : length(std::abs(r.value), r.sigma, part) + " mm")});
  }
  if (refused.size() > most_refused)
    rows.push_back(
        {"", "and " + std::to_string(refused.size() - most_refused) + " more that do not hold, in faces.json", ""});
}

/// "  and 12 more in faces.csv" in place of what is too long.
std::string cut_table(TableRows rows, const std::string& file) {
  std::string more;
  if (rows.size() > most_rows + 1) {
    more = "  and " + std::to_string(rows.size() - most_rows - 1) + " more in " + file + "\n";
    rows.resize(most_rows + 1);
  }
  return table(rows) + more;
}

}  // namespace

TableRows feature_rows(const MeasuredPart& part) {
  TableRows rows = {{"feature", "kind", "size in mm", "place", "faces"}};
  for (const auto& feature : part.features)
    rows.push_back({feature.name, feature.kind, text_of(feature, part), place_text(place_of(part.faces, feature), part),
                    numbers_of(feature.faces)});
  return rows;
}

TableRows face_rows(const MeasuredPart& part) {
  TableRows rows = {{"face", "size in mm", "place", "direction", "covered", "area mm2", "rms", "± mm", "± deg"}};
  const double finest = fine_step(part);
  for (std::size_t f = 0; f < part.faces.faces.size(); ++f) {
    const Face& face = part.faces.faces[f];
    const bool fitted = face.kind != FaceKind::free_form;
    rows.push_back({face_name(part.faces, f), size_of(part, f), place_text(place_of(face), part),
                    has_direction(face.kind) ? triple(face.surface().axis, 0.001) : "", covered_text(face),
                    readable(face.area), fitted ? small(face.fit.rms, finest) : "",
                    fitted ? small(face.fit.sigma_point, finest) : "",
                    has_direction(face.kind) ? small(degrees(face.fit.sigma_axis), fine_degrees) : ""});
  }
  return rows;
}

TableRows relation_rows(const MeasuredPart& part) {
  TableRows rows = {{"relation", "faces", ""}};
  const auto directions = groups_of(part, RelationKind::parallel);
  for (std::size_t d = 0; d < directions.size(); ++d)
    rows.push_back({"direction " + letters(d), face_list(part.faces, directions[d].faces),
                    within(RelationKind::parallel, directions[d].largest, part)});
  add_square_pairs(part, directions, rows);
  const std::vector<std::pair<RelationKind, const char*>> kinds = {{RelationKind::coaxial, "one axis"},
                                                                   {RelationKind::coplanar, "one plane"},
                                                                   {RelationKind::equal_radius, "equal radius"}};
  for (const auto& [kind, words] : kinds)
    for (const auto& group : groups_of(part, kind)) {
      std::string faces = face_list(part.faces, group.faces);
      if (kind == RelationKind::equal_radius) {
        double sum = 0;
        for (const auto f : group.faces) {
          const Face& face = part.faces.faces[f];
          sum += face.kind == FaceKind::torus ? face.surface().tube : face.surface().radius;
        }
        faces += ": radius " + extent(sum / static_cast<double>(group.faces.size()), part);
      }
      rows.push_back({words, faces, within(kind, group.largest, part)});
    }
  std::size_t tangent = 0;
  double largest = 0;
  std::set<std::uint32_t> touching;
  for (const auto& r : part.relations)
    if (r.kind == RelationKind::tangent && r.accepted) {
      ++tangent, largest = std::max(largest, std::abs(r.value));
      touching.insert({r.first, r.second});
    }
  if (tangent > 0)
    rows.push_back({"tangent",
                    std::to_string(tangent) + (tangent > 1 ? " pairs of " : " pair of ") +
                        std::to_string(touching.size()) + " faces",
                    within(RelationKind::tangent, largest, part)});
  add_refused(part, rows);
  return rows;
}

std::string unclassified_text(const MeasuredPart& part) {
  const double total = total_area(part);
  double left = 0, free = 0;
  std::size_t free_faces = 0;
  for (const auto& place : part.unclassified) left += place.area;
  for (const auto& face : part.faces.faces)
    if (face.kind == FaceKind::free_form) free += face.area, ++free_faces;
  const auto share = [&](double area) {
    return readable(area) + " of " + readable(total) + " mm2 (" + percent(total > 0 ? area / total : 0) + ")";
  };
  std::string text;
  if (free_faces > 0)
    text += "Free form: " + share(free) + " in " + std::to_string(free_faces) + (free_faces > 1 ? " faces" : " face") +
            ".\n";
  if (part.unclassified.empty()) return text + "Unclassified: nothing of " + readable(total) + " mm2.\n";
  text += "Unclassified: " + share(left) + ".\n";
  const auto near = [&](const UnclassifiedPlace& place) { return "near " + place_text(place.place, part); };
  TableRows rows;
  double small_area = 0;
  std::size_t small_places = 0, others = 0;
  const UnclassifiedPlace* largest_small = nullptr;
  for (const auto& place : part.unclassified) {
    if (place.small) {
      small_area += place.area, ++small_places;
      if (!largest_small) largest_small = &place;
    } else if (++others <= most_listed) {
      rows.push_back({readable(place.area) + " mm2", near(place), place.reason});
    }
  }
  if (others > most_listed)
    rows.push_back({"", "", "and " + std::to_string(others - most_listed) + " more in faces.json"});
  if (largest_small)
    rows.push_back({readable(small_area) + " mm2",
                    small_places > 1 ? "in " + std::to_string(small_places) + " places" : near(*largest_small),
                    largest_small->reason});
  return text + table(rows);
}

std::string measured_text(const MeasuredPart& part) {
  std::string text;
  if (!part.features.empty()) text += cut_table(feature_rows(part), "features.csv") + "\n";
  if (!part.faces.faces.empty()) text += cut_table(face_rows(part), "faces.csv") + "\n";
  if (const auto rows = relation_rows(part); rows.size() > 1) text += cut_table(rows, "faces.json") + "\n";
  return text + unclassified_text(part);
}

}  // namespace partscribe::cli
