// Scans: range images, files that name others, reference points.
#include "core/ensure.h"
#include "scan/read/range_file.h"
#include "scan/read/read.h"
#include "scan/register/fiducials.h"
#include "testing/fuzz/bundle.h"
#include "testing/fuzz/entries.h"

namespace partscribe::testing {

using namespace scan;

void fuzz_range(std::string_view bytes) {
  const auto image = parse_range_file(bytes, "a.png");
  if (!image.ok()) return;
  ensure(image->width > 0 && image->height > 0, "an image has pixels");
  ensure(image->codes.size() == std::size_t(image->width) * std::size_t(image->height), "every pixel has its code");
}

void fuzz_scan(std::string_view bytes) {
  const Bundle bundle(bytes);
  if (bundle.first().empty()) return;
  Context context;
  std::vector<RangeImage> images;
  const auto scan = read_scan({bundle.first()}, {}, context, &images);
  if (!scan.ok()) return;
  for (const auto& p : scan->cloud.points) ensure(p.allFinite(), "places are finite");
  ensure(images.size() == scan->views.size(), "every view has its image");
}

void fuzz_fiducials(std::string_view bytes) {
  std::vector<View> views(3);
  views[0].file = "a.ply", views[1].file = "b.ply", views[2].file = "c/a.ply";
  const auto fiducials = parse_fiducials(bytes, views, 1);
  if (!fiducials.ok()) return;
  for (const auto& fiducial : *fiducials) ensure(fiducial.view < views.size(), "a reference point is of a view");
  (void)register_by_fiducials({{}, {}, {}}, *fiducials);
}

}  // namespace partscribe::testing
