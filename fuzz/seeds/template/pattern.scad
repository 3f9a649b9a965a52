module {{name}}()
  {{place}}for (i = [0 : {{last}}]) {{motion}} {{operand}}();
