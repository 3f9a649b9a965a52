// What a surface passes as it moves.
module {{name}}()
  {{place}}swept_surface({{surfaces}}, {{corners}}, {{name}}_faces, {{name}}_rim, {{direction}});
