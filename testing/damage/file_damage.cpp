#include "testing/damage/file_damage.h"

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

#include "core/number.h"
#include "testing/damage/parts.h"

namespace partscribe::testing {
namespace {

/// What is said of a file that does not hold what its kind must hold.
const std::vector<std::string> unreadable = {"cannot", "expected", "error", "holds no", "no geometry",
                                             "ends",   "empty",    "begin", "this is a"};

/// Damages for which another model is written by the same backend.
void other_models(const FileSubject& s, std::vector<FileDamage>& damages) {
  Model own_frame = s.model;
  own_frame.as_scanned = false;
  const bool placed = !s.model.scan_from_part.identity();
  if (placed) damages.push_back({"wrong frame", "the part's own frame", s.write(own_frame), {"whole part"}});
  const Pose there = evaluate(s.model.scan_from_part, values_of(s.model));
  auto placed_at = [&](const Pose& pose) {
    Model m = s.model;
    const Vec3 turn = euler_from_rotation(pose.rotation);
    m.scan_from_part = {pose.translation.x(), pose.translation.y(), pose.translation.z(), turn.x(), turn.y(), turn.z()};
    return s.write(m);
  };
  if (placed)
    damages.push_back(
        {"wrong frame", "turned but not moved", placed_at({there.rotation, Vec3::Zero()}), {"whole part"}});
  const Mat3 y_up = rotation_of(-pi / 2 * Vec3::UnitX());
  damages.push_back({"axes swapped", "y up", placed_at(Pose{y_up, Vec3::Zero()} * there), {"whole part"}});
  const Mat3 cycled = rotation_of(2 * pi / 3 * Vec3::Ones().normalized());
  damages.push_back({"axes swapped", "x to y to z", placed_at(Pose{cycled, Vec3::Zero()} * there), {"whole part"}});
  const std::string other = s.model.name == "bracket" ? "block" : "bracket";
  damages.push_back({"stale file",
                     "of another part",
                     s.write(part_named(other)),
                     {"another part", "whole part", "too far", "missing", "too much"}});
}

}  // namespace

std::string with(const std::string& text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) return "";
  return text.substr(0, at) + to + text.substr(at + from.size());
}

std::string with_all(std::string text, const std::string& from, const std::string& to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string text_of(const std::vector<std::string>& lines, const std::string& end) {
  std::string text;
  for (const auto& line : lines) text += line + end;
  return text;
}

std::vector<FileDamage> file_damages(const FileSubject& s) {
  std::vector<FileDamage> damages;
  other_models(s, damages);
  damages.push_back({"empty file", "no byte", "", unreadable});
  damages.push_back({"empty file", "spaces only", "   \n\n", unreadable});
  damages.push_back({"wrong format", "written by another backend", s.other_format, unreadable});
  damage_scripts(s, damages);
  damage_exchange(s, damages);
  damage_facets(s, damages);
  // A damage that this file does not allow has left no text.
  std::erase_if(damages, [](const FileDamage& d) { return d.bytes.empty() && d.kind != "empty file"; });
  return damages;
}

}  // namespace partscribe::testing
