module {{name}}()
  {{place}}cube([{{size_x}}, {{size_y}}, {{size_z}}]);
