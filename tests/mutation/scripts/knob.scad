// A star knob: grips around a body, a hexagon for the nut, a hole for the screw.
grips=6; body_r=20; body_h=14;
grip_r=5;

module body() cylinder(r=body_r,h=body_h,$fn=72);
module grip(i) rotate(i*360/grips) translate([body_r+2,0,-1]) cylinder(r=grip_r,h=body_h+2,$fn=36);
module nut() translate([0,0,body_h-6]) cylinder(d=13/cos(30),h=10,$fn=6);
module screw() translate([0,0,-1]) cylinder(d=6.6,h=body_h+2,$fn=36);

difference(){
  union(){ body(); translate([0,0,-5]) cylinder(r1=9,r2=12,h=5.5,$fn=60); }
  for(i=[0:grips-1]) grip(i);
  nut();
  translate([0,0,-6]) screw();
}
