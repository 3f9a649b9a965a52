#include "cli/report/report_page.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "cli/describe.h"
#include "cli/inputs.h"
#include "cli/report/report_code.h"
#include "cli/report/report_words.h"
#include "cli/verdict_file.h"
#include "codegen/emit.h"
#include "core/files.h"

namespace partscribe::testing {

using namespace cli;

namespace {

Model ball() {
  Model model;
  model.name = "ball <1>";
  model.tolerance = 0.1;
  Parameter radius;
  radius.name = "radius";
  radius.value = 5;
  radius.fitted = 4.99731;
  radius.sigma = 0.0042;
  radius.points = 4120;
  radius.nominal = NominalEvidence{5, 0.64, true, "0.5 mm grid"};
  radius.note = "of the ball";
  model.parameters = {radius};
  Object object;
  object.name = "ball";
  object.shape = Sphere{Expr::of("radius")};
  model.objects = {object};
  model.rivals = {{"ellipsoid", true, 0.02, 312.5, "explains no more and needs two numbers more"}};
  return model;
}

Verdict verdict_with_mesh() {
  Verdict verdict;
  verdict.verdict = Outcome::out_of_tolerance;
  verdict.tolerance = 0.1;
  ArtifactVerdict artifact;
  artifact.file = "part.scad";
  artifact.backend = artifact.program = "openscad";
  artifact.verdict = Outcome::out_of_tolerance;
  artifact.reasons = {"largest local deviation 0.2 mm > 0.1 mm"};
  FeatureVerdict row;
  row.name = "ball </script>";
  row.kind = "sphere";
  row.points = 3, row.rms = 0.1, row.max = 0.2, row.covered = 0.8;
  row.verdict = Outcome::out_of_tolerance;
  row.dimensions = {{"diameter", Quantity::length, 10, 10.21, 0.004, 0.21, false}};
  artifact.objects = {row};
  Finding finding;
  finding.feature = "ball </script>";
  finding.place = Vec3(1, 1, 1);
  finding.direction = Vec3(1, 0, 0);
  finding.deviation = 0.2, finding.area = 14, finding.extent = 4;
  finding.text = "ball: 0.2 mm too far in +x over 14 mm2 at (1, 1, 1)";
  Finding unseen;
  unseen.kind = Finding::Kind::not_scanned;
  unseen.reason = "no view faces it";
  artifact.findings = {finding, unseen};
  artifact.data_to_model.points = 3;
  artifact.data_to_model.local_max = 0.2;
  artifact.model_to_data = {50, 40, 8, 2};
  artifact.mesh.vertices = {{0, 0, 0}, {5, 0, 0}, {0, 5, 0}, {0, 0, 5}};
  artifact.mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  artifact.point_deviation = {0.0f, 0.2f, -0.05f};
  artifact.point_object = {0, 0, -1};
  artifact.triangle_object = {0, 0, 0, -1};
  artifact.sample_support = {0, 0, 1, 0, 2, 0, 0, 1};
  verdict.artifacts = {artifact};
  return verdict;
}

PointCloud four_points() {
  PointCloud cloud;
  cloud.points = {{0, 0, 1}, {1, 0, 0}, {9, 9, 9}, {0, 1, 0}};
  cloud.rejected = {0, 0, 1, 0};
  return cloud;
}

std::string page_of(const std::optional<Model>& model, const Verdict& verdict, const PointCloud& cloud) {
  Context context;
  const auto scene = report_scene(model, verdict, cloud, context);
  const auto pictures = draw_report(scene, context);
  return report_page({"ball <1>",
                      model,
                      verdict,
                      scene,
                      pictures,
                      {{"part.scad", "if (a < b) cube(1.5); // <why>"}},
                      {{"ball.ply", "abc"}},
                      {"unit guessed"},
                      "1.2.3"});
}

/// What stands between `before` and `after`, every time.
std::vector<std::string> all_between(const std::string& text, const std::string& before, const std::string& after) {
  std::vector<std::string> found;
  for (auto at = text.find(before); at != std::string::npos; at = text.find(before, at + 1)) {
    const auto begin = at + before.size();
    found.push_back(text.substr(begin, text.find(after, begin) - begin));
  }
  return found;
}

}  // namespace

TEST_CASE("report: base64 agrees with RFC 4648") {
  CHECK(base64("") == "");
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foo") == "Zm9v");
  CHECK(base64("foobar") == "Zm9vYmFy");
}

TEST_CASE("report: the page is self-contained, escaped and says the verdict") {
  const std::string page = page_of(ball(), verdict_with_mesh(), four_points());
  CHECK(page.find("Out of tolerance") != std::string::npos);
  CHECK(page.find("ball &lt;1&gt;") != std::string::npos);
  CHECK(page.find("(a &lt; b)") != std::string::npos);
  CHECK(page.find("4.9973 ± 0.0042") != std::string::npos);
  CHECK(page.find("needs two numbers more") != std::string::npos);
  CHECK(page.find("unit guessed") != std::string::npos);
  CHECK(page.find("no view faces it") != std::string::npos);
  CHECK(page.find("10.2100 ± 0.0040") == std::string::npos);  // numbers carry no more digits than they deserve
  CHECK(page.find("10.21 ± 0.004") != std::string::npos);
  CHECK(page.find("http") == page.find("http-equiv"));  // no network
  CHECK(page.find("http", page.find("http-equiv") + 1) == std::string::npos);
  CHECK(page == page_of(ball(), verdict_with_mesh(), four_points()));
}

TEST_CASE("report: only the page's own programs may run, and no name can end its data") {
  const std::string page = page_of(ball(), verdict_with_mesh(), four_points());
  const auto programs = all_between(page, "<script>", "</script>");
  REQUIRE(programs.size() == 2);  // the colour scheme's and the map's
  std::string allowed = "script-src";
  for (const auto& program : programs) {
    std::string digest;
    const std::string hex = sha256(program);
    for (std::size_t i = 0; i < hex.size(); i += 2)
      digest += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
    allowed += " 'sha256-" + base64(digest) + "'";
  }
  CHECK(page.find(allowed + ";") != std::string::npos);
  CHECK(page.find("default-src 'none'") != std::string::npos);
  CHECK(all_between(page, "<script", "</script>").size() == 3);
  CHECK(all_between(page, "</script", ">").size() == 3);
}

TEST_CASE("report: every picture has a text, every label a control, headings follow one another") {
  const std::string page = page_of(ball(), verdict_with_mesh(), four_points());
  const auto images = all_between(page, "<img ", ">");
  CHECK(images.size() == 3 + 6 + 2);  // overview, scan, model; six sides; two findings
  for (const auto& image : images) {
    const auto texts = all_between(image, "alt=\"", "\"");
    REQUIRE(texts.size() == 1);
    CHECK(texts.front().size() > 5);
  }
  const auto ids = all_between(page, " id=\"", "\"");
  const std::set<std::string> unique(ids.begin(), ids.end());
  CHECK(unique.size() == ids.size());
  for (const char* reference : {" for=\"", "aria-labelledby=\"", "aria-describedby=\"", "href=\"#"})
    for (const auto& id : all_between(page, reference, "\"")) CHECK(unique.count(id) == 1);
  int last = 0;
  for (auto at = page.find("<h"); at != std::string::npos; at = page.find("<h", at + 1)) {
    const int level = page[at + 2] - '0';
    if (level < 1 || level > 6) continue;
    CHECK(level <= last + 1);
    last = level;
  }
  CHECK(all_between(page, "<h1", "</h1>").size() == 1);
  CHECK(page.find("<html lang=\"en\">") != std::string::npos);
  CHECK(page.find("scope=\"col\"") != std::string::npos);
}

TEST_CASE("report: an artifact without a model or without geometry is reported too") {
  Verdict verdict = verdict_with_mesh();
  const std::string foreign = page_of(std::nullopt, verdict, four_points());
  CHECK(foreign.find("ball.ply") != std::string::npos);
  CHECK(foreign.find("id=\"map\"") != std::string::npos);
  CHECK(foreign.find("id=\"dimensions\"") == std::string::npos);
  ArtifactVerdict missing;
  missing.file = "part.scad";
  missing.reasons = {"openscad is not installed"};
  verdict.verdict = Outcome::not_run;
  verdict.artifacts = {missing};
  const std::string page = page_of(ball(), verdict, four_points());
  CHECK(page.find("openscad is not installed") != std::string::npos);
  CHECK(page.find("id=\"map\"") == std::string::npos);
  CHECK(all_between(page, "<script", ">").size() == 1);  // for the colour scheme
}

TEST_CASE("report: faces have a section where the scan was measured, and none where it was not") {
  const Verdict verdict = verdict_with_mesh();
  const PointCloud cloud = four_points();
  Context context;
  const std::optional<Model> model = ball();
  const auto scene = report_scene(model, verdict, cloud, context);
  const std::string page = report_page({"ball", model, verdict, scene, {}, {}, {}, {}, "1.2.3", "<p>seven faces</p>"});
  CHECK(page.find("id=\"faces\"") != std::string::npos);
  CHECK(page.find("href=\"#faces\"") != std::string::npos);
  CHECK(page.find("<p>seven faces</p>") != std::string::npos);
  CHECK(page_of(model, verdict, cloud).find("id=\"faces\"") == std::string::npos);
}

TEST_CASE("report: the sentence names the worst place, or says what the scan can decide") {
  Verdict verdict = verdict_with_mesh();
  CHECK(verdict_sentence(verdict).find("ball: 0.2 mm too far in +x") != std::string::npos);
  verdict.verdict = verdict.artifacts[0].verdict = Outcome::verified;
  verdict.artifacts[0].data_to_model.local_max = 0.05;
  CHECK(verdict_sentence(verdict).find("agree within 0.05 mm, and 0.1 mm is allowed") != std::string::npos);
  verdict.verdict = verdict.artifacts[0].verdict = Outcome::cannot_decide;
  verdict.smallest_honest_tolerance = 0.25;
  CHECK(verdict_sentence(verdict).find("It can decide from 0.25 mm upward") != std::string::npos);
  CHECK(honesty_sentences(verdict).find("cannot decide") != std::string::npos);
}

TEST_CASE("report: a share that is not nothing never reads as nothing") {
  CHECK(percent(0, 5) == "0 %");
  CHECK(percent(1e-9, 5) == "under 0.1 %");
  CHECK(percent(5, 5) == "100 %");
  CHECK(percent(4.9999, 5) == "over 99.9 %");
  CHECK(percent(1, 0) == "-");
  CHECK(typeset("19.99 +- 0.01 over 14 mm2 < 15 mm^2") == "19.99 \u00b1 0.01 over 14 mm\u00b2 &lt; 15 mm\u00b2");
  CHECK(grouped(0) == "0");
  CHECK(grouped(1035921) == "1,035,921");
}

TEST_CASE("report: highlighting changes no character of the script") {
  const std::string scad = "// a < b\nr = 1.5e-3; /* two\nlines */ module m(x) { cube(\"q\\\"\", 3); }\n";
  const std::string html = highlighted(scad, backends()[0].language);
  std::string text;
  for (std::size_t i = 0; i < html.size(); ++i) {
    if (html[i] == '<')
      i = html.find('>', i);
    else
      text += html[i];
  }
  CHECK(text == escaped(scad));
  CHECK(html.find("<span class=\"c\">// a &lt; b</span>") != std::string::npos);
  CHECK(html.find("<span class=\"n\">1.5e-3</span>") != std::string::npos);
  CHECK(html.find("<span class=\"k\">module</span>") != std::string::npos);
  CHECK(html.find("<span class=\"f\">cube</span>") != std::string::npos);
  CHECK(highlighted("# n\nA : 1;", backends()[1].language).find("<span class=\"c\"># n</span>") == 0);
}

TEST_CASE("report: deviations belong to kept points, outliers have none, and a wrong number of them is not drawn") {
  Verdict verdict = verdict_with_mesh();
  PointCloud cloud = four_points();
  const auto deviations = deviations_of(cloud, &verdict.artifacts.front());
  REQUIRE(deviations.size() == 4);
  CHECK(deviations[0] == 0.0f);
  CHECK(deviations[1] == 0.2f);
  CHECK(std::isnan(deviations[2]));
  verdict.artifacts[0].data_to_model.local_max = 0.1;  // the point 0.2 off was not judged
  CHECK(std::isnan(deviations_of(cloud, &verdict.artifacts.front())[1]));
  cloud.rejected.assign(4, 0);
  CHECK(deviations_of(cloud, &verdict.artifacts.front()).empty());
}

TEST_CASE("verdict file: what was written is read back") {
  const Verdict verdict = verdict_with_mesh();
  const auto back = read_verdict_json(write_verdict_json(verdict), "verdict.json");
  REQUIRE(back.ok());
  CHECK(back->verdict == Outcome::out_of_tolerance);
  CHECK(back->tolerance == 0.1);
  REQUIRE(back->artifacts.size() == 1);
  CHECK(back->artifacts[0].file == "part.scad");
  REQUIRE(back->artifacts[0].objects.size() == 1);
  CHECK(back->artifacts[0].objects[0].max == 0.2);
  const auto bad = read_verdict_json("{\"verdict\": \"fine\"}", "x/verdict.json");
  REQUIRE_FALSE(bad.ok());
  CHECK(bad.error().message.find("x/verdict.json: expected a verdict") == 0);
}

}  // namespace partscribe::testing
