#include "codegen/analysis/simulator_files.h"

#include <cmath>
#include <utility>

#include "core/number.h"
#include "geometry/io/read_geometry.h"

namespace partscribe::codegen {
namespace {

/// Text between quotes of an attribute. Characters that XML does not know at all become spaces.
std::string attribute_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result;
}

/// Nine digits: more than any measurement of a part has, and no tail of rounding.
std::string digits_of(double value) {
  if (value == 0) return "0";
  const double resolution = power_of_ten_below(std::abs(value)) * 1e-8;
  return print_number(snapped(value, resolution));
}

std::string metres(const Vec3& mm) {
  // Nanometres: a centroid on an axis is 0, not what rounding leaves of it.
  std::string text;
  for (int k = 0; k < 3; ++k) text += (k > 0 ? " " : "") + print_number(snapped(mm[k] / 1000, 1e-9));
  return text;
}

/// kg m^2, products below a billionth of the largest moment left out.
struct SiBody {
  double mass = 0;  ///< kg
  Mat3 inertia;
};

SiBody in_si(const SimulatedBody& body) {
  SiBody si{body.mass.volume * 1e-9 * body.density, body.mass.inertia * 1e-15 * body.density};
  const double least = 1e-9 * si.inertia.cwiseAbs().maxCoeff();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      if (std::abs(si.inertia(r, c)) < least) si.inertia(r, c) = 0;
  return si;
}

}  // namespace

std::string urdf_text(const SimulatedBody& body) {
  const SiBody si = in_si(body);
  const std::string name = attribute_text(body.name), mesh = attribute_text(body.mesh);
  const auto shape = [&](const std::string& element) {
    return "    <" + element +
           ">\n      <origin xyz=\"0 0 0\" rpy=\"0 0 0\"/>\n      <geometry>\n        <mesh filename=\"" + mesh +
           "\"/>\n      </geometry>\n    </" + element + ">\n";
  };
  const auto term = [&](const char* key, int r, int c) {
    return std::string(" ") + key + "=\"" + digits_of(si.inertia(r, c)) + "\"";
  };
  return "<?xml version=\"1.0\"?>\n<!-- metres, kilograms; density " + print_number(body.density) +
         " kg/m^3; the inertia is about the centre of mass, along the axes of the link -->\n<robot name=\"" + name +
         "\">\n  <link name=\"" + name + "\">\n    <inertial>\n      <origin xyz=\"" + metres(body.mass.centroid) +
         "\" rpy=\"0 0 0\"/>\n      <mass value=\"" + digits_of(si.mass) + "\"/>\n      <inertia" + term("ixx", 0, 0) +
         term("ixy", 0, 1) + term("ixz", 0, 2) + term("iyy", 1, 1) + term("iyz", 1, 2) + term("izz", 2, 2) +
         "/>\n    </inertial>\n" + shape("visual") + shape("collision") + "  </link>\n</robot>\n";
}

std::string mjcf_text(const SimulatedBody& body) {
  const SiBody si = in_si(body);
  const std::string name = attribute_text(body.name), mesh = attribute_text(body.mesh);
  std::string inertia;
  for (const auto& [r, c] : {std::pair(0, 0), {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}})
    inertia += (inertia.empty() ? "" : " ") + digits_of(si.inertia(r, c));
  return "<!-- metres, kilograms; density " + print_number(body.density) + " kg/m^3 -->\n<mujoco model=\"" + name +
         "\">\n  <asset>\n    <mesh name=\"" + name + "\" file=\"" + mesh +
         "\"/>\n  </asset>\n  <worldbody>\n    <body name=\"" + name +
         "\">\n      <freejoint/>\n      <inertial pos=\"" + metres(body.mass.centroid) + "\" mass=\"" +
         digits_of(si.mass) + "\" fullinertia=\"" + inertia + "\"/>\n      <geom type=\"mesh\" mesh=\"" + name +
         "\"/>\n    </body>\n  </worldbody>\n</mujoco>\n";
}

std::string mesh_in_metres(const TriangleMesh& mesh) {
  TriangleMesh scaled = mesh;
  for (auto& vertex : scaled.vertices) vertex /= 1000;
  std::string bytes = write_stl(scaled);
  const std::string_view title = "binary STL, metres     ";  // in place of what write_stl says of its unit
  return bytes.replace(0, title.size(), title);
}

}  // namespace partscribe::codegen
