// An open sheet; what OpenSCAD builds is a solid that reaches this thickness behind it.
module {{name}}()
  {{place}}thick_sheet({{name}}_points, {{name}}_normals, {{name}}_faces, {{name}}_rim, thickness = {{thickness}});
