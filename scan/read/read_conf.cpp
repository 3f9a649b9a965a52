/// Stanford .conf files: range meshes with the poses that put them together.
#include <Eigen/Geometry>

#include "core/lies_within.h"
#include "core/number.h"
#include "scan/read/sources.h"

namespace partscribe::scan {
namespace {

std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  std::string word;
  for (const char c : line) {
    if (c != ' ' && c != '\t' && c != '\r') {
      word += c;
    } else if (!word.empty()) {
      words.push_back(word);
      word.clear();
    }
  }
  if (!word.empty()) words.push_back(word);
  return words;
}

}  // namespace

std::optional<Error> add_conf(const Path& path, Context& context, Pieces& pieces) {
  const auto bytes = read_source(path, pieces);
  if (!bytes.ok()) return bytes.error();
  const auto name = path.filename().string();
  std::string_view rest = *bytes;
  std::size_t line = 0, meshes = 0;
  while (!rest.empty()) {
    const auto end = rest.find('\n');
    const auto words = words_of(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    ++line;
    if (words.empty() || words[0].front() == '#' || words[0] == "camera") continue;
    const auto wrong = [&](const std::string& message) {
      return bad_input(name + ", line " + std::to_string(line) + ": " + message);
    };
    if (words[0] != "bmesh" && words[0] != "mesh")
      return wrong("expected 'bmesh', 'mesh' or 'camera', found '" + words[0] + "'");
    if (words.size() < 9)
      return wrong("expected a file, tx ty tz and qi qj qk qw, found " + std::to_string(words.size() - 1) + " words");
    double v[7];
    for (std::size_t i = 0; i < 7; ++i) {
      const auto number = parse_number(words[i + 2]);
      if (!number) return wrong("expected a number, found '" + words[i + 2] + "'");
      v[i] = *number;
    }
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (std::abs(q.norm() - 1) > 0.01)
      return wrong("expected a unit quaternion, found one of length " + print_number(q.norm()));
    // The quaternion turns the world into the view: the published meshes only meet with its inverse.
    const Pose pose{q.normalized().toRotationMatrix().transpose(), Vec3(v[0], v[1], v[2])};
    if (!lies_within(path.parent_path() / words[1], path.parent_path()))
      return wrong("expected a file in the folder of " + name + " or below, found '" + words[1] + "'");
    if (auto error = add_geometry(path.parent_path() / words[1], pose, false, "", context, pieces)) return error;
    ++meshes;
  }
  if (!meshes) return bad_input(name + ": expected 'bmesh' lines, found none");
  return {};
}

}  // namespace partscribe::scan
