/// The figures and tables of the 1993 paper (Koivunen, Vezien & Bajcsy), each made by this program.
#pragma once

#include <string>
#include <vector>

#include "cli/paper/paper_subjects.h"
#include "core/context.h"
#include "core/result.h"

namespace partscribe::cli {

struct PaperPicture {
  std::string file;         ///< "figure-7-mask.png"
  std::string png;          ///< its bytes
  std::string description;  ///< what a person who cannot see it should know
};

struct PaperFigure {
  std::string title;  ///< "Figure 7: triangulations"
  std::string text;   ///< what was done and measured, in sentences
  std::vector<PaperPicture> pictures;
  std::vector<std::vector<std::string>> table;  ///< the first row is the heading; empty: none
  std::string listing;                          ///< lines of a file, as they are
};

/// Figure 2: 12 bits, sigma 5 codes, bit errors with probability 0.015; trimmed lines through five samples.
PaperFigure filtered_profile_figure(Context& context);

/// Figures 3 to 5: eight views of a polyhedral part, registered; its sections.
Result<std::vector<PaperFigure>> registration_figures(Context& context);

/// Figure 6: the range images that all else is made of.
PaperFigure range_images_figure(const PaperSubjects& subjects);
/// Figure 7: triangulations of the face mask at 0.5 mm and of the hand at 0.4 mm.
PaperFigure triangulations_figure(const PaperSubjects& subjects, Context& context);
/// Table 1: what is recovered of each kind of primitive, and which procedure it invokes.
Result<PaperFigure> primitives_table(Context& context);
/// Table 2 and figure 8: the superellipsoids of the three images.
PaperFigure superellipsoids_figure(const PaperSubjects& subjects, Context& context);
/// Figure 9: maps of the surfaces' characters, and the sizes of control meshes that they suggest.
PaperFigure characterization_figure(const PaperSubjects& subjects);
/// Figure 10: a profile of the face as a spline, and refined to 1.0 mm.
PaperFigure profile_figure(const PaperSubjects& subjects);
/// Figure 11: four knots at one place.
PaperFigure discontinuity_figure(const PaperSubjects& subjects);
/// Figure 12: the hand over its bounding box, and trimmed.
PaperFigure trimmed_figure(Context& context);
/// Figures 13 and 14: CAD models of the pin and of the face, and the pin's procedures.
Result<std::vector<PaperFigure>> model_figures(const PaperSubjects& subjects, Context& context);

}  // namespace partscribe::cli
