module {{name}}() {
  longest = max({{radius_x}}, {{radius_y}}, {{radius_z}});
  {{place}}scale([{{radius_x}}, {{radius_y}}, {{radius_z}}] / longest) ball(longest);
}
