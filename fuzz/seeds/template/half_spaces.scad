// Each face by its outward normal and its distance from the origin.
module {{name}}()
  {{place}}half_spaces([
    {{rows}}
  ]);
