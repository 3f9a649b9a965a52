/// The figures of the 1993 paper: what they state is true, and pictures have ink.
#include "cli/paper/paper_figure.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <set>

#include "cli/paper/paper_page.h"
#include "testing/paper_subjects.h"

using namespace partscribe;
using namespace partscribe::cli;
using partscribe::testing::subjects_of_paper;

namespace {

double number_in(const PaperFigure& figure, std::size_t row, std::size_t column) {
  REQUIRE(figure.table.size() > row);
  REQUIRE(figure.table[row].size() > column);
  return std::atof(figure.table[row][column].c_str());
}

/// A PNG of one colour is short.
void check_ink(const PaperFigure& figure) {
  CHECK(!figure.pictures.empty());
  for (const auto& picture : figure.pictures) {
    INFO(picture.file);
    CHECK(picture.png.starts_with("\x89PNG"));
    CHECK(picture.png.size() > 2500);
    CHECK(!picture.description.empty());
  }
}

}  // namespace

TEST_CASE("paper figures: eight views of a polyhedron show one section, within a quarter of a pixel") {
  Context context;
  const auto figures = registration_figures(context);
  REQUIRE(figures);
  REQUIRE(figures->size() == 3);
  for (const auto& figure : *figures) check_ink(figure);
  const PaperFigure& section = (*figures)[1];
  CHECK(number_in(section, 1, 0) == 8);
  CHECK(number_in(section, 1, 1) == 8);
  CHECK(number_in(section, 1, 2) < 0.25);
  CHECK(number_in(section, 1, 3) > 500);
  CHECK(number_in(section, 1, 4) < 0.25);
  CHECK(number_in(section, 1, 5) < 1);
}

TEST_CASE("paper figures: trimmed lines take the spikes out of a profile") {
  Context context;
  const auto figure = filtered_profile_figure(context);
  check_ink(figure);
  CHECK(figure.text.find("flipped bit") != std::string::npos);
}

TEST_CASE("paper figures: range images are as noisy as stated, and what stands in for lost ones says so") {
  const auto figure = range_images_figure(subjects_of_paper());
  check_ink(figure);
  REQUIRE(figure.table.size() == 4);
  CHECK(figure.table[2][1].find("stand-in") != std::string::npos);
  CHECK(figure.table[3][1].find("stand-in") != std::string::npos);
  for (std::size_t row = 1; row <= 3; ++row) CHECK(number_in(figure, row, 2) > 10000);
  CHECK(number_in(figure, 2, 4) == Approx(0.1).epsilon(0.1));
  // Four codes.
  CHECK(subjects_of_paper().pin.filtered.noise.sigma(1) == Approx(4 * subjects_of_paper().pin.image.q).epsilon(0.15));
}

TEST_CASE("paper figures: face and hand are triangulated within 0.5 and 0.4 mm along their normals") {
  Context context;
  const auto figure = triangulations_figure(subjects_of_paper(), context);
  check_ink(figure);
  for (std::size_t row = 1; row <= 2; ++row) {
    CHECK(number_in(figure, row, 4) <= number_in(figure, row, 1));
    CHECK(number_in(figure, row, 2) > 300);
    CHECK(number_in(figure, row, 2) < 0.1 * number_in(figure, row, 3));
  }
}

TEST_CASE("paper figures: the pin's superellipsoid indicates a cylinder, those of face and hand nothing") {
  Context context;
  const auto figure = superellipsoids_figure(subjects_of_paper(), context);
  check_ink(figure);
  CHECK(number_in(figure, 1, 1) == Approx(0.1).margin(0.05));
  CHECK(number_in(figure, 1, 2) == Approx(1).margin(0.1));
  CHECK(figure.table[1][6] == "cylinder");
  CHECK(figure.table[2][6] == "none");
  CHECK(figure.table[3][6] == "none");
  for (std::size_t row = 2; row <= 3; ++row) {
    CHECK(number_in(figure, row, 4) > number_in(figure, 1, 4));
    CHECK(number_in(figure, row, 5) > 10 * number_in(figure, 1, 5));
  }
}

TEST_CASE(
    "paper figures: by equation (6) a tapered superellipsoid fits the hand about twice as well as a straight one") {
  Context context;
  const auto figure = superellipsoids_figure(subjects_of_paper(), context);
  CHECK(number_in(figure, 3, 8) > 0);
  CHECK(number_in(figure, 3, 8) < 0.6 * number_in(figure, 3, 7));
}

TEST_CASE("paper figures: characters of surfaces size control meshes, the pin's smaller than those of the reliefs") {
  const auto figure = characterization_figure(subjects_of_paper());
  check_ink(figure);
  for (std::size_t row = 1; row <= 3; ++row) {
    CHECK(number_in(figure, row, 1) > 1);
    CHECK(figure.table[row][4] == std::to_string(int(3 * number_in(figure, row, 2))) + " x " +
                                      std::to_string(int(3 * number_in(figure, row, 3))));
  }
  CHECK(number_in(figure, 1, 2) < number_in(figure, 2, 2));
  CHECK(number_in(figure, 1, 3) < number_in(figure, 3, 3));
}

TEST_CASE("paper figures: a profile sized by its patches is refined to 1.0 mm by few more control points") {
  const auto figure = profile_figure(subjects_of_paper());
  check_ink(figure);
  CHECK(number_in(figure, 1, 2) > 1);
  CHECK(number_in(figure, 2, 2) <= 1);
  CHECK(number_in(figure, 2, 1) > number_in(figure, 1, 1));
  CHECK(number_in(figure, 2, 1) < 2 * number_in(figure, 1, 1));
}

TEST_CASE("paper figures: four knots at the shoulder of the pin leave less than half of the error") {
  const auto figure = discontinuity_figure(subjects_of_paper());
  check_ink(figure);
  CHECK(number_in(figure, 2, 2) < 0.5 * number_in(figure, 1, 2));
  CHECK(number_in(figure, 2, 1) == number_in(figure, 1, 1) + 4);
}

TEST_CASE("paper figures: the hand's surface is fitted over its bounding box and trimmed at edges of depth") {
  Context context;
  const auto figure = trimmed_figure(context);
  check_ink(figure);
  REQUIRE(figure.table.size() == 4);
  const auto share_after = [&](const std::string& words) {
    const auto at = figure.text.find(words);
    REQUIRE(at != std::string::npos);
    return std::atof(figure.text.c_str() + at + words.size());
  };
  INFO(figure.text);
  CHECK(share_after("Of these ") > 95);     // per cent of the trims within two pixels of the outline
  CHECK(share_after("and of that ") > 95);  // the other way round: between fingers as well
}

TEST_CASE("paper figures: both pages hold every figure, and names of files are used once") {
  const std::vector<PaperFigure> figures = {discontinuity_figure(subjects_of_paper()),
                                            range_images_figure(subjects_of_paper())};
  const std::string html = paper_html(figures, "1"), markdown = paper_markdown(figures, "1");
  std::set<std::string> files;
  for (const auto& figure : figures) {
    CHECK(html.find(figure.title) != std::string::npos);
    CHECK(markdown.find(figure.title) != std::string::npos);
    for (const auto& picture : figure.pictures) {
      CHECK(files.insert(picture.file).second);
      CHECK(markdown.find("(" + picture.file + ")") != std::string::npos);
    }
  }
  CHECK(html.find("data:image/png;base64,") != std::string::npos);
  CHECK(html == paper_html(figures, "1"));
}
