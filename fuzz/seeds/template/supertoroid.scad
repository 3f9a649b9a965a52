module {{name}}()
  {{place}}supertoroid({{major_radius}}, {{minor_radius}}, {{half_height}}, e1 = {{e1}}, e2 = {{e2}},
    chord_error = chord_error);
