module {{name}}()
  {{place}}linear_extrude(height = {{size_z}})
    polygon([[0, 0], [{{size_x}}, 0], [{{top_x}}, {{size_y}}], [0, {{size_y}}]]);
