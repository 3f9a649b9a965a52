"""Scans and their arrays, which are the memory of C++ itself."""

import gc
import weakref

import numpy as np
import partscribe
import pytest


def address(array):
    return array.__array_interface__["data"][0]


def test_points_and_normals_of_a_scan(pin):
    scan = partscribe.read(pin)
    assert scan.points.shape == (len(scan), 3) and scan.points.dtype == np.float64
    assert len(scan) == 43324 and len(scan.views) == 6
    assert np.allclose(np.linalg.norm(scan.rays, axis=1), 1)
    assert set(np.unique(scan.view)) == set(range(6))
    assert scan.triangles is None and scan.vertices is None
    assert scan.files == [pin]


def test_triangles_of_a_mesh(box):
    scan = partscribe.read(box)
    assert scan.vertices.shape == (8, 3) and scan.triangles.shape == (12, 3)
    assert np.array_equal(scan.vertices.max(axis=0), [20, 30, 10])
    corners = scan.vertices[scan.triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(20 * 30 * 10)
    assert scan.rays is None


def test_arrays_are_views_without_a_copy(box):
    scan = partscribe.read(box)
    for name in ("points", "normals", "vertices", "triangles"):
        first, second = getattr(scan, name), getattr(scan, name)
        assert first is not second and address(first) == address(second), name
        assert not first.flags.owndata and first.base is scan, name


def test_arrays_cannot_be_written_to(box):
    points = partscribe.read(box).points
    with pytest.raises(ValueError):
        points[0, 0] = 1
    with pytest.raises(ValueError):
        points.setflags(write=True)


def test_an_array_keeps_its_scan_alive(pin):
    scan = partscribe.read(pin)
    watch, points = weakref.ref(scan), scan.points
    before = points.copy()
    tail = points[-1:]
    del scan, points
    gc.collect()
    partscribe.read(pin)  # takes memory that was given back, if any was
    assert watch() is not None
    assert np.array_equal(watch().points, before) and np.array_equal(tail, before[-1:])
    del tail
    gc.collect()
    assert watch() is None


def test_units(box):
    assert np.allclose(partscribe.read(box, "inch").vertices, 25.4 * partscribe.read(box, "mm").vertices)
    assert partscribe.read(box, units="inch").unit_scale == 25.4


def test_several_files_are_several_views(box):
    scan = partscribe.read([box, str(box)])
    assert scan.views == ["box.stl", "box.stl"]


def test_warnings_of_a_scan_are_warnings_of_python(tmp_path):
    file = tmp_path / "twice.xyz"
    file.write_text("".join(f"{i % 40} {i // 40} 0\n" for i in range(1600)) + "5 5 0\n" * 200)
    with pytest.warns(partscribe.ScanWarning) as caught:
        scan = partscribe.read(file)
    assert [str(warning.message) for warning in caught] == scan.warnings
    assert caught[0].filename == __file__


def test_bad_arguments_name_what_is_expected(box):
    with pytest.raises(partscribe.UsageError, match="units: expected one of mm, cm, m, inch, found 'furlong'"):
        partscribe.read(box, "furlong")
    with pytest.raises(partscribe.UsageError, match="expected the files of a scan, found none"):
        partscribe.read([])
    with pytest.raises(partscribe.UsageError, match="threads: .* found -1"):
        partscribe.read(box, threads=-1)
