"""A smoothing spline by FITPACK (SciPy): regrid for a grid, surfit for scattered points.

usage: fitpack.py INPUT OUTPUT; INPUT: doubles columns, rows (0, 0: scattered), s, then x, y, z of every point (y runs
fastest). OUTPUT: doubles seconds of processor time of the call, its megabytes, degree, number of knots, knots in x, the
same in y, coefficients (y fastest).
"""
import resource
import sys
import time
import warnings

import numpy as np
from scipy.interpolate import RectBivariateSpline, bisplrep

warnings.simplefilter("ignore")


def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main():
    data = np.fromfile(sys.argv[1])
    columns, rows, s = int(data[0]), int(data[1]), data[2]
    x, y, z = data[3:].reshape(-1, 3).T.copy()
    box = [x.min(), x.max(), y.min(), y.max()]
    if columns:
        x, y, z = x.reshape(columns, rows)[:, 0].copy(), y.reshape(columns, rows)[0].copy(), z.reshape(columns, rows)
    memory, begin = peak(), time.process_time()
    if columns:
        u, v, c = RectBivariateSpline(x, y, z, s=s).tck
    else:
        most = int(min(4 + np.sqrt(len(z) / 2), 150)) + 8
        u, v, c, _, _ = bisplrep(x, y, z, xb=box[0], xe=box[1], yb=box[2], ye=box[3], s=s, nxest=most, nyest=most)
    seconds, memory = time.process_time() - begin, peak() - memory
    np.concatenate([[seconds, memory, 3, len(u)], u, [3, len(v)], v, c]).astype(float).tofile(sys.argv[2])


main()
