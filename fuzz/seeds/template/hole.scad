module {{name}}()
  {{place}}round_cutter(d = {{diameter}}, from = {{from}}, to = {{to}});
