/// Parts and folders are called after their files, in any script.
#include "cli/names.h"

#include <catch2/catch.hpp>

namespace partscribe::testing {

using namespace cli;

TEST_CASE("names: a part is named after its file, or its folder where the file's name says nothing") {
  CHECK(part_name("scans/Pump cover (2).ply") == "pump_cover_2");
  CHECK(part_name("bracket-partscribe/model.json") == "bracket");
  CHECK(part_name("lever/scan/merged.ply") == "lever");
  CHECK(part_name("3mm_plate.stl") == "part_3mm_plate");
}

TEST_CASE("names: inside scripts letters of other languages are written in plain ones, or by number") {
  CHECK(part_name("Größe_Ø10.stl") == "groesse_o10");
  CHECK(part_name("Größe_Ø10.stl") == part_name("GRÖßE Ø10.ply"));
  CHECK(part_name("czółenko.stl") == "czolenko");
  CHECK(part_name("Деталь-5.stl") == "detal_5");
  CHECK(part_name("零件.stl") == "u96f6_u4ef6");
  CHECK(part_name("轴.stl") == "u8f74");
  CHECK(part_name("轴 2.stl") == "u8f74_2");
  CHECK(part_name("cafe\xcc\x81.stl") == "cafe");  // an accent of its own
  CHECK(part_name("\xf6ko.stl") == "ko");          // no UTF-8
}

TEST_CASE("names: folders keep their characters and stay apart") {
  CHECK(folder_name("Größe_Ø10.stl") == "Größe_Ø10");
  CHECK(folder_name("零件.stl") == "零件");
  CHECK(folder_name("轴.stl") == "轴");
  CHECK(folder_name("Pump cover (2).ply") == "Pump_cover_2");
  CHECK(folder_name("bracket-v2.1.stl") == "bracket-v2.1");
  CHECK(folder_name("-dash.stl") == "dash");
  CHECK(folder_name("零件-partscribe/model.json") == "零件");
  CHECK(folder_name("scans/Bracket.ply") != folder_name("scans/bracket.ply"));
}

}  // namespace partscribe::testing
