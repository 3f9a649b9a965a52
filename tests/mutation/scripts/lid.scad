/* Lid of a small case: rounded all around, hollow, with pins below */
L = 50; W = 34; H = 9; R = 3; wall = 2.4;

module rounded(l, w, h, r)
    minkowski() {
        translate([r, r, 0]) cube([l - 2*r, w - 2*r, h/2]);
        cylinder(r = r, h = h/2, $fn = 32);
    }

module pins(rows, columns, pitch)
    for (x = [0 : columns - 1], y = [0 : rows - 1])
        translate([9 + x*pitch, 9 + y*pitch, 1])
            cylinder(r = 2.5, h = 5.5, $fn = 28);

difference() {
    rounded(L, W, H, R);
    translate([wall, wall, wall]) cube([L - 2*wall, W - 2*wall, H]);
}
pins(2, 3, 16);
