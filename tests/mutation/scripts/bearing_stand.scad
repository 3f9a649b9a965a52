// A stand for a bearing, the way a hobbyist writes it.
$fn = 40;

base = [64, 36, 7];
n_screws = 2;
screw_d = 5.2;
screw_gap = 48;

module base_plate() {
    difference() {
        translate([-base.x/2, -base.y/2, 0]) cube(base);
        for (i = [0 : n_screws - 1])
            for (s = [-1, 1])
                translate([(i - (n_screws - 1)/2) * screw_gap, s * 11, -1])
                    cylinder(d = screw_d, h = base.z + 2);
    }
}

module upright(width = 26, height = 30, t = 10) {
    difference() {
        hull() {
            translate([-width/2, -t/2, 0]) cube([width, t, 1]);
            translate([0, t/2, height]) rotate([90, 0, 0]) cylinder(d = width, h = t);
        }
        translate([0, t, height]) rotate([90, 0, 0]) cylinder(d = 15, h = 2*t);
    }
}

base_plate();
translate([0, 3, 5]) upright();
