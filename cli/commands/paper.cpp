/// paper: the figures and tables of the 1993 paper, made anew.
#include "cli/commands.h"
#include "cli/commands/stages.h"
#include "cli/paper/paper_page.h"
#include "cli/result_folder.h"

namespace partscribe::cli {
namespace {

constexpr const char* paper_help =
    R"(Examples
  partscribe paper                        paper/paper.html and paper/paper.md with their pictures
  partscribe paper --out DIR --force      into another folder, over what is there

Makes figures 2 to 14 and tables 1 and 2 of the paper that this program began with (Koivunen, Vezien & Bajcsy 1993):
filtering, registration of eight views, triangulations, superellipsoids, characters of surfaces, splines, trimmed
surfaces, CAD models and procedures. Nothing is read: parts and scans are simulated, and stand-ins say that they are.
The same version writes the same bytes.)";

/// Everything that the page shows, one stage after the other.
Result<std::vector<PaperFigure>> all_figures(Session& session) {
  std::vector<PaperFigure> figures;
  const auto add = [&](std::vector<PaperFigure> more) {
    for (auto& figure : more) figures.push_back(std::move(figure));
  };
  Context& context = session.context;
  if (auto ok = session.stage("filter"); !ok) return ok.error();
  add({filtered_profile_figure(context)});
  if (auto ok = session.stage("register"); !ok) return ok.error();
  auto registered = registration_figures(context);
  if (!registered) return registered.error();
  add(std::move(*registered));
  if (auto ok = session.stage("range images"); !ok) return ok.error();
  const auto subjects = paper_subjects(context);
  if (!subjects) return subjects.error();
  add({range_images_figure(*subjects)});
  if (auto ok = session.stage("triangulate"); !ok) return ok.error();
  add({triangulations_figure(*subjects, context)});
  if (auto ok = session.stage("primitives"); !ok) return ok.error();
  auto primitives = primitives_table(context);
  if (!primitives) return primitives.error();
  add({std::move(*primitives)});
  if (auto ok = session.stage("superellipsoids"); !ok) return ok.error();
  add({superellipsoids_figure(*subjects, context)});
  if (auto ok = session.stage("characterize"); !ok) return ok.error();
  add({characterization_figure(*subjects)});
  if (auto ok = session.stage("splines"); !ok) return ok.error();
  add({profile_figure(*subjects), discontinuity_figure(*subjects), trimmed_figure(context)});
  if (auto ok = session.stage("models"); !ok) return ok.error();
  auto models = model_figures(*subjects, context);
  if (!models) return models.error();
  add(std::move(*models));
  return figures;
}

Result<int> run_paper(Session& session) {
  const Path folder = session.options.out.empty() ? Path("paper") : session.options.out;
  const std::vector<std::string> pages = {"paper.html", "paper.md"};
  const ResultFolder checked(folder, pages, "paper", {});
  if (auto ok = checked.check(session.options.force); !ok) return ok.error();
  auto figures = all_figures(session);
  if (!figures) return figures.error();
  if (auto ok = session.stage("write"); !ok) return ok.error();
  std::vector<std::string> names = pages;
  for (const auto& figure : *figures)
    for (const auto& picture : figure.pictures) names.push_back(picture.file);
  ResultFolder results(folder, names, "paper", {});
  if (auto ok = results.check(session.options.force); !ok) return ok.error();
  if (auto ok = results.begin(); !ok) return ok.error();
  const auto write = [&]() -> Result<int> {
    for (const auto& figure : *figures)
      for (const auto& picture : figure.pictures)
        if (auto ok = write_file(folder / picture.file, picture.png); !ok) return ok.error();
    if (auto ok = write_file(folder / "paper.html", paper_html(*figures, session.version)); !ok) return ok.error();
    if (auto ok = write_file(folder / "paper.md", paper_markdown(*figures, session.version)); !ok) return ok.error();
    return 0;
  };
  auto outcome = results.close(write());
  if (!outcome) return outcome;
  session.finish_stage();
  std::vector<Path> written;
  for (const auto& name : names) written.push_back(folder / name);
  session.print("Wrote " + (folder / "paper.html").string() + " and paper.md with " +
                std::to_string(names.size() - pages.size()) + " pictures. " + seconds_line(session) + "\n");
  session.print_json(summary_json("paper", written, {}));
  return outcome;
}

}  // namespace

Command paper_command() {
  return {"paper", "make the figures and tables of the 1993 paper anew", paper_help, [](Arguments&) {},
          [](Session& session) { return run_paper(session); }};
}

}  // namespace partscribe::cli
