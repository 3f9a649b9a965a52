/// The parts that the figures of the 1993 paper are simulated from, as model.json texts.
#pragma once

namespace partscribe::cli {

/// A headed pin, turned about z, lying across the first view.
inline constexpr const char* pin_model_text = R"json({
  "format": "partscribe-model",
  "version": 1,
  "units": "mm",
  "name": "pin",
  "tolerance": 0.05,
  "parameters": [
    {"name": "shank_radius", "quantity": "length", "value": 9, "note": "radius of the shank"},
    {"name": "shank_length", "quantity": "length", "value": 46, "note": "from the tip to the head"},
    {"name": "head_radius", "quantity": "length", "value": 10.5, "note": "radius of the head"},
    {"name": "head_height", "quantity": "length", "value": 8, "note": "height of the head"},
    {"name": "chamfer", "quantity": "length", "value": 1, "note": "at the tip, 45 degrees"}
  ],
  "objects": [
    {
      "name": "pin_body",
      "note": "a headed pin, turned about z",
      "shape": {
        "kind": "revolve",
        "sketch": {
          "loops": [
            {
              "name": "profile",
              "elements": [
                {"point": {"x": 0, "y": 0, "edge": "tip"}},
                {"point": {"x": ["-", "shank_radius", "chamfer"], "y": 0, "edge": "chamfer"}},
                {"point": {"x": "shank_radius", "y": "chamfer", "edge": "shank"}},
                {"point": {"x": "shank_radius", "y": "shank_length", "edge": "shoulder"}},
                {"point": {"x": "head_radius", "y": "shank_length", "edge": "head"}},
                {"point": {"x": "head_radius", "y": ["+", "shank_length", "head_height"], "edge": "top"}},
                {"point": {"x": 0, "y": ["+", "shank_length", "head_height"]}}
              ]
            }
          ]
        }
      }
    }
  ]
})json";

/// A prism over a polygon with ten corners, no two sides alike.
inline constexpr const char* polyhedron_model_text = R"json({
  "format": "partscribe-model",
  "version": 1,
  "units": "mm",
  "name": "polyhedron",
  "tolerance": 0.1,
  "parameters": [{"name": "height", "quantity": "length", "value": 46, "note": "of the prism"}],
  "objects": [
    {
      "name": "prism",
      "note": "a polyhedral body",
      "shape": {
        "kind": "extrude",
        "sketch": {
          "loops": [
            {
              "name": "outline",
              "elements": [
                {"point": {"x": -42, "y": -30}},
                {"point": {"x": 34, "y": -30}},
                {"point": {"x": 45, "y": -14}},
                {"point": {"x": 45, "y": 6}},
                {"point": {"x": 18, "y": 2}},
                {"point": {"x": 6, "y": 16}},
                {"point": {"x": 14, "y": 34}},
                {"point": {"x": -14, "y": 34}},
                {"point": {"x": -24, "y": 10}},
                {"point": {"x": -42, "y": 4}}
              ]
            }
          ]
        },
        "height": "height"
      }
    }
  ]
})json";

}  // namespace partscribe::cli
