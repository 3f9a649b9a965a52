#include "testing/xml_elements.h"

#include <expat.h>

#include <catch2/catch.hpp>
#include <memory>
#include <sstream>

#include "core/number.h"

namespace partscribe::testing {
namespace {

struct ElementsSoFar {
  std::vector<XmlElement> elements;
  std::vector<std::string> open;
};

void XMLCALL element_begins(void* data, const XML_Char* name, const XML_Char** attributes) {
  auto& document = *static_cast<ElementsSoFar*>(data);
  document.open.push_back(document.open.empty() ? name : document.open.back() + "/" + name);
  XmlElement element{document.open.back(), {}};
  for (; *attributes; attributes += 2) element.attributes[attributes[0]] = attributes[1];
  document.elements.push_back(std::move(element));
}

void XMLCALL element_ends(void* data, const XML_Char*) { static_cast<ElementsSoFar*>(data)->open.pop_back(); }

}  // namespace

std::vector<XmlElement> xml_elements(const std::string& text) {
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(XML_ParserCreate(nullptr), XML_ParserFree);
  ElementsSoFar document;
  XML_SetUserData(parser.get(), &document);
  XML_SetElementHandler(parser.get(), element_begins, element_ends);
  INFO(text);
  REQUIRE(XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 1) == XML_STATUS_OK);
  return document.elements;
}

std::string xml_attribute(const std::vector<XmlElement>& elements, const std::string& path, const std::string& name) {
  const XmlElement* found = nullptr;
  for (const auto& element : elements) {
    if (element.path != path) continue;
    INFO(path);
    REQUIRE(found == nullptr);
    found = &element;
  }
  INFO(path << " " << name);
  REQUIRE(found != nullptr);
  REQUIRE(found->attributes.count(name) == 1);
  return found->attributes.at(name);
}

std::vector<double> xml_numbers(const std::vector<XmlElement>& elements, const std::string& path,
                                const std::string& name) {
  std::istringstream words(xml_attribute(elements, path, name));
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    const auto number = core::parse_number(word);
    INFO(path << " " << name << ": " << word);
    REQUIRE(number);
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace partscribe::testing
