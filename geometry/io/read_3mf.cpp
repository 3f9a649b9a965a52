/// 3MF: meshes, components, build items with their transforms, and the unit.
#include <expat.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <memory>

#include "geometry/io/read_formats.h"
#include "geometry/io/read_zip.h"

namespace partscribe::geometry::formats {
namespace {

using Affine = Eigen::Matrix<double, 3, 4>;

/// A name without the prefix of its namespace.
std::string_view local(std::string_view name) {
  const auto colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

/// An element as expat delivers it.
struct Element {
  std::string_view name;
  const XML_Char** attributes;

  /// Value of an attribute; empty if there is none.
  std::string_view attribute(std::string_view wanted) const {
    for (const XML_Char** at = attributes; *at; at += 2)
      if (local(*at) == wanted) return at[1];
    return {};
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

constexpr std::size_t most_copies = 100, few_triangles = 2'000'000, most_triangles = 50'000'000;
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

/// Reads one model part of the archive into the package.
class ModelReader {
 public:
  ModelReader(std::string part, const std::string& name, bool root, Package& package)
      : part_(std::move(part)),
        name_(name),
        root_(root),
        package_(package),
        parser_(XML_ParserCreate(nullptr), XML_ParserFree) {
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(
        parser_.get(),
        [](void* self, const XML_Char* tag, const XML_Char** attributes) {
          static_cast<ModelReader*>(self)->begin({local(tag), attributes});
        },
        [](void* self, const XML_Char* tag) { static_cast<ModelReader*>(self)->end(local(tag)); });
  }

  std::optional<Error> read(std::string_view text) {
    constexpr std::size_t most = 1u << 30;  // expat counts in int
    for (std::size_t at = 0; !error_ && (at < text.size() || at == 0); at += most) {
      const auto piece = text.substr(at, most);
      if (XML_Parse(parser_.get(), piece.data(), static_cast<int>(piece.size()), at + most >= text.size()) ==
              XML_STATUS_OK ||
          error_)
        continue;
      return at_byte(
          name_, place(),
          "expected whole XML in " + shown(part_) + ", found " + XML_ErrorString(XML_GetErrorCode(parser_.get())));
    }
    if (!error_ && !model_) return bad_input(name_ + ": expected a <model> in " + shown(part_) + ", found none");
    return error_;
  }

 private:
  const std::string part_;
  const std::string& name_;
  const bool root_;
  Package& package_;
  std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser_;
  Object* object_ = nullptr;
  bool model_ = false;
  std::optional<Error> error_;

  std::size_t place() const {
    return static_cast<std::size_t>(std::max<XML_Index>(XML_GetCurrentByteIndex(parser_.get()), 0));
  }

  void stop(std::optional<Error> error) {
    if (!error || error_) return;
    error_ = std::move(error);
    XML_StopParser(parser_.get(), XML_FALSE);
  }

  void begin(const Element& element) {
    if (error_) return;
    if (element.name == "model") {
      model_ = true;
      const auto unit = element.attribute("unit");
      if (root_) package_.unit = unit.empty() ? "millimeter" : std::string(unit);
    } else if (element.name == "object") {
      object_ = &package_.objects[part_ + "#" + std::string(element.attribute("id"))];
    } else if (element.name == "vertex" && object_) {
      vertex(element);
    } else if (element.name == "triangle" && object_) {
      triangle(element);
    } else if (element.name == "component" && object_) {
      component(element, object_->components);
    } else if (element.name == "item" && root_) {
      component(element, package_.items);
    }
  }

  void end(std::string_view name) {
    if (name == "object") object_ = nullptr;
  }

  void vertex(const Element& element) {
    Vec3 p;
    constexpr std::string_view axes[] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k)
      if (const auto word = element.attribute(axes[k]); !to_real(word, p[k]))
        return stop(at_byte(name_, place(), "expected the coordinates of a vertex, found " + shown(word)));
    object_->mesh.vertices.push_back(p);
  }

  void triangle(const Element& element) {
    std::array<std::uint32_t, 3> t{};
    constexpr std::string_view corners[] = {"v1", "v2", "v3"};
    const std::size_t vertices = object_->mesh.vertices.size();
    for (std::size_t k = 0; k < 3; ++k) {
      std::int64_t index = -1;
      const auto word = element.attribute(corners[k]);
      if (!to_integer(word, index) || index < 0 || static_cast<std::size_t>(index) >= vertices)
        return stop(at_byte(name_, place(),
                            "expected a vertex index below " + std::to_string(vertices) + ", found " + shown(word)));
      t[k] = static_cast<std::uint32_t>(index);
    }
    object_->mesh.triangles.push_back(t);
  }

  void component(const Element& element, std::vector<Component>& list) {
    Component component;
    const auto path = element.attribute("path");
    component.object = (path.empty() ? part_ : part_name(path)) + "#" + std::string(element.attribute("objectid"));
    stop(parse_transform(element.attribute("transform"), name_, component.transform));
    list.push_back(component);
  }
};

/// Components may multiply without end: how many triangles, and how many vertices, may come of those in the file.
std::size_t credible_size(const Package& package) {
  std::size_t stated = 0;
  for (const auto& [key, object] : package.objects)
    stated += std::max(object.mesh.triangles.size(), object.mesh.vertices.size());
  return std::clamp(most_copies * stated, few_triangles, most_triangles);
}

std::optional<Error> place(const Package& package, const Component& item, const Affine& outer, int depth,
                           std::size_t most, std::size_t& visits, const std::string& name, TriangleMesh& mesh) {
  const auto found = package.objects.find(item.object);
  if (found == package.objects.end())
    return bad_input(name + ": expected an object " + shown(item.object) + ", found none");
  if (depth > deepest)
    return bad_input(name + ": expected components at most " + std::to_string(deepest) + " deep, found deeper ones");
  // Components without triangles could multiply without end too.
  if (++visits > most_visits)
    return bad_input(name + ": expected at most " + std::to_string(most_visits) + " components, found more");
  const Affine transform = chained(outer, item.transform);
  const auto& object = found->second;
  if (mesh.triangles.size() + object.mesh.triangles.size() + object.components.size() > most ||
      mesh.vertices.size() + object.mesh.vertices.size() > most)
    return bad_input(name + ": expected at most " + std::to_string(most) + " triangles, found more");
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
    if (auto error = place(package, component, transform, depth + 1, most, visits, name, mesh)) return error;
  return {};
}

}  // namespace

Result<RawGeometry> parse_3mf(std::string_view bytes, const std::string& name) {
  RawGeometry raw;
  raw.format = "3MF";
  const auto models =
      unzip(bytes, name, [](const std::string& entry) { return suffix_of(part_name(entry)) == ".model"; });
  if (!models) return models.error();
  if (models->empty()) return bad_input(name + ": expected a 3-D model (3D/3dmodel.model) in the archive, found none");
  // The start part by its usual name, else the first model.
  const auto usual =
      std::ranges::find_if(*models, [](const ZippedFile& file) { return part_name(file.name) == "3d/3dmodel.model"; });
  const ZippedFile& start = usual == models->end() ? models->front() : *usual;
  Package package;
  for (const auto& file : *models)
    if (auto error = ModelReader(part_name(file.name), name, &file == &start, package).read(file.bytes)) return *error;
  if (package.items.empty()) {
    raw.warnings.push_back(name + ": has no build items; all its objects are read");
    for (const auto& [key, object] : package.objects)
      if (!object.mesh.triangles.empty()) package.items.push_back({key, Affine::Identity()});
  }
  const std::size_t most = credible_size(package);
  std::size_t visits = 0;
  for (const auto& item : package.items)
    if (auto error = place(package, item, Affine::Identity(), 0, most, visits, name, raw.mesh)) return *error;
  if (raw.mesh.triangles.empty()) return bad_input(name + ": expected triangles, found none");
  raw.unit = package.unit;
  raw.cloud.points = raw.mesh.vertices;
  return raw;
}

}  // namespace partscribe::geometry::formats
