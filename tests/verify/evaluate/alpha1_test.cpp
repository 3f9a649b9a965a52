#include "verify/evaluate/alpha1.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "core/number.h"
#include "verify/evaluate/run_occt.h"

using namespace partscribe::verify;

namespace {

/// A folder with the files of one procedure; the first is run.
struct Procedure {
  TemporaryDirectory folder;
  Path add(const std::string& name, const std::string& text) const {
    const Path path = folder.path() / name;
    REQUIRE(write_file(path, text).ok());
    return path;
  }
};

Evaluation run(const std::string& text, double tolerance = 0.1) {
  Procedure procedure;
  const Path path = procedure.add("t.scl", text);
  Context context;
  auto result = evaluate_alpha1(path, {.tolerance = tolerance, .seconds = 20}, context);
  if (!result.ok()) FAIL(result.error().message);
  return *result;
}

double good_volume(const std::string& text, double tolerance = 0.1) {
  const Evaluation e = run(text, tolerance);
  INFO(text);
  for (const auto& c : e.complaints) UNSCOPED_INFO(c);
  CHECK(e.complaints.empty());
  CHECK_FALSE(e.failed);
  CHECK(e.solid);
  CHECK(topology(e.mesh).closed());
  CHECK(e.error <= tolerance / 5);
  return e.mesh.empty() ? 0 : volume(e.mesh);
}

std::string refusal(const std::string& text) {
  const Evaluation e = run(text);
  CHECK(e.failed);
  return e.complaints.empty() ? std::string() : e.complaints.front();
}

/// How many triangles each edge of a mesh has.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> borders_of(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++count[std::minmax(t[k], t[(k + 1) % 3])];
  return count;
}

// Our own statement of the helpers that a prelude defines.
const std::string helpers = R"(
set demand_eval true;
procedure joined( A, B ) combineShells( "union", A, B );
procedure cutBy( A, B ) combineShells( "difference", A, B );
procedure shared( A, B ) combineShells( "intersection", A, B );
Factor : 1.026034064;
procedure circlePoints( R, Z )
  forCollect( J; 0; J < 16; J + 1 ) objTransform( pt( R * Factor, 0.0, Z ), rz( J * 22.5 ) );
)";

}  // namespace

TEST_CASE("alpha1: primitives have the volumes of the textbook") {
  CHECK(good_volume("B : makeGeom( box( pt(1,2,3), vec(10,0,0), vec(0,20,0), vec(0,0,5) ) );") == Approx(1000));
  CHECK(good_volume("B : makeGeom( box( pt(1,2,3), vec(0,20,0), vec(10,0,0), vec(0,0,5) ) );") == Approx(1000));
  CHECK(good_volume("B : box( Origin, vec(10,0,0), vec(3,20,0), vec(1,2,5) );") == Approx(1000));
  CHECK(good_volume("W : rightAngleWedge( pt(20,0,0), vec(10,0,0), vec(0,10,0), vec(0,0,7) );") == Approx(350));
  CHECK(good_volume("C : rightCirCylinder( pt(5,0,0), vec(0,12,0), 4.0 );") == Approx(pi * 16 * 12).epsilon(3e-3));
  CHECK(good_volume("S : objTransform( objTransform( unitSphere, sG( 6.0 ) ), tY( 40.0 ) );") ==
        Approx(4.0 / 3 * pi * 216).epsilon(6e-3));
  CHECK(good_volume("E : objTransform( unitSphere, sXYZ( 8.0, 5.0, 3.0 ) );", 0.02) ==
        Approx(4.0 / 3 * pi * 120).epsilon(2e-3));
  CHECK(good_volume("M : objTransform( box( Origin, vec(1,0,0), vec(0,2,0), vec(0,0,3) ), sXYZ( -1, 1, 1 ) );") ==
        Approx(6));
}

TEST_CASE("alpha1: transformations turn by degrees and move by millimetres") {
  const Evaluation e =
      run("A : box( Origin, vec(10,0,0), vec(0,2,0), vec(0,0,1) );"
          "B : objTransform( objTransform( objTransform( objTransform( A, rx( 90.0 ) ), ry( 90.0 ) ), rz( 90.0 ) ), "
          "tX( 5.0 ) );");
  // x: 10 -> x -> -z -> -z;  y: 2 -> z -> x -> y;  z: 1 -> -y -> -y -> x
  REQUIRE(e.complaints.empty());
  const Box3 box = e.mesh.bounds();
  CHECK((box.low - Vec3(5, 0, -10)).norm() < 1e-12);
  CHECK((box.high - Vec3(6, 2, 0)).norm() < 1e-12);
}

TEST_CASE("alpha1: booleans, loops and procedures build a drilled plate") {
  const std::string plate = helpers + R"(
PlateL : 80.0; PlateW : 50.0; PlateT : 8.0; HoleR : 4.0;
Blank : makeGeom( box( Origin, vec( PlateL, 0.0, 0.0 ), vec( 0.0, PlateW, 0.0 ), vec( 0.0, 0.0, PlateT ) ) );
procedure drill( X, Y ) makeGeom( rightCirCylinder( pt( X, Y, -1.0 ), vec( 0.0, 0.0, PlateT + 2.0 ), HoleR ) );
One : cutBy( Blank, drill( 12.0, PlateW / 2.0 ) );
Plate : cutBy( One, drill( PlateL - 12.0, PlateW / 2.0 ) );
)";
  CHECK(good_volume(plate) == Approx(80 * 50 * 8 - 2 * pi * 16 * 8).epsilon(1e-4));
  const std::string moved = helpers + R"(
A : makeGeom( box( Origin, vec(10,0,0), vec(0,10,0), vec(0,0,10) ) );
B : objTransform( A, tX( 5.0 ) );
)";
  CHECK(good_volume(moved + "U : joined( A, B );") == Approx(1500));
  CHECK(good_volume(moved + "I : shared( A, B );") == Approx(500));
  CHECK_THAT(refusal(moved + "I : shared( A, objTransform( A, tX( 50.0 ) ) );"), Catch::Contains("leaves nothing"));
}

TEST_CASE("alpha1: a pin of B-spline rings is round to the accuracy its control points promise") {
  const std::string pin = helpers + R"(
procedure turned( Order, Mesh )
  surface( Cubic, "ec_periodic", "kv_uniform", Order, "ec_open", "kv_uniform", Mesh );
R : 12.0; L : 60.0; C : 1.5;
Rings : seqCollect {
  circlePoints( 0.0, 0.0 ); circlePoints( R - C, 0.0 ); circlePoints( R, C );
  circlePoints( R, L - C ); circlePoints( R - C, L ); circlePoints( 0.0, L );
}
Pin : turned( Linear, Rings );
setAttr( Pin, "name", "pin" );
Out : seqCollect { Pin; }
dumpGeomFile( Out, "pin.a1" );
)";
  const double cone = pi * 1.5 / 3 * (144 + 12 * 10.5 + 10.5 * 10.5);
  CHECK(good_volume(pin, 0.02) == Approx(pi * 144 * 57 + 2 * cone).epsilon(5e-4));
  const Evaluation e = run(pin, 0.02);
  double widest = 0;
  for (const auto& v : e.mesh.vertices) widest = std::max(widest, v.head<2>().norm());
  CHECK(widest == Approx(12).margin(1e-3));
  CHECK(widest <= 12 + 1e-6);  // the approximation is inward everywhere
}

TEST_CASE("alpha1: inserting knots leaves a patch what it is") {
  const std::string mesh = R"(
Mesh : seqCollect {
  seqCollect { pt( 0,0,0 ); pt( 10,0,1.2 ); pt( 20,0,0.9 ); pt( 30,0,0 ); }
  seqCollect { pt( 0,10,1 ); pt( 10,10,4.8 ); pt( 20,10,4.1 ); pt( 30,10,1.1 ); }
  seqCollect { pt( 0,20,1.1 ); pt( 10,20,5.2 ); pt( 20,20,4.4 ); pt( 30,20,0.8 ); }
  seqCollect { pt( 0,30,0 ); pt( 10,30,1 ); pt( 20,30,1.3 ); pt( 30,30,0 ); }
}
Patch : surface( Cubic, "ec_open", "kv_bezier", Cubic, "ec_open", "kv_bezier", Mesh );
)";
  const Evaluation plain = run(mesh);
  const Evaluation refined =
      run(mesh + "Knots : seqCollect { 0.25; 0.5; } Fine : sRefine( Patch, \"row\", Knots, true );");
  CHECK(plain.complaints.empty());
  CHECK(refined.complaints.empty());
  CHECK_FALSE(plain.solid);
  CHECK(area(refined.mesh) == Approx(area(plain.mesh)).epsilon(1e-3));
  CHECK(refined.mesh.bounds().high.z() == Approx(plain.mesh.bounds().high.z()).margin(0.01));
  // The corners are interpolated and u runs along a row.
  CHECK((plain.mesh.bounds().high.head<2>() - Vec2(30, 30)).norm() < 1e-9);
  const std::string knots = "K : seqCollect { 0; 0; 0; 0; 1; 1; 1; 1; }";
  const Evaluation given =
      run(mesh + knots + "G : surface( Cubic, \"ec_open\", K, Cubic, \"ec_open\", \"kv_uniform\", Mesh );");
  CHECK(area(given.mesh) == Approx(area(plain.mesh)).epsilon(1e-9));
}

TEST_CASE("alpha1: a patch is trimmed by a tool shell") {
  const Evaluation e = run(helpers + R"(
Mesh : seqCollect { seqCollect { pt( 0,0,0 ); pt( 30,0,0 ); } seqCollect { pt( 0,30,0 ); pt( 30,30,0 ); } }
Patch : surface( Linear, "ec_open", "kv_uniform", Linear, "ec_open", "kv_uniform", Mesh );
Tool : makeGeom( rightCirCylinder( pt( 15,15,-10 ), vec( 0,0,30 ), 11.0 ) );
Disc : shared( Patch, Tool );
)",
                           0.01);
  for (const auto& c : e.complaints) UNSCOPED_INFO(c);
  CHECK(e.complaints.empty());
  CHECK_FALSE(e.solid);
  CHECK(area(e.mesh) == Approx(pi * 121).epsilon(1e-3));
}

TEST_CASE("alpha1: where surfaces meet is said once, and is as fine as the tolerance at which it is evaluated") {
  // The procedure names two surfaces and that they are cut; no curve stands in it.
  const std::string disc = helpers + R"(
Mesh : seqCollect { seqCollect { pt( 0,0,0 ); pt( 30,0,0 ); } seqCollect { pt( 0,30,0 ); pt( 30,30,0 ); } }
Patch : surface( Linear, "ec_open", "kv_uniform", Linear, "ec_open", "kv_uniform", Mesh );
Tool : makeGeom( rightCirCylinder( pt( 15,15,-10 ), vec( 0,0,30 ), 11.0 ) );
Disc : shared( Patch, Tool );
)";
  // Two rods of one radius that cross: 16 r^3 / 3 is common to them.
  const std::string rods = helpers + R"(
One : makeGeom( rightCirCylinder( pt( -30,0,0 ), vec( 60,0,0 ), 9.0 ) );
Other : makeGeom( rightCirCylinder( pt( 0,-30,0 ), vec( 0,60,0 ), 9.0 ) );
Common : shared( One, Other );
)";
  double off_before = 1e300;
  std::size_t before = 0;
  for (const double tolerance : {1.0, 0.1, 0.01}) {
    const Evaluation e = run(disc, tolerance);
    REQUIRE(e.complaints.empty());
    double off = 0;
    std::size_t on_border = 0;
    for (const auto& [border, count] : borders_of(e.mesh))
      if (count == 1) {
        const Vec3 middle = 0.5 * (e.mesh.vertices[border.first] + e.mesh.vertices[border.second]);
        off = std::max(off, std::abs((middle - Vec3(15, 15, 0)).norm() - 11)), ++on_border;
      }
    INFO("tolerance " << tolerance << ", off " << off << ", pieces " << on_border);
    CHECK(off <= tolerance / 5);
    CHECK(off < off_before);
    CHECK(on_border > before);
    off_before = off, before = on_border;
    const double common = 16.0 / 3 * 9 * 9 * 9;
    CHECK(good_volume(rods, tolerance) == Approx(common).margin(tolerance / 5 * 16 * 9 * 9));
  }
}

TEST_CASE("alpha1: a procedure with a choice and a circular pattern") {
  const std::string text = helpers + R"(
procedure peg( R1, R2 ) {
  Small : if ( R2 < R1 ) R2; else R1;
  return rightCirCylinder( Origin, vec( 0, 0, 10 ), Small );
}
procedure around( Part, N, Radius )
  forCollect( K; 0; K < N; K + 1 ) objTransform( objTransform( Part, tX( Radius ) ), rz( K * 360.0 / N ) );
Copies : around( peg( 3.0, 2.0 ), 6, 40.0 );
Pattern : group( Copies );
)";
  CHECK(good_volume(text, 0.01) == Approx(6 * pi * 4 * 10).epsilon(2e-3));
  CHECK(topology(run(text).mesh).components == 6);
}

TEST_CASE("alpha1: profiles turn and extrude into the volumes of Pappus and Cavalieri") {
  CHECK(good_volume(
            "P : profile( pt(10.0,0.0,0.0), pt(14.0,0.0,0.0), pt(14.0,0.0,3.0), pt(10.0,0.0,3.0), pt(10.0,0.0,0.0) );"
            "R : surfRev( P );",
            0.02) == Approx(pi * (196 - 100) * 3).epsilon(1e-3));
  // An open profile is closed straight to the axis.
  CHECK(good_volume("P : profile( pt(5.0,0.0,0.0), pt(5.0,0.0,8.0) ); R : surfRev( P );", 0.02) ==
        Approx(pi * 25 * 8).epsilon(2e-3));
  CHECK(good_volume("C : profile( arcThru3Pts( pt(12.0,0.0,0.0), pt(10.0,0.0,2.0), pt(8.0,0.0,0.0) ),"
                    "             arcThru3Pts( pt(8.0,0.0,0.0), pt(10.0,0.0,-2.0), pt(12.0,0.0,0.0) ) );"
                    "T : surfRev( C );",
                    0.02) == Approx(2 * pi * 10 * pi * 4).epsilon(5e-3));
  const std::string disc =
      "procedure disc( X, R ) profile( arcThru3Pts( pt( X + R, 0.0 ), pt( X, R ), pt( X - R, 0.0 ) ),"
      "                                arcThru3Pts( pt( X - R, 0.0 ), pt( X, -R ), pt( X + R, 0.0 ) ) );";
  CHECK(
      good_volume(disc + "Both : seqCollect { disc( 0.0, 10.0 ); disc( 2.0, 4.0 ); } T : extrudeProfiles( Both, 7.0 );",
                  0.02) == Approx(pi * (100 - 16) * 7).epsilon(2e-3));
  CHECK(good_volume("K : seqCollect { 0.; 0.; 0.; 1.; 1.; 1.; } W : seqCollect { 1.; 0.7071067811865476; 1.; }"
                    "Q : seqCollect { pt(3.,0.); pt(3.,3.); pt(0.,3.); }"
                    "P : profile( nurbsCrv( 3, K, Q, W ), pt(0.,0.), pt(3.,0.) ); E : extrudeProfiles( P, 2.0 );",
                    0.005) == Approx(pi * 9 / 4 * 2).epsilon(1e-3));
}

TEST_CASE("alpha1: walls lean by the angle they are given, about the plane of the profiles") {
  const std::string frame =
      "P : profile( pt( 0.0, 0.0 ), pt( 20.0, 0.0 ), pt( 20.0, 12.0 ), pt( 0.0, 12.0 ), pt( 0.0, 0.0 ) );"
      "H : profile( arcThru3Pts( pt( 12.0, 6.0 ), pt( 10.0, 8.0 ), pt( 8.0, 6.0 ) ),"
      "             arcThru3Pts( pt( 8.0, 6.0 ), pt( 10.0, 4.0 ), pt( 12.0, 6.0 ) ) );";
  // The integral of (20 - 2 t z) (12 - 2 t z), and that of pi (2 + t z)^2.
  auto part = [](double t, double z) { return 240 * z - 32 * t * z * z + 4 * t * t * z * z * z / 3; };
  auto hole = [](double t, double z) { return pi * (4 * z + 2 * t * z * z + t * t * z * z * z / 3); };
  const double t = std::tan(radians(8));
  CHECK(good_volume(frame + "B : extrudeProfilesWithDraft( P, 2.0, 9.0, 8.0 );") ==
        Approx(part(t, 9) - part(t, -2)).epsilon(1e-9));
  CHECK(good_volume(frame + "Both : seqCollect { P; H; } B : extrudeProfilesWithDraft( Both, 2.0, 9.0, 8.0 );",
                    0.005) == Approx(part(t, 9) - part(t, -2) - hole(t, 9) + hole(t, -2)).epsilon(1e-4));
  CHECK(good_volume(frame + "B : extrudeProfilesWithDraft( P, 0.0, 9.0, -8.0 );") == Approx(part(-t, 9)).epsilon(1e-9));
  CHECK(good_volume(frame + "B : extrudeProfilesWithDraft( P, 0.0, 9.0, 0.0 );") == Approx(2160).epsilon(1e-9));
  CHECK_THAT(refusal(frame + "B : extrudeProfilesWithDraft( P, 0.0, 9.0, 90.0 );"),
             Catch::Contains("below 90 degrees"));
  CHECK_THAT(refusal(frame + "B : extrudeProfilesWithDraft( P, 0.0, 60.0, 8.0 );"), Catch::Contains("cannot lean"));
  CHECK_THAT(refusal(frame + "B : extrudeProfilesWithDraft( P, -1.0, 9.0, 8.0 );"), Catch::Contains("negative length"));
}

TEST_CASE("alpha1: facets and half-spaces close into solids that face outward") {
  const std::string tetrahedron =
      "A : pt(0,0,0); B : pt(6,0,0); C : pt(0,6,0); D : pt(0,0,6);"
      "procedure facet( P, Q, R ) seqCollect { P; Q; R; }"
      "F : seqCollect { facet( A, C, B ); facet( A, B, D ); facet( B, C, D ); facet( C, A, D ); }"
      "S : shellOfFacets( F );";
  CHECK(good_volume(tetrahedron) == Approx(36));
  CHECK(good_volume(tetrahedron + "Cube : makeGeom( box( Origin, vec(2,0,0), vec(0,2,0), vec(0,0,2) ) );"
                                  "Rest : combineShells( \"difference\", S, Cube );") == Approx(28));
  const Evaluation open =
      run("F : seqCollect { seqCollect { pt(0,0,0); pt(4,0,0); pt(4,3,0); pt(0,3,0); } } S : shellOfFacets( F );");
  CHECK(open.complaints.empty());
  CHECK_FALSE(open.solid);
  CHECK(area(open.mesh) == Approx(12));
  const std::string octahedron =
      "procedure half( X, Y, Z ) seqCollect { X; Y; Z; 6.0; }"
      "P : seqCollect { half(1,1,1); half(1,1,-1); half(1,-1,1); half(1,-1,-1);"
      "                 half(-1,1,1); half(-1,1,-1); half(-1,-1,1); half(-1,-1,-1); } O : shellOfHalfSpaces( P );";
  CHECK(good_volume(octahedron) == Approx(4.0 / 3 * 216));
  CHECK_THAT(refusal("procedure half( X, Y, Z ) seqCollect { X; Y; Z; 6.0; }"
                     "P : seqCollect { half(1,0,0); half(-1,0,0); half(0,1,0); half(0,-1,0); half(0,0,1); } O : "
                     "shellOfHalfSpaces( P );"),
             Catch::Contains("expected") || Catch::Contains("bound"));
}

TEST_CASE("alpha1: a solid of B-spline surfaces can be cut") {
  const std::string ball = helpers + R"(
Rings : seqCollect {
  circlePoints( 0.0, -10.0 ); circlePoints( 10.0, -10.0 ); circlePoints( 10.0, 10.0 ); circlePoints( 0.0, 10.0 );
}
Skin : surface( Cubic, "ec_periodic", "kv_uniform", Cubic, "ec_open", "kv_uniform", Rings );
Body : shellOfSurfaces( Skin );
)";
  const double whole = good_volume(ball, 0.02);
  const double half =
      good_volume(ball +
                      "Block : makeGeom( box( pt( -20,-20,0 ), vec( 40,0,0 ), vec( 0,40,0 ), vec( 0,0,40 ) ) );"
                      "Half : cutBy( Body, Block );",
                  0.02);
  CHECK(half == Approx(whole / 2).epsilon(2e-3));
}

TEST_CASE("alpha1: a surface within a border has the area inside of it, borders have to close, and shells to fit") {
  // 40 x 30, flat; u and v run from 0 to 1.
  const std::string sheet = R"(
Net : seqCollect {
  seqCollect { pt( 0.0, 0.0, 5.0 ); pt( 40.0, 0.0, 5.0 ); }
  seqCollect { pt( 0.0, 30.0, 5.0 ); pt( 40.0, 30.0, 5.0 ); }
}
Whole : surface( Linear, "ec_open", "kv_uniform", Linear, "ec_open", "kv_uniform", Net );
Ends : seqCollect { 0.0; 0.0; 1.0; 1.0; }
procedure side( A, B ) nurbsCrv( Linear, Ends, seqCollect2( A, B ) );
procedure seqCollect2( A, B ) seqCollect { A; B; }
procedure corner( U, V ) pt( U, V, 0.0 );
Outline : seqCollect {
  side( corner( 0.1, 0.1 ), corner( 0.9, 0.1 ) ); side( corner( 0.9, 0.1 ), corner( 0.9, 0.9 ) );
  side( corner( 0.9, 0.9 ), corner( 0.1, 0.9 ) ); side( corner( 0.1, 0.9 ), corner( 0.1, 0.1 ) );
}
Window : seqCollect {
  side( corner( 0.4, 0.4 ), corner( 0.4, 0.6 ) ); side( corner( 0.4, 0.6 ), corner( 0.6, 0.6 ) );
  side( corner( 0.6, 0.6 ), corner( 0.6, 0.4 ) ); side( corner( 0.6, 0.4 ), corner( 0.4, 0.4 ) );
}
Gap : seqCollect { side( corner( 0.1, 0.1 ), corner( 0.9, 0.1 ) ); side( corner( 0.9, 0.1 ), corner( 0.9, 0.9 ) ); }
Loops : seqCollect { Outline; Window; }
)";
  const Evaluation e = run(sheet + "Out : objTransform( trimSurface( Whole, Loops ), rx( 90.0 ) );");
  CHECK_FALSE(e.failed);
  CHECK_FALSE(e.solid);
  CHECK(area(e.mesh) == Approx(40 * 30 * (0.64 - 0.04)));
  CHECK(e.mesh.bounds().size().y() == Approx(0).margin(1e-9));
  const auto refused = [&](const std::string& statement) { return refusal(sheet + statement); };
  CHECK(refused("Open : seqCollect { Gap; } Out : trimSurface( Whole, Open );").find("closed border") !=
        std::string::npos);
  CHECK(refused("L : seqCollect { Whole; } M : seqCollect { L; } Out : trimSurface( Whole, M );").find("curves") !=
        std::string::npos);
  CHECK(refused("B : box( Origin, vec(1,0,0), vec(0,1,0), vec(0,0,1) ); Out : trimSurface( B, Loops );") != "");
  CHECK(
      refused("F : seqCollect { trimSurface( Whole, Loops ); Whole; } Out : shellOfSurfaces( F );").find("whole one") !=
      std::string::npos);
}

TEST_CASE("alpha1: the result is the last dump, else the last show, else the last labelled object") {
  const std::string two =
      "A : box( Origin, vec(1,0,0), vec(0,1,0), vec(0,0,1) ); B : box( Origin, vec(2,0,0), vec(0,1,0), vec(0,0,1) );";
  CHECK(good_volume(two) == Approx(2));
  CHECK(good_volume(two + "show( A );") == Approx(1));
  CHECK(good_volume(two + "L : seqCollect { A; } dumpA1File( L, \"a.a1\" ); show( B );") == Approx(1));
  CHECK_THAT(refusal("A : 1;"), Catch::Contains("expected a procedure that makes an object, found none"));
  CHECK_THAT(refusal("P : pt( 1, 2 );"), Catch::Contains("expected a procedure that makes an object, found none"));
}

TEST_CASE("alpha1: another number gives another part") {
  auto pin = [](const std::string& radius) {
    return "PinRadius : " + radius + "; Pin : rightCirCylinder( Origin, vec( 0.0, 0.0, 60.0 ), PinRadius );";
  };
  CHECK(good_volume(pin("12.2"), 0.02) / good_volume(pin("12.0"), 0.02) == Approx(12.2 * 12.2 / 144).epsilon(1e-4));
}

TEST_CASE("alpha1: bad text is refused with file, line and column") {
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"A : sphere( 3.0 );", "t.scl:1:5: unknown function sphere"},
      {"A : circTubeConstantWidth( 1, 2 );", "radius or a diameter"},
      {"A : B;", "t.scl:1:5: unknown label B"},
      {"Abc : 1; D : abc;", "unknown label abc (there is Abc"},
      {"A : 1; a : 2;", "differ by case only"},
      {"A : 1; A : 2;", "t.scl:1:8: the label A is defined twice"},
      {"Cubic : 3;", "already defined by Alpha_1"},
      {"procedure box( A ) A;", "has the name of a function of Alpha_1"},
      {"procedure f( A ) A; procedure F( A ) A;", "defined twice"},
      {"procedure f( A, a ) A;", "occurs twice"},
      {"procedure f( A ) A; f( 1, 2 );", "f: expected 1 arguments, found 2"},
      {"return 3;", "return stands outside of any procedure"},
      {"A : 1 / 2;", "found two whole numbers"},
      {"A : 1.0 / 0;", "division by 0"},
      {"A : 10.0 ** 400;", "not a finite number"},
      {"A : 9000000000000000000 + 9000000000000000000;", "too large"},
      {"A : pt( 1 );", "t.scl:1:5: pt: expected 2 or 3 arguments, found 1"},
      {"A : pt( 1, \"x\" );", "argument 2: expected a number, found the string \"x\""},
      {"A : pt( 1.0e300, 0 );", "at most 1000000000.0 in size"},
      {"A : rightCirCylinder( Origin, Zaxis, -2.0 );", "expected a positive radius"},
      {"A : box( Origin, vec(1,0,0), vec(2,0,0), vec(0,0,1) );", "lie in a plane"},
      {"A : arcThru3Pts( pt(0,0), pt(1,1), pt(2,2) );", "lie on a line"},
      {"A : arcEndCenterEnd( pt(1,0), pt(0,0), pt(-1,0) );", "which way round"},
      {"A : objTransform( unitSphere, sG( 0.0 ) );", "flattens"},
      {"A : combineShells( \"union\", unitSphere, unitSphere );", "makeGeom makes its shell"},
      {"A : combineShells( \"minus\", unitSphere, unitSphere );", "expected \"union\""},
      {"P : profile( pt(0,0), pt(1,0), pt(1,1) ); A : extrudeProfiles( P, 2.0 );", "expected a closed profile"},
      {"P : profile( pt(0,0), pt(4,4), pt(4,0), pt(0,4), pt(0,0) ); A : extrudeProfiles( P, 2.0 );", "cross"},
      {"P : profile( pt(-1,0,0), pt(4,0,0), pt(4,0,4), pt(-1,0,0) ); A : surfRev( P );", "beyond the axis"},
      {"A : if ( 1 ) 2; else 3;", "expected true or false as the condition of if"},
      {"A : ptZ( pt( 1, 2 ) );", "expected a point with this coordinate"},
      {"A : 1; getAttr( unitSphere, \"x\" );", "has no attribute"},
      {"include \"nowhere.scl\";",
       "t.scl:1:1: expected a file to include in the procedure's folder or below, found \"nowhere.scl\""},
      {"M : seqCollect { seqCollect { pt(0,0,0); pt(1,0,0); } seqCollect { pt(0,1,0); } }"
       "A : surface( Linear, \"ec_open\", \"kv_uniform\", Linear, \"ec_open\", \"kv_uniform\", M );",
       "rows of equal length"},
      {"M : seqCollect { seqCollect { pt(0,0,0); pt(1,0,0); } seqCollect { pt(0,1,0); pt(1,1,0); } }"
       "A : surface( Cubic, \"ec_open\", \"kv_uniform\", Linear, \"ec_open\", \"kv_uniform\", M );",
       "expected at least 4 points, found 2"},
  };
  for (const auto& [text, message] : bad) {
    INFO(text);
    CHECK_THAT(refusal(text), Catch::Contains(message));
  }
}

TEST_CASE("alpha1: hostile text comes to an end") {
  CHECK_THAT(refusal("A : 0; while ( true ) A;"), Catch::Contains("steps"));
  CHECK_THAT(refusal("procedure f( N ) f( N + 1 ); f( 0 );"), Catch::Contains("deep"));
  CHECK_THAT(refusal("procedure f( N ) { A : f( N + 1 ); } f( 0 );"), Catch::Contains("deep"));
  CHECK_THAT(refusal("A : forCollect( I; 0; I < 1; I * 1 ) I;"), Catch::Contains("at most"));
  CHECK_THAT(refusal("A : forCollect( I; 0; true; I + 1 ) pt( I, I );"), Catch::Contains("at most"));
  std::string bomb = "L0 : seqCollect { pt(0,0,0); pt(1,0,0); }";
  for (int i = 1; i < 40; ++i)
    bomb +=
        "L" + std::to_string(i) + " : seqCollect { L" + std::to_string(i - 1) + "; L" + std::to_string(i - 1) + "; }";
  CHECK_THAT(refusal(bomb + "M : objTransform( L39, tX( 1.0 ) );"), Catch::Contains("at most"));
  std::string deep = "procedure f( N ) ";
  for (int i = 0; i < 150; ++i) deep += "-( ";
  deep += "f( N )";
  for (int i = 0; i < 150; ++i) deep += " )";
  CHECK_THAT(refusal(deep + "; f( 1 );"), Catch::Contains("deep") || Catch::Contains("nesting"));
}

TEST_CASE("alpha1: files are included from the folder of the file that asks") {
  Procedure procedure;
  std::filesystem::create_directory(procedure.folder.path() / "sub");
  procedure.add("sub/sizes.scl", "Size : 3.0;");
  procedure.add("sub/more.scl",
                "include \"sizes.scl\"; procedure cube( S ) box( Origin, vec(S,0,0), vec(0,S,0), vec(0,0,S) );");
  const Path main = procedure.add("main.scl", "include \"sub/more.scl\"; C : cube( Size );");
  Context context;
  const auto good = evaluate_alpha1(main, {}, context);
  REQUIRE(good.ok());
  CHECK(good->complaints.empty());
  CHECK(volume(good->mesh) == Approx(27));

  const Path loop = procedure.add("loop.scl", "include \"loop.scl\";");
  const auto endless = evaluate_alpha1(loop, {}, context);
  REQUIRE(endless.ok());
  CHECK(endless->failed);
  CHECK_THAT(endless->complaints.at(0), Catch::Contains("includes at most 16 deep"));

  procedure.add("bad.scl", "\n\nA : @;");
  const Path outer = procedure.add("outer.scl", "include \"bad.scl\";");
  const auto complaint = evaluate_alpha1(outer, {}, context);
  REQUIRE(complaint.ok());
  CHECK_THAT(complaint->complaints.at(0), Catch::StartsWith("bad.scl:3:5: "));

  const auto missing = evaluate_alpha1(procedure.folder.path() / "none.scl", {}, context);
  REQUIRE_FALSE(missing.ok());
  CHECK_THAT(missing.error().message, Catch::Contains("none.scl"));
}

TEST_CASE("alpha1: nothing is included from elsewhere, and one line says what was asked for") {
  Procedure procedure;
  std::filesystem::create_directory(procedure.folder.path() / "own");
  procedure.add("sizes.scl", "Size : 3.0;");
  procedure.add("own/.sizes.scl", "Size : 3.0;");
  std::filesystem::create_symlink(procedure.folder.path() / "sizes.scl", procedure.folder.path() / "own/link.scl");
  for (const std::string named : {"/etc/passwd", "../sizes.scl", "link.scl", ".sizes.scl", "/dev/zero", "."}) {
    const Path file = procedure.add("own/part.scl", "include \"" + named + "\";");
    Context context;
    const auto e = evaluate_alpha1(file, {}, context);
    REQUIRE(e.ok());
    CHECK(e->failed);
    REQUIRE(e->complaints.size() == 1);
    CHECK_THAT(e->complaints[0],
               Catch::StartsWith("part.scl:1:1: expected a file to include in the procedure's folder") &&
                   Catch::EndsWith("\"" + named + "\""));
  }
}

TEST_CASE("alpha1: a cancelled run stops") {
  Procedure procedure;
  const Path path = procedure.add("t.scl", "A : unitSphere; B : objTransform( A, sG( 2.0 ) );");
  Context context;
  context.cancelled = true;
  const auto stopped = evaluate_alpha1(path, {}, context);
  REQUIRE_FALSE(stopped.ok());
  CHECK(stopped.error().kind == ErrorKind::stopped);
}
