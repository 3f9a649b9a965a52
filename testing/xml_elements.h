/// The elements of an XML document, read by expat.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace partscribe::testing {

struct XmlElement {
  std::string path;  ///< names from the root on: "robot/link/inertial"
  std::map<std::string, std::string> attributes;
};

/// In the order of the document. A document that is not well formed ends the test.
std::vector<XmlElement> xml_elements(const std::string& text);

/// An attribute of the only element with this path; anything else ends the test.
std::string xml_attribute(const std::vector<XmlElement>& elements, const std::string& path, const std::string& name);

/// The numbers in such an attribute.
std::vector<double> xml_numbers(const std::vector<XmlElement>& elements, const std::string& path,
                                const std::string& name);

}  // namespace partscribe::testing
