module {{name}}()
  {{place}}ball({{radius}});
