/// 3MF: meshes, components, build items with their transforms, and the unit.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <map>

#include "geometry/read_formats.h"
#include "geometry/read_zip.h"

namespace partscribe::formats {
namespace {

using Affine = Eigen::Matrix<double, 3, 4>;

/// Walks the tags of an XML document; text between tags has no meaning in 3MF.
class Tags {
 public:
  explicit Tags(std::string_view text) : text_(text) {}
  std::string_view name;  ///< without its namespace
  bool closing = false;   ///< </name>

  bool next() {
    while (true) {
      at_ = text_.find('<', at_);
      if (at_ == std::string_view::npos) return false;
      const auto rest = text_.substr(at_);
      std::string_view end = ">";
      if (rest.substr(0, 4) == "<!--") end = "-->";
      else if (rest.substr(0, 9) == "<![CDATA[") end = "]]>";
      else if (rest.substr(0, 2) == "<?") end = "?>";
      else if (rest.substr(0, 2) == "<!") end = ">";
      else return tag();
      at_ = text_.find(end, at_);
      if (at_ == std::string_view::npos) return false;
    }
  }
  /// Value of an attribute, its namespace left out; empty if there is none.
  std::string_view attribute(std::string_view wanted) const {
    auto rest = attributes_;
    while (true) {
      const auto equal = rest.find('=');
      if (equal == std::string_view::npos) return {};
      auto key = rest.substr(0, equal);
      while (!key.empty() && space(key.back())) key.remove_suffix(1);
      if (const auto begin = key.find_last_of(" \t\r\n:"); begin != std::string_view::npos) key.remove_prefix(begin + 1);
      const auto open = rest.find_first_of("\"'", equal);
      if (open == std::string_view::npos) return {};
      const auto close = rest.find(rest[open], open + 1);
      if (close == std::string_view::npos) return {};
      if (key == wanted) return rest.substr(open + 1, close - open - 1);
      rest.remove_prefix(close + 1);
    }
  }
  std::size_t place() const { return at_; }

 private:
  std::string_view text_, attributes_;
  std::size_t at_ = 0;

  static bool space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
  bool tag() {
    std::size_t end = ++at_;
    char quote = 0;
    for (; end < text_.size() && (quote || text_[end] != '>'); ++end) {
      if (quote) quote = text_[end] == quote ? 0 : quote;
      else if (text_[end] == '"' || text_[end] == '\'') quote = text_[end];
    }
    if (end >= text_.size()) return false;
    auto body = text_.substr(at_, end - at_);
    at_ = end;
    closing = !body.empty() && body.front() == '/';
    if (closing) body.remove_prefix(1);
    std::size_t stop = 0;
    while (stop < body.size() && !space(body[stop]) && body[stop] != '/') ++stop;
    name = body.substr(0, stop);
    attributes_ = body.substr(stop);
    if (const auto colon = name.find(':'); colon != std::string_view::npos) name.remove_prefix(colon + 1);
    return true;
  }
};

struct Component {
  std::string object;  ///< key of an object
  Affine transform = Affine::Identity();
};

struct Object {
  TriangleMesh mesh;
  std::vector<Component> components;
};

struct Package {
  std::map<std::string, Object> objects;  ///< by "part#id"
  std::vector<Component> items;
  std::string unit;
};

constexpr std::size_t most_triangles = 50'000'000;  // components may multiply without end
constexpr std::size_t most_visits = 1'000'000;
constexpr int deepest = 32;

std::optional<Error> parse_transform(std::string_view text, const std::string& name, Affine& transform) {
  transform = Affine::Identity();
  if (text.empty()) return {};
  for (int i = 0; i < 12; ++i) {
    // Row vectors: the matrix is written transposed.
    const auto word = next_word(text);
    if (!to_real(word, transform(i % 3, i / 3)) || !(std::abs(transform(i % 3, i / 3)) < 1e15))
      return bad_input(name + ": expected 12 numbers of a transform, found " + shown(word));
  }
  return {};
}

Affine chained(const Affine& outer, const Affine& inner) {
  Affine result;
  result.leftCols<3>() = outer.leftCols<3>() * inner.leftCols<3>();
  result.col(3) = outer.leftCols<3>() * inner.col(3) + outer.col(3);
  return result;
}

std::string part_name(std::string_view path) {
  if (!path.empty() && path.front() == '/') path.remove_prefix(1);
  return lower_case(path);
}

std::optional<Error> parse_model(std::string_view text, const std::string& part, const std::string& name, bool root, Package& package) {
  Tags tags(text);
  Object* object = nullptr;
  bool model = false, ended = false;
  const auto key = [&](std::string_view id) {
    const auto path = tags.attribute("path");
    return (path.empty() ? part : part_name(path)) + "#" + std::string(id);
  };
  while (tags.next()) {
    if (tags.closing) {
      if (tags.name == "object") object = nullptr;
      ended = ended || tags.name == "model";
      continue;
    }
    if (tags.name == "model") {
      model = true;
      if (root) package.unit = tags.attribute("unit").empty() ? "millimeter" : std::string(tags.attribute("unit"));
    } else if (tags.name == "object") {
      object = &package.objects[part + "#" + std::string(tags.attribute("id"))];
    } else if (tags.name == "vertex" && object) {
      Vec3 p;
      constexpr std::string_view axes[] = {"x", "y", "z"};
      for (int k = 0; k < 3; ++k)
        if (const auto word = tags.attribute(axes[k]); !to_real(word, p[k]))
          return at_byte(name, tags.place(), "expected the coordinates of a vertex, found " + shown(word));
      object->mesh.vertices.push_back(p);
    } else if (tags.name == "triangle" && object) {
      std::array<std::uint32_t, 3> t{};
      constexpr std::string_view corners[] = {"v1", "v2", "v3"};
      for (int k = 0; k < 3; ++k) {
        std::int64_t index = -1;
        const auto word = tags.attribute(corners[k]);
        if (!to_integer(word, index) || index < 0 || static_cast<std::size_t>(index) >= object->mesh.vertices.size())
          return at_byte(name, tags.place(), "expected a vertex index below " + std::to_string(object->mesh.vertices.size()) + ", found " + shown(word));
        t[k] = static_cast<std::uint32_t>(index);
      }
      object->mesh.triangles.push_back(t);
    } else if ((tags.name == "component" && object) || (tags.name == "item" && root)) {
      Component component;
      component.object = key(tags.attribute("objectid"));
      if (auto error = parse_transform(tags.attribute("transform"), name, component.transform)) return error;
      (tags.name == "item" ? package.items : object->components).push_back(component);
    }
  }
  if (!model) return bad_input(name + ": expected a <model> in " + part + ", found none");
  if (!ended) return bad_input(name + ": expected </model> at the end of " + part + ", found a document cut off");
  return {};
}

std::optional<Error> place(const Package& package, const Component& item, const Affine& outer, int depth, std::size_t& visits,
                           const std::string& name, TriangleMesh& mesh) {
  const auto found = package.objects.find(item.object);
  if (found == package.objects.end()) return bad_input(name + ": expected an object " + item.object + ", found none");
  if (depth > deepest) return bad_input(name + ": expected components at most " + std::to_string(deepest) + " deep, found deeper ones");
  // Components without triangles could multiply without end too.
  if (++visits > most_visits) return bad_input(name + ": expected at most " + std::to_string(most_visits) + " components, found more");
  const Affine transform = chained(outer, item.transform);
  const auto& object = found->second;
  if (mesh.triangles.size() + object.mesh.triangles.size() + object.components.size() > most_triangles ||
      mesh.vertices.size() + object.mesh.vertices.size() > most_triangles)
    return bad_input(name + ": expected at most " + std::to_string(most_triangles) + " triangles, found more");
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const bool exact = transform == Affine(Affine::Identity());
  for (const auto& v : object.mesh.vertices)
    mesh.vertices.push_back(exact ? v : Vec3(transform.leftCols<3>() * v + transform.col(3)));
  const bool mirrored = transform.leftCols<3>().determinant() < 0;
  for (auto t : object.mesh.triangles) {
    if (mirrored) std::swap(t[1], t[2]);
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  for (const auto& component : object.components)
    if (auto error = place(package, component, transform, depth + 1, visits, name, mesh)) return error;
  return {};
}

}  // namespace

Result<RawGeometry> parse_3mf(std::string_view bytes, const std::string& name) {
  RawGeometry raw;
  raw.format = "3MF";
  const auto entries = list_zip(bytes, name);
  if (!entries.ok()) return entries.error();
  // The start part by its usual name, else the first model.
  const ZipEntry* start = nullptr;
  for (const auto& entry : *entries) {
    const auto part = part_name(entry.name);
    if (suffix_of(part) != ".model") continue;
    if (!start || part == "3d/3dmodel.model") start = &entry;
  }
  if (!start) return bad_input(name + ": expected a 3-D model (3D/3dmodel.model) in the archive, found none");
  Package package;
  for (const auto& entry : *entries) {
    const auto part = part_name(entry.name);
    if (suffix_of(part) != ".model") continue;
    const auto text = unzip(bytes, entry, name);
    if (!text.ok()) return text.error();
    if (auto error = parse_model(*text, part, name, &entry == start, package)) return *error;
  }
  if (package.items.empty()) {
    raw.warnings.push_back(name + ": has no build items; all its objects are read");
    for (const auto& [key, object] : package.objects)
      if (!object.mesh.triangles.empty()) package.items.push_back({key, Affine::Identity()});
  }
  std::size_t visits = 0;
  for (const auto& item : package.items)
    if (auto error = place(package, item, Affine::Identity(), 0, visits, name, raw.mesh)) return *error;
  if (raw.mesh.triangles.empty()) return bad_input(name + ": expected triangles, found none");
  raw.unit = package.unit;
  raw.cloud.points = raw.mesh.vertices;
  return raw;
}

}  // namespace partscribe::formats
